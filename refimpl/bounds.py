"""Support function, bounding box and bounding sphere of every proxy.

Bounding volumes contain their proxy as exact sets: whatever is rounded is rounded outwards.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl.intervals import plus_rounded
from refimpl.linear import (
    Array,
    apply,
    apply_inverse,
    as_floats,
    cross,
    dot,
    largest,
    norm,
    power_of_two,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.proxy import Proxy, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Ray,
    Sphere,
)

SLACK = 32 * 2.0**-53  # more than a rotation matrix, a square root and a sum of three lose together


def support(shape: Proxy, n: Any) -> Array:
    """Support function h(n) = max over x in the shape of n·x.

    Parameters
    ----------
    shape : any proxy
    n : (..., 3)
        Of any length; batch shapes broadcast.

    Returns
    -------
    (...)
        Infinite where the shape is unbounded along `n`.
    """
    way = as_floats(n)
    if isinstance(shape, Ray):
        return np.where(dot(way, shape.direction) > 0, np.inf, dot(way, shape.origin))[()]
    if isinstance(shape, HalfSpace):
        along, size = dot(way, shape.normal), dot(shape.normal, shape.normal)
        parallel = np.all(cross(way, shape.normal) == 0, axis=-1) & (along >= 0)
        return np.where(parallel, -shape.k * (along / size), np.inf)[()]
    return dot(way, support_point(shape, way))[()]


def support_point(shape: Proxy, n: Any) -> Array:
    """Point of a bounded proxy that is farthest along `n` (..., 3); some such point where several are.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which have none along most directions.
    """
    way = as_floats(n)
    return np.asarray(_of(SUPPORTS, shape, "support point")(shape, way))


def aabb(shape: Proxy) -> AABB:
    """Axis-aligned bounding box: contains the proxy, and is larger than the smallest by rounding only.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which are unbounded.
    """
    bounds = _of(BOXES, shape, "bounding box")
    exponent = power_of_two(shape.magnitude)
    return AABB(*bounds(shape.times_power(-exponent))).times_power(exponent)


def bounding_sphere(shape: Proxy) -> Sphere:
    """Give a ball that contains the proxy: the smallest one for curved shapes and boxes, up to rounding.

    For polytopes it is the one about the middle of their bounding box. Around a point its radius is the least double.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which are unbounded.
    """
    ball = _of(BALLS, shape, "bounding sphere")
    exponent = power_of_two(shape.magnitude)
    center, radius = ball(shape.times_power(-exponent))
    back = np.ldexp(radius, exponent)
    return Sphere(np.ldexp(center, exponent[..., None]), np.maximum(back, np.nextafter(0.0, 1.0)))


def _of(table: dict[type[Proxy], Any], shape: Proxy, what: str) -> Callable[..., Any]:
    found: Callable[..., Any] | None = table.get(type(shape))
    if found is None:
        raise UnsupportedOperation(f"a {type(shape).__name__} has no {what}: it is unbounded")
    return found


def _support_sphere(s: Sphere, n: Array) -> Array:
    return s.center + scale(s.radius, unit_or(n, np.eye(3)[0])[0])


def _support_capsule(c: Capsule, n: Array) -> Array:
    far = np.where((dot(n, c.q - c.p) > 0)[..., None], c.q, c.p)
    return far + scale(c.radius, unit_or(n, np.eye(3)[0])[0])


def _support_aabb(b: AABB, n: Array) -> Array:
    return np.where(n > 0, b.upper, b.lower)


def _support_box(b: Box, n: Array) -> Array:
    axes = rotation_matrix(b.rotation)
    return b.center + apply(axes, np.copysign(b.half_extents, apply_inverse(axes, n)))


def _support_ellipsoid(e: Ellipsoid, n: Array) -> Array:
    """Point where the gradient of Σ (y_i / radii_i)² is along n: y_i = radii_i² n_i / |radii·n|."""
    axes = rotation_matrix(e.rotation)
    way = apply_inverse(axes, n)
    stretched = unit_or(e.radii * (way / _size(way)), np.eye(3)[0])[0]
    return e.center + apply(axes, e.radii * stretched)


def _size(v: Array) -> Array:
    size = largest(v)[..., None]
    return np.where(size > 0, size, 1.0)


def _support_cylinder(c: Cylinder, n: Array) -> Array:
    axis = unit_or(c.q - c.p, np.eye(3)[0])[0]
    way = n / _size(n)
    along = dot(way, axis)
    outward = unit_or(way - scale(along, axis), np.zeros(3))[0]
    return np.where((along > 0)[..., None], c.q, c.p) + scale(c.radius, outward)


def _farthest(vertices: Array, n: Array) -> Array:
    """Of points (..., m, 3) the first that is farthest along n (..., 3)."""
    heights = dot(vertices, n[..., None, :])
    best = np.argmax(heights, axis=-1)[..., None, None]
    full = np.broadcast_to(vertices, (*heights.shape, 3))
    return np.asarray(np.take_along_axis(full, best, axis=-2)[..., 0, :])


def _support_convex(c: ConvexPolyhedron, n: Array) -> Array:
    axes = rotation_matrix(c.rotation)
    return c.position + apply(axes, _farthest(c.hull.vertices, apply_inverse(axes, n)))


SUPPORTS: dict[type[Proxy], Callable[[Any, Array], Array]] = {
    Point: lambda p, n: np.broadcast_to(p.position, np.broadcast_shapes(p.position.shape, n.shape)),
    Sphere: _support_sphere,
    Capsule: _support_capsule,
    AABB: _support_aabb,
    Box: _support_box,
    KDOP: lambda k, n: _farthest(k.hull.vertices, n),
    Ellipsoid: _support_ellipsoid,
    Cylinder: _support_cylinder,
    ConvexPolyhedron: _support_convex,
}

Bounds = tuple[Array, Array]


def _about(middle: Array, reach: Array) -> Bounds:
    """Bounds middle ± reach, rounded outwards."""
    return plus_rounded(middle, -reach, -np.inf), plus_rounded(middle, reach, np.inf)


def _box_of_capsule(c: Capsule) -> Bounds:
    reach = c.radius[..., None]
    lower, upper = np.minimum(c.p, c.q), np.maximum(c.p, c.q)
    return _about(lower, reach)[0], _about(upper, reach)[1]


def _box_of_box(b: Box) -> Bounds:
    reach = apply(np.abs(rotation_matrix(b.rotation)), b.half_extents)
    return _about(b.center, reach + SLACK * largest(b.half_extents)[..., None])


def _box_of_ellipsoid(e: Ellipsoid) -> Bounds:
    """Reach along an axis: the length of the row of R·diag(radii)."""
    rows = rotation_matrix(e.rotation) * e.radii[..., None, :]
    return _about(e.center, norm(rows) + SLACK * largest(e.radii)[..., None])


def _box_of_cylinder(c: Cylinder) -> Bounds:
    """Reach of the end discs along an axis: radius · the sine of its angle with the cylinder's axis."""
    axis = unit_or(c.q - c.p, np.eye(3)[0])[0]
    sine = np.hypot(np.roll(axis, 1, axis=-1), np.roll(axis, 2, axis=-1))
    reach = scale(c.radius, sine + SLACK)
    return _about(np.minimum(c.p, c.q), reach)[0], _about(np.maximum(c.p, c.q), reach)[1]


