"""Regimes of sweeps: recipes for two proxies on their ways, as `oracles.regimes` has them for shapes at rest.

Most are made backwards: the two are put as they are to stand when they meet, and moved back along their ways. Each
works for every pair of solids; its docstring says why it exists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oracles.builds import aligned, generic, sliver
from oracles.course import Course, can_turn
from oracles.draws import Draws, log_uniform
from oracles.frames import FRAMES
from oracles.placements import PLACEMENTS, signed_gap
from oracles.regimes import Recipe
from oracles.world import is_flat, world_of
from refimpl import Proxy
from refimpl.linear import Array, cross, norm, scale
from refimpl.motions import RigidMotion
from refimpl.shapes import ConvexPolyhedron, Polyhedron
from refimpl.supports import support

Swept = tuple[Proxy, Proxy, Course]
SweepRegime = Callable[[Draws, type[Proxy], type[Proxy]], Swept]
SWEEP_REGIMES: dict[str, SweepRegime] = {}

TOUCHING = Recipe(generic, PLACEMENTS["touching"])
ROUND = Recipe(aligned, PLACEMENTS["touching"])
THIN = Recipe(sliver, PLACEMENTS["touching"])
FACES = Recipe(aligned, PLACEMENTS["face_on_face"])
FAR = Recipe(generic, PLACEMENTS["touching"], FRAMES["far_away"])

UPRIGHT, LEVEL = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0])
"""Of flat proxies: the way out of their plane, and what is left of vectors in it."""
TIMES = (0.5, 0.25, 0.75, 0.125)
MOST_TURN = 1.5
"""Largest coordinate of an angular velocity: no body turns by more than half a turn."""


def regime(function: SweepRegime) -> SweepRegime:
    """Register a regime, by a name of its own: other queries have regimes of the same ideas."""
    SWEEP_REGIMES[f"sweep_{function.__name__}"] = function
    return function


def sweep_reasons() -> dict[str, str]:
    """Why each regime exists: the first line of its docstring."""
    return {name: (make.__doc__ or "").strip().splitlines()[0] for name, make in SWEEP_REGIMES.items()}


@dataclass(frozen=True)
class _Meeting:
    """Two proxies as they stand when they meet; the normal points from A to B, and `length` is about their size."""

    a: Proxy
    b: Proxy
    normal: Array
    length: Array

    @classmethod
    def of(cls, draws: Draws, kinds: tuple[type[Proxy], type[Proxy]], recipe: Recipe) -> _Meeting:
        """Draw one."""
        a, b = recipe.draft(draws, *kinds).settled()
        normal = signed_gap(a, b)[1]
        world = world_of(b)
        normal = np.where(np.isfinite(normal).all(axis=-1, keepdims=True), normal, world.up)
        widths = [support(shape, normal) + support(shape, -normal) for shape in (a, b)]
        known = [np.where(np.isfinite(width), width, 0.0) for width in widths]
        length = np.maximum(*known)
        return cls(a, b, world.fill(normal), np.where(length > 0, length, 1.0))

    def aside(self, draws: Draws) -> Array:
        """Directions square to the normals, of length 1."""
        given = draws.uniform(-1.0, 1.0, 3)
        if is_flat(self.b):  # so that what is square to both lies in the plane
            given = given * UPRIGHT
        square = cross(self.normal, given)
        square = np.where(
            (norm(square) < 1e-3)[:, None],
            cross(self.normal, UPRIGHT if is_flat(self.b) else self.normal[:, [1, 2, 0]] + 0.1),
            square,
        )
        return scale(1.0 / norm(square), square)

    def back(self, time: Array, approach: Array, along: Array) -> Swept:
        """Both at the start: A comes to B by `approach` in the whole time, while B moves `along`."""
        if is_flat(self.b):
            approach, along = approach * LEVEL, along * LEVEL
        ways, world = (approach + along, along), world_of(self.b)
        a, b = (
            shape.translated(-world.vectors(scale(time, way)))
            for shape, way in zip((self.a, self.b), ways, strict=True)
        )
        return a, b, Course.translating(*ways)

    def coming(self, draws: Draws, time: Array, approach: Array) -> Swept:
        """The same with B at rest, or moving as well."""
        moving = draws.choice((0.0, 0.0, 1.0, -0.5))
        return self.back(time, approach, scale(moving * self.length, draws.uniform(-1.0, 1.0, 3)))


Kinds = tuple[type[Proxy], type[Proxy]]


def _straight(draws: Draws, kinds: Kinds, recipe: Recipe, ways: Array, time: Array) -> Swept:
    """Along the normal, by so many lengths."""
    meeting = _Meeting.of(draws, kinds, recipe)
    return meeting.coming(draws, time, scale(ways * meeting.length, meeting.normal))


@regime
def meeting(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Head on or in any direction, B at rest or moving as well: only the relative motion counts."""
    found = _Meeting.of(draws, (kind_a, kind_b), TOUCHING)
    ahead = scale(draws.choice((2.0, 1.0, 4.0)) * found.length, found.normal)
    aside = scale(draws.choice((0.0, 1.0, 1.0)) * draws.uniform(0.0, 4.0) * found.length, found.aside(draws))
    return found.coming(draws, draws.uniform(0.05, 0.95), ahead + aside)


