"""Points that overlapping proxies have in common: where a sweep that begins with an overlap has its contact."""

from __future__ import annotations

import numpy as np

from refimpl.flat import polygons
from refimpl.linear import Array
from refimpl.queries import distance
from refimpl.results import where
from refimpl.shapes import Point, Proxy

MOST_ROUNDS = 200
"""Of projections; a wedge between two faces that are nearly parallel would take more, and is left as it is by then."""


def common_points(x: Proxy, y: Proxy) -> Array:
    """One point (n, 3) of both of two convex proxies that overlap, or nearly so; with one batch axis.

    That between the witnesses of the overlap, unless it lies outside one of them, as where something thin goes through
    something wide: then what projecting it onto both by turns comes to (Bregman 1965), up to rounding.
    """
    for probe in (x, y):
        if isinstance(probe, Point):
            return np.array(probe.position)
    if x.dimension == 2:
        return polygons.common_points(x, y)
    overlap = distance(x, y)
    middle = 0.5 * (overlap.on_a + overlap.on_b)
    point = where(np.asarray(np.isfinite(middle).all(axis=-1)), middle, np.zeros_like(middle))
    rows = np.arange(len(point))
    for _ in range(MOST_ROUNDS):
        before = point[rows]
        point[rows] = _projected(_projected(before, x[rows]), y[rows])
        moved = np.abs(point[rows] - before) > 2 * np.spacing(np.abs(before))
        rows = rows[moved.any(axis=-1)]
        if not len(rows):
            break
    return point


def _projected(point: Array, solid: Proxy) -> Array:
    """The nearest point of a solid: a point inside stays."""
    nearest = distance(Point(point), solid)
    return where(nearest.distance > 0, nearest.on_b, point)
