"""The level of the textbooks: each object is in the list of every cell that its box covers.

The lists are stretches of one array: that of bucket b is ``members[starts[b]:starts[b + 1]]``.
"""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.buckets import Cells, count_covered, covered
from refimpl.broadphase.corners import Corners, meeting
from refimpl.broadphase.levels import Level
from refimpl.broadphase.protocol import Candidates
from refimpl.broadphase.ranges import pieces, shares
from refimpl.linear import Array
from refimpl.signs import Indices


class Lists(Level):
    """Cells with lists of objects."""

    def __init__(self, rows: Indices, lower: Array, upper: Array, low: Indices, high: Indices, cells: Cells) -> None:
        super().__init__(rows, lower, upper, low, high, cells)
        owner, entered = covered(self.low, self.high)
        self.cells = cells.for_entries(len(owner))
        bucket = self.cells.bucket(entered)
        packed = np.sort(bucket * len(rows) + owner)  # numbers are sorted several times faster than by their indices
        self.members = rows[packed % len(rows)]
        self.starts = np.concatenate([[0], np.cumsum(np.bincount(bucket, minlength=self.cells.buckets))])

    @property
    def memory(self) -> int:
        """Bytes of the lists and of their beginnings."""
        return int(self.members.nbytes + self.starts.nbytes)

    def renumber(self, row: Indices) -> None:
        """Follow new numbers of all rows; −1: taken away."""
        super().renumber(row)
        listed = row[self.members] >= 0
        self.members = row[self.members[listed]]
        self.starts = np.concatenate([[0], np.cumsum(listed)])[self.starts]

    def pairs(self, lower: Array, upper: Array) -> Candidates:
        """Objects that share a bucket: each member with those after it in its list."""
        boxes = Corners.of(lower[self.members], upper[self.members])
        place = np.arange(len(self.members))
        after = np.repeat(self.starts[1:], np.diff(self.starts)) - place - 1
        for one, other in pieces(place + 1, after):
            kept = meeting(boxes, one, boxes, other)
            yield self.members[one[kept]], self.members[other[kept]]

    def around(self, lower: Array, upper: Array) -> Candidates:
        """Query indices and objects in the buckets of the cells that boxes (Q, D) cover."""
        low, high = self.cells.of(lower), self.cells.of(upper)
        count = count_covered(low, high)
        wide = count > len(self.members)
        yield from self.everything(np.flatnonzero(wide))
        few = np.flatnonzero(~wide)
        for some in shares(count[few].astype(np.int64)):
            asked = few[some]
            owner, cells = covered(low[asked], high[asked])
            bucket = self.cells.bucket(cells)
            start = self.starts[bucket]
            for entry, place in pieces(start, self.starts[bucket + 1] - start):
                yield asked[owner[entry]], self.members[place]
