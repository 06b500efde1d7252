"""Support functions: how far a proxy reaches along a direction, and its point that reaches farthest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl.flat.difference import outline_of, radius_of
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, Rectangle, Segment
from refimpl.linear import (
    Array,
    apply,
    apply_inverse,
    as_floats,
    cross,
    dot,
    largest,
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
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
)


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
    return np.asarray(rule_for(SUPPORTS, shape, "support point")(shape, way))


def rule_for(table: dict[type[Proxy], Any], shape: Proxy, what: str) -> Callable[..., Any]:
    """Entry of a table by type; a type without one is unbounded."""
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
    outward = way
    for _ in range(4):  # what rounding leaves of a direction along the axis may itself lie along the axis
        outward = unit_or(outward - scale(dot(outward, axis), axis), np.zeros(3))[0]
    return np.where((along > 0)[..., None], c.q, c.p) + scale(c.radius, outward)


def _farthest(vertices: Array, n: Array) -> Array:
    """Of points (..., m, 3) the first that is farthest along n (..., 3)."""
    heights = dot(vertices, n[..., None, :])
    best = np.argmax(heights, axis=-1)[..., None, None]
    full = np.broadcast_to(vertices, (*heights.shape, vertices.shape[-1]))
    return np.asarray(np.take_along_axis(full, best, axis=-2)[..., 0, :])


def _placed(shape: Any, point: Array) -> Array:
    """Bring a point of a shape's own frame into the world."""
    return np.asarray(shape.position + apply(rotation_matrix(shape.rotation), point))


def _support_convex(c: ConvexPolyhedron, n: Array) -> Array:
    return _placed(c, _farthest(c.hull.vertices, apply_inverse(rotation_matrix(c.rotation), n)))


def _support_polyhedron(p: Polyhedron, n: Array) -> Array:
    return _placed(p, _farthest(p.vertices, apply_inverse(rotation_matrix(p.rotation), n)))


def _support_composite(c: Composite, n: Array) -> Array:
    """Farthest of the parts' support points."""
    points = np.stack([support_point(part, n) for part in c.parts], axis=-2)
    return _farthest(points, n)


def _support_flat(shape: Any, n: Array) -> Array:
    """Farthest corner of a flat proxy's outline, and from there as far as the radius."""
    corners, radius = outline_of(shape).corners, radius_of(shape)
    return _farthest(corners, n) + scale(radius, unit_or(n, np.eye(2)[0])[0])


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
    Polyhedron: _support_polyhedron,
    Composite: _support_composite,
    FlatPoint: _support_flat,
    Disc: _support_flat,
    Segment: _support_flat,
    Rectangle: _support_flat,
    ConvexPolygon: _support_flat,
}
