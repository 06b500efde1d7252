"""Where a ray first enters a polytope given by planes or vertices, in exact rational arithmetic.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

from refimpl.proof.bodies import Corners
from refimpl.proof.convex import exact_nearest
from refimpl.proof.planes import Planes
from refimpl.proof.points import AXES, ZERO, Vector, along, cross, dot, minus, opposite
from refimpl.proof.rays import Hit, Miss, moment


def planes(origin: Vector, way: Vector, solid: Planes) -> Hit | Miss:
    """Last entry behind a plane, if it comes before the first exit (Cyrus and Beck 1978)."""
    entry, inwards, rate_in = Fraction(0), ZERO, Fraction(0)
    leave: tuple[Fraction, Vector, Fraction] | None = None
    for normal, k in zip(solid.normals(), solid.levels(), strict=True):
        height, rate = dot(normal, origin) + k, dot(normal, way)
        if height > 0 and rate >= 0:
            return Miss(opposite(normal))
        if rate < 0 and -height / rate > entry:
            entry, inwards, rate_in = -height / rate, opposite(normal), -rate
        if rate > 0 and (leave is None or -height / rate < leave[0]):
            leave = -height / rate, normal, rate
    if leave is not None and entry > leave[0]:  # the planes of entry and exit meet beside the ray
        return Miss(along(along(ZERO, leave[2], inwards), -rate_in, leave[1]))
    return moment(entry, inwards)


def hull(origin: Vector, way: Vector, solid: Corners) -> Hit | Miss:
    """First entry into a hull of vertices.

    It lies in the hull of up to three vertices whose plane has all others behind it. The search keeps the vertices
    that matter: those that carry some point of the ray in the hull, and any that lies before the plane found so far.
    """
    start = Corners([origin])
    if not any(exact_nearest(start, solid)[0].normal):
        return moment(Fraction(0), ZERO)
    ahead = solid.corner(solid.farthest(way))
    reach = max(Fraction(0), Fraction(dot(minus(ahead, origin), way)) / dot(way, way))
    found, (_, mix) = exact_nearest(Corners([origin, along(origin, reach, way)]), solid)
    if any(found.normal):
        return Miss(found.normal)
    chosen = [i for i, _ in mix]
    chosen += {solid.farthest(n) for n in (opposite(way), way, *AXES)} - set(chosen)
    while True:
        time, normal, _ = entry([minus(solid.corner(i), origin) for i in chosen], way)
        lowest = solid.farthest(opposite(normal))
        if dot(normal, minus(solid.corner(lowest), origin)) >= time * dot(normal, way):
            return moment(time, normal)
        chosen.append(lowest)


def entry(points: Sequence[Vector], way: Vector) -> tuple[Fraction, Vector, Sequence[Vector]]:
    """Time when the line from 0 enters the hull of a few points, the normal of a plane that has all of them behind.

    And the points of that plane in whose hull the line enters, one to three.
    """
    for size in (1, 2, 3):
        for carriers in combinations(points, size):
            normal = _plane(carriers, way)
            if any(normal) and all(dot(normal, minus(p, carriers[0])) >= 0 for p in points):
                return Fraction(dot(normal, carriers[0])) / dot(normal, way), normal, carriers
    raise AssertionError("the line meets the hull of these points")


def shares_of(points: Sequence[Vector], way: Vector) -> Sequence[Any]:
    """Weights of one to three points whose mean is where the line along `way` through 0 meets their hull."""
    aside = [cross(p, way) for p in points]
    match points:
        case [_]:
            return (1,)
        case [_, _]:  # on opposite sides of the line, or on it
            u, v = (max(abs(c) for c in side) for side in aside)
            return (v, u) if u or v else (1, 0)
        case [u, v, w]:
            sides = dot(w, aside[1]), dot(u, aside[2]), dot(v, aside[0])
            return [abs(side) for side in sides]
    raise AssertionError("one to three points")


def _plane(points: Sequence[Vector], way: Vector) -> Vector:
    """Normal, along the ray, of a plane through points whose hull the ray's line crosses; zero if it does not."""
    aside = [cross(p, way) for p in points]
    match points:
        case [_]:
            return way if not any(aside[0]) else ZERO
        case [u, v]:
            edge = minus(v, u)
            if any(cross(*aside)) or dot(*aside) > 0 or not any(cross(edge, way)):
                return ZERO
            square, rate = dot(edge, edge), dot(way, edge)
            return minus(
                (square * way[0], square * way[1], square * way[2]), (rate * edge[0], rate * edge[1], rate * edge[2])
            )
        case [u, v, w]:
            normal = cross(minus(v, u), minus(w, u))
            sides = [dot(w, aside[1]), dot(u, aside[2]), dot(v, aside[0])]  # of the line seen from each edge
            if dot(normal, way) == 0 or not (min(sides) >= 0 or max(sides) <= 0):
                return ZERO
            return normal if dot(normal, way) > 0 else opposite(normal)
    raise AssertionError("one to three points")
