"""Bounds on how far two proxies are apart as sets, for shapes that an engine effectively uses.

Signed distances are Lipschitz: they differ by no more than the shapes do (their Hausdorff distance, of unions that of
their parts). The bounds compare numbers, or corners; where they know nothing, they are infinite.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from oracles.growth import CORNERS
from refimpl.flat import ConvexPolygon, Disc, Rectangle, Segment
from refimpl.linear import Array, apply, norm, rotation_matrix, scale
from refimpl.shapes import (
    AABB,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Point,
    Proxy,
    Sphere,
)

ROUNDING = 2.0**-48
"""Rounding of a corner's place, relative to the largest number of its shape, with room to spare."""
MOST_PAIRS = 2000
"""More pairs of corners than this are compared in their order only."""


def apart(x: Proxy, y: Proxy) -> Array:
    """Bound, for each row, on the Hausdorff distance of two sets; on that of the parts, of composites."""
    n = len(x)
    if type(x) is type(y) and x.sizes == y.sizes and np.array_equal(x.pack(), y.pack()):
        return np.zeros(n)
    if isinstance(x, Composite) and isinstance(y, Composite) and len(x.parts) == len(y.parts):
        return np.asarray(np.max([apart(p, q) for p, q in zip(x.parts, y.parts, strict=True)], axis=0))
    if type(x) is type(y) and type(x) in _ROUND:
        return _ROUND[type(x)](x, y)
    corners = _corners(x), _corners(y)
    if corners[0] is None or corners[1] is None:
        same = type(x) is type(y) and x.sizes == y.sizes
        return np.where(np.all(x.pack() == y.pack(), axis=-1), 0.0, np.inf) if same else np.full(n, np.inf)
    return _farthest(corners[0], corners[1]) + ROUNDING * (x.magnitude + y.magnitude)


def _corners(shape: Proxy) -> Array | None:
    """Points of which a shape is the hull, (n, m, 3), or of the plane (n, m, 2)."""
    if isinstance(shape, Point):
        return shape.position[:, None, :]
    if isinstance(shape, AABB | Rectangle):
        corners = CORNERS[:, : shape.lower.shape[-1]]
        return np.where(corners > 0, shape.upper[:, None, :], shape.lower[:, None, :])
    if isinstance(shape, ConvexPolygon) and shape.given == "vertices":
        return shape.numbers
    if isinstance(shape, Box):
        return _posed(CORNERS * shape.half_extents[:, None, :], shape.center, shape.rotation)
    if isinstance(shape, ConvexPolyhedron) and shape.given == "vertices":
        return _posed(shape.numbers, shape.position, shape.rotation)
    return None


def _posed(points: Array, position: Array, rotation: Array) -> Array:
    return np.asarray(position[:, None, :] + apply(rotation_matrix(rotation)[:, None, :, :], points))


def _farthest(p: Array, q: Array) -> Array:
    """Largest distance of a point of either list from the nearest, or from the corresponding, one of the other."""
    many = p.shape[1] * q.shape[1] > MOST_PAIRS
    in_order = norm(p - q).max(axis=-1) if p.shape == q.shape else np.full(len(p), np.inf)
    if many:
        return np.asarray(in_order)
    between = norm(p[:, :, None, :] - q[:, None, :, :])
    nearest = np.maximum(between.min(axis=2).max(axis=1), between.min(axis=1).max(axis=1))
    return np.asarray(np.minimum(in_order, nearest))


def _turned_by(x: Array, y: Array) -> Array:
    """Length of the difference of two rotations' matrices: no unit vector is turned apart by more."""
    difference = rotation_matrix(x) - rotation_matrix(y)
    return np.asarray(np.sqrt((difference**2).sum(axis=(-1, -2))) + ROUNDING * np.any(x != y, axis=-1))


def _cylinders(x: Cylinder, y: Cylinder) -> Array:
    """Ends and radii apart, and the discs turned."""
    ends = np.maximum(norm(x.p - y.p), norm(x.q - y.q))
    axes = [scale(1 / norm(c.q - c.p), c.q - c.p) for c in (x, y)]
    tilt = norm(axes[0] - axes[1]) + ROUNDING * (ends > 0)
    return np.asarray(ends + np.abs(x.radius - y.radius) + tilt * np.maximum(x.radius, y.radius))


def _balls(x: Sphere | Disc, y: Sphere | Disc) -> Array:
    return np.asarray(norm(x.center - y.center) + np.abs(x.radius - y.radius))


def _capsules(x: Capsule | Segment, y: Capsule | Segment) -> Array:
    return np.asarray(np.maximum(norm(x.p - y.p), norm(x.q - y.q)) + np.abs(x.radius - y.radius))


_ROUND: dict[type[Proxy], Callable[[Any, Any], Array]] = {
    Sphere: _balls,
    Disc: _balls,
    Capsule: _capsules,
    Segment: _capsules,
    Cylinder: _cylinders,
    Ellipsoid: lambda x, y: (
        norm(x.center - y.center) + norm(x.radii - y.radii) + _turned_by(x.rotation, y.rotation) * x.radii.max(axis=-1)
    ),
}
"""Round types by their numbers."""
