"""What each claim of a certificate proves about two convex shapes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.exact import Vector, cross, dot, length, minus, number, require, root, times, vector
from oracles.repro.pieces.inscribed import ball_in_ball
from oracles.repro.pieces.polytopes import Planes, shares_of
from oracles.repro.pieces.solids import Solid

Interval = tuple[Any, Any]


def room_along(claim: Any, a: Solid, b: Solid) -> tuple[Vector, Any]:
    """The direction n of a claim, and the room that planes across it leave between two cores, times ‖n‖."""
    n, (of_a, of_b) = vector(claim["n"]), claim["faces"]
    require(any(n), "a direction must not be 0")
    return n, -(a.support(n, shares_of(of_a)) + b.support(times(-1, n), shares_of(of_b)))


def sign_of(room: Any, n: Vector, radius: Any) -> Any:
    """Sign of room/‖n‖ − radius, without a root."""
    return room * room - radius * radius * dot(n, n) if room >= 0 else -1


def width_of(room: Any, n: Vector, radius: Any) -> Any:
    """At most room/‖n‖ − radius, by less than 2⁻¹⁵⁰ of it."""
    low, high = length(n)
    return room / (high if room > 0 else low) - radius


def separated(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ L > 0: planes across n leave a gap."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) > 0, "the planes across n leave no gap")
    return width_of(room, n, a.radius + b.radius), math.inf


def escape(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≥ −D: moving B by D along n separates the two."""
    n, room = room_along(claim, a, b)
    require(sign_of(room, n, a.radius + b.radius) <= 0, "the planes across n leave a gap")
    return width_of(room, n, a.radius + b.radius), math.inf


def near(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ ‖p − q‖, as p lies in A and q in B."""
    (p, beyond_a), (q, beyond_b) = a.member(claim["a"], True), b.member(claim["b"], True)
    return -math.inf, length(minus(p, q))[1] + beyond_a + beyond_b


def common(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ 0, as p lies in both."""
    return near({"a": claim["p"], "b": claim["p"]}, a, b)


def ball_inside(points: Sequence[Vector], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of some points.

    The triangles are a closed surface, all of which turn their inner side to 0: so it winds around 0, and no ray from
    0 leaves the hull before it meets the plane of one of them.
    """
    edges: Counter[tuple[int, int]] = Counter()
    squares = []
    for i, j, k in triangles:
        require(min(i, j, k) >= 0, "no such point")
        edges.update([(i, j), (j, k), (k, i)])
        normal = cross(minus(points[j], points[i]), minus(points[k], points[i]))
        height = dot(normal, points[i])
        require(height > 0, "a triangle does not turn its inner side to 0")
        squares.append(Fraction(height * height) / dot(normal, normal))
    require(squares and all(n == edges[j, i] for (i, j), n in list(edges.items())), "the surface is not closed")
    least: Fraction = min(squares)
    return least


def core(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ −r: a polytope of points p − q, with p in A and q in B, holds a ball of radius r around 0."""
    found = [(a.member(p), b.member(q)) for p, q in claim["pairs"]]
    points = [minus(p, q) for (p, _), (q, _) in found]
    outside = max(beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found)
    if len(points) == 1 and not claim["triangles"]:
        upper = length(points[0])[1] + outside - a.radius - b.radius
    else:
        upper = outside - root(ball_inside(points, claim["triangles"]))[0] - a.radius - b.radius
    require(upper <= 0, "the points do not prove that the shapes meet")
    return -math.inf, upper


def endless(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ = −∞: directions u − v, in which A and B have no end, surround 0."""
    ways = [[vector(way) for way in pair] for pair in claim["pairs"]]
    for solid, way in [(solid, way) for pair in ways for solid, way in zip((a, b), pair, strict=True)]:
        open_there = all(dot(n, way) <= 0 for n, _ in solid.planes) if isinstance(solid, Planes) else not any(way)
        require(open_there, "a shape ends in a direction")
    ball_inside([minus(u, v) for u, v in ways], claim["triangles"])
    return -math.inf, -math.inf


def inscribed(claim: Any, a: Solid, b: Solid) -> Interval:
    """σ ≤ −r: A and B hold ellipsoids whose difference holds the ball of radius r around 0."""
    centres, maps = [], []
    *shares, last = (number(share) for share in claim["shares"])
    for solid, place, columns, share in zip(
        (a, b), (claim["a"], claim["b"]), (claim["p"], claim["q"]), shares, strict=True
    ):
        centre, matrix = solid.member(place)[0], [vector(column) for column in columns]
        require(solid.holds(centre, matrix, share), "an ellipsoid does not lie in its shape")
        centres.append(centre)
        maps.append(matrix)
    across, radius = minus(*centres), number(claim["radius"])
    u, v, w = (minus(*columns) for columns in zip(*maps, strict=True))
    rows, volume = [cross(v, w), cross(w, u), cross(u, v)], dot(u, cross(v, w))  # of M⁻¹, times det M
    require(radius >= 0 and volume, "no ball")
    start = [-dot(row, across) / volume for row in rows]
    images = [[radius * row[axis] / volume for row in rows] for axis in range(3)]
    require(ball_in_ball(start, images, last), "the ball does not lie in the difference of the ellipsoids")
    return -math.inf, -radius - a.radius - b.radius


CLAIMS: dict[str, Any] = {
    "separated": separated,
    "escape": escape,
    "near": near,
    "common": common,
    "core": core,
    "endless": endless,
    "inscribed": inscribed,
}
