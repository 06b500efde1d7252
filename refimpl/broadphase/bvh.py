"""Bounding volume hierarchy: a binary tree of boxes, built from the top by surface area and refitted when they move.

A node's objects are put into bins along each axis by the centres of their boxes; of the cuts between bins, the one is
taken for which the surfaces of both sides' boxes, times how many objects they hold, add up to the least (Goldsmith &
Salmon 1987, Automatic Creation of Object Hierarchies for Ray Tracing; Wald 2007, On fast Construction of SAH-based
Bounding Volume Hierarchies).
"""

from __future__ import annotations

import numpy as np

from refimpl.boxtree import along_widest
from refimpl.broadphase.corners import Corners
from refimpl.broadphase.growing import grow
from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.surfaces import bounded, reach, surface
from refimpl.broadphase.tree import ObjectTree
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

BINS = 8
LEAF = 4
LENGTH = 2.0**-20
"""Boxes count with this part of their edges' length too, or those without surface would all be alike."""


class BVH(ObjectTree):
    """The tree. Build: O(N log N). Moving objects are followed by `refit`, O(N) and without a sort."""

    def _grow(self) -> Hierarchy:
        return grow(self._groups(), SurfaceArea(self.lower, self.upper), LEAF)


class SurfaceArea:
    """Deals objects out so that the two boxes around them have little surface.

    Parameters
    ----------
    lower, upper : (n, D)
        The objects' boxes; infinite ones count as if they ended where the finite ones do.
    """

    fan = 2

    def __init__(self, lower: Array, upper: Array) -> None:
        self.boxes = Corners.of(*bounded(lower, upper, reach(lower, upper)))
        self.level = 0
        self.nodes = 2
        self.balanced = 2 * len(lower).bit_length()

    def final(self) -> Bools:
        """Give no node: objects that nothing parts are dealt out half and half."""
        return np.zeros(self.nodes, dtype=bool)

    def descend(self, node: Indices, child: Indices) -> None:  # noqa: ARG002
        """Count the levels."""
        self.level += 1
        self.nodes = len(node)

    def deal(self, node: Indices, owner: Indices, rows: Indices) -> Indices:
        """0 or 1 for each object: on which side of its node's best cut its centre lies."""
        if len(rows) == 0:
            return rows
        begin = np.searchsorted(owner, np.arange(len(node)))
        boxes = self.boxes.at(rows)
        centers = boxes.low / 2 + boxes.high / 2
        best = np.full(len(node), np.inf)
        side = np.zeros(len(rows), dtype=np.int64)
        for center in centers:
            bins = _bins(center, owner, begin)
            cost, cut = _costs(owner * BINS + bins, boxes, len(node))
            better = cost < best
            best = np.where(better, cost, best)
            np.copyto(side, bins > cut.take(owner), where=better.take(owner))
        lopsided = ~np.isfinite(best) if self.level < self.balanced else np.ones(len(node), dtype=bool)
        if lopsided.any():
            mine = np.flatnonzero(lopsided.take(owner))
            side[mine] = _halves(centers[:, mine].T, np.searchsorted(owner[mine], np.flatnonzero(lopsided)))
        return side


def _halves(center: Array, begin: Indices) -> Indices:
    """0 or 1 for each centre, half and half of each run, along the axis in which they spread most."""
    sort = along_widest(center, begin)
    size = np.diff(np.append(begin, len(center)))
    rank = np.arange(len(center)) - np.repeat(begin, size)
    side = np.empty(len(center), dtype=np.int64)
    side[sort] = 2 * rank >= np.repeat(size, size)
    return side


def _bins(values: Array, owner: Indices, begin: Indices) -> Indices:
    """Number of the bin, from 0 to BINS − 1, of each value, where those of an owner reach from bin to bin."""
    least = np.minimum.reduceat(values, begin)
    spread = np.maximum.reduceat(values, begin) - least
    share = (values - least.take(owner)) / np.where(spread > 0, spread, 1.0).take(owner)
    return np.minimum((share * BINS).astype(np.int64), BINS - 1)


def _costs(key: Indices, boxes: Corners, nodes: int) -> tuple[Array, Indices]:
    """Least cost of a cut of each node, and the last bin on its lower side; infinite where one side would be empty.

    Parameters
    ----------
    key : (m,)
        Node times BINS plus bin, of each of the boxes.
    """
    number = np.bincount(key, minlength=nodes * BINS).reshape(nodes, BINS)
    around = Corners.empty(boxes.dimension, nodes * BINS)
    for found, values in zip(around.low, boxes.low, strict=True):
        np.minimum.at(found, key, values)
    for found, values in zip(around.high, boxes.high, strict=True):
        np.maximum.at(found, key, values)
    below = _sizes(around.low.reshape(-1, nodes, BINS), around.high.reshape(-1, nodes, BINS))
    above = _sizes(*(side.reshape(-1, nodes, BINS)[:, :, ::-1] for side in around))[:, ::-1]
    first = np.cumsum(number, axis=1)
    rest = first[:, -1:] - first
    cost = np.full((nodes, BINS), np.inf)
    some = (first > 0) & (rest > 0)
    above = np.roll(above, -1, axis=1)
    cost[some] = (first * below + rest * above)[some]
    cut = np.argmin(cost, axis=1)
    return cost[np.arange(nodes), cut], cut


def _sizes(low: Array, high: Array) -> Array:
    """Sizes of the boxes around the first bin of each row, the first two, and so on; (D, k, BINS) each."""
    extent = np.maximum.accumulate(high, axis=2) - np.minimum.accumulate(low, axis=2)
    extent = np.maximum(extent, 0.0)  # where all bins are empty
    return np.asarray(surface(np.moveaxis(extent, 0, -1)) + LENGTH * np.sum(extent, axis=0))
