"""Sort and sweep within the columns of a grid: cells across, a sorted order along.

Each object is in one column only, that of its lower corner; being no longer than a cell it can meet only what is in
that column or one next to it. Within a column objects are sorted along the remaining axis, by *rank*: the number of
objects of the level that begin before. The key column · m + rank sorts all columns at once, and where a run of ranks
begins in a column is found by bisection: nothing is stored for a column (compare Tracy, Buss and Woods 2009, Efficient
Large-Scale Sweep and Prune Methods).
"""

from __future__ import annotations

from itertools import product

import numpy as np

from refimpl.broadphase.buckets import Cells, Window, count_covered, covered
from refimpl.broadphase.corners import Corners, meeting
from refimpl.broadphase.grids import Grid
from refimpl.broadphase.levels import Level
from refimpl.broadphase.protocol import Candidates
from refimpl.broadphase.ranges import pieces, shares
from refimpl.broadphase.sizes import middle, spans
from refimpl.linear import Array, Bools, largest
from refimpl.signs import Indices

RIM = 1 << 14
"""Cells from the middle beyond which all coordinates are in the same one."""


class Columns(Level):
    """Objects sorted by column, then by rank."""

    def __init__(self, rows: Indices, lower: Array, upper: Array, low: Indices, high: Indices, cells: Cells) -> None:
        super().__init__(rows, lower, upper, low, high, cells)
        begin, end = spans(lower, upper)
        self.axis = int(np.argmax(end - begin))
        self.across = np.delete(np.arange(lower.shape[1]), self.axis)
        order = np.argsort(lower[:, self.axis])
        rank = np.empty_like(order)
        rank[order] = np.arange(len(rows))
        self.begins = lower[order, self.axis]
        self.longest = np.nextafter(np.max((upper - lower)[:, self.axis]), np.inf)
        self.width = len(rows)
        self.keys = np.sort(self._number(self.low[:, self.across]) * self.width + rank)
        self.members = rows[order[self.keys % self.width]]

    @staticmethod
    def _number(column: Indices) -> Indices:
        """Number of a column (..., D − 1), given by its cells across; those beside it may lie one beyond the rim."""
        number = column[..., 0]
        for k in range(1, column.shape[-1]):
            number = number * (2 * RIM + 2) + column[..., k]
        return number

    @property
    def memory(self) -> int:
        """Bytes of the order."""
        return int(self.members.nbytes + self.keys.nbytes + self.begins.nbytes)

    def hold(self, places: Indices, lower: Array, upper: Array) -> Bools:  # noqa: ARG002
        """Hold nothing that moves: it may have another rank."""
        return np.zeros(len(places), dtype=bool)

    def renumber(self, row: Indices) -> None:
        """Follow new numbers of all rows; the ranks keep the gaps of those that are taken away."""
        super().renumber(row)
        kept = row[self.members] >= 0
        self.keys, self.members = self.keys[kept], row[self.members[kept]]

    def _ranks(self, lower: Array, upper: Array) -> tuple[Indices, Indices]:
        """Ranks from the first that may still be there at the lower corner to the first that begins after the upper."""
        with np.errstate(over="ignore"):
            start = np.nextafter(lower[:, self.axis] - self.longest, -np.inf)
        return np.searchsorted(self.begins, start), np.searchsorted(self.begins, upper[:, self.axis], side="right")

    def pairs(self, lower: Array, upper: Array) -> Candidates:
        """Each with those after it in its column, and with those about as far along in half of the columns around."""
        low, high = lower[self.members], upper[self.members]
        boxes = Corners.of(low, high)
        column, place = self.keys // self.width, np.arange(len(self.keys))
        first, end = self._ranks(low, high)
        for step in product((-1, 0, 1), repeat=len(self.across)):
            if step < (0,) * len(step):
                continue
            there = (column + self._number(np.array(step))) * self.width
            start = np.searchsorted(self.keys, there + first) if any(step) else place + 1
            count = np.maximum(np.searchsorted(self.keys, there + end) - start, 0)
            for one, other in pieces(start, count):
                kept = meeting(boxes, one, boxes, other)
                yield self.members[one[kept]], self.members[other[kept]]

    def around(self, lower: Array, upper: Array) -> Candidates:
        """Query indices and objects in the columns that boxes cover, and in those before, which reach in."""
        low, high = self.cells.of(lower)[:, self.across] - 1, self.cells.of(upper)[:, self.across]
        count = count_covered(low, high)
        wide = count > len(self.members)
        yield from self.everything(np.flatnonzero(wide))
        first, end = self._ranks(lower, upper)
        few = np.flatnonzero(~wide)
        for some in shares(count[few].astype(np.int64)):
            asked = few[some]
            owner, column = covered(low[asked], high[asked])
            q, there = asked[owner], self._number(column) * self.width
            start, stop = (np.searchsorted(self.keys, there + rank[q]) for rank in (first, end))
            for entry, place in pieces(start, np.maximum(stop - start, 0)):
                yield q[entry], self.members[place]


class ColumnSweep(Grid):
    """Sort and sweep in the columns of a grid: the tightest candidates, each once, from plain sorting."""

    level = Columns

    def _fit(self, low: Indices, high: Indices) -> Bools:
        return np.asarray(largest((high - low).astype(np.float64)) <= 1)

    def _cells(self, lower: Array, upper: Array, size: float) -> Cells:
        return Window(middle(lower, upper) - RIM * size, size, (2 * RIM,) * lower.shape[1])
