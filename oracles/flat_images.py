"""Images of flat proxies, and larger ones, for `oracles.images` and `oracles.growth`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.linear import Array, norm, scale
from refimpl.shapes import Proxy

if TYPE_CHECKING:
    from oracles.images import Axes


def _turned_rectangle(axes: Axes, r: Rectangle) -> Proxy:
    ends = axes.places(r.lower), axes.places(r.upper)
    return Rectangle(np.minimum(*ends), np.maximum(*ends))


def _turned_polygon(axes: Axes, c: ConvexPolygon) -> Proxy:
    vectors = axes.places(c.numbers[..., :2])
    return c._validated(np.concatenate([vectors, c.numbers[..., 2:]], axis=-1))


FLAT_TURN: dict[type[Proxy], Callable[[Axes, Any], Proxy]] = {
    FlatPoint: lambda m, s: FlatPoint(m.places(s.position)),
    FlatRay: lambda m, s: FlatRay(m.places(s.origin), m.places(s.direction)),
    Disc: lambda m, s: Disc(m.places(s.center), s.radius),
    Segment: lambda m, s: Segment(m.places(s.p), m.places(s.q), s.radius),
    Rectangle: _turned_rectangle,
    ConvexPolygon: _turned_polygon,
}
"""Images under isometries that keep the plane."""


def _reversed(c: ConvexPolygon) -> Proxy:
    """Vertices in the opposite order, or lines, of longer normals."""
    return c._validated(c.numbers[..., ::-1, :] * (2.0 if c.given == "lines" else 1.0))


FLAT_REWRITE: dict[type[Proxy], Callable[[Any], Proxy]] = {
    Segment: lambda s: Segment(s.q, s.p, s.radius),
    ConvexPolygon: _reversed,
}
"""The same sets in other numbers."""


def _grown_polygon(c: ConvexPolygon, by: Array) -> Proxy:
    """Lines move outwards; vertices are joined by one more."""
    if c.given == "lines":
        lines = np.array(c.numbers)
        lines[..., 2] -= by[..., None] * norm(lines[..., :2])
        return ConvexPolygon(lines)
    more = c.numbers[..., 0, :] + scale(by, np.array([1.0, 0.25]))
    return ConvexPolygon.from_vertices(np.concatenate([c.numbers, more[..., None, :]], axis=-2))


FLAT_GROW: dict[type[Proxy], Callable[[Any, Array], Proxy]] = {
    Disc: lambda s, by: Disc(s.center, s.radius + by),
    Segment: lambda s, by: Segment(s.p, s.q, s.radius + by),
    Rectangle: lambda b, by: Rectangle(b.lower - by[..., None], b.upper + 2.0 * by[..., None]),
    ConvexPolygon: _grown_polygon,
}
FLAT_FARTHEST: dict[type[Proxy], float] = {Rectangle: 2.0 * 2**0.5}
