"""Rays: when they first hit a shape."""

from __future__ import annotations

import math
from typing import Any

from oracles.repro.pieces.claims import Interval, sign_of
from oracles.repro.pieces.exact import Vector, along, dot, number, require, vector
from oracles.repro.pieces.rounds import Segment
from oracles.repro.pieces.solids import Solid
from oracles.repro.pieces.unions import Union, chosen, gaps


class Line(Solid):
    """{origin + t·direction : t ≥ 0}."""

    def __init__(self, origin: Vector, direction: Vector) -> None:
        self.origin, self.direction = origin, direction

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at the origin, where the ray goes the other way."""
        require(dot(n, self.direction) <= 0, "the ray has no end in a direction")
        return dot(n, self.origin)

    def at(self, time: Any) -> list[Any]:
        """Point at a time."""
        return along(self.origin, time, self.direction)


def ray(shape: Any) -> Line:
    """{origin + t·direction : t ≥ 0}, t in units of the direction's length."""
    direction = vector(shape["direction"])
    require(any(direction), "a ray needs a direction")
    return Line(vector(shape["origin"]), direction)


def free(claim: Any, a: Union, b: Union) -> Interval:
    """Prove t ≥ `until`, or no hit at all: planes part the ray up to then from every atom of B."""
    (line,) = a.atoms
    until = claim["until"]
    time = math.inf if until is None else number(until)
    require(time >= 0, "a time before the start")
    path = line if until is None else Segment(line.origin, line.at(time), line.radius)
    for n, room, radius in gaps(claim["tree"], Union([path]), b):
        ends_there = until is not None and dot(n, line.direction) > 0  # then the end of the way may touch the plane
        gap = sign_of(room, n, radius)
        require(gap > 0 or (gap == 0 and ends_there), "the planes across n leave no gap")
    require(not b.contains(line.origin), "the ray starts inside")
    return time, math.inf


def hit(claim: Any, a: Union, b: Union) -> Interval:
    """Prove t ≤ `time`: the ray is inside then."""
    (line,), time = a.atoms, number(claim["time"])
    place = line.at(time)
    point, outside = chosen(b, claim["of_b"]).member(place if claim["p"] is None else claim["p"], True)
    require(time >= 0 and outside == 0 and list(point) == place, "the ray is not inside then")
    return -math.inf, time
