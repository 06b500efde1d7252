"""Signed heights of many points over one proxy, negative inside."""

from __future__ import annotations

import numpy as np

from refimpl.atoms import leaves
from refimpl.bounds import bounding_sphere
from refimpl.linear import Array, norm
from refimpl.proxy import Proxy
from refimpl.queries import distance
from refimpl.shapes import Point


def heights(shape: Proxy, points: Array, reach: float = np.inf) -> Array:
    """Signed distances of points from a single bounded solid; of a union, the least over its parts.

    Outside this is the distance itself. Inside a union it may be less deep than the shortest way out, and like the
    distance it is nowhere steeper than 1.

    Parameters
    ----------
    shape : Proxy
    points : (n, 3)
    reach : length
        Points that are farther outside may get any height beyond it.

    Returns
    -------
    (n,)
    """
    parts = leaves(shape)
    if len(parts) == 1:
        return np.array(distance(Point(points), parts[0]).distance)
    at_least = _below(parts, points)
    found = np.full(len(points), np.inf)
    nearest = np.argmin(at_least, axis=1)
    for first in (True, False):  # the part whose ball is nearest leaves few others to be asked
        for i, part in enumerate(parts):
            wanted = (at_least[:, i] <= np.minimum(found, reach)) & ((nearest == i) == first)
            rows = np.flatnonzero(wanted)
            if len(rows):
                found[rows] = np.minimum(found[rows], distance(Point(points[rows]), part).distance)
    return found


def _below(parts: list[Proxy], points: Array) -> Array:
    """Heights over the bounding spheres of parts, (n, k)."""
    balls = [bounding_sphere(part) for part in parts]
    return np.stack([norm(points - ball.center) - ball.radius for ball in balls], axis=1)
