"""How large objects are, how far apart, and which size of cells suits them."""

from __future__ import annotations

import numpy as np

from refimpl.linear import Array, Bools, largest
from refimpl.signs import Indices

SAMPLE = 4096
"""Objects from which sizes and places are estimated."""
SMALL, LARGE = 0.1, 0.9
"""Ranks by size between which are the objects that the cells may suit."""
AMPLE = 1.001
"""Cells are so much larger than the objects, for boxes of equal objects differ by rounding."""
CORE = 0.05
"""Part of the objects at either end that counts as outliers."""
CROWD = 8.0
"""Others in a cell, on average, above which cells are too large, unless the objects are."""
LEAST = 2.0**-500
"""Edge of a cell at least."""
TAME = 2.0**500
"""Coordinates up to which nothing here overflows."""


def extents(lower: Array, upper: Array) -> Array:
    """Longest edges of boxes (n, D); infinite ones too."""
    with np.errstate(over="ignore"):
        return largest(upper - lower)


def tame(lower: Array, upper: Array) -> Bools:
    """Which boxes have an end, and not one that is so far away that sums and quotients overflow."""
    return np.asarray((np.maximum(largest(lower), largest(upper))) <= TAME)


def sample(count: int) -> Indices:
    """Numbers of some objects among so many, evenly spread."""
    return np.linspace(0, count - 1, min(SAMPLE, count)).astype(np.int64)


def middle(lower: Array, upper: Array) -> Array:
    """A place in the middle of tame boxes, by the median of each coordinate of a sample."""
    some = sample(len(lower))
    return np.asarray(np.median((lower[some] + upper[some]) / 2, axis=0))


def spans(lower: Array, upper: Array) -> tuple[Array, Array]:
    """Corners between which are the middles of most of the tame boxes, outliers left out, by a sample."""
    some = sample(len(lower))
    low, high = np.quantile((lower[some] + upper[some]) / 2, [CORE, 1 - CORE], axis=0)
    return low, high


def cell_size(lower: Array, upper: Array) -> float:
    """Choose the edge of the cells for boxes (n, D): that of the large ones among them, but of about one object each.

    Cells as large as the objects hold each in 2^D lists at most. Where objects are small and far apart, cells as large
    as the space that each has, on average, do better. If objects then crowd in cells, since many are smaller than
    others or they are in clusters, cells are made smaller. A sample of the tame boxes is looked at.
    """
    known = np.flatnonzero(tame(lower, upper))
    if not len(known):
        return 1.0
    some = known[sample(len(known))]
    small, large = np.maximum(np.quantile(extents(lower[some], upper[some]), [SMALL, LARGE]) * AMPLE, LEAST).tolist()
    places = (lower[some] + upper[some]) / 2
    low, high = spans(lower[some], upper[some])
    span = (high - low)[high > low] / (1 - 2 * CORE)
    space = float(np.exp(np.mean(np.log(span)))) / len(known) ** (1 / len(span)) if len(span) else 0.0
    found = max(large, space) if max(large, space) > LEAST else 1.0
    while found > 4 * small and _crowd(places - low, found) * len(known) / len(some) > CROWD:
        found /= 4
    return found


def _crowd(places: Array, size: float) -> float:
    """Others in the same cell, on average over places (n, D)."""
    cells = np.floor(places / size)
    counts = np.unique(cells, axis=0, return_counts=True)[1]
    return float(np.sum(counts * (counts - 1.0)) / len(places))
