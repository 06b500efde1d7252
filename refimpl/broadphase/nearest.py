"""The k nearest objects of a tree of boxes, for many points at the same time.

A front of (point, node) pairs goes down level by level. A node of at least k objects bounds the distance of the k-th
nearest one by that of its farthest point; nodes beyond the least such bound are left out (Roussopoulos, Kelley &
Vincent 1995, Nearest Neighbor Queries).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from refimpl.broadphase.corners import Corners
from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.ranges import written_out
from refimpl.linear import Array, Bools
from refimpl.signs import Indices

TOGETHER = 1 << 12
"""Points that are looked at together."""
SLACK = 1 + 2.0**-48
"""Distances are rounded by less than this factor."""

Distance = Callable[[Indices, Indices], Array]
"""Distances of points from objects, by their numbers, row by row."""


def nearest(tree: Hierarchy, nodes: Corners, points: Array, count: int, distance: Distance) -> tuple[Array, Indices]:
    """Distances and rows of the nearest objects.

    Parameters
    ----------
    tree : Hierarchy
    nodes : Corners
        The boxes of its nodes in a unit in which no finite coordinate exceeds 1.
    points : (Q, D), finite
        In the same unit.
    count : int, at least 1
    distance : callable
        No less than the distance of the object's box, and no more than that of its farthest point.

    Returns
    -------
    (Q, count), (Q, count)
        Ascending; of equal distances the one of the smaller row comes first. Where there are fewer objects, the rest
        is infinite, of row −1.
    """
    distances, rows = np.full((len(points), count), np.inf), np.full((len(points), count), -1, dtype=np.int64)
    members = _members(tree)
    for begin in range(0, len(points), TOGETHER):
        some = np.arange(begin, min(begin + TOGETHER, len(points)))

        def length(query: Indices, row: Indices, some: Indices = some) -> Array:
            return distance(some[query], row)

        query, leaf, gap, bound = _near_leaves(tree, members, nodes, points[some], count)
        first = _first_leaves(query, leaf, gap, tree.count >= count)
        _, _, found, rank = _sorted(*_below(tree, query[first], leaf[first]), length)
        asked = query[first]
        bound[asked] = np.minimum(bound[asked], found[rank == count - 1])
        near = gap <= bound.take(query) * SLACK
        query, row, found, rank = _sorted(*_below(tree, query[near], leaf[near]), length)
        best = np.flatnonzero(rank < count)
        place = some[query[best]], rank[best]
        distances[place], rows[place] = found[best], row[best]
    return distances, rows


def _below(tree: Hierarchy, query: Indices, leaf: Indices) -> tuple[Indices, Indices]:
    """Points and the rows that hang in leaves, each pair once."""
    place, item = written_out(tree.start.take(leaf), tree.count.take(leaf))
    key = np.unique(query.take(place) * (len(tree.order) + 1) + tree.order.take(item))
    return np.divmod(key, len(tree.order) + 1)


def _sorted(query: Indices, row: Indices, length: Distance) -> tuple[Indices, Indices, Array, Indices]:
    """Points and rows in order of point, distance, row; the distances; and each one's rank for its point."""
    found = length(query, row)
    sort = np.lexsort((row, found, query))
    query = query[sort]
    return query, row[sort], found[sort], np.arange(len(query)) - np.searchsorted(query, query)


def _first_leaves(query: Indices, leaf: Indices, gap: Array, full: Bools) -> Indices:
    """For each point the place of its nearest leaf, among those that are full enough."""
    place = np.flatnonzero(full.take(leaf))
    place = place[np.lexsort((gap[place], query[place]))]
    _, first = np.unique(query[place], return_index=True)
    return np.asarray(place[first])


def spans(points: Array, boxes: Corners, index: Indices) -> tuple[Array, Array]:
    """Distances of points (n, D) from boxes, row by row: of the nearest and of the farthest point of the box.

    Finite coordinates must not exceed 2^500. Lengths that the largest ones exceed by 2^500 may count as 0.
    """
    gap, far = np.zeros(len(points)), np.zeros(len(points))
    with np.errstate(under="ignore"):
        for x, low, high in zip(points.T, *boxes, strict=True):
            below, above = low.take(index) - x, x - high.take(index)
            gap += np.maximum(np.maximum(below, above), 0.0) ** 2
            far += np.maximum(np.abs(below), np.abs(above)) ** 2
    return np.sqrt(gap), np.sqrt(far)


def _members(tree: Hierarchy) -> Indices:
    """How many objects hang below each node; one that hangs in several leaves counts in one of them."""
    found = np.zeros(len(tree), dtype=np.int64)
    _, first = np.unique(tree.order, return_index=True)
    np.add.at(found, tree.home[first], 1)
    for inner in reversed(tree.inner):
        if len(inner):
            stop = tree.first[inner[-1]] + tree.arity[inner[-1]]
            found[inner] = np.add.reduceat(found[:stop], tree.first[inner])
    return found


def _near_leaves(
    tree: Hierarchy, members: Indices, nodes: Corners, points: Array, count: int
) -> tuple[Indices, Indices, Array, Array]:
    """Points, leaves that may hold one of their nearest objects, their distances; and bounds of the answers."""
    roots = tree.roots
    query, node = np.repeat(np.arange(len(points)), len(roots)), np.tile(roots, len(points))
    bound = np.full(len(points), np.inf)
    leaves: list[tuple[Indices, Indices, Array]] = []
    while len(node):
        gap, far = spans(points.take(query, axis=0), nodes, node)
        enough = members.take(node) >= count
        np.minimum.at(bound, query[enough], far[enough])
        near = gap <= bound.take(query) * SLACK
        leaf = near & (tree.arity.take(node) == 0)
        leaves.append((query[leaf], node[leaf], gap[leaf]))
        inner = near & ~leaf
        child, place = tree.below(node[inner])
        query, node = query[inner].take(place), child
    query, node, gap = (np.concatenate(column) for column in zip(*leaves, strict=True))
    near = gap <= bound.take(query) * SLACK
    return query[near], node[near], gap[near], bound
