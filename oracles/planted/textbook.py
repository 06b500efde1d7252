"""The engine: its table of pairs, and what it promises."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from importlib.metadata import version
from types import MappingProxyType
from typing import Any, ClassVar

from oracles.engine import (
    NATIVE,
    VELOCITIES,
    AnswerRow,
    Engine,
    Kind,
    Solver,
    Support,
    Tolerance,
    answer_row,
    unsupported,
)
from oracles.planted.bricks import Bricks
from oracles.planted.impacts import Impacts
from oracles.planted.rays import Hit, Line, Rays
from oracles.planted.shapes import Gap, Reading
from oracles.planted.vectors import along
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST
from refimpl.shapes import AABB, KDOP, Box, Capsule, HalfSpace, Point, Sphere

PROMISED = 1e-9
"""Relative to the scene's largest number; two orders above what was measured."""

PAIRS: Mapping[tuple[Kind, Kind], str] = MappingProxyType(
    {
        (Point, Sphere): "ball_ball",
        (Point, Capsule): "ball_rod",
        (Point, HalfSpace): "ball_plane",
        (Point, AABB): "ball_brick",
        (Point, Box): "ball_brick",
        (Sphere, Sphere): "ball_ball",
        (Sphere, Capsule): "ball_rod",
        (Sphere, HalfSpace): "ball_plane",
        (Sphere, AABB): "ball_brick",
        (Sphere, Box): "ball_brick",
        (Capsule, Capsule): "rod_rod",
        (Capsule, HalfSpace): "rod_plane",
        (Capsule, AABB): "rod_brick",
        (Capsule, Box): "rod_brick",
        (HalfSpace, AABB): "plane_brick",
        (HalfSpace, Box): "plane_brick",
        (AABB, AABB): "upright_upright",
        (AABB, Box): "brick_brick",
        (Box, Box): "brick_brick",
    }
)
"""Types to the method that answers their signed distance."""
REJECTS: Mapping[tuple[Kind, Kind], str] = MappingProxyType(
    {(AABB, Box): "upright_brick_meet", (Box, Box): "brick_brick_meet"}
)
"""Types to the method that answers only whether they meet, where there is one."""
RAYS: Mapping[Kind, str] = MappingProxyType(
    {Sphere: "ray_ball", Capsule: "ray_rod", HalfSpace: "ray_plane", AABB: "ray_brick", Box: "ray_brick"}
)
COLUMNS_OF: Mapping[str, frozenset[str]] = MappingProxyType(
    {
        DISTANCE: frozenset({"distance", "on_a", "on_b", "normal"}),
        CONTACTS: frozenset({"hit", "distance", "on_a", "on_b", "normal"}),
        BOOLEAN: frozenset({"hit"}),
        RAYCAST: frozenset({"hit", "t", "point", "normal"}),
        IMPACT: frozenset(VELOCITIES),
    }
)


class Textbook(Reading, Bricks, Rays, Impacts, Engine):
    """Closed forms, separating axes, nearest features, GJK, slabs, and the impulse of two rigid bodies."""

    name: ClassVar[str] = "textbook"

    def versions(self) -> dict[str, str]:
        """It is part of this package."""
        return {"textbook": version("proxyproof")}

    def warm(self) -> None:
        """Nothing is to be imported."""

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        written = (B in RAYS or B is KDOP) if query == RAYCAST else (A, B) in PAIRS
        return NATIVE if written else unsupported("not written")

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        del A, B
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Give the columns that an answer fills."""
        del A, B
        return COLUMNS_OF[query]

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give one bound for everything."""
        del query, A, B
        return Tolerance.uniform(0.0, PROMISED, "ties are broken at 1e-10 of the scene's size; all else is rounding")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Return a function that answers one scene."""
        self.require(query, A, B)
        if query == IMPACT:
            return lambda a, _: self.impact(a)
        if query == RAYCAST:
            return self._caster(B)
        if query == BOOLEAN and (A, B) in REJECTS:
            meet: Callable[[Any, Any], bool] = getattr(self, REJECTS[A, B])
            return lambda a, b: answer_row(hit=float(meet(self.read(A, a), self.read(B, b))))
        gap: Callable[[Any, Any], Gap] = getattr(self, PAIRS[A, B])
        tell = {DISTANCE: self.distance, CONTACTS: self.contact, BOOLEAN: self.meets}[query]
        return lambda a, b: tell(gap(self.read(A, a), self.read(B, b)))

    def _caster(self, B: Kind) -> Solver:
        if B is KDOP:
            return lambda a, b: self.told(self.line(a), self.ray_slab_polytope(self.line(a), b))
        cast: Callable[[Line, Any], Hit | None] = getattr(self, RAYS[B])
        return lambda a, b: self.told(self.line(a), cast(self.line(a), self.read(B, b)))

    # -- answers ---------------------------------------------------------------------------------------------

    def distance(self, gap: Gap) -> AnswerRow:
        """Answer a signed distance."""
        return answer_row(distance=gap.distance, on_a=gap.on_a, on_b=gap.on_b, normal=gap.normal)

    def contact(self, gap: Gap) -> AnswerRow:
        """Answer a contact, or that there is none."""
        if not self.hits(gap):
            return answer_row(hit=0.0)
        return answer_row(hit=1.0, distance=gap.distance, on_a=gap.on_a, on_b=gap.on_b, normal=gap.normal)

    def meets(self, gap: Gap) -> AnswerRow:
        """Answer yes or no."""
        return answer_row(hit=float(self.hits(gap)))

    def hits(self, gap: Gap) -> bool:
        """Whether it is a contact: touching is."""
        return gap.distance <= 0

    def told(self, ray: Line, hit: Hit | None) -> AnswerRow:
        """Answer a ray."""
        if hit is None:
            return answer_row(hit=0.0, t=math.inf)
        point = along(ray.origin, hit.way, ray.direction)
        if hit.normal is None:
            return answer_row(hit=1.0, t=0.0, point=point)
        way = max(hit.way, 0.0)  # that it starts outside has been decided by other roundings
        return answer_row(hit=1.0, t=way / ray.speed, point=point, normal=hit.normal)
