"""Larger versions of proxies: sets that contain the given one exactly, whatever is rounded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl.linear import norm, scale
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
    Sphere,
)
from tests.solids import box


def _cylinder(c: Cylinder, by: Any) -> Proxy:
    return Cylinder(c.p, c.q, c.radius + by)


def _polyhedron(c: ConvexPolyhedron, by: Any) -> Proxy:
    """Planes move outwards; vertices are joined by one more."""
    if c.given == "planes":
        planes = np.array(c.numbers)
        planes[..., 3] -= by[..., None] * norm(planes[..., :3])
        return ConvexPolyhedron(planes, c.position, c.rotation)
    more = c.numbers[..., 0, :] + scale(by, np.array([1.0, 0.25, -0.5]))
    vertices = np.concatenate([c.numbers, more[..., None, :]], axis=-2)
    return ConvexPolyhedron.from_vertices(vertices, c.position, c.rotation)


def _solid(mesh: Polyhedron, by: Any) -> Proxy:
    """The box around a mesh, in its own frame: one for the batch."""
    most = np.max(by, initial=0.0)
    low, high = mesh.vertices.min(axis=0) - most, mesh.vertices.max(axis=0) + 2.0 * most
    corners, triangles = box()
    return Polyhedron(np.where(corners > 0, high, low), triangles, mesh.position, mesh.rotation)


GROW: dict[type[Proxy], Callable[[Any, Any], Proxy]] = {
    Sphere: lambda s, by: Sphere(s.center, s.radius + by),
    Capsule: lambda c, by: Capsule(c.p, c.q, c.radius + by),
    HalfSpace: lambda h, by: HalfSpace(h.normal, h.k - by * norm(h.normal)),
    AABB: lambda b, by: AABB(b.lower - by[..., None], b.upper + 2.0 * by[..., None]),
    Box: lambda b, by: Box(b.center, b.half_extents + by[..., None], b.rotation),
    KDOP: lambda d, by: KDOP(d.directions, d.lower - by[..., None], d.upper + by[..., None]),
    Ellipsoid: lambda e, by: Ellipsoid(e.center, e.radii + scale(by, np.array([1.0, 0.0, 0.5])), e.rotation),
    Cylinder: _cylinder,
    ConvexPolyhedron: _polyhedron,
    Polyhedron: _solid,
    Composite: lambda c, by: Composite([grown(part, by) for part in c.parts]),
}


def grown(shape: Proxy, by: Any) -> Proxy:
    """A proxy of the same type that contains `shape`, and may reach beyond it by `by`."""
    return GROW[type(shape)](shape, np.broadcast_to(np.asarray(by, dtype=float), shape.batch_shape))
