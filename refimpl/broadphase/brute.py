"""Brute force: every object against every other. The reference that all structures are held against."""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.corners import Corners, all_meeting
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
        return every(self.lower, self.upper, self.lower, self.upper, later=True)

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        return every(lower, upper, self.lower, self.upper)

    def _near_rays(self, origin: Array, direction: Array, length: Array) -> Candidates:
        return every_ray(origin, direction, length, self.lower, self.upper)


def every(lower_a: Array, upper_a: Array, lower_b: Array, upper_b: Array, *, later: bool = False) -> Candidates:
    """Indices of boxes of A (n, D) and boxes of B (m, D) that meet, in tiles.

    If both are the same, `later` leaves out what is before the diagonal.
    """
    rows = max(1, TILE // max(len(lower_b), 1))
    a, b = Corners.of(lower_a, upper_a), Corners.of(lower_b, upper_b)
    for begin in range(0, len(lower_a), rows):
        some, rest = slice(begin, begin + rows), slice(begin if later else 0, None)
        i, j = np.nonzero(all_meeting(a, some, b, rest))
        i, j = i + begin, j + rest.start
        yield (i[i < j], j[i < j]) if later else (i, j)


def every_ray(origin: Array, direction: Array, length: Array, lower: Array, upper: Array) -> Candidates:
    """Indices of rays (n, D) and boxes (m, D) that may meet, in tiles."""
    rows = max(1, TILE // max(len(lower), 1))
    for begin in range(0, len(origin), rows):
        o, d, t = (x[begin : begin + rows, None] for x in (origin, direction, length))
        i, j = np.nonzero(rays_may_meet(o, d, t, lower, upper))
        yield i + begin, j
