"""Flat shapes: sets of the plane z = 0, whose vectors have two numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.boxes import Bricks
from oracles.repro.pieces.claims import Interval
from oracles.repro.pieces.exact import Vector, cross, dot, minus, number, require, root, times, vector
from oracles.repro.pieces.polytopes import Hull, Planes, Points
from oracles.repro.pieces.rays import Line
from oracles.repro.pieces.rounds import Segment
from oracles.repro.pieces.solids import Solid


class Flat(Solid):
    """A core in the plane z = 0, widened by discs of that plane: there are no other directions than its own."""

    def __init__(self, core: Solid) -> None:
        self.core, self.radius = core, core.radius

    def support(self, n: Vector, shares: Any = ()) -> Any:
        """Largest n·x over the core."""
        require(not n[2], "a direction must be one of the plane")
        return self.core.support(n, shares)

    def member(self, place: Any, widened: bool = False) -> tuple[list[Fraction], Any]:
        """Read a point of the certificate, and find how far at most it lies outside the core, or the set."""
        point, beyond = self.core.member(place, widened)
        require(not point[2], "a point must be one of the plane")
        return point, beyond

    def outside(self, x: Vector) -> Any:
        """How far a point is outside, at least."""
        return self.core.outside(x)

    def holds(self, _: Vector, __: Sequence[Vector], ___: Any) -> bool:
        """No solid lies in a plane."""
        return False


def place_of(values: Any) -> list[Fraction]:
    """Take two numbers."""
    require(len(values) == 2, f"not two numbers: {values!r}")
    return vector([*values, 0])


def flat_point(shape: Any) -> Flat:
    """{position}."""
    at = place_of(shape["position"])
    return Flat(Segment(at, at, Fraction(0)))


def flat_ray(shape: Any) -> Line:
    """{origin + t·direction : t ≥ 0}, t in units of the direction's length."""
    direction = place_of(shape["direction"])
    require(any(direction), "a ray needs a direction")
    return Line(place_of(shape["origin"]), direction)


def disc(shape: Any) -> Flat:
    """‖x − center‖ ≤ radius."""
    center = place_of(shape["center"])
    return Flat(Segment(center, center, number(shape["radius"])))


def flat_segment(shape: Any) -> Flat:
    """All points within `radius` of the segment pq."""
    return Flat(Segment(place_of(shape["p"]), place_of(shape["q"]), number(shape["radius"])))


def rectangle(shape: Any) -> Flat:
    """All x with lower ≤ x ≤ upper."""
    lower, upper = place_of(shape["lower"]), place_of(shape["upper"])
    half = times(Fraction(1, 2), minus(upper, lower))
    require(min(half) >= 0, "upper must not be below lower")
    return Flat(Bricks(minus(upper, half), [[half[0], 0, 0], [0, half[1], 0]]))


def polygon(shape: Any) -> Flat:
    """The hull of vertices, or what lies behind all lines."""
    if shape["given"] == "vertices":
        points = Points([place_of(vertex) for vertex in shape["numbers"]])
        return Flat(Hull(points, range(len(points.places))))
    lines = []
    for *normal, k in shape["numbers"]:
        require(any(normal), "a line's normal must not be 0")
        lines.append((place_of(normal), number(k)))
    return Flat(Planes(lines))


def around(claim: Any, a: Flat, b: Flat) -> Interval:
    """σ ≤ −r: a polygon of points p − q, with p in A and q in B, holds a disc of radius r around 0.

    Every edge has 0 to its left. So the closed line of the edges, seen from 0, only turns anticlockwise, and comes to
    every direction: no ray from 0 leaves the hull before it meets some edge.
    """
    require(isinstance(a, Flat) and isinstance(b, Flat), "a polygon of shapes that are not flat")
    found = [(a.member(p), b.member(q)) for p, q in claim["pairs"]]
    points = [minus(p, q) for (p, _), (q, _) in found]
    beyond = max(beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found)
    squares = []
    for i, point in enumerate(points):
        edge, area = minus(point, points[i - 1]), cross(points[i - 1], point)[2]
        require(area > 0, "0 is not to the left of an edge")
        squares.append(Fraction(area * area) / dot(edge, edge))
    upper = beyond - root(min(squares))[0] - a.radius - b.radius
    require(upper <= 0, "the points do not prove that the shapes meet")
    return -math.inf, upper
