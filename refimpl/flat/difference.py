"""The Minkowski difference of two flat proxies: a convex polygon around the origin or beside it, and a radius.

Every flat proxy is a convex polygon, a segment or a point, widened by a disc. What two of them are to each other is
what the origin is to the difference A ⊖ B = {a − b} of their cores: a convex polygon whose sides are those of A and
those of B turned over, in the order of their directions (de Berg et al., Computational Geometry, 13.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from refimpl.flat.outlines import Outline
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, Rectangle, Segment
from refimpl.linear import Array, Bools, perpendicular
from refimpl.signs import Indices

Solid: TypeAlias = Disc | Segment | Rectangle | ConvexPolygon
SIDES = np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
"""Outward normals of a rectangle's sides."""


def outline_of(shape: FlatPoint | Solid) -> Outline:
    """Outline of the cores of a batch of flat proxies: of a disc the centre, of a segment its two sides."""
    match shape:
        case FlatPoint():
            return point_outline(shape.position)
        case Disc():
            return point_outline(shape.center)
        case Segment():
            return _two_sides(shape.p, shape.q)
        case Rectangle():
            left, low, right, high = shape.lower[..., 0], shape.lower[..., 1], shape.upper[..., 0], shape.upper[..., 1]
            x, y = np.stack([left, right, right, left], axis=-1), np.stack([low, low, high, high], axis=-1)
            return Outline(np.stack([x, y], axis=-1), np.broadcast_to(SIDES, (*left.shape, 4, 2)))
    return shape.outline


def point_outline(point: Array) -> Outline:
    """Outline of points (..., 2): one corner and no side."""
    corners = point[..., None, :]
    return Outline(corners, np.zeros_like(corners))


def _two_sides(p: Array, q: Array) -> Outline:
    """Outline of segments: from the lower end to the upper one, and back."""
    step = q - p
    upwards = (step[..., 1] > 0) | ((step[..., 1] == 0) & (step[..., 0] > 0))
    low, high = np.where(upwards[..., None], p, q), np.where(upwards[..., None], q, p)
    right = np.where(np.any(step != 0, axis=-1)[..., None], -perpendicular(high - low), 0.0)
    return Outline(np.stack([low, high], axis=-2), np.stack([right, -right], axis=-2) + 0.0)


def radius_of(shape: FlatPoint | Solid) -> Array:
    """Radius of the disc by which the core is widened."""
    return shape.radius if isinstance(shape, Disc | Segment) else np.zeros(shape.batch_shape)


@dataclass(frozen=True)
class Difference:
    """Outlines of A ⊖ B, and what their sides are made of.

    Attributes
    ----------
    outline : Outline with one batch axis
        Sides that a row has less than others are of no length, at the end, with a normal of zero.
    of_a : (n, m) bool
        Whether a side is one of A; else it is one of B, turned over.
    i, j : (n, m) int
        The corners of A and of B whose difference is the side's first corner.
    """

    outline: Outline
    of_a: Bools
    i: Indices
    j: Indices


def _along(normals: Array) -> Array:
    """Numbers from 0 to 4 that grow with the direction of anticlockwise sides, from that of the x axis; inf for none.

    Only sums and quotients, so that they are the same to the last bit in any batch.
    """
    x, y = -normals[..., 1], normals[..., 0]
    size = np.abs(x) + np.abs(y)
    part = x / np.where(size > 0, size, 1.0)
    return np.where(size > 0, np.where(_rises(normals), 1.0 - part, 3.0 + part), np.inf)


def _rises(normals: Array) -> Bools:
    """Whether anticlockwise sides lead upwards, or level to the right."""
    x, y = -normals[..., 1], normals[..., 0]
    return np.asarray((y > 0) | ((y == 0) & (x > 0)))


def _taken(rows: Array, index: Any) -> Array:
    return np.take_along_axis(rows, index[..., None], axis=1)


def difference(a: Outline, b: Outline) -> Difference:
    """Merge the sides of two outlines with one batch axis by their directions.

    Both are read from the corner that starts A ⊖ B: the lowest of A, the highest of B. Then the directions of each grow
    on the way, and are made to where rounding has two sides in the other order.
    """
    many_a, many_b = a.normals.shape[1], b.normals.shape[1]
    sides_a, sides_b = (np.sum(np.any(o.normals != 0, axis=-1), axis=1)[:, None] for o in (a, b))
    first_b = np.sum(_rises(b.normals), axis=1)[:, None] % np.maximum(sides_b, 1)
    steps = np.arange(many_b)[None]
    normals_b = np.where(
        (steps < sides_b)[..., None], -_taken(b.normals, (first_b + steps) % np.maximum(sides_b, 1)), 0.0
    )
    ways = np.concatenate([np.maximum.accumulate(_along(n), axis=1) for n in (a.normals, normals_b)], axis=1)
    order = np.argsort(ways, axis=1, kind="stable")
    there = np.isfinite(np.take_along_axis(ways, order, axis=1))
    of_a = order < many_a
    from_a, from_b = there & of_a, there & ~of_a
    i = (np.cumsum(from_a, axis=1) - from_a) % np.maximum(sides_a, 1)
    j = (first_b + np.cumsum(from_b, axis=1) - from_b) % np.maximum(sides_b, 1)
    normals = _taken(np.concatenate([np.broadcast_to(a.normals, (len(order), many_a, 2)), normals_b], axis=1), order)
    return Difference(Outline(_taken(a.corners, i) - _taken(b.corners, j), normals), of_a, i, j)


def sides_of(outline: Outline) -> NDArray[np.int64]:
    """How many sides each outline (n) has."""
    return np.asarray(np.sum(np.any(outline.normals != 0, axis=-1), axis=1))
