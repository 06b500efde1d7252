"""What the eye sees of a proxy: where it is, how large and how thin, and which directions it has."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.world import PLANE
from refimpl import Proxy, flat
from refimpl.linear import Array, apply, norm, rotation_matrix
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

NO_AXES = np.zeros((0, 3))
MOST_AXES = 64
"""Directions of a mesh that are looked at."""


@dataclass(frozen=True)
class Look:
    """A single proxy as it looks.

    Attributes
    ----------
    middle : (3,)
    size
        Largest half extent: 0 of a point, infinite of a half-space or ray.
    thin
        Smallest half extent.
    axes : (k, 3)
        Unit directions along which it is built: of an axis of symmetry, or of faces' normals.
    line
        Whether it is the same all round its only axis.
    """

    middle: Array
    size: float
    thin: float
    axes: Array
    line: bool = False


def look(shape: Proxy) -> Look:
    """Look at one proxy."""
    return LOOKS[type(shape)](shape)


def _rod(shape: Any) -> Look:
    step = shape.q - shape.p
    half, radius = float(norm(step)) / 2, float(shape.radius)
    axes = _units(step[None])
    if isinstance(shape, Capsule):
        return Look(shape.reference_point, half + radius, radius, axes, line=bool(len(axes)))
    return Look(shape.reference_point, max(half, radius), min(half, radius), axes, line=True)


def _boxed(middle: Array, halves: Array, axes: Array) -> Look:
    return Look(middle, float(halves.max()), float(halves.min()), axes)


def _ellipsoid(shape: Any) -> Look:
    distinct = [i for i in range(3) if np.count_nonzero(shape.radii == shape.radii[i]) == 1]
    axes = rotation_matrix(shape.rotation).T[distinct]
    return _boxed(shape.center, shape.radii, axes)


def _slabs(shape: Any) -> Look:
    lengths = norm(shape.directions)
    halves = (shape.upper - shape.lower) / 2 / lengths
    corners = shape.vertices
    size = float((corners.max(axis=0) - corners.min(axis=0)).max()) / 2
    return Look(shape.reference_point, size, float(halves.min()), _units(shape.directions))


def _hull(shape: Any) -> Look:
    corners, normals = shape.vertices, _units(shape.planes[:, :3])
    reach = corners @ normals.T
    halves = (reach.max(axis=0) - reach.min(axis=0)) / 2
    size = float((corners.max(axis=0) - corners.min(axis=0)).max()) / 2
    thin = min(size, float(halves.min(initial=math.inf)))
    return Look(shape.reference_point, size, thin, apply(rotation_matrix(shape.rotation), normals))


def _mesh(shape: Any) -> Look:
    corners = shape.vertices
    halves = (corners.max(axis=0) - corners.min(axis=0)) / 2
    p, q, r = (corners[shape.triangles[:MOST_AXES, i]] for i in range(3))
    normals = _units(np.cross(q - p, r - p))
    return _boxed(shape.reference_point, halves, apply(rotation_matrix(shape.rotation), normals))


def _union(shape: Any) -> Look:
    looks = [look(part) for part in shape.parts]
    middle = shape.reference_point
    size = max(float(norm(seen.middle - middle)) + seen.size for seen in looks)
    axes = np.concatenate([seen.axes for seen in looks])
    return Look(middle, size, min(seen.thin for seen in looks), axes)


def _units(directions: Array) -> Array:
    """Directions of length 1, without those of length 0."""
    largest = np.abs(directions).max(axis=-1, initial=0.0)
    scaled = directions[largest > 0] / largest[largest > 0][:, None]
    return np.asarray(scaled / norm(scaled)[:, None])


def _in_space(vectors: Array) -> Array:
    """Vectors of the plane as such of space."""
    return PLANE.fill(np.asarray(vectors))


def _segment(shape: Any) -> Look:
    half, radius = float(norm(shape.q - shape.p)) / 2, float(shape.radius)
    axes = _in_space(_units((shape.q - shape.p)[None]))
    return Look(_in_space(shape.reference_point), half + radius, radius, axes, line=bool(len(axes)))


def _rectangle(shape: Any) -> Look:
    halves = (shape.upper - shape.lower) / 2
    return _boxed(_in_space(shape.reference_point), halves, np.eye(3)[:2])


def _polygon(shape: Any) -> Look:
    corners, normals = shape.outline.corners, _units(shape.outline.normals)
    reach = corners @ normals.T
    halves = (reach.max(axis=0) - reach.min(axis=0)) / 2
    size = float((corners.max(axis=0) - corners.min(axis=0)).max()) / 2
    thin = min(size, float(halves.min(initial=math.inf)))
    return Look(_in_space(shape.reference_point), size, thin, _in_space(normals))


LOOKS: dict[type[Proxy], Callable[[Any], Look]] = {
    Point: lambda s: Look(s.position, 0.0, 0.0, NO_AXES),
    Ray: lambda s: Look(s.origin, math.inf, math.inf, _units(s.direction[None]), line=True),
    Sphere: lambda s: Look(s.center, float(s.radius), float(s.radius), NO_AXES),
    Capsule: _rod,
    HalfSpace: lambda s: Look(s.reference_point, math.inf, math.inf, _units(s.normal[None]), line=True),
    AABB: lambda s: _boxed(s.reference_point, (s.upper - s.lower) / 2, np.eye(3)),
    Box: lambda s: _boxed(s.center, s.half_extents, rotation_matrix(s.rotation).T),
    KDOP: _slabs,
    Ellipsoid: _ellipsoid,
    Cylinder: _rod,
    ConvexPolyhedron: _hull,
    Polyhedron: _mesh,
    Composite: _union,
    flat.FlatPoint: lambda s: Look(_in_space(s.position), 0.0, 0.0, NO_AXES),
    flat.FlatRay: lambda s: Look(
        _in_space(s.origin), math.inf, math.inf, _in_space(_units(s.direction[None])), line=True
    ),
    flat.Disc: lambda s: Look(_in_space(s.center), float(s.radius), float(s.radius), NO_AXES),
    flat.Segment: _segment,
    flat.Rectangle: _rectangle,
    flat.ConvexPolygon: _polygon,
}
