"""The volume that a proxy sweeps in translation: a proxy where it is one, a support function elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.atoms import groups, leaves
from refimpl.flat.base import Flat
from refimpl.flat.difference import outline_of
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, Rectangle, Segment
from refimpl.linear import Array, apply, as_floats, cross, dot, rotation_matrix
from refimpl.motions import Translation
from refimpl.proxy import Proxy, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    HalfSpace,
    Point,
    Polyhedron,
    Ray,
    Sphere,
)
from refimpl.supports import support, support_point


@dataclass(frozen=True)
class SweptShape:
    """The set {x + t·v : x in the shape, 0 ≤ t ≤ 1}, by its support function; of a union, its hull.

    Attributes
    ----------
    shape : Proxy
    translation : Translation
    """

    shape: Proxy
    translation: Translation

    def support(self, n: Any) -> Array:
        """Support function, the largest n·x over the set: h(n) + max(0, n·v)."""
        way = as_floats(n)
        return np.asarray(support(self.shape, way) + np.maximum(dot(way, self.translation.vector), 0.0))[()]

    def support_point(self, n: Any) -> Array:
        """Point of the set that is farthest along n (..., 3)."""
        way = as_floats(n)
        ahead = dot(way, self.translation.vector)[..., None] > 0
        return support_point(self.shape, way) + np.where(ahead, self.translation.vector, 0.0)


def swept(shape: Proxy, translation: Translation) -> Proxy | SweptShape:
    """Volume that a proxy sweeps in translation.

    Parameters
    ----------
    shape : a point or solid
    translation : Translation
        Its batch shape broadcasts against the shape's.

    Returns
    -------
    Proxy or SweptShape
        Of a point a segment, as a `Capsule` of radius 0; of a sphere a `Capsule`; of a half-space a `HalfSpace`; of
        what moves along its own axes the same type; of other solids with flat faces the hull of both ends, and of
        unions the union of what the parts sweep. In the plane, of a point or disc a `Segment`, of what has sides a
        `ConvexPolygon`. Where that is no proxy, a support function. Ends are rounded.

    Raises
    ------
    UnsupportedOperation
        For a ray.
    """
    if isinstance(shape, Ray):
        raise UnsupportedOperation("a Ray sweeps a part of a plane, which is no proxy")
    batch = np.broadcast_shapes(shape.batch_shape, translation.batch_shape)
    body, way = shape.broadcast_to(batch), translation.broadcast_to(batch).vector
    made = _as_flat(body, way) if isinstance(body, Flat) else _as_proxy(body, way)
    return SweptShape(shape, translation) if made is None else made


def _as_flat(shape: Flat, way: Array) -> Proxy | None:
    """Of a point or a disc a segment; of a polygon of which any corner moves, the hull of both ends."""
    match shape:
        case FlatPoint():
            return Segment(shape.position, shape.position + way)
        case Disc():
            return Segment(shape.center, shape.center + way, shape.radius)
        case Rectangle() | ConvexPolygon():
            corners = outline_of(shape).corners
            return ConvexPolygon.from_vertices(np.concatenate([corners, corners + way[..., None, :]], axis=-2))
    return None


def _as_proxy(shape: Proxy, way: Array) -> Proxy | None:
    found: Proxy | None = None
    match shape:
        case Point():
            found = Capsule(shape.position, shape.position + way, 0.0)
        case Sphere():
            found = Capsule(shape.center, shape.center + way, shape.radius)
        case HalfSpace():
            found = HalfSpace(shape.normal, np.minimum(shape.k, shape.k - dot(shape.normal, way)))
        case Capsule() | Cylinder():
            found = _along_axis(shape, way)
        case AABB() if np.all(np.count_nonzero(way, axis=-1) <= 1):
            ends = shape.lower + way, shape.upper + way
            found = AABB(np.minimum(shape.lower, ends[0]), np.maximum(shape.upper, ends[1]))
        case AABB() | Box() | KDOP() | ConvexPolyhedron():
            found = _hull(shape, way)
        case Composite() | Polyhedron() if not shape.batch_shape:
            found = _union(shape, way)
    return found


def _along_axis(shape: Capsule | Cylinder, way: Array) -> Proxy | None:
    """The same type, if it moves along its axis."""
    axis = shape.q - shape.p
    if np.any(cross(axis, way) != 0):
        return None
    ahead = (dot(axis, way) > 0)[..., None]
    return type(shape)(np.where(ahead, shape.p, shape.p + way), np.where(ahead, shape.q + way, shape.q), shape.radius)


def _hull(shape: AABB | Box | KDOP | ConvexPolyhedron, way: Array) -> ConvexPolyhedron:
    """The hull of the corners at both ends."""
    corners = shape.vertices
    if isinstance(shape, Box | ConvexPolyhedron):
        place = shape.center if isinstance(shape, Box) else shape.position
        corners = place[..., None, :] + apply(rotation_matrix(shape.rotation)[..., None, :, :], corners)
    return ConvexPolyhedron.from_vertices(np.concatenate([corners, corners + way[..., None, :]], axis=-2))


def _union(shape: Proxy, way: Array) -> Proxy | None:
    """The union of what all parts sweep."""
    parts: list[Proxy] = []
    for group in groups(leaves(shape)):
        made = [_as_proxy(part, way) for part in (group.proxies[i] for i in range(len(group)))]
        known = [part for part in made if part is not None]
        if len(known) < len(made):
            return None
        parts += known
    return Composite(parts)
