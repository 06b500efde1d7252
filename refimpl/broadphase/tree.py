"""What all trees of boxes have in common: queries go down the boxes, and moving objects move the boxes around them."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from refimpl.broadphase.boxes import as_points
from refimpl.broadphase.corners import Corners, meeting
from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.nearest import nearest, spans
from refimpl.broadphase.protocol import BroadPhase, Candidates
from refimpl.broadphase.slabs import rays_may_meet
from refimpl.broadphase.surfaces import bounded, reach, surface
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

WORSE = 2.0
"""A tree whose boxes have become so much larger, or whose leaves so much fuller, is built anew."""
CROWDED = 32
"""Leaves of no more objects are never too full."""
MOVING, STATIC = 0, 1
"""The roots of trees whose objects are divided."""


class BoxHierarchy(BroadPhase):
    """A broad phase whose queries descend a hierarchy of boxes; what is a leaf, and why, a subclass says."""

    tree: Hierarchy

    @abstractmethod
    def _grow(self) -> Hierarchy:
        """Build the tree over all rows; its boxes need not be fitted."""

    def _rebuild(self) -> None:
        self.tree = self._grow()
        self.refit()
        self._cost = self.cost()
        self._fullest = max(CROWDED, int(np.max(self.tree.count, initial=0)))

    def refit(self) -> None:
        """Fit the boxes of the tree to the objects as they are, and leave the tree as it is."""
        self.tree.refit(self.lower, self.upper)

    def cost(self) -> float:
        """Sum of the surfaces of all nodes, in units of that of the whole: about how many a query visits."""
        full = self.tree.nodes.low[0] <= self.tree.nodes.high[0]
        low, high = (side.T[full] for side in self.tree.nodes)
        low, high = bounded(low, high, reach(low, high))
        every = surface(high - low)
        return float(np.sum(every) / max(np.max(every, initial=0.0), np.finfo(float).tiny))

    def _renewed(self) -> None:
        """Refit; and build anew where that has become worth it."""
        self.refit()
        if np.max(self.tree.count, initial=0) > WORSE * self._fullest or self.cost() > WORSE * self._cost:
            self._rebuild()

    def nearest(self, points: Any, count: int = 1) -> tuple[Array, Indices]:
        """Distances and ids of the objects whose boxes are nearest to each of some points.

        Parameters
        ----------
        points : (Q, D), finite
            Within a box the distance is 0.
        count : int, at least 1

        Returns
        -------
        (Q, count), (Q, count)
            Ascending; of equal distances the smaller id comes first. Where there are fewer objects than `count`, the
            rest is infinite, with the id −1.
        """
        where = as_points(points, self.dimension)
        if count < 1:
            raise ValueError(f"nearest: count must be at least 1, got {count}")
        exponent = max(reach(self.lower, self.upper), reach(where, where))
        nodes, boxes = (c.in_units(exponent) for c in (self.tree.nodes, Corners.of(self.lower, self.upper)))
        near = np.ldexp(where, -exponent)
        found, rows = nearest(self.tree, nodes, near, count, lambda query, row: spans(near[query], boxes, row)[0])
        with np.errstate(over="ignore"):
            found = np.ldexp(found, exponent)
        return found, np.where(rows < 0, -1, np.append(self.ids, -1)[rows])

    def _updated(self, rows: Indices) -> None:  # noqa: ARG002
        self._renewed()

    def _removed(self, kept: Bools) -> None:
        there = kept[self.tree.order]
        moved = np.cumsum(kept) - 1
        self.tree.hang(moved[self.tree.order[there]], self.tree.home[there])
        self._renewed()

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        asked = Corners.of(lower, upper)

        def near(query: Indices, boxes: Corners, box: Indices) -> Indices:
            return meeting(asked, query, boxes, box)

        return self.tree.found(len(lower), near)

    def _near_rays(self, origin: Array, direction: Array, length: Array) -> Candidates:
        def near(query: Indices, boxes: Corners, box: Indices) -> Indices:
            low, high = boxes.low[:, box].T, boxes.high[:, box].T
            return np.flatnonzero(rays_may_meet(origin[query], direction[query], length[query], low, high))

        return self.tree.found(len(origin), near)


class ObjectTree(BoxHierarchy):
    """A tree that divides the objects, not the space: each hangs in one leaf.

    Static objects and moving ones have a root each, so that no two static ones are ever compared.
    """

    def _groups(self) -> list[Indices]:
        """Rows of the moving objects, and of the static ones; there may be none."""
        return [np.flatnonzero(~self.static), np.flatnonzero(self.static)]

    def _near_pairs(self) -> Candidates:
        return self.tree.pairs((np.array([MOVING, MOVING]), np.array([MOVING, STATIC])))

    def _inserted(self, count: int) -> None:
        """Hang new objects where the boxes on the way have to grow least."""
        if count > len(self) // 2:
            self._rebuild()
            return
        new = np.arange(len(self) - count, len(self))
        low, high, scale = self.lower[new], self.upper[new], reach(self.lower, self.upper)
        low, high = bounded(low, high, scale)
        node = np.where(self.static[new], STATIC, MOVING)
        while (self.tree.arity[node] > 0).any():
            child, place = self.tree.below(node)
            around = bounded(self.tree.nodes.low[:, child].T, self.tree.nodes.high[:, child].T, scale)
            joint = np.minimum(around[0], low[place]), np.maximum(around[1], high[place])
            growth = surface(joint[1] - joint[0]) - surface(np.maximum(around[1] - around[0], 0.0))
            begin = np.searchsorted(place, np.arange(count))
            least = np.flatnonzero(growth == np.minimum.reduceat(growth, begin)[place])
            node = child[least[np.searchsorted(place[least], np.arange(count))]]
        self.tree.hang(np.append(self.tree.order, new), np.append(self.tree.home, node))
        self._renewed()
