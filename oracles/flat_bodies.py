"""What a body in the making is as a flat proxy: its place, extents and turn as they are seen along the z axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from oracles import solids
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.linear import Array, scale

if TYPE_CHECKING:
    from oracles.bodies import Body
    from refimpl.shapes import Proxy

CORNERS = (4, 3, 5, 6, 8, 12)
"""How many corners polygons have; those of a batch as many as each other."""
SQUARE = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
CUTS = (0.0, 1.0, 2.0)
"""Lines that cut off corners of polygons that are given by lines."""


def flat_proxy(body: Body, kind: type[Proxy]) -> Proxy:
    """Build a flat proxy with a body's place, size and turn; its axis is the body's x axis."""
    return MADE[kind](body)


def _place(body: Body) -> Array:
    return body.place[:, :2]


def turned(body: Body, vectors: Array) -> Array:
    """Vectors (n, ..., 2) turned as the body is about the z axis; round numbers stay so in quarter turns."""
    z, w = body.rotation[:, 2], body.rotation[:, 3]
    size = z * z + w * w
    usable = size > 0
    cosine = np.where(usable, (w * w - z * z) / np.where(usable, size, 1.0), 1.0)
    sine = np.where(usable, 2.0 * z * w / np.where(usable, size, 1.0), 0.0)
    extra = (1,) * (vectors.ndim - 2)
    c, s = cosine.reshape(-1, *extra), sine.reshape(-1, *extra)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _reach(body: Body) -> Array:
    """Half the axis of a segment or ray."""
    along = np.zeros((body.draws.n, 2))
    along[:, 0] = body.extents[:, 0]
    return turned(body, along)


def _ray(body: Body) -> FlatRay:
    reach = _reach(body)
    return FlatRay(_place(body) - scale(body.back, reach), scale(body.length, reach))


def _segment(body: Body) -> Segment:
    """With a radius, or without."""
    reach, bare = _reach(body), body.draws.choice((0.0, 1.0)) == 0
    return Segment(_place(body) - reach, _place(body) + reach, np.where(bare, 0.0, body.extents[:, 1]))


def _polygon(body: Body) -> ConvexPolygon:
    """The hull of points, or a rectangle of which lines cut off corners."""
    if solids.pick(body.draws, (1.0, 0.0)):
        corners = turned(body, _corners(body) * body.extents[:, None, :2])
        return ConvexPolygon.from_vertices(_place(body)[:, None] + corners)
    normals, offsets = _lines(body)
    normals = turned(body, normals)
    middle = (normals * _place(body)[:, None]).sum(axis=-1)
    return ConvexPolygon(np.concatenate([normals, -(offsets + middle)[..., None]], axis=-1))


def _corners(body: Body) -> Array:
    """Points of a square of half side 1: round numbers, or near a circle; the first are a triangle of its corners."""
    count, n = int(solids.pick(body.draws, CORNERS)), body.draws.n
    if body.even:
        free = body.draws.choice((1.0, -1.0, 0.0, 0.5, -0.5), 2 * max(1, count - 4)).reshape(n, -1, 2)
        return np.concatenate([np.broadcast_to(SQUARE, (n, 4, 2))[:, :count], free[:, : max(0, count - 4)]], axis=1)
    share = (np.arange(count) + body.draws.uniform(0.1, 0.9, count)) / count
    angle = 2.0 * np.pi * share
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _lines(body: Body) -> tuple[Array, Array]:
    """Normals (n, m, 2) and offsets of the sides of the rectangle, and of lines that cut off corners of it."""
    cuts, n = int(solids.pick(body.draws, CUTS)), body.draws.n
    sides = np.broadcast_to(np.concatenate([np.eye(2), -np.eye(2)]), (n, 4, 2))
    way = body.draws.choice((1.0, -1.0), 4).reshape(n, 2, 2)[:, :cuts]
    slope = body.draws.choice((1.0, 2.0, 0.5), 2)[:, :cuts] if body.even else body.draws.uniform(0.3, 3.0, 2)[:, :cuts]
    normals = np.concatenate([sides, way * np.stack([np.ones_like(slope), slope], axis=-1)], axis=1)
    width = (np.abs(normals) * body.extents[:, None, :2]).sum(axis=-1)
    left = body.draws.choice((0.5, 0.75), 2) if body.even else body.draws.uniform(0.3, 0.9, 2)
    return normals, width * np.concatenate([np.ones((n, 4)), left[:, :cuts]], axis=1)


MADE: dict[type[Proxy], Callable[[Body], Proxy]] = {
    FlatPoint: lambda b: FlatPoint(_place(b)),
    FlatRay: _ray,
    Disc: lambda b: Disc(_place(b), b.extents[:, 0]),
    Segment: _segment,
    Rectangle: lambda b: Rectangle(_place(b) - b.extents[:, :2], _place(b) + b.extents[:, :2]),
    ConvexPolygon: _polygon,
}
