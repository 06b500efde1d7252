"""When a ray is in a solid: slabs exactly, quadrics by one square root at 60 digits."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from mpmath import mp, mpf  # type: ignore[import-untyped]

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
    Polyhedron,
    Proxy,
    Ray,
    Sphere,
)
from tests.truth.bodies import frame, hull_of
from tests.truth.rationals import (
    DIGITS,
    UNIT_VECTORS,
    Vector,
    cross,
    dot,
    minus,
    number,
    plus,
    real,
    rotated,
    scaled,
    vector,
)
from tests.truth.unions import corners_of, planes_of, surrounds
from tests.truth.zonotopes import core_of

Interval = tuple[Any, Any] | None
FOREVER: tuple[Any, Any] = (0, math.inf)


def ray_interval(ray: Ray, b: Proxy) -> tuple[mpf, mpf] | None:
    """Times t ≥ 0 at which origin + t·direction lies in the solid `b`; None if there are none.

    Whether the ray hits is decided exactly, and grazing is a hit. The times are right to a relative 1e-58.
    The first is 0 exactly when the origin lies in `b`; the last is +inf when the ray stays in a half-space. Of a
    union, the first is its own, the last that of a piece: a part, or a triangle of a polyhedron.
    """
    with mp.workdps(DIGITS):
        pieces = _union_stays(vector(ray.origin), vector(ray.direction), b)
        hits = [(real(piece[0]), real(piece[1])) for piece in pieces if piece]
        return (min(first for first, _ in hits), max(last for _, last in hits)) if hits else None


def _stays(origin: Vector, d: Vector, b: Proxy) -> list[Interval]:
    """Times of the pieces of a solid, whose hull is the time in the whole."""
    match b:
        case Capsule():
            return _ray_in_capsule(origin, d, b)
        case Sphere():
            return [_ray_in_ball(minus(origin, vector(b.center)), d, number(b.radius))]
        case Ellipsoid():
            return [_ray_in_ellipsoid(origin, d, b)]
        case Cylinder():
            p, q = vector(b.p), vector(b.q)
            half = scaled(Fraction(1, 2), minus(q, p))
            return [_ray_in_cylinder(minus(origin, plus(p, half)), d, half, number(b.radius))]
    return [_ray_below(origin, d, _planes(b))]


def _union_stays(origin: Vector, d: Vector, b: Proxy) -> list[Interval]:
    """Times of the parts, or of the triangles of a polyhedron, and 0 where the ray starts within it."""
    if isinstance(b, Composite):
        return [stay for part in b.parts for stay in _union_stays(origin, d, part)]
    if not isinstance(b, Polyhedron):
        return _stays(origin, d, b)
    triangles = corners_of(b)
    on_surface = [_ray_below(origin, d, planes_of(t)) for t in triangles]
    return [*on_surface, (0, 0)] if _inside(triangles, origin) else on_surface


def _inside(triangles: list[tuple[Vector, Vector, Vector]], p: Vector) -> bool:
    """Whether a point that may lie on the surface is in the solid."""
    return any(_ray_below(p, (0, 0, 0), planes_of(t)) for t in triangles) or surrounds(triangles, p)


def _planes(b: Proxy) -> list[tuple[Vector, Fraction]]:
    """Planes (n, k) of a polytope or half-space: n·x + k ≤ 0."""
    match b:
        case HalfSpace():
            return [(vector(b.normal), number(b.k))]
        case AABB() | Box():
            center, half_axes = frame(b)
            both = [(n, h) for axis, h in half_axes for n in (axis, scaled(-1, axis))]
            return [(n, -h - dot(n, center)) for n, h in both]
        case KDOP() | ConvexPolyhedron():
            return [((x, y, z), k) for x, y, z, k in hull_of(b).planes]
    raise TypeError(f"no true ray times for {type(b).__name__}")


def _ray_below(origin: Vector, d: Vector, planes: Iterable[tuple[Vector, Fraction]]) -> Interval:
    times: Interval = FOREVER
    for n, k in planes:
        if times is not None:
            times = _at_most_0(0, Fraction(dot(n, d)) / 2, dot(n, origin) + k, times)
    return times


def _ray_in_ellipsoid(origin: Vector, d: Vector, b: Ellipsoid) -> Interval:
    """The stay in the unit ball of the frame in which the radii are 1."""
    axes = [scaled(1 / number(r), rotated(b.rotation, e)) for r, e in zip(b.radii, UNIT_VECTORS, strict=True)]
    x = minus(origin, vector(b.center))
    y, way = (tuple(dot(g, v) for g in axes) for v in (x, d))
    return _ray_in_ball(y, way, Fraction(1))  # type: ignore[arg-type]


def _ray_in_capsule(origin: Vector, d: Vector, capsule: Capsule) -> list[Interval]:
    """Stays in the two end balls and in the cylinder between them, whose hull is the stay in the capsule."""
    core = core_of(capsule)
    x = minus(origin, core.center)
    if not core.generators:
        return [_ray_in_ball(x, d, core.radius)]
    (g,) = core.generators
    balls = [_ray_in_ball(plus(x, g), d, core.radius), _ray_in_ball(minus(x, g), d, core.radius)]
    return [*balls, _ray_in_cylinder(x, d, g, core.radius)]


def _ray_in_cylinder(x: Vector, d: Vector, g: Vector, radius: Fraction) -> Interval:
    """Stay within `radius` of the axis g through 0, and between the planes through ±g."""
    between = _ray_below(x, d, [(g, -dot(g, g)), (scaled(-1, g), -dot(g, g))])
    if between is None:
        return None
    p, v = cross(g, x), cross(g, d)  # of length ‖g‖ times the distance from the axis
    return _at_most_0(dot(v, v), dot(v, p), dot(p, p) - radius**2 * dot(g, g), between)


def _ray_in_ball(x: Vector, d: Vector, radius: Fraction) -> Interval:
    return _at_most_0(dot(d, d), dot(d, x), dot(x, x) - radius**2, FOREVER)


def _at_most_0(a: Any, b: Any, c: Any, times: tuple[Any, Any]) -> Interval:
    """Part of `times` in which a t² + 2b t + c ≤ 0, for a ≥ 0; rational unless an end is a square's root."""
    first, last = times

    def f(t: Any) -> Any:
        return (a * t + 2 * b) * t + c

    if a == 0 and b == 0:
        return times if c <= 0 else None
    if a == 0:
        root = -c / (2 * b)
        low, high = (root, last) if b < 0 else (first, root)
        low, high = max(low, first), min(high, last)
        return (low, high) if low <= high else None
    if f(min(max(-b / a, first), last)) > 0:
        return None
    q = -real(b) - (1 if b > 0 else -1) * mp.sqrt(real(b * b - a * c))  # adds, so that nothing cancels
    low, high = sorted([q / real(a), real(c) / q if q else mpf(0)])
    return first if f(first) <= 0 else low, last if last < math.inf and f(last) <= 0 else high
