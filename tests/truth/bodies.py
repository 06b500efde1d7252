"""Every bounded convex proxy as one kind of set: the hull of points, plus an ellipsoid, plus a ball.

A polytope has corners alone, an ellipsoid is a point plus itself, a cylinder a segment plus a disk (an ellipsoid of
no height), a capsule a segment plus a ball. The support function of such a body is
max over its points of p·n, plus √(n·M n), plus radius·‖n‖, with M = 0 for polytopes; all its numbers are rational.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations, product
from typing import Any

import numpy as np
from mpmath import mp, mpf  # type: ignore[import-untyped]

from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Point,
    Proxy,
    Sphere,
)
from tests.truth.hulls import Hull, hull_of_planes, hull_of_points
from tests.truth.rationals import (
    UNIT_VECTORS,
    Matrix,
    Vector,
    applied,
    cross,
    dot,
    minus,
    number,
    opposite,
    plus,
    real,
    rotated,
    scaled,
    vector,
)


@dataclass(frozen=True)
class Body:
    """The set hull(points) ⊕ {x : √(n·M n) ≥ n·x for all n} ⊕ ball(radius), in rationals.

    Attributes
    ----------
    points
        Corners of the hull.
    edges
        Pairs (direction, a point of the edge).
    normals
        Outward normals of the hull's facets.
    ellipsoid
        M, or None for 0.
    axes
        Columns g with M = Σ g gᵀ, in doubles: good for a search, and for nothing else.
    tips
        Directions n with M n = 0, where the support function of a disk has a kink.
    """

    points: tuple[Vector, ...]
    edges: tuple[tuple[Vector, Vector], ...] = ()
    normals: tuple[Vector, ...] = ()
    ellipsoid: Matrix | None = None
    axes: tuple[tuple[float, ...], ...] = ()
    tips: tuple[Vector, ...] = ()
    radius: Fraction = Fraction(0)

    def support(self, n: Any) -> mpf:
        """Support function without the radius, at the working precision; `n` in mpf or exact."""
        farthest = max(dot(p, n) for p in self.points_for(n))
        return real(farthest) + self.bulge(n)

    def points_for(self, n: Any) -> Any:
        """The points in the arithmetic of `n`: exact ones for an exact direction."""
        exact = isinstance(n[0], int | Fraction)
        return self.points if exact else tuple(tuple(real(x) for x in p) for p in self.points)

    def bulge(self, n: Any) -> mpf:
        """√(n·M n)."""
        if self.ellipsoid is None:
            return mpf(0)
        if isinstance(n[0], int | Fraction):
            return mp.sqrt(real(dot(n, applied(self.ellipsoid, n))))
        M = tuple(tuple(real(x) for x in row) for row in self.ellipsoid)
        return mp.sqrt(max(dot(n, applied(M, n)), mpf(0)))  # type: ignore[arg-type]


def body_of(shape: Proxy) -> Body:
    """The body that the stored doubles of a single proxy mean, exactly."""
    make = BODIES.get(type(shape))
    if make is None:
        raise TypeError(f"no body for {type(shape).__name__}")
    return make(shape)


def frame(shape: AABB | Box) -> tuple[Vector, list[tuple[Vector, Fraction]]]:
    """Centre of a box, and its three unit axes with their half extents."""
    if isinstance(shape, Box):
        turned = [rotated(shape.rotation, e) for e in UNIT_VECTORS]
        return vector(shape.center), list(zip(turned, vector(shape.half_extents), strict=True))
    lower, upper = vector(shape.lower), vector(shape.upper)
    half = scaled(Fraction(1, 2), minus(upper, lower))
    return plus(lower, half), list(zip(UNIT_VECTORS, half, strict=True))


def hull_of(shape: Proxy) -> Hull:
    """Corners, edges and planes of a polytope, where it stands."""
    match shape:
        case KDOP():
            return _kdop(shape.directions.tobytes(), shape.lower.tobytes(), shape.upper.tobytes())
        case ConvexPolyhedron():
            given = shape.numbers
            local = _local(shape.given, given.tobytes())
            return _placed(local, shape.position, shape.rotation)
    raise TypeError(f"no hull for {type(shape).__name__}")


def _segment(p: Vector, q: Vector, radius: Fraction) -> Body:
    if p == q:
        return Body((p,), radius=radius)
    return Body((p, q), ((minus(q, p), p),), radius=radius)


def _parallelepiped(center: Vector, axes: list[tuple[Vector, Fraction]]) -> Body:
    spans = [scaled(h, axis) for axis, h in axes if h]
    corners = []
    for signs in product((-1, 1), repeat=len(spans)):
        corner = center
        for sign, span in zip(signs, spans, strict=True):
            corner = plus(corner, scaled(sign, span))
        corners.append((signs, corner))
    edges = [(spans[i], corner) for signs, corner in corners for i, sign in enumerate(signs) if sign < 0]
    normals = [cross(u, v) for u, v in combinations(spans, 2)]
    both = tuple(n for normal in normals for n in (normal, opposite(normal)))
    return Body(tuple(corner for _, corner in corners), tuple(edges), both)


def _ellipsoid(shape: Ellipsoid) -> Body:
    turned = [rotated(shape.rotation, e) for e in UNIT_VECTORS]
    spans = [scaled(number(r), axis) for r, axis in zip(shape.radii, turned, strict=True)]
    M = tuple(tuple(sum(g[i] * g[j] for g in spans) for j in range(3)) for i in range(3))
    columns = tuple(tuple(float(x) for x in g) for g in spans)
    return Body((vector(shape.center),), ellipsoid=M, axes=columns)  # type: ignore[arg-type]


def _cylinder(p: Vector, q: Vector, radius: Fraction) -> Body:
    d = minus(q, p)
    square = dot(d, d)
    M = tuple(
        tuple(radius**2 * ((1 if i == j else 0) - Fraction(d[i] * d[j]) / square) for j in range(3)) for i in range(3)
    )
    largest = max(abs(x) for x in d)
    u = np.array([float(x / largest) for x in d])
    u /= np.linalg.norm(u)
    v = np.cross(np.eye(3)[np.argmin(np.abs(u))], u)
    v /= np.linalg.norm(v)
    w = np.cross(u, v)
    columns = (tuple((float(radius) * v).tolist()), tuple((float(radius) * w).tolist()))
    return Body((p, q), ((d, p),), (), M, columns, (d, opposite(d)))  # type: ignore[arg-type]


def _polytope(hull: Hull) -> Body:
    edges = tuple((minus(hull.corners[j], hull.corners[i]), hull.corners[i]) for i, j in hull.edges)
    return Body(hull.corners, edges, tuple(plane[:3] for plane in hull.planes))


@cache
def _kdop(directions: bytes, lower: bytes, upper: bytes) -> Hull:
    ways = [vector(d) for d in np.frombuffer(directions).reshape(-1, 3)]
    lows, highs = ([number(x) for x in np.frombuffer(ends)] for ends in (lower, upper))
    above = [(*d, -high) for d, high in zip(ways, highs, strict=True)]
    below = [(*opposite(d), low) for d, low in zip(ways, lows, strict=True)]
    return hull_of_planes(above + below)


@cache
def _local(given: str, numbers: bytes) -> Hull:
    """Hull of a geometry in its own frame: cached, for one geometry stands in many places."""
    if given == "planes":
        rows = np.frombuffer(numbers).reshape(-1, 4)
        return hull_of_planes((*vector(row[:3]), number(row[3])) for row in rows)
    return hull_of_points(vector(v) for v in np.frombuffer(numbers).reshape(-1, 3))


def _placed(hull: Hull, position: Any, rotation: Any) -> Hull:
    place = vector(position)
    turn = [rotated(rotation, e) for e in UNIT_VECTORS]

    def turned(v: Vector) -> Vector:
        return plus(plus(scaled(v[0], turn[0]), scaled(v[1], turn[1])), scaled(v[2], turn[2]))

    planes = []
    for *n, k in hull.planes:
        normal = turned((n[0], n[1], n[2]))
        planes.append((*normal, k - dot(normal, place)))
    return Hull(tuple(plus(turned(c), place) for c in hull.corners), hull.edges, tuple(planes))


BODIES: dict[type[Proxy], Callable[[Any], Body]] = {
    Point: lambda x: Body((vector(x.position),)),
    Sphere: lambda s: Body((vector(s.center),), radius=number(s.radius)),
    Capsule: lambda c: _segment(vector(c.p), vector(c.q), number(c.radius)),
    AABB: lambda b: _parallelepiped(*frame(b)),
    Box: lambda b: _parallelepiped(*frame(b)),
    Ellipsoid: _ellipsoid,
    Cylinder: lambda c: _cylinder(vector(c.p), vector(c.q), number(c.radius)),
    KDOP: lambda d: _polytope(hull_of(d)),
    ConvexPolyhedron: lambda c: _polytope(hull_of(c)),
}
