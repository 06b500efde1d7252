"""Brute force: every object against every other. The reference that all structures are held against."""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.boxes import meet
from refimpl.broadphase.protocol import BroadPhase, Candidates
from refimpl.broadphase.slabs import rays_may_meet
from refimpl.linear import Array

TILE = 1 << 18
"""Comparisons at a time: as much as stays in the processor's cache."""


class BruteForce(BroadPhase):
    """No structure at all: N² / 2 comparisons, in tiles, so that memory does not grow with N²."""

    def _rebuild(self) -> None:
        """Nothing to make."""

    def _near_pairs(self) -> Candidates:
        count = len(self)
        rows = max(1, TILE // max(count, 1))
        for begin in range(0, count, rows):
            some = slice(begin, begin + rows)
            found = meet(self.lower[some, None], self.upper[some, None], self.lower[begin:], self.upper[begin:])
            i, j = np.nonzero(found)
            later = i < j
            yield i[later] + begin, j[later] + begin

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        rows = max(1, TILE // max(len(self), 1))
        for begin in range(0, len(lower), rows):
            some = slice(begin, begin + rows)
            q, found = np.nonzero(meet(lower[some, None], upper[some, None], self.lower, self.upper))
            yield q + begin, found

    def _near_rays(self, origin: Array, direction: Array, length: Array) -> Candidates:
        rows = max(1, TILE // max(len(self), 1))
        for begin in range(0, len(origin), rows):
            o, d, t = (x[begin : begin + rows, None] for x in (origin, direction, length))
            q, found = np.nonzero(rays_may_meet(o, d, t, self.lower, self.upper))
            yield q + begin, found
