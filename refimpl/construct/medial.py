"""Balls inside a solid that touch its surface twice or more: their centres are the medial axis.

From a point of the surface a ball that touches there is shrunk until nothing of the surface is inside (Ma, Bae and
Choi, 3D Medial Axis Point Approximation Using Nearest Neighbors and the Normal Field, 2012). The nearest point of the
surface is asked for exactly, so unlike the poles of a Voronoi diagram of samples (Amenta, Choi and Kolluri, The Power
Crust, 2001), each ball is inside the solid, however coarse the samples are.
"""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.surfaces import points_surface
from refimpl.construct.primitives import squared_distances
from refimpl.construct.surfaces import Samples
from refimpl.linear import Array, dot, scale
from refimpl.solids import Solid

ROUNDS = 24
ENOUGH = 1e-3  # a ball that would shrink by less than this part of its radius is the one
ROUNDED = 2.0**-46  # of the largest coordinate; more than a distance is rounded by


def medial_balls(solid: Solid, samples: Samples, size: float) -> tuple[Array, Array]:
    """Centres and radii of balls inside a solid, one for each sample whose ball is not flat.

    Parameters
    ----------
    solid : Solid
    samples : points of its surface
    size : length
        No ball is larger.
    """
    radius = np.full(len(samples.points), size / 2)
    asked = np.arange(len(radius))
    for _ in range(ROUNDS):
        center = samples.points[asked] - scale(radius[asked], samples.normals[asked])
        height, foot, _ = points_surface(solid, center)
        offset = foot - samples.points[asked]
        along = -dot(offset, samples.normals[asked])
        with np.errstate(divide="ignore", invalid="ignore"):
            smaller = np.where(along > 0, dot(offset, offset) / (2 * along), 0.0)
        shrinks = (np.abs(height) < (1 - ENOUGH) * radius[asked]) | (height > 0)
        smaller = np.minimum(smaller, (1 - ENOUGH) * radius[asked])
        radius[asked[shrinks]] = smaller[shrinks]
        asked = asked[shrinks]
        if not len(asked):
            break
    center = samples.points - scale(radius, samples.normals)
    radius = inscribed_radii(solid, center)
    kept = radius > 0
    return center[kept], radius[kept]


def inscribed_radii(solid: Solid, center: Array) -> Array:
    """Radii of the largest balls about points that are inside a solid, rounded down; not positive outside."""
    height = points_surface(solid, center)[0]
    return np.asarray(-height - ROUNDED * np.maximum(solid.extent, np.max(np.abs(center), axis=-1, initial=0.0)))


def covering(center: Array, radius: Array, points: Array, weight: Array, count: int) -> list[int]:
    """Balls that one after the other cover the most of what is left of some weighted points; indices, `count` at most.

    At least 63 % of what any choice of as many could cover (Nemhauser, Wolsey and Fisher, 1978).
    """
    inside = (squared_distances(points, center) <= radius**2).astype(np.float32)
    left = weight.astype(np.float32)
    chosen: list[int] = []
    while len(chosen) < min(count, len(radius)):
        gain = left @ inside
        best = int(np.argmax(gain))
        if gain[best] <= 0:
            rest = np.where(np.isin(np.arange(len(radius)), chosen), -1.0, radius)
            best = int(np.argmax(rest))
        chosen.append(best)
        left = left * (1 - inside[:, best])
    return chosen
