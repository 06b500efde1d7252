"""Larger versions of proxies: sets that contain the given one exactly, whatever is rounded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from oracles.flat_images import FLAT_FARTHEST, FLAT_GROW
from refimpl.flat import ConvexPolygon, Disc, Segment
from refimpl.linear import Array, norm, scale
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

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""Corners of a cube of half extents 1."""
SIDES = [
    triangle
    for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    for triangle in ((a, b, c), (a, c, d))
]
"""Triangles of its surface."""

ROUND = (Sphere, Capsule, Disc, Segment)
"""Types that are grown by a ball, or disc."""
ROUNDED = 1.0 + 2.0**-40
"""Room for rounding in a bound on growth."""


def _hull(c: ConvexPolyhedron, by: Array) -> Proxy:
    """Planes move outwards; vertices are joined by one more."""
    if c.given == "planes":
        planes = np.array(c.numbers)
        planes[..., 3] -= by[..., None] * norm(planes[..., :3])
        return ConvexPolyhedron(planes, c.position, c.rotation)
    more = c.numbers[..., 0, :] + scale(by, np.array([1.0, 0.25, -0.5]))
    vertices = np.concatenate([c.numbers, more[..., None, :]], axis=-2)
    return ConvexPolyhedron.from_vertices(vertices, c.position, c.rotation)


def _solid(mesh: Polyhedron, by: Array) -> Proxy:
    """The box around a mesh, in its own frame: one for the batch."""
    most = np.max(by, initial=0.0)
    low, high = mesh.vertices.min(axis=0) - most, mesh.vertices.max(axis=0) + 2.0 * most
    return Polyhedron(np.where(CORNERS > 0, high, low), SIDES, mesh.position, mesh.rotation)


GROW: dict[type[Proxy], Callable[[Any, Array], Proxy]] = {
    Sphere: lambda s, by: Sphere(s.center, s.radius + by),
    Capsule: lambda c, by: Capsule(c.p, c.q, c.radius + by),
    HalfSpace: lambda h, by: HalfSpace(h.normal, h.k - by * norm(h.normal)),
    AABB: lambda b, by: AABB(b.lower - by[..., None], b.upper + 2.0 * by[..., None]),
    Box: lambda b, by: Box(b.center, b.half_extents + by[..., None], b.rotation),
    KDOP: lambda d, by: KDOP(d.directions, d.lower - by[..., None], d.upper + by[..., None]),
    Ellipsoid: lambda e, by: Ellipsoid(e.center, e.radii + scale(by, np.array([1.0, 0.0, 0.5])), e.rotation),
    Cylinder: lambda c, by: Cylinder(c.p, c.q, c.radius + by),
    ConvexPolyhedron: _hull,
    Polyhedron: _solid,
    Composite: lambda c, by: Composite([grown(part, by) for part in c.parts]),
    **FLAT_GROW,
}

FARTHEST: dict[type[Proxy], float] = {
    HalfSpace: 1.0,
    AABB: 2.0 * 3**0.5,
    Box: 3**0.5,
    Ellipsoid: 1.25**0.5,
    Cylinder: 1.0,
    **FLAT_FARTHEST,
}
"""How far a grown proxy reaches beyond the given one, in units of the growth; rounding aside."""


def grown(shape: Proxy, by: Any) -> Proxy:
    """A proxy of the same type that contains `shape`, and may reach beyond it by `by`."""
    return GROW[type(shape)](shape, np.broadcast_to(np.asarray(by, dtype=float), shape.batch_shape))


def growth(shape: Proxy, larger: Proxy, by: Array) -> tuple[Array, Array]:
    """By how much the grown proxy's support function is larger than that of the given one: at least, and at most.

    Both are the same for round proxies, which are grown by a ball. Hulls and slabs have corners that may go anywhere.
    """
    if isinstance(shape, ROUND) and isinstance(larger, ROUND):
        exactly = larger.radius - shape.radius
        rounding = 2.0**-52 * larger.radius
        return exactly - rounding, exactly + rounding
    if isinstance(shape, Composite) and isinstance(larger, Composite):
        most = [growth(part, other, by)[1] for part, other in zip(shape.parts, larger.parts, strict=True)]
        return np.zeros(len(by)), np.asarray(np.max(most, axis=0))
    if isinstance(shape, ConvexPolyhedron | ConvexPolygon) and shape.given == "vertices":
        return np.zeros(len(by)), ROUNDED * 1.25 * by + 2.0**-50 * larger.magnitude
    far = FARTHEST.get(type(shape), np.inf)
    return np.zeros(len(by)), ROUNDED * far * by + 2.0**-50 * larger.magnitude
