"""Aspect ratios: how much longer than thick proxies are, over a batch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl import flat
from refimpl.linear import Array, norm
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
    Proxy,
    Ray,
    Sphere,
)


def aspect_of(shape: Proxy) -> Array:
    """Largest extent by the smallest, (n,): 1 of what is round or has no size at all, infinite of what is flat.

    Extents are those along a proxy's own axes; of a k-DOP the widths of its slabs, of a composite those of its longest
    part. What is endless counts as 1.
    """
    return np.asarray(np.broadcast_to(ASPECTS[type(shape)](shape), shape.batch_shape))


def _ratio(most: Array, least: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(most > 0, most / least, 1.0)


def _of_extents(extents: Array) -> Array:
    return _ratio(extents.max(axis=-1), extents.min(axis=-1))


def _of_capsule(shape: Any) -> Array:
    return _ratio(norm(shape.q - shape.p) / 2 + shape.radius, shape.radius)


def _of_cylinder(shape: Any) -> Array:
    half = norm(shape.q - shape.p) / 2
    return _ratio(np.maximum(half, shape.radius), np.minimum(half, shape.radius))


def _of_hull(shape: Any) -> Array:
    """That of its geometry, which a batch may share."""
    derived = shape.derived()
    corners = derived.table.vertices
    aspects: Array = _of_extents(corners.max(axis=-2) - corners.min(axis=-2))[derived.which]
    return aspects


def _of_parts(shape: Any) -> Array:
    return np.asarray(np.max([aspect_of(part) for part in shape.parts], axis=0))


def _of_polygon(shape: Any) -> Array:
    corners = shape.outline.corners
    return _of_extents(corners.max(axis=-2) - corners.min(axis=-2))


ASPECTS: dict[type[Proxy], Callable[[Any], Array]] = {
    **dict.fromkeys((Point, Ray, HalfSpace, Sphere, flat.FlatPoint, flat.FlatRay, flat.Disc), lambda _: np.ones(())),
    Capsule: _of_capsule,
    AABB: lambda s: _of_extents(s.upper - s.lower),
    Box: lambda s: _of_extents(s.half_extents),
    KDOP: lambda s: _of_extents((s.upper - s.lower) / norm(s.directions)),
    Ellipsoid: lambda s: _of_extents(s.radii),
    Cylinder: _of_cylinder,
    ConvexPolyhedron: _of_hull,
    Polyhedron: lambda s: _of_extents(s.vertices.max(axis=0) - s.vertices.min(axis=0)),
    Composite: _of_parts,
    flat.Segment: _of_capsule,
    flat.Rectangle: lambda s: _of_extents(s.upper - s.lower),
    flat.ConvexPolygon: _of_polygon,
}
