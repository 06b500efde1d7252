"""Chipmunk, the engine of flat games, by way of Pymunk. Facts below were measured on Pymunk 7.3.1.

Its library is Munk2D 2.0.1, a fork of Chipmunk. All is in doubles. In general position, and from 1e-100 to 1e100 of the
size, contacts and distances are right to a few roundings, for polygons of up to 300 corners as well; what goes wrong
does so where things line up or vanish.

`Shape.shapes_collide` is asked for contacts: one point of a round shape, two of edges, each with the depth between its
two places; the deepest counts. It tells that there is no contact by failing an assertion, and so cannot be asked under
``python -O``. Two circles that touch are no contact, two polygons are. Of shapes in another order than circle, segment,
polygon the sign of the depth is wrong: the pair table's order is Chipmunk's own.

`Shape.point_query` is asked for distances: Chipmunk measures those of points alone. That of a Disc is the one of its
centre, less the radius, which is exact for convex shapes; there is none of two polygons. The gradient points away from
the shape, so the contract's normal is its opposite. Nearer than 1e-5, Chipmunk's MAGIC_EPSILON, to a centre or an edge,
the gradient is not the direction to the nearest point, but that of the edge, or (0, 1).

`Shape.segment_query` is asked for rays, which are segments that end past the shape, and with a radius for sweeps: the
Disc moves as it is seen from the other, which rests. From inside it hits at once.

Impacts are in `pymunk_impacts`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import Any, ClassVar

import numpy as np

from oracles.course import WIDTH as COURSE
from oracles.course import Course
from oracles.engine import (
    NATIVE,
    NOWHERE,
    VELOCITIES,
    AnswerRow,
    Convention,
    Engine,
    EngineUnavailable,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    answer_row,
    emulated,
    unsupported,
)
from oracles.engines import pymunk_impacts as impacts
from oracles.engines.pymunk_scripts import cast_script, contact_script, distance_script, sweep_script
from oracles.engines.pymunk_shapes import Maker, Placed, import_pymunk, place
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP
from refimpl.flat import Disc, FlatPoint

ROUND = (FlatPoint, Disc)
"""Shapes that are a point and a radius."""
ROUNDING = Tolerance.uniform(0.0, 1e-12, "closed forms, or finite searches among edges, in double precision")
SAYS = {
    DISTANCE: frozenset({"distance", "on_b", "normal"}),
    CONTACTS: frozenset({"hit", "distance", "normal", "on_a", "on_b"}),
    BOOLEAN: frozenset({"hit"}),
    RAYCAST: frozenset({"hit", "t", "point", "normal"}),
    SWEEP: frozenset({"hit", "t", "point", "normal"}),
    IMPACT: frozenset(VELOCITIES),
}
POINTS_ONLY = "Chipmunk measures the distance of a point from a shape, and of no other two"
A_CIRCLE = "a FlatPoint is a Circle of radius 0"
LESS_RADIUS = "the distance of a Disc is that of its centre, less the radius"
A_SEGMENT = "a FlatRay is a segment that ends past the shape"
A_THICK_SEGMENT = "a round A that moves is a segment query of its radius, on the way that it goes as seen from B"
ROUND_ONLY = "Chipmunk sweeps discs: a segment query has a radius, and no other shape"
OPTIMISED = "pymunk tells that two shapes do not touch by failing an assertion, and python -O leaves those out"


class PymunkEngine(Engine):
    """Pymunk: contacts of two shapes, distances from points, segment queries."""

    name: ClassVar[str] = "pymunk"
    flat: ClassVar[bool] = True
    thresholds: ClassVar[Mapping[str, float]] = {"MAGIC_EPSILON": 1e-5}

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains Chipmunk."""
        return {"pymunk": metadata.version("pymunk")}

    def warm(self) -> None:
        """Import pymunk."""
        import_pymunk()
        if not __debug__:
            raise EngineUnavailable(OPTIMISED)

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        del B
        if query == RAYCAST:
            return emulated(A_SEGMENT)
        if query == DISTANCE:
            if A not in ROUND:
                return unsupported(POINTS_ONLY)
            return NATIVE if A is FlatPoint else emulated(LESS_RADIUS)
        return emulated(A_CIRCLE) if A is FlatPoint else NATIVE

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        del A, B
        return NATIVE

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        del B
        return emulated(A_THICK_SEGMENT) if A in ROUND else unsupported(ROUND_ONLY)

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer; of distances the nearest point is told of B alone."""
        del A, B
        return SAYS.get(query, frozenset())

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give rounding: nothing is searched for that has no end."""
        del A, B
        return impacts.TOLERANCE if query == IMPACT else ROUNDING

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Say what is another law of friction."""
        del A, B
        text = "friction ends the sliding after the bounce; the reference's ends that of the compression"
        return {Convention.OTHER_FRICTION: text} if query == IMPACT else {}

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 15 to 30 µs."""
        self.require(query, A, B)
        pymunk = import_pymunk()
        if query == IMPACT:
            return impacts.solver(pymunk, A, B)
        if query == RAYCAST:
            return lambda ray, b: _cast(Maker(pymunk), ray, place(B, b))
        if query == SWEEP:
            return lambda a, b: _sweep(Maker(pymunk), *moving(A, a), place(B, b))
        if query == DISTANCE:
            return lambda a, b: _distance(Maker(pymunk), place(A, a), place(B, b))
        ask = ASK[query]
        return lambda a, b: ask(Maker(pymunk), place(A, a), place(B, b))

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs pymunk alone."""
        self.require(query, A, B)
        if query == IMPACT:
            return impacts.script(A, row_a, B, row_b)
        if query == RAYCAST:
            shape = place(B, row_b)
            return cast_script((A, B), shape, *segment_of(row_a, shape))
        if query == SWEEP:
            return sweep_script((A, B), *moving(A, row_a), place(B, row_b))
        first, second = place(A, row_a), place(B, row_b)
        if query == DISTANCE:
            return distance_script((A, B), first, second)
        return contact_script(query, (A, B), first, second)


def _touching(make: Maker, a: Placed, b: Placed) -> Any:
    """What Chipmunk says of the contacts of two shapes; None where there is none."""
    try:
        return make(a).shapes_collide(make(b))
    except AssertionError:  # how pymunk tells it
        return None


def _boolean(make: Maker, a: Placed, b: Placed) -> AnswerRow:
    return answer_row(hit=float(_touching(make, a, b) is not None))


def _contacts(make: Maker, a: Placed, b: Placed) -> AnswerRow:
    found = _touching(make, a, b)
    if found is None:
        return answer_row(hit=0.0)
    deepest = min(found.points, key=lambda point: point.distance)
    return answer_row(
        hit=1.0,
        distance=deepest.distance,
        normal=(*found.normal, 0.0),
        on_a=(*deepest.point_a, 0.0),
        on_b=(*deepest.point_b, 0.0),
    )


def _distance(make: Maker, ball: Placed, other: Placed) -> AnswerRow:
    found = make(other).point_query(ball.points[0])
    x, y = found.gradient
    return answer_row(distance=found.distance - ball.radius, on_b=(*found.point, 0.0), normal=(0.0 - x, 0.0 - y, 0.0))


def segment_of(ray: Row, b: Placed) -> tuple[list[float], list[float], float]:
    """The part of a ray that ends past a shape, and the time at which it ends there."""
    (x, y), (u, v) = ray[:2], ray[2:]
    away = max(math.hypot(px - x, py - y) for px, py in b.points) + 2.0 * b.radius
    reach = 2.0 * away / math.hypot(u, v)
    return [x, y], [x + reach * u, y + reach * v], reach


def _cast(make: Maker, ray: Row, b: Placed) -> AnswerRow:
    start, end, reach = segment_of(ray, b)
    found = make(b).segment_query(start, end)
    if found is None:
        return answer_row(hit=0.0, t=math.inf)
    normal = (*found.normal, 0.0) if found.alpha > 0 else NOWHERE  # that of a start inside is none of the contract's
    return answer_row(hit=1.0, t=found.alpha * reach, point=(*found.point, 0.0), normal=normal)


def moving(kind: Kind, row: Row) -> tuple[Placed, list[float], list[float]]:
    """A round shape at its start, where its middle would end as it is seen from B, and the way of B."""
    ball = place(kind, row[:-COURSE])
    course = Course.unpack(np.array(row[-COURSE:]))
    along, own = (side.linear[:2].tolist() for side in course.sides)
    end = [x + (u - v) for x, u, v in zip(ball.points[0], along, own, strict=True)]
    return ball, end, own


def _sweep(make: Maker, ball: Placed, end: list[float], own: list[float], b: Placed) -> AnswerRow:
    found = make(b).segment_query(ball.points[0], end, ball.radius)
    if found is None:
        return answer_row(hit=0.0, t=math.inf)
    x, y = (p + found.alpha * v for p, v in zip(found.point, own, strict=True))
    u, v = found.normal
    normal = (0.0 - u, 0.0 - v, 0.0) if found.alpha > 0 else NOWHERE
    return answer_row(hit=1.0, t=found.alpha, point=(x, y, 0.0), normal=normal)


ASK: dict[str, Callable[[Maker, Placed, Placed], AnswerRow]] = {BOOLEAN: _boolean, CONTACTS: _contacts}
