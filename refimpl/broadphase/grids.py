"""Regular grids: each object is in the list of every cell that its box covers; who shares a cell may meet.

The size of the cells is a trade: small ones are many and hold each object several times, large ones hold many objects
each. Objects of very different size need cells of different size, so there are *levels*, each with cells four times as
large as those of the one before; an object is kept in the cells of its own size and looks itself up in all larger
ones (Eitz and Gu 2007, Hierarchical Spatial Hashing; Ericson, Real-Time Collision Detection, 7.1 and 7.2).
"""

from __future__ import annotations

from abc import abstractmethod
from itertools import chain
from typing import ClassVar

import numpy as np

from refimpl.broadphase.brute import every, every_ray
from refimpl.broadphase.buckets import Cells, Hashed, Window, count_covered
from refimpl.broadphase.levels import Level
from refimpl.broadphase.lists import Lists
from refimpl.broadphase.protocol import BroadPhase, Candidates
from refimpl.broadphase.sizes import LEAST, TAME, cell_size, extents, middle, spans, tame
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

LEVELS = 24
"""Sizes of cells at most: the largest are 4²³ times as large as the smallest."""
MANY = 4096
"""Cells beyond which an object is kept aside."""
SPARSE = 1000
"""A level for less than this part of all objects is not worth its cells."""
LOOSE = 16
"""The grid is made anew when more than this part of all objects has left its cells,"""
MANY_LOOSE = 4096
"""or so many have."""
ROOM = 4
"""Cells of an array for each object, unless their size is given."""
MOST_CELLS = 1 << 24