@regime
def grazing(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Along the surface, with 1e-2 to 1e-9 of the way along the normal, or none: the time is all but free."""
    meeting = _Meeting.of(draws, (kind_a, kind_b), TOUCHING)
    share = draws.choice((1.0, 1.0, 0.0)) * log_uniform(draws, -9.0, -2.0)
    way = scale(share * meeting.length, meeting.normal) + scale(2.0 * meeting.length, meeting.aside(draws))
    return meeting.coming(draws, draws.choice(TIMES), way)


@regime
def touching_at_start(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Touching at t = 0, and moving on or apart: contact at once, whatever follows."""
    ways = draws.choice((1.0, -1.0, 0.0, 2.0))
    return _straight(draws, (kind_a, kind_b), ROUND, ways, np.zeros(draws.n))


@regime
def just_missing(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Past each other with a gap of 1e-1 to 1e-9 of the size: no contact, but nearly."""
    meeting = _Meeting.of(draws, (kind_a, kind_b), TOUCHING)
    gap = world_of(meeting.b).vectors(scale(log_uniform(draws, -9.0, -1.0) * meeting.length, meeting.normal))
    apart = _Meeting(meeting.a.translated(-gap), meeting.b, meeting.normal, meeting.length)
    return apart.coming(draws, draws.choice(TIMES), scale(3.0 * meeting.length, meeting.aside(draws)))


@regime
def fast(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Through thin shapes, by 1e2 to 1e4 times their size: whoever steps finds them on the other side."""
    ways = log_uniform(draws, 2.0, 4.0)
    return _straight(draws, (kind_a, kind_b), THIN, ways, draws.uniform(0.1, 0.9))


@regime
def far_away(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Small bodies at coordinates of 1e3 to 1e6: only relative positions should count."""
    return _straight(draws, (kind_a, kind_b), FAR, draws.choice((2.0, 1.0)), draws.choice(TIMES))


@regime
def tiny_motion(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """By 1e-3 to 1e-10 of the size: thresholds on lengths swallow the motion."""
    ways = log_uniform(draws, -10.0, -3.0)
    return _straight(draws, (kind_a, kind_b), TOUCHING, ways, draws.choice(TIMES))


@regime
def parallel_faces(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Whole faces meet squarely, in round numbers: every point of them touches at once."""
    return _straight(draws, (kind_a, kind_b), FACES, draws.choice((1.0, 2.0, 0.5)), draws.choice(TIMES))


@regime
def at_the_end(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Contact at t = 1 exactly, up to rounding: the last moment counts."""
    return _straight(draws, (kind_a, kind_b), ROUND, draws.choice((1.0, 2.0, 0.5)), np.ones(draws.n))


@regime
def overlapping(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """In each other from the start: contact at t = 0, wherever they go."""
    meeting = _Meeting.of(draws, (kind_a, kind_b), TOUCHING)
    inside = scale(draws.uniform(0.01, 0.5) * meeting.length, meeting.normal)
    deep = _Meeting(
        meeting.a.translated(world_of(meeting.b).vectors(inside)),
        meeting.b,
        meeting.normal,
        meeting.length,
    )
    return deep.coming(draws, np.zeros(draws.n), scale(meeting.length, draws.uniform(-1.0, 1.0, 3)))


def _turning(draws: Draws, swept: Swept) -> Swept:
    """The same with each side that can turn turning about its own place."""
    a, b, course = swept
    sides = []
    for shape, side in ((a, course.a), (b, course.b)):
        if not can_turn(shape):
            sides.append(side)
            continue
        free = draws.uniform(-MOST_TURN, MOST_TURN, 3)
        length = norm(side.linear)
        along = scale(draws.uniform(-2.0, 2.0) / np.where(length > 0, length, 1.0), side.linear)
        screws = (draws.choice((1.0, 1.0, 0.0)) == 1) & (length > 0)
        spins = draws.choice((1.0, 1.0, 1.0, 0.0))[:, None] * np.where(screws[:, None], along, free)
        place = shape.position if isinstance(shape, ConvexPolyhedron | Polyhedron) else shape.reference_point
        center = np.where(np.any(spins != 0, axis=-1, keepdims=True), place, 0.0)
        sides.append(RigidMotion(side.linear, spins, center))
    return a, b, Course(*sides)


@regime
def turning(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Swept:
    """Turning by up to half a turn, in place or on their way, many as screws: corners and ends come first."""
    found = _Meeting.of(draws, (kind_a, kind_b), TOUCHING)
    in_place = draws.choice((0.0, 1.0)) == 1
    gap = np.where(in_place, draws.choice((0.05, 0.01, 0.2)), 0.0)
    aside = world_of(found.b).vectors(scale(gap * found.length, found.normal))
    apart = _Meeting(found.a.translated(-aside), found.b, found.normal, found.length)
    ways = np.where(in_place, 0.0, draws.choice((2.0, 1.0)))
    along = np.where(in_place, 0.0, draws.choice((0.0, 0.5)))
    approach = scale(ways * found.length, found.normal)
    beside = scale(along * found.length, draws.uniform(-1.0, 1.0, 3))
    return _turning(draws, apart.back(draws.choice(TIMES), approach, beside))


TURNING = frozenset({"sweep_turning"})
"""Regimes in which bodies turn, which not every engine can have."""