def _box_of_points(points: Array, slack: Array) -> Bounds:
    """Bounds of points (..., m, 3) that lie within `slack` (...) of the true ones."""
    reach = slack[..., None]
    return _about(np.min(points, axis=-2), reach)[0], _about(np.max(points, axis=-2), reach)[1]


def _corners(c: ConvexPolyhedron) -> tuple[Array, Array]:
    """Corners in the world, and how far they may be off."""
    local = c.hull.vertices
    placed = c.position[..., None, :] + apply(rotation_matrix(c.rotation)[..., None, :, :], local)
    return placed, SLACK * (largest(c.position) + np.max(np.abs(local), axis=(-2, -1)))


BOXES: dict[type[Proxy], Callable[[Any], Bounds]] = {
    Point: lambda p: (p.position, p.position),
    Sphere: lambda s: _about(s.center, s.radius[..., None]),
    Capsule: _box_of_capsule,
    AABB: lambda b: (b.lower, b.upper),
    Box: _box_of_box,
    KDOP: lambda k: _box_of_points(k.hull.vertices, SLACK * k.magnitude),
    Ellipsoid: _box_of_ellipsoid,
    Cylinder: _box_of_cylinder,
    ConvexPolyhedron: lambda c: _box_of_points(*_corners(c)),
}


def _ball_of_points(points: Array, slack: Array) -> tuple[Array, Array]:
    """Ball about the middle of the bounding box of points that lie within `slack` of the true ones."""
    lower, upper = np.min(points, axis=-2), np.max(points, axis=-2)
    center = lower / 2 + upper / 2
    reach = np.max(norm(points - center[..., None, :]), axis=-1)
    return center, (reach + 2 * slack) * (1 + SLACK)


def _ball_of_ends(p: Array, q: Array, radius: Array, *, round_ends: bool) -> tuple[Array, Array]:
    """Ball about the middle of an axis pq around which a capsule (round ends) or a cylinder lies."""
    center = p / 2 + q / 2
    half = np.maximum(norm(p - center), norm(q - center))
    slack = 0.0 if round_ends else SLACK * largest(center)  # off the axis, the ends' rims are not equally far
    return center, (half + radius if round_ends else np.hypot(half, radius)) * (1 + SLACK) + slack


def _ball_of_aabb(b: AABB) -> tuple[Array, Array]:
    center = b.lower / 2 + b.upper / 2
    return center, norm(np.maximum(b.upper - center, center - b.lower)) * (1 + SLACK)


BALLS: dict[type[Proxy], Callable[[Any], tuple[Array, Array]]] = {
    Point: lambda p: (p.position, np.zeros(p.batch_shape)),
    Sphere: lambda s: (s.center, s.radius),
    Capsule: lambda c: _ball_of_ends(c.p, c.q, c.radius, round_ends=True),
    AABB: _ball_of_aabb,
    Box: lambda b: (b.center, norm(b.half_extents) * (1 + SLACK)),
    KDOP: lambda k: _ball_of_points(k.hull.vertices, SLACK * k.magnitude),
    Ellipsoid: lambda e: (e.center, largest(e.radii)),
    Cylinder: lambda c: _ball_of_ends(c.p, c.q, c.radius, round_ends=False),
    ConvexPolyhedron: lambda c: _ball_of_points(*_corners(c)),
}
