"""Cells of a regular grid: which ones a box covers, and the numbers of the buckets in which they are kept.

A grid as an array has a bucket for each cell of a window, and those at its rim take in all that is beyond. A grid as a
hash has a fixed number of buckets, in which cells share at random (Teschner et al. 2003). Coordinates are rounded to
cells by one monotone function, so boxes that meet have a cell in common, however rounding turns out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from refimpl.broadphase.ranges import written_out
from refimpl.linear import Array
from refimpl.signs import Indices

FAR = 2.0**40
"""Cells from the middle beyond which all coordinates are in the same one."""
PRIMES = np.array([73856093, 19349663, 83492791], dtype=np.int64)


class Cells(Protocol):
    """A regular grid's cells and buckets."""

    @property
    def buckets(self) -> int:
        """How many there are."""

    @property
    def size(self) -> float:
        """Edge of a cell."""

    def of(self, x: Array) -> Indices:
        """Cells (n, D) of coordinates (n, D), which may be infinite."""

    def bucket(self, cells: Indices) -> Indices:
        """Bucket of each cell (n, D)."""

    def for_entries(self, count: int) -> Self:
        """Give the same cells in as many buckets as so many entries need."""


@dataclass(frozen=True)
class Window:
    """An array of cells: `shape` of them, from `origin` on."""

    origin: Array
    size: float
    shape: tuple[int, ...]

    @property
    def buckets(self) -> int:
        """One for each cell."""
        return int(np.prod(self.shape))

    def of(self, x: Array) -> Indices:
        """Cells of coordinates, those at the rim for all that is beyond."""
        return _cells(x, self.origin, self.size, 0.0, np.array(self.shape) - 1.0)

    def for_entries(self, count: int) -> Self:  # noqa: ARG002
        """Keep a bucket for each cell."""
        return self

    def bucket(self, cells: Indices) -> Indices:
        """Row by row."""
        found = cells[:, 0]
        for k in range(1, len(self.shape)):
            found = found * self.shape[k] + cells[:, k]
        return found


@dataclass(frozen=True)
class Hashed:
    """Cells without bounds around `origin`, in `slots` buckets, a power of two."""

    origin: Array
    size: float
    slots: int = 1

    @property
    def buckets(self) -> int:
        """The slots."""
        return self.slots

    def of(self, x: Array) -> Indices:
        """Cells of coordinates."""
        return _cells(x, self.origin, self.size, -FAR, FAR)

    def for_entries(self, count: int) -> Self:
        """Twice as many buckets as entries, or up to four times."""
        return replace(self, slots=2 << max(count, 1).bit_length())

    def bucket(self, cells: Indices) -> Indices:
        """Each coordinate times a large prime, mixed."""
        found = cells[:, 0] * PRIMES[0]
        for k in range(1, cells.shape[1]):
            found = found ^ (cells[:, k] * PRIMES[k])
        return np.asarray((found ^ (found >> 20)) & (self.slots - 1))


def _cells(x: Array, origin: Array, size: float, least: float | Array, most: float | Array) -> Indices:
    with np.errstate(over="ignore"):
        return np.asarray(np.clip(np.floor((x - origin) / size), least, most)).astype(np.int64)


def count_covered(low: Indices, high: Indices) -> Array:
    """Count the cells from `low` to `high` (n, D), as doubles, which cannot overflow."""
    found = (high[:, 0] - low[:, 0] + 1).astype(np.float64)
    for k in range(1, low.shape[1]):
        found *= high[:, k] - low[:, k] + 1
    return found


def covered(low: Indices, high: Indices) -> tuple[Indices, Indices]:
    """Every cell from `low` to `high` (n, D): its owner's index, and the cell."""
    widths = high - low + 1
    owner, number = written_out(np.zeros(len(low), dtype=np.int64), count_covered(low, high).astype(np.int64))
    cells = low[owner]
    for k in range(low.shape[1] - 1, 0, -1):
        width = widths[owner, k]
        cells[:, k] += number % width
        number = number // width
    cells[:, 0] += number
    return owner, cells
