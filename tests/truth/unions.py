"""Unions: composites by their parts, polyhedra by their triangles, and by whether these surround a point.

Apart, the signed distance of unions is the least over the pairs of their pieces. A solid that holds another, or has no
point of its surface in it, is found by counting how often a ray from a point meets its triangles, in exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mpf  # type: ignore[import-untyped]

from refimpl.shapes import Composite, HalfSpace, Polyhedron, Proxy
from tests.truth.bodies import Body, body_of
from tests.truth.rationals import Vector, cross, dot, minus, opposite, plus, rotated, scaled, vector

Piece = Body | HalfSpace


def pieces_of(shape: Proxy) -> list[Piece]:
    """Convex pieces whose union is a shape, but for the inside of a polyhedron: parts, and triangles."""
    if isinstance(shape, HalfSpace):
        return [shape]
    if isinstance(shape, Composite):
        return [piece for part in shape.parts for piece in pieces_of(part)]
    if isinstance(shape, Polyhedron):
        return [triangle(*corners) for corners in corners_of(shape)]
    return [body_of(shape)]


def triangle(p: Vector, q: Vector, r: Vector) -> Body:
    """A triangle as a body of no thickness."""
    normal = cross(minus(q, p), minus(r, p))
    edges = ((minus(q, p), p), (minus(r, q), q), (minus(p, r), r))
    return Body((p, q, r), edges, (normal, opposite(normal)))


def planes_of(t: tuple[Vector, Vector, Vector]) -> list[tuple[Vector, Any]]:
    """Planes (n, k) around a triangle: both sides of its own, and one through each edge."""
    normal = cross(minus(t[1], t[0]), minus(t[2], t[0]))
    level = -dot(normal, t[0])
    planes = [(normal, level), (opposite(normal), -level)]
    for i in range(3):
        outward = cross(minus(t[(i + 1) % 3], t[i]), normal)
        planes.append((outward, -dot(outward, t[i])))
    return planes


def corners_of(shape: Polyhedron) -> list[tuple[Vector, Vector, Vector]]:
    """Exact corners of a polyhedron's triangles, where it stands."""
    turn = [rotated(shape.rotation, e) for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    place = vector(shape.position)
    placed = []
    for v in np.asarray(shape.vertices):
        x, y, z = vector(v)
        turned = plus(plus(scaled(x, turn[0]), scaled(y, turn[1])), scaled(z, turn[2]))
        placed.append(plus(turned, place))
    return [(placed[i], placed[j], placed[k]) for i, j, k in np.asarray(shape.triangles).tolist()]


def solids_of(shape: Proxy) -> list[list[tuple[Vector, Vector, Vector]]]:
    """Triangles of every polyhedron in a shape."""
    if isinstance(shape, Composite):
        return [solid for part in shape.parts for solid in solids_of(part)]
    return [corners_of(shape)] if isinstance(shape, Polyhedron) else []


def union_distance(a: Proxy, b: Proxy, between: Callable[[Piece, Piece], mpf]) -> mpf:
    """Signed distance of unions that are apart; where they overlap, an upper bound: minus the deepest pair, or 0.

    Parameters
    ----------
    between
        Signed distance of two convex pieces.
    """
    least = mpf("inf")
    for p, q in _nearest_first(pieces_of(a), pieces_of(b)):
        if _apart(p, q) > least:
            break
        least = min(least, between(p, q))
    if least > 0 and (_swallows(a, b) or _swallows(b, a)):
        return mpf(0)
    return least


def _nearest_first(left: list[Piece], right: list[Piece]) -> Iterator[tuple[Piece, Piece]]:
    pairs = [(p, q) for p in left for q in right]
    return iter(sorted(pairs, key=lambda pair: _apart(*pair)))


def _apart(p: Piece, q: Piece) -> float:
    """Lower bound of a distance: that of balls around the pieces, less rounding; −inf for half-spaces."""
    if isinstance(p, HalfSpace) or isinstance(q, HalfSpace):
        return -float("inf")
    (c, r), (d, s) = _ball(p), _ball(q)
    size = max(float(np.abs(c).max()), float(np.abs(d).max()), r, s)
    return float(np.linalg.norm(c - d)) - r - s - 1e-12 * size


def _ball(body: Body) -> tuple[Any, float]:
    points = np.array([[float(x) for x in p] for p in body.points])
    center = points.mean(axis=0)
    bulge = sum(float(np.linalg.norm(g)) for g in body.axes)
    return center, float(np.linalg.norm(points - center, axis=1).max()) + bulge + float(body.radius)


def _swallows(outer: Proxy, inner: Proxy) -> bool:
    """Whether a polyhedron of `outer` holds a point of a piece of `inner`, their surfaces being apart."""
    points = [piece.points[0] for piece in pieces_of(inner) if isinstance(piece, Body)]
    return any(surrounds(solid, p) for solid in solids_of(outer) for p in points)


def surrounds(triangles: list[tuple[Vector, Vector, Vector]], p: Vector) -> bool:
    """Whether a closed surface surrounds a point that is not on it: a ray meets an odd number of triangles."""
    for way in ((3, 5, 7), (-7, 3, 5), (5, -7, 3), (11, 2, -5), (2, 13, 3)):
        crossings = [_crossing(t, p, way) for t in triangles]
        if None not in crossings:
            return sum(map(int, crossings)) % 2 == 1  # type: ignore[arg-type]
    raise AssertionError("every ray tried meets an edge")


def _crossing(t: tuple[Vector, Vector, Vector], p: Vector, way: Vector) -> bool | None:
    """Whether the ray p + s·way, s > 0, goes through a triangle; None when it meets its edge or runs in its plane."""
    normal = cross(minus(t[1], t[0]), minus(t[2], t[0]))
    height, speed = dot(normal, minus(t[0], p)), dot(normal, way)
    if speed == 0:
        return None if height == 0 else False
    time = Fraction(height) / speed
    if time <= 0:  # behind, or at the start, which is not on the surface
        return False
    x = plus(p, scaled(time, way))
    inside = [dot(normal, cross(minus(t[(i + 1) % 3], t[i]), minus(x, t[i]))) for i in range(3)]
    if min(inside) < 0:
        return False
    return None if min(inside) == 0 else True
