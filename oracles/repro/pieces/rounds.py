"""Points, spheres and capsules."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from oracles.repro.pieces.exact import Vector, along, dot, minus, number, vector
from oracles.repro.pieces.solids import Solid


class Segment(Solid):
    """All points within `radius` of the segment from p to q: a point or ball, where these are one."""

    def __init__(self, p: Vector, q: Vector, radius: Fraction) -> None:
        self.p, self.q, self.radius = p, q, radius
        self.centre = along(p, Fraction(1, 2), minus(q, p))

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x over the segment."""
        return max(dot(n, self.p), dot(n, self.q))

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point from the segment."""
        way = minus(self.q, self.p)
        t = min(max(dot(minus(x, self.p), way) / dot(way, way), 0), 1) if any(way) else 0
        rest = minus(x, along(self.p, t, way))
        return dot(rest, rest)

    def local(self, way: Vector) -> tuple[list[list[Any]], list[Any]]:
        """A way in shares of the half segment, and what is left of it."""
        half = minus(self.q, self.centre)
        if not any(half):
            return [], list(way)
        t = dot(way, half) / dot(half, half)
        return [[t]], along(way, -t, half)


def point(shape: Any) -> Segment:
    """{position}."""
    place = vector(shape["position"])
    return Segment(place, place, Fraction(0))


def sphere(shape: Any) -> Segment:
    """‖x − center‖ ≤ radius."""
    center = vector(shape["center"])
    return Segment(center, center, number(shape["radius"]))


def capsule(shape: Any) -> Segment:
    """All points within `radius` of the segment pq."""
    return Segment(vector(shape["p"]), vector(shape["q"]), number(shape["radius"]))
