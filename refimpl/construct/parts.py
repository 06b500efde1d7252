"""The inside of a solid, split into parts that are nearly boxes.

The root of the determinant of a part's covariance is, up to a factor, the volume of the box or ellipsoid that has its
moments. So that the parts are full, the solid is split, part by part, by the planes across principal and coordinate
axes that lower the sum of these volumes most. (Splitting at planes across principal axes builds trees of oriented boxes
in Gottschalk, Lin and Manocha, OBBTree, 1996; here the best of all planes is taken.)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array, scale

FEWEST = 8  # points that may be a part


class Part(NamedTuple):
    """Points of a part with their volumes, and the best way to split it: gain, and which points come first."""

    points: Array
    weight: Array
    gain: float
    first: NDArray[np.bool_]


def split(points: Array, weight: Array, count: int) -> list[tuple[Array, Array]]:
    """Split weighted points into `count` parts, or fewer if there are few points; each its points and weights."""
    parts = [_part(points, weight)]
    while len(parts) < count:
        best = int(np.argmax([part.gain for part in parts]))
        if parts[best].gain == -np.inf:
            break
        chosen = parts.pop(best)
        parts += [_part(chosen.points[some], chosen.weight[some]) for some in (chosen.first, ~chosen.first)]
    return [(part.points, part.weight) for part in parts]


def moments(points: Array, weight: Array) -> tuple[Array, Array]:
    """Mean (3,) and covariance (3, 3) of cubes of these volumes about points."""
    mean = weight @ points / np.sum(weight)
    return mean, np.sum(_second(points - mean, weight), axis=0) / np.sum(weight)


def _second(points: Array, weight: Array) -> Array:
    """Second moments (n, 3, 3) about the origin of cubes of these volumes: x xᵀ and edge² / 12 times their volume."""
    own = np.cbrt(weight) ** 2 / 12
    return weight[:, None, None] * (points[:, :, None] * points[:, None, :] + own[:, None, None] * np.eye(3))


def _part(points: Array, weight: Array) -> Part:
    """A part, and the plane that splits it best."""
    best, first = -np.inf, np.zeros(len(points), dtype=bool)
    mean, covariance = moments(points, weight)
    away = points - mean
    whole = float(_fullness(np.sum(weight), np.zeros(3), np.sum(weight) * covariance))
    for axis in np.concatenate([np.linalg.eigh(covariance)[1].T, np.eye(3)]):
        height = away @ axis
        order = np.argsort(height, kind="stable")
        volumes = _halves(away[order], weight[order])
        free = np.diff(height[order]) > 0
        free[: FEWEST - 1] = free[len(free) - FEWEST + 1 :] = False
        if not np.any(free):
            continue
        at = int(np.argmin(np.where(free, volumes, np.inf)))
        if whole - volumes[at] > best:
            best, first = whole - float(volumes[at]), np.zeros(len(points), dtype=bool)
            first[order[: at + 1]] = True
    return Part(points, weight, best, first)


def _halves(points: Array, weight: Array) -> Array:
    """Sums of the volumes of the first i + 1 points and of the others, for every i but the last."""
    sums = [np.cumsum(weight), np.cumsum(scale(weight, points), axis=0)]
    sums.append(np.cumsum(_second(points, weight), axis=0))
    before = [x[:-1] for x in sums]
    after = [x[-1] - x[:-1] for x in sums]
    return _fullness(*before) + _fullness(*after)


def _fullness(weight: Any, first: Array, second: Array) -> Array:
    """Volume of the boxes that have these moments, (...)."""
    mass = np.maximum(weight, np.finfo(float).tiny)[..., None, None]
    mean = first[..., None] / mass
    covariance = second / mass - mean * np.swapaxes(mean, -1, -2)
    return np.asarray(np.sqrt(12.0**3 * np.maximum(np.linalg.det(covariance), 0.0)))
