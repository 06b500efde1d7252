"""Trees that divide space, not the objects: planes part it into cells, and an object is in every cell that it meets.

Boxes that meet have a point in common: that of their greatest lower coordinates. It is in one of the cells, and so are
the boxes; so the pairs within cells are all there are. Heights above planes are rounded, but rounding keeps the order
of numbers, and so this holds for heights as they are computed.
"""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from refimpl.broadphase.corners import meeting
from refimpl.broadphase.hierarchy import FRONT, Hierarchy
from refimpl.broadphase.parting import Members, Planes, partings
from refimpl.broadphase.protocol import Candidates
from refimpl.broadphase.ranges import pieces
from refimpl.broadphase.surfaces import bounded, reach
from refimpl.broadphase.tree import BoxHierarchy
from refimpl.linear import Array
from refimpl.signs import Indices

COPIES = 16
"""Cells are not parted any further when all objects are in so many of them, on the average."""


class PartitionTree(BoxHierarchy):
    """A binary tree of cells; along which directions they are parted, a subclass says.

    Objects that move are put into the cells where they are now; the planes stay until they make a bad tree.
    """

    @staticmethod
    @abstractmethod
    def _ways(spread: Array) -> Array:
        """Directions across which cells may be parted; see `parting.Ways`."""

    def _grow(self) -> Hierarchy:
        self._scale = reach(self.lower, self.upper)
        members, nodes = self._members(np.arange(len(self))), 1
        arity: list[Indices] = []
        planes: list[Planes] = []
        rows: list[Indices] = []
        leaves: list[Indices] = []
        hung = begin = 0
        while nodes:
            parted, found = partings(members, nodes, self._ways)
            if hung + len(members.rows) > COPIES * len(self):
                parted[:] = False
            whole = members.among(~parted)
            rows.append(whole.rows)
            leaves.append(begin + whole.node)
            arity.append(np.where(parted, 2, 0))
            planes.append(found)
            hung += len(whole.rows)
            begin += nodes
            nodes = 2 * int(np.count_nonzero(parted))
            members = members.below(found, parted)
        self._planes = Planes(*(np.concatenate(column) for column in zip(*planes, strict=True)))
        tree = Hierarchy(arity)
        self._hang(tree, np.concatenate(rows), np.concatenate(leaves))
        return tree

    def _members(self, rows: Indices) -> Members:
        """Objects as members of the root."""
        return Members(rows, np.zeros_like(rows), *bounded(self.lower[rows], self.upper[rows], self._scale))

    def _hang(self, tree: Hierarchy, rows: Indices, leaves: Indices) -> None:
        """Hang objects into leaves, in each the moving ones first."""
        sort = np.argsort(self.static[rows], kind="stable")
        tree.hang(rows[sort], leaves[sort])

    def _near_pairs(self) -> Candidates:
        tree = self.tree
        one = np.flatnonzero(~self.static[tree.order])
        leaf = tree.home[one]
        for place, other in pieces(one + 1, tree.start[leaf] + tree.count[leaf] - one - 1, FRONT):
            mine = one.take(place)
            kept = meeting(tree.items, mine, tree.items, other)
            yield tree.order.take(mine.take(kept)), tree.order.take(other.take(kept))

    # -- moving objects ----------------------------------------------------------------------------------------

    def _updated(self, rows: Indices) -> None:
        stay = np.ones(len(self), dtype=bool)
        stay[rows] = False
        kept = stay[self.tree.order]
        self._settle(rows, self.tree.order[kept], self.tree.home[kept])

    def _inserted(self, count: int) -> None:
        self._settle(np.arange(len(self) - count, len(self)), self.tree.order, self.tree.home)

    def _settle(self, new: Indices, rows: Indices, leaves: Indices) -> None:
        """Put objects into the cells that they meet, beside others that are where they were."""
        members = self._members(new)
        while len(members.rows):
            inner = self.tree.arity.take(members.node) > 0
            ends = members.at(np.flatnonzero(~inner))
            rows, leaves = np.append(rows, ends.rows), np.append(leaves, ends.node)
            members = members.at(np.flatnonzero(inner))
            sides = self._planes.sides(*members[1:])
            first = self.tree.first.take(members.node)
            halves = [members._replace(node=first + upper).at(np.flatnonzero(side)) for upper, side in enumerate(sides)]
            members = Members(*(np.concatenate(column) for column in zip(*halves, strict=True)))
        self._hang(self.tree, rows, leaves)
        self._renewed()
