"""Bounding box and bounding sphere of every proxy; its support function is in `refimpl.supports`.

Bounding volumes contain their proxy as exact sets: whatever is rounded is rounded outwards.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, overload

import numpy as np

from refimpl.flat.base import Flat
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, Rectangle, Segment
from refimpl.intervals import plus_rounded
from refimpl.linear import (
    Array,
    apply,
    largest,
    norm,
    power_of_two,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.proxy import Proxy
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Point,
    Polyhedron,
    Sphere,
)
from refimpl.supports import rule_for, support, support_point

__all__ = ["aabb", "bounding_sphere", "support", "support_point"]

SLACK = 32 * 2.0**-53  # more than a rotation matrix, a square root and a sum of three lose together


@overload
def aabb(shape: Flat) -> Rectangle: ...  # type: ignore[overload-overlap]
@overload
def aabb(shape: Proxy) -> AABB: ...
def aabb(shape: Proxy) -> AABB | Rectangle:
    """Axis-aligned bounding box: contains the proxy, and is larger than the smallest by rounding only.

    That of a flat proxy is a `Rectangle`.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which are unbounded, and a composite with a half-space.
    """
    bounds = rule_for(BOXES, shape, "bounding box")
    exponent = _exponent(shape)
    kind = AABB if shape.dimension == 3 else Rectangle
    return kind(*bounds(shape.times_power(-exponent))).times_power(exponent)


@overload
def bounding_sphere(shape: Flat) -> Disc: ...  # type: ignore[overload-overlap]
@overload
def bounding_sphere(shape: Proxy) -> Sphere: ...
def bounding_sphere(shape: Proxy) -> Sphere | Disc:
    """Give a ball that contains the proxy: the smallest one for curved shapes and boxes, up to rounding.

    That of a flat proxy is a `Disc`.

    For polytopes, meshes and unions it is one about the middle of their bounding box. Around a point its radius is the
    least double.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which are unbounded, and a composite with a half-space.
    """
    ball = rule_for(BALLS, shape, "bounding sphere")
    exponent = _exponent(shape)
    center, radius = ball(shape.times_power(-exponent))
    back = np.ldexp(radius, exponent)
    kind = Sphere if shape.dimension == 3 else Disc
    return kind(np.ldexp(center, exponent[..., None]), np.maximum(back, np.nextafter(0.0, 1.0)))


def _exponent(shape: Proxy) -> Any:
    """Exponent of the power of two by which a shape is brought to about 1; meshes and unions stay as they are."""
    exponent = power_of_two(shape.magnitude)
    return np.zeros_like(exponent) if isinstance(shape, Polyhedron | Composite) else exponent


Bounds = tuple[Array, Array]


def _about(middle: Array, reach: Array) -> Bounds:
    """Bounds middle ± reach, rounded outwards."""
    return plus_rounded(middle, -reach, -np.inf), plus_rounded(middle, reach, np.inf)


def _box_of_capsule(c: Capsule | Segment) -> Bounds:
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


def _corners(shape: Any, local: Array) -> tuple[Array, Array]:
    """Corners (..., m, 3) of a shape's own frame in the world, and how far they may be off."""
    placed = shape.position[..., None, :] + apply(rotation_matrix(shape.rotation)[..., None, :, :], local)
    return placed, SLACK * (largest(shape.position) + np.max(np.abs(local), axis=(-2, -1)))


def _box_of_composite(c: Composite) -> Bounds:
    boxes = [aabb(part) for part in c.parts]
    return np.min([b.lower for b in boxes], axis=0), np.max([b.upper for b in boxes], axis=0)


BOXES: dict[type[Proxy], Callable[[Any], Bounds]] = {
    Point: lambda p: (p.position, p.position),
    Sphere: lambda s: _about(s.center, s.radius[..., None]),
    Capsule: _box_of_capsule,
    AABB: lambda b: (b.lower, b.upper),
    Box: _box_of_box,
    KDOP: lambda k: _box_of_points(k.hull.vertices, SLACK * k.magnitude),
    Ellipsoid: _box_of_ellipsoid,
    Cylinder: _box_of_cylinder,
    ConvexPolyhedron: lambda c: _box_of_points(*_corners(c, c.hull.vertices)),
    Polyhedron: lambda p: _box_of_points(*_corners(p, p.vertices)),
    Composite: _box_of_composite,
    FlatPoint: lambda p: (p.position, p.position),
    Disc: lambda s: _about(s.center, s.radius[..., None]),
    Segment: _box_of_capsule,
    Rectangle: lambda b: (b.lower, b.upper),
    ConvexPolygon: lambda p: _box_of_points(p.vertices, (p.given == "lines") * SLACK * p.magnitude),
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


def _ball_of_aabb(b: AABB | Rectangle) -> tuple[Array, Array]:
    center = b.lower / 2 + b.upper / 2
    return center, norm(np.maximum(b.upper - center, center - b.lower)) * (1 + SLACK)


def _ball_of_composite(c: Composite) -> tuple[Array, Array]:
    """Ball about the middle of the bounding box, as large as the parts' own balls need it."""
    box = aabb(c)
    center = box.lower / 2 + box.upper / 2
    balls = [bounding_sphere(part) for part in c.parts]
    return center, np.max([norm(b.center - center) + b.radius for b in balls], axis=0) * (1 + SLACK)


BALLS: dict[type[Proxy], Callable[[Any], tuple[Array, Array]]] = {
    Point: lambda p: (p.position, np.zeros(p.batch_shape)),
    Sphere: lambda s: (s.center, s.radius),
    Capsule: lambda c: _ball_of_ends(c.p, c.q, c.radius, round_ends=True),
    AABB: _ball_of_aabb,
    Box: lambda b: (b.center, norm(b.half_extents) * (1 + SLACK)),
    KDOP: lambda k: _ball_of_points(k.hull.vertices, SLACK * k.magnitude),
    Ellipsoid: lambda e: (e.center, largest(e.radii)),
    Cylinder: lambda c: _ball_of_ends(c.p, c.q, c.radius, round_ends=False),
    ConvexPolyhedron: lambda c: _ball_of_points(*_corners(c, c.hull.vertices)),
    Polyhedron: lambda p: _ball_of_points(*_corners(p, p.vertices)),
    Composite: _ball_of_composite,
    FlatPoint: lambda p: (p.position, np.zeros(p.batch_shape)),
    Disc: lambda s: (s.center, s.radius),
    Segment: lambda s: _ball_of_ends(s.p, s.q, s.radius, round_ends=True),
    Rectangle: _ball_of_aabb,
    ConvexPolygon: lambda p: _ball_of_points(p.outline.corners, SLACK * p.magnitude),
}
