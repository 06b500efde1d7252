"""Sort and sweep: along one axis, an object can only meet those that begin before it ends."""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.corners import Corners, all_meeting
from refimpl.broadphase.protocol import BroadPhase, Candidates
from refimpl.broadphase.ranges import pieces
from refimpl.broadphase.sizes import spans, tame
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

BLOCK = 64
"""Neighbours in the order whose runs are looked through together."""
LONG = 8
"""A run so many times as long as the mean is looked through alone."""


class SortAndSweep(BroadPhase):
    """Objects sorted along the axis on which they are spread most (Baraff 1992, Dynamic Simulation of Rigid Bodies).

    Object i and those that follow it until its end are a *run*: the candidates of i. Runs of neighbours are nearly the
    same, so they are compared block by block. In 3 dimensions runs grow with N^(2/3).
    """

    def _rebuild(self) -> None:
        self._axis = self._spread_most()
        self._order: Indices = np.argsort(self.lower[:, self._axis])
        self._sort()

    def _spread_most(self) -> int:
        known = tame(self.lower, self.upper)
        if not known.any():
            return 0
        low, high = spans(self.lower[known], self.upper[known])
        return int(np.argmax(high - low))

    def _sort(self) -> None:
        """Boxes in the order of their lower corners, and for each how many begin before it ends."""
        self._boxes = Corners.of(self.lower[self._order], self.upper[self._order])
        self._begins, ends = self._boxes.low[self._axis], self._boxes.high[self._axis]
        self._ends = np.searchsorted(self._begins, ends, side="right")
        self._last_end = np.maximum.accumulate(ends)

    def _updated(self, rows: Indices) -> None:  # noqa: ARG002
        """Sort again, beginning with the old order: what is nearly sorted is sorted in nearly linear time."""
        self._order = self._order[np.argsort(self.lower[self._order, self._axis], kind="stable")]
        self._sort()

    def _removed(self, kept: Bools) -> None:
        row = np.cumsum(kept) - 1
        self._order = row[self._order[kept[self._order]]]
        self._sort()

    def _near_pairs(self) -> Candidates:
        first = np.arange(len(self)) + 1
        count = self._ends - first
        long = count > LONG * (np.sum(count) / max(len(self), 1) + BLOCK)
        for i, j in pieces(first[long], count[long]):
            yield self._order[np.flatnonzero(long)[i]], self._order[j]
        for begin in range(0, len(self), BLOCK):
            short = ~long[begin : begin + BLOCK]
            if short.any():
                yield from self._block(begin, short)

    def _block(self, begin: int, short: Bools) -> Candidates:
        """Compare neighbours in the order with all that begin before the last of those with short runs ends."""
        some = slice(begin, begin + len(short))
        run = slice(begin, int(np.max(self._ends[some][short])))
        i, j = np.nonzero(all_meeting(self._boxes, some, self._boxes, run))
        wanted = (i < j) & short[i]
        yield self._order[i[wanted] + begin], self._order[j[wanted] + begin]

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        """Those that begin before the query ends, from the first on that may end after the query begins."""
        start = np.searchsorted(self._last_end, lower[:, self._axis], side="left")
        end = np.searchsorted(self._begins, upper[:, self._axis], side="right")
        for q, place in pieces(start, np.maximum(end - start, 0)):
            yield q, self._order[place]