class Grid(BroadPhase):
    """A regular grid; its subclasses say where cells are kept.

    Parameters
    ----------
    cell
        Edge of the smallest cells; chosen from the objects if it is None.
    levels
        How many sizes of cells there may be; 1 is the plain grid of the textbooks.

    Attributes
    ----------
    cell_size : float
        Edge of the smallest cells, as given or as chosen.
    aside : (k,) int64
        Objects too large for any cell, compared with all others one by one.
    """

    level: ClassVar[type[Level]] = Lists
    """What a level is made of."""

    def __init__(self, cell: float | None = None, levels: int = LEVELS) -> None:
        super().__init__()
        if cell is not None and not LEAST <= cell <= TAME:
            raise ValueError(f"cell must lie between {LEAST:g} and {TAME:g}, got {cell!r}")
        if levels < 1:
            raise ValueError(f"levels must be at least 1, got {levels!r}")
        self._cell, self._most = cell, levels
        self.cell_size = cell or 1.0
        self.levels: list[Level] = []
        self.aside = self._loose = np.empty(0, dtype=np.int64)
        self._home = self._place = self._loose

    @property
    def memory(self) -> int:
        """Bytes of the cells' lists."""
        return sum(level.memory for level in self.levels)

    def _rebuild(self) -> None:
        self.cell_size = self._cell or cell_size(self.lower, self.upper)
        which = self._level_of()
        self.levels, aside = [], [np.flatnonzero(which < 0)]
        for number in np.unique(which[which >= 0]).tolist():
            rows = np.flatnonzero(which == number)
            lower, upper = self.lower.take(rows, axis=0), self.upper.take(rows, axis=0)
            cells = self._cells(lower, upper, self.cell_size * 4.0**number)
            low, high = cells.of(lower), cells.of(upper)
            fits = self._fit(low, high) & (len(rows) * SPARSE >= len(self))
            if not fits.all():
                aside.append(rows[~fits])
                rows, lower, upper = rows[fits], lower[fits], upper[fits]
                low, high = low[fits], high[fits]
            if len(rows):
                self.levels.append(self.level(rows, lower, upper, low, high, cells))
        self.aside = np.concatenate(aside)
        self._loose = np.empty(0, dtype=np.int64)
        self._settle()

    def _settle(self) -> None:
        """Note the level of each row, or −1, and its place there."""
        self._home, self._place = np.full(len(self), -1), np.zeros(len(self), dtype=np.int64)
        for number, level in enumerate(self.levels):
            self._home[level.rows], self._place[level.rows] = number, np.arange(len(level.rows))

    def _level_of(self) -> Indices:
        """Level by size: a box is at most as long as a cell, and in all but the first a quarter of it; −1: none."""
        known = tame(self.lower, self.upper)
        found = np.where(known, 0, -1)
        with np.errstate(over="ignore", invalid="ignore"):
            size = extents(self.lower, self.upper)
        large = np.flatnonzero(known & (size > self.cell_size))
        found[large] = np.minimum(np.ceil(np.log2(size[large] / self.cell_size) / 2), self._most - 1)
        return found

    def _fit(self, low: Indices, high: Indices) -> Bools:
        """Which objects a level can hold, by their first and last cells."""
        return np.asarray(count_covered(low, high) <= MANY)

    @abstractmethod
    def _cells(self, lower: Array, upper: Array, size: float) -> Cells:
        """Make cells for boxes, of which there is one at least."""

    # -- changes --------------------------------------------------------------------------------------------

    def _updated(self, rows: Indices) -> None:
        """Objects that have left their cells come loose: they are looked up like queries, until they are many."""
        left = []
        for number, level in enumerate(self.levels):
            mine = rows[self._home[rows] == number]
            left.append(mine[~level.hold(self._place[mine], self.lower[mine], self.upper[mine])])
        self._loosen(np.concatenate([*left, rows[:0]]))

    def _inserted(self, count: int) -> None:
        new = np.arange(len(self) - count, len(self))
        self._home, self._place = (np.append(x, np.full(count, -1)) for x in (self._home, self._place))
        self._loosen(new)

    def _removed(self, kept: Bools) -> None:
        row = np.where(kept, np.cumsum(kept) - 1, -1)
        for level in self.levels:
            level.renumber(row)
        self.levels = [level for level in self.levels if len(level.rows)]
        self.aside, self._loose = (row[x[kept[x]]] for x in (self.aside, self._loose))
        self._settle()

    def _loosen(self, rows: Indices) -> None:
        self._home[rows] = -1
        self._loose = np.union1d(self._loose, rows)
        if len(self._loose) > min(max(len(self) // LOOSE, 1), MANY_LOOSE):
            self._rebuild()

    # -- questions ------------------------------------------------------------------------------------------

    def _near_pairs(self) -> Candidates:
        for number, level in enumerate(self.levels):
            yield from level.pairs(self.lower, self.upper)
            for coarser in self.levels[number + 1 :]:
                for q, row in coarser.around(self.lower[level.rows], self.upper[level.rows]):
                    yield level.rows[q], row
        for rows, others in ((self.aside, np.arange(len(self))), (self._loose, self._loose)):
            for i, j in every(self.lower[rows], self.upper[rows], self.lower[others], self.upper[others]):
                yield rows[i], others[j]
        for level in self.levels:
            for i, row in level.around(self.lower[self._loose], self.upper[self._loose]):
                yield self._loose[i], row

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        yield from chain.from_iterable(level.around(lower, upper) for level in self.levels)
        apart = np.concatenate([self.aside, self._loose])
        for q, i in every(lower, upper, self.lower[apart], self.upper[apart]):
            yield q, apart[i]

    def _near_rays(self, origin: Array, direction: Array, length: Array) -> Candidates:
        yield from chain.from_iterable(level.along(origin, direction, length) for level in self.levels)
        apart = np.concatenate([self.aside, self._loose])
        for q, i in every_ray(origin, direction, length, self.lower[apart], self.upper[apart]):
            yield q, apart[i]


class HashGrid(Grid):
    """Cells without bounds, in a hash table: memory grows with the objects, wherever they are."""

    def _cells(self, lower: Array, upper: Array, size: float) -> Cells:
        return Hashed(middle(lower, upper), size)


class ArrayGrid(Grid):
    """Cells of a window around the objects, in an array: no hashing, but memory for empty cells too.

    What is beyond the window is in the cells at its rim. Where the size of the cells is chosen, it is such that there
    are a few cells for each object.
    """

    def _cells(self, lower: Array, upper: Array, size: float) -> Cells:
        most = min(MOST_CELLS, MANY * len(lower)) if self._cell else max(ROOM * len(lower), 64)
        low, high = np.min(lower, axis=0), np.max(upper, axis=0)
        if _excess(low, high, size, most) > 1:
            low, high = spans(lower, upper)
        if not self._cell:
            size *= max(_excess(low, high, size, most), 1.0)
        along = np.maximum(np.ceil(np.minimum((high - low) / size, 2.0**20)), 1)
        if np.prod(along) > most:
            along = np.minimum(along, max(int(most ** (1 / len(low))), 1))
        return Window((low + high - along * size) / 2, size, tuple(int(n) for n in along))


def _excess(low: Array, high: Array, size: float, most: int) -> float:
    """By how much cells must be larger for only so many to be between two corners."""
    return float(np.exp((np.sum(np.log(np.maximum((high - low) / size + 1, 1.0))) - np.log(most)) / len(low)))
