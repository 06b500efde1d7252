"""A hierarchy of boxes, flat: every node's box holds those of its children, down to leaves that hold objects.

Nodes are numbered level by level, so that the children of a node, and all nodes of a level, are runs of numbers. Boxes
are fitted from the leaves upwards, a level at a time; questions go downwards with a whole front of nodes (Ericson,
Real-Time Collision Detection, ch. 6). Nothing is rounded: a node's box is the least one, and comparisons are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from refimpl.broadphase.corners import Corners, meeting
from refimpl.broadphase.ranges import pieces, written_out
from refimpl.linear import Array
from refimpl.signs import Indices

FRONT = 1 << 16
"""Pairs that are looked at together: as many as stay in the processor's cache."""

Front = tuple[Indices, Indices]
Near = Callable[[Indices, Corners, Indices], Indices]
"""Places k at which the query i[k] may meet the box j[k]: called as near(i, boxes, j)."""


class Hierarchy:
    """The tree.

    Parameters
    ----------
    arity : list of (n_l,) int
        For each level, how many children its nodes have; 0 is a leaf. The nodes of the first level are roots.

    Attributes
    ----------
    arity, first : (k,) int
        How many children a node has, and the number of the first one.
    ends : list of int
        Level l has the nodes ends[l], ..., ends[l + 1] − 1.
    order, home : (r,) int
        The rows that hang in the leaves, and the leaf of each, in order of the leaves. A row may hang in several.
    start, count : (k,) int
        Run of each node in `order`; only leaves have one.
    nodes, items : Corners
        Boxes of the nodes, and of what hangs in the leaves, in that order.
    """

    nodes: Corners
    items: Corners

    def __init__(self, arity: Sequence[Indices]) -> None:
        self.ends: list[int] = [0, *np.cumsum([len(level) for level in arity]).tolist()]
        self.arity = np.concatenate([np.empty(0, dtype=np.int64), *arity])
        self.first = self.ends[min(1, len(arity))] + np.cumsum(self.arity) - self.arity
        self.inner = [begin + np.flatnonzero(level) for begin, level in zip(self.ends, arity, strict=False)]
        self.hang(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.arity)

    @property
    def roots(self) -> Indices:
        """The nodes of the first level."""
        return np.arange(self.ends[min(1, len(self.ends) - 1)])

    def hang(self, rows: Indices, leaves: Indices) -> None:
        """Hang rows into leaves, in place of what had been there."""
        sort = np.argsort(leaves, kind="stable")
        self.order, self.home = rows[sort], leaves[sort]
        self.count = np.bincount(leaves, minlength=len(self))
        self.start = np.cumsum(self.count) - self.count

    def refit(self, lower: Array, upper: Array) -> None:
        """Fit all boxes to those of the rows, (n, D)."""
        self.items = Corners.of(lower, upper).at(self.order)
        self.nodes = Corners.empty(lower.shape[1], len(self))
        full = np.flatnonzero(self.count)
        for items, nodes, least in self._sides():
            if len(full):
                nodes[full] = least.reduceat(items, self.start[full])
            for inner in reversed(self.inner):
                if len(inner):
                    stop = self.first[inner[-1]] + self.arity[inner[-1]]
                    nodes[inner] = least.reduceat(nodes[:stop], self.first[inner])

    def _sides(self) -> Iterator[tuple[Array, Array, np.ufunc]]:
        """Each coordinate of the items, that of the nodes, and whether the least or the greatest counts."""
        for side, least in ((0, np.minimum), (1, np.maximum)):
            for items, nodes in zip(self.items[side], self.nodes[side], strict=True):
                yield items, nodes, least

    def below(self, nodes: Indices) -> Front:
        """Children of nodes, and the place of each one's parent in `nodes`; leaves stand for themselves."""
        arity = self.arity.take(nodes)
        first = np.where(arity > 0, self.first.take(nodes), nodes)
        place, child = written_out(first, np.maximum(arity, 1))
        return child, place

    # -- pairs -----------------------------------------------------------------------------------------------

    def pairs(self, front: Front) -> Iterator[Front]:
        """Rows of objects whose boxes meet, found by descending into two nodes at the same time.

        Parameters
        ----------
        front : two arrays of nodes
            Pairs of nodes whose objects are compared: a node and itself, or two of which none is below the other.
        """
        waiting = [front]
        while waiting:
            a, b = waiting.pop()
            if len(a) > FRONT:
                waiting += [(a[FRONT:], b[FRONT:]), (a[:FRONT], b[:FRONT])]
                continue
            leaves = (self.arity.take(a) == 0) & (self.arity.take(b) == 0)
            if leaves.any():
                yield from self._pairs_of_leaves(a[leaves], b[leaves])
                a, b = a[~leaves], b[~leaves]
            if len(a):
                waiting.append(self._pairs_below(a, b))

    def _pairs_below(self, a: Indices, b: Indices) -> Front:
        """Children of nodes and of their partners, where their boxes meet."""
        child, place = self.below(a)
        kept = meeting(self.nodes, child, self.nodes, b.take(place))
        child, place = child.take(kept), place.take(kept)
        partner, again = self.below(b.take(place))
        child, place = child.take(again), place.take(again)
        once = np.flatnonzero((a != b).take(place) | (child <= partner))
        child, partner = child.take(once), partner.take(once)
        kept = meeting(self.nodes, child, self.nodes, partner)
        return child.take(kept), partner.take(kept)

    def _pairs_of_leaves(self, a: Indices, b: Indices) -> Iterator[Front]:
        """Objects of leaves and of their partners, where their boxes meet."""
        for owner, item in pieces(self.start[a], self.count[a], FRONT):
            leaf = b.take(owner)
            kept = meeting(self.items, item, self.nodes, leaf)
            one, leaf = item.take(kept), leaf.take(kept)
            stop = self.start.take(leaf) + self.count.take(leaf)
            start = np.where(self.home.take(one) == leaf, one + 1, self.start.take(leaf))
            for place, other in pieces(start, stop - start, FRONT):
                mine = one.take(place)
                kept = meeting(self.items, mine, self.items, other)
                yield self.order.take(mine.take(kept)), self.order.take(other.take(kept))

    # -- queries ---------------------------------------------------------------------------------------------

    def found(self, queries: int, near: Near) -> Iterator[Front]:
        """Queries and rows of objects that may meet, found by descending with all queries at the same time."""
        roots = self.roots
        step = max(1, FRONT // max(1, len(roots)))
        for begin in range(0, queries, step):
            some = np.arange(begin, min(begin + step, queries))
            yield from self._found([(np.repeat(some, len(roots)), np.tile(roots, len(some)))], near)

    def _found(self, waiting: list[Front], near: Near) -> Iterator[Front]:
        while waiting:
            query, node = waiting.pop()
            if len(node) > FRONT:
                waiting += [(query[FRONT:], node[FRONT:]), (query[:FRONT], node[:FRONT])]
                continue
            kept = near(query, self.nodes, node)
            query, node = query.take(kept), node.take(kept)
            leaf = self.arity.take(node) == 0
            for place, item in pieces(self.start[node[leaf]], self.count[node[leaf]], FRONT):
                asking = query[leaf].take(place)
                kept = near(asking, self.items, item)
                yield asking.take(kept), self.order.take(item.take(kept))
            query, node = query[~leaf], node[~leaf]
            if len(node):
                child, place = self.below(node)
                waiting.append((query.take(place), child))
