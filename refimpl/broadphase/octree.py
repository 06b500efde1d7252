"""Octree and quadtree: space is halved along every axis at once, and each object sinks to the cells of its own size.

An object is in the cell that its centre is in, as long as it is no longer than the cell: there is no need to cut it,
since the boxes of nodes reach as far as their objects do (the loose octree: Ulrich 2000, in Game Programming Gems).
Whether it fits is asked axis by axis, so that a plate sinks like a point across its flat side.
"""

from __future__ import annotations

import numpy as np

from refimpl.broadphase.growing import grow
from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.surfaces import bounded, reach
from refimpl.broadphase.tree import ObjectTree
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

LEAF = 8
LONG = 2  # beside the lower and the upper half of a cell: objects that are longer than these


class Octree(ObjectTree):
    """The tree; in two dimensions a quadtree. Build: O(N) for each level, of which there are as many as sizes."""

    def _grow(self) -> Hierarchy:
        return grow(self._groups(), Cells(self.lower, self.upper), LEAF)


class Cells:
    """Deals objects out to the 2^D halves of cells, and along each axis those that are too long to one more.

    Where all objects of a cell go the same way, the next cell is fitted to their centres, however small it becomes.

    Attributes
    ----------
    middle, half : (k, D)
        The cells of the present level.
    fitted, whole : (k,) bool
        Cells to be fitted to what is in them, and those that are not divided any further.
    """

    def __init__(self, lower: Array, upper: Array) -> None:
        low, high = bounded(lower, upper, reach(lower, upper))
        self.center, self.length = low / 2 + high / 2, high - low
        self.dimension = self.center.shape[1]
        self.fan = 3**self.dimension
        self.middle, self.half = np.zeros((2, self.dimension)), np.zeros((2, self.dimension))
        self.fitted, self.whole = np.ones(2, dtype=bool), np.zeros(2, dtype=bool)
        self.digits = np.arange(self.fan)[:, None] // 3 ** np.arange(self.dimension) % 3

    def final(self) -> Bools:
        """Cells whose objects nothing parts."""
        return self.whole

    def deal(self, node: Indices, owner: Indices, rows: Indices) -> Indices:
        """Number of each object's child: a digit 0, 1 or `LONG` for each axis, to the base of 3."""
        begin = np.searchsorted(owner, np.arange(len(node)))
        fitted = np.flatnonzero(self.fitted[node])
        child = np.zeros(len(rows), dtype=np.int64)
        for axis in range(self.dimension):
            place, length = self.center[:, axis].take(rows), self.length[:, axis].take(rows)
            if len(fitted):
                self._fit(axis, node[fitted], place, begin, fitted)
            middle, half = self.middle[node, axis].take(owner), self.half[node, axis].take(owner)
            child += 3**axis * np.where(length > half, LONG, place > middle)
        return child

    def _fit(self, axis: int, node: Indices, place: Array, begin: Indices, fitted: Indices) -> None:
        low, high = np.minimum.reduceat(place, begin)[fitted], np.maximum.reduceat(place, begin)[fitted]
        middle = low / 2 + high / 2
        self.middle[node, axis] = np.where(middle < high, middle, low)  # so that it parts them, whatever is rounded
        self.half[node, axis] = high / 2 - low / 2

    def descend(self, node: Indices, child: Indices) -> None:
        """Halve the cells along the axes along which the objects fit."""
        digit = self.digits[child]
        alone = np.bincount(node, minlength=len(self.whole))[node] == 1
        halved = np.where(digit == LONG, 0.0, self.half[node] / 2)
        self.middle = self.middle[node] + np.where(digit == 0, -halved, halved)
        self.half = self.half[node] - halved
        self.whole = np.all(digit == LONG, axis=1) | (alone & self.fitted[node])
        self.fitted = alone
