"""Which points lie in a proxy, exactly: each convex proxy is where a few polynomials are at most 0.

The polynomials are those of the proxies' exact meaning: a quaternion of any length gives a rational matrix, of which
the denominator is multiplied away.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.facets import Side, sides_around
from refimpl.construct.formulas import (
    Polynomial,
    about_one,
    across,
    along,
    columns_of,
    inner,
    less,
    near_segment,
    off_slab,
    rational,
    square,
)
from refimpl.linear import Bools
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Sphere,
)

Formulas = list[Polynomial]


def contains(proxy: Proxy, points: ArrayLike) -> Bools:
    """Whether each point lies in a closed proxy; exact.

    Parameters
    ----------
    proxy : a single proxy (batch shape ()), not a ray and not a polyhedron
    points : (n, 3), finite

    Returns
    -------
    (n,) of booleans

    Raises
    ------
    UnsupportedOperation
        For a proxy of another type; a `Polyhedron` is asked by `refimpl.broadphase.SolidTree`.
    ShapeError
        For a batch of proxies, for points that are none, and for a hull of vertices of which the coordinates along one
        axis differ by more than a factor of 2^1000.
    """
    given = np.array(points, dtype=np.float64)
    if given.ndim != 2 or given.shape[1] != 3 or not np.all(np.isfinite(given)):
        raise ShapeError(f"contains: expected finite points (n, 3), got an array of shape {given.shape}")
    if proxy.batch_shape:
        raise ShapeError(f"contains: expected a single {type(proxy).__name__}, got a batch of {proxy.batch_shape}")
    if not len(given):
        return np.zeros(0, dtype=bool)
    if isinstance(proxy, Composite):
        return np.asarray(np.any([contains(part, given) for part in proxy.parts], axis=0))
    cloud = Cloud(given, float(proxy.magnitude))
    inside = np.ones(len(given), dtype=bool)
    for formula in formulas(proxy, cloud):
        inside &= cloud.not_positive(formula)
    return inside


def formulas(proxy: Proxy, cloud: Cloud) -> Formulas:
    """Polynomials, in a cloud's units, that are all at most 0 in the proxy and nowhere else."""
    if type(proxy) not in RULES:
        raise UnsupportedOperation(f"whether a {type(proxy).__name__} contains points is not decided here")
    return RULES[type(proxy)](proxy, cloud)


def _point(p: Point, c: Cloud) -> Formulas:
    return [square(rational(p.position, c), Fraction(0))]


def _sphere(s: Sphere, c: Cloud) -> Formulas:
    return [square(rational(s.center, c), c.inwards(float(s.radius)) ** 2)]


def _capsule(s: Capsule, c: Cloud) -> Formulas:
    p, q = rational(s.p, c), rational(s.q, c)
    if p == q:
        return [square(p, c.inwards(float(s.radius)) ** 2)]
    return [near_segment(p, q, c.inwards(float(s.radius)) ** 2)]


def _cylinder(s: Cylinder, c: Cloud) -> Formulas:
    p, q = rational(s.p, c), rational(s.q, c)
    way = less(q, p)
    square_radius = c.inwards(float(s.radius)) ** 2
    return [across(p, way, square_radius), *off_slab(way, inner(way, p), inner(way, q))]


def _aabb(b: AABB, c: Cloud) -> Formulas:
    lower, upper = rational(b.lower, c), rational(b.upper, c)
    axes = [[Fraction(i == j) for j in range(3)] for i in range(3)]
    return [side for axis, low, high in zip(axes, lower, upper, strict=True) for side in off_slab(axis, low, high)]


def _box(b: Box, c: Cloud) -> Formulas:
    center, half = rational(b.center, c), rational(b.half_extents, c)
    columns, size = columns_of(b.rotation)
    found = []
    for way, reach in zip(columns, half, strict=True):
        middle = sum((a * b for a, b in zip(way, center, strict=True)), Fraction(0))
        found += off_slab(way, middle - reach * size, middle + reach * size)
    return found


def _kdop(k: KDOP, c: Cloud) -> Formulas:
    lower, upper = rational(k.lower, c), rational(k.upper, c)
    found = []
    for given, low, high in zip(k.directions.tolist(), lower, upper, strict=True):
        way, size = about_one([Fraction(v) for v in given])
        found += off_slab(way, low / size, high / size)
    return found


def _half_space(h: HalfSpace, c: Cloud) -> Formulas:
    way, size = about_one([Fraction(v) for v in h.normal.tolist()])
    return [along(way, -c.inwards(float(h.k)) / size)]


def _ellipsoid(e: Ellipsoid, c: Cloud) -> Formulas:
    center, radii = rational(e.center, c), rational(e.radii, c)
    columns, size = columns_of(e.rotation)
    ways = [[v / (r * size) for v in way] for way, r in zip(columns, radii, strict=True)]
    return [across_ellipsoid(center, ways)]


def across_ellipsoid(center: Sequence[Fraction], ways: Sequence[Sequence[Fraction]]) -> Polynomial:
    """Σ (wayᵢ·(x − center))² − 1."""

    def formula(x: Sequence[Any], of: Callable[[Fraction], Any]) -> Any:
        v = [a - of(b) for a, b in zip(x, center, strict=True)]
        heights = [v[0] * of(w[0]) + v[1] * of(w[1]) + v[2] * of(w[2]) for w in ways]
        return heights[0] * heights[0] + heights[1] * heights[1] + heights[2] * heights[2] - of(Fraction(1))

    return formula


def _polytope(p: ConvexPolyhedron, c: Cloud) -> Formulas:
    """Behind all its planes: normal·Rᵀ(x − position) + k ≤ 0."""
    place = rational(p.position, c)
    columns, size = columns_of(p.rotation)
    if p.given == "planes":
        sides = [Side([Fraction(v) for v in n], c.inwards(k)) for *n, k in p.numbers.tolist()]
    else:
        sides, _ = sides_around(p.numbers, c)
    found = []
    for side in sides:
        way = [sum((side.normal[j] * columns[j][i] for j in range(3)), Fraction(0)) / size for i in range(3)]
        found += Side(way, side.k - inner(way, place), side.flat).formulas()
    return found


RULES: dict[type[Proxy], Callable[[Any, Cloud], Formulas]] = {
    Point: _point,
    Sphere: _sphere,
    Capsule: _capsule,
    AABB: _aabb,
    Box: _box,
    KDOP: _kdop,
    HalfSpace: _half_space,
    Ellipsoid: _ellipsoid,
    Cylinder: _cylinder,
    ConvexPolyhedron: _polytope,
}
