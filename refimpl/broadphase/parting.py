"""Planes that part the objects of many cells at the same time, each cell by a plane of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from refimpl.linear import Array, Bools
from refimpl.signs import Indices

LEAF = 48
"""So few objects are not parted."""
GAIN = 0.85
"""A plane is worth it if it leaves no more than this part of the pairs within cells."""

Ways = Callable[[Array], Array]
"""Of the covariances (k, D, D) of the centres in cells, the directions (D, k, D) across which they may be parted.

The best ones come first; no coordinate exceeds 1.
"""


class Planes(NamedTuple):
    """Planes normal·x = offset, one for each node: (k, D) and (k,)."""

    normal: Array
    offset: Array

    def sides(self, node: Indices, low: Array, high: Array) -> tuple[Bools, Bools]:
        """Whether boxes (m, D) reach below the planes of their nodes, and whether they reach them from above."""
        least, most = heights(self.normal.take(node, axis=0), low, high)
        offset = self.offset.take(node)
        return least < offset, most >= offset


def heights(normal: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Least and greatest normal·x of the points of boxes, row by row; monotonic in every coordinate."""
    least, most = np.zeros(len(normal)), np.zeros(len(normal))
    for axis in range(normal.shape[1]):
        one, other = normal[:, axis] * low[:, axis], normal[:, axis] * high[:, axis]
        least += np.minimum(one, other)
        most += np.maximum(one, other)
    return least, most


class Members(NamedTuple):
    """Objects in the cells of one level.

    Attributes
    ----------
    rows, node : (m,)
        Which objects, and in which nodes of the level.
    low, high : (m, D)
        Their boxes, finite.
    """

    rows: Indices
    node: Indices
    low: Array
    high: Array

    def at(self, index: Indices) -> Members:
        """Some of them."""
        return Members(self.rows[index], self.node[index], self.low[index], self.high[index])

    def among(self, chosen: Bools) -> Members:
        """Those whose nodes are chosen."""
        return self.at(np.flatnonzero(chosen.take(self.node)))

    def below(self, planes: Planes, chosen: Bools) -> Members:
        """What is in the two halves of the chosen nodes, which are numbered through; some objects are in both."""
        mine = self.among(chosen)
        sides = planes.sides(mine.node, mine.low, mine.high)
        index = np.concatenate([np.flatnonzero(side) for side in sides])
        upper = np.repeat([0, 1], [np.count_nonzero(side) for side in sides])
        node = 2 * (np.cumsum(chosen) - 1).take(mine.node.take(index)) + upper
        sort = np.argsort(node * len(node) + np.arange(len(node)))
        return mine.at(index.take(sort))._replace(node=node.take(sort))


def partings(members: Members, nodes: int, ways: Ways) -> tuple[Bools, Planes]:
    """Which nodes are parted, and by which planes: for each node the first of those tried that is worth it.

    Tried is the plane through the mean of the centres across the best direction, then those through their medians
    across each direction.
    """
    size = np.bincount(members.node, minlength=nodes)
    planes = Planes(np.zeros((nodes, members.low.shape[1])), np.zeros(nodes))
    parted, left = np.zeros(nodes, dtype=bool), size > LEAF
    directions = ways(_spread(members.among(left), nodes))
    for number, way in enumerate([directions[0], *directions]):
        mine = members.among(left)
        if len(mine.rows) == 0:
            break
        center = mine.low / 2 + mine.high / 2
        height, _ = heights(way.take(mine.node, axis=0), center, center)
        tried = Planes(way, _medians(height, mine.node, nodes) if number else _means(height, mine.node, nodes))
        below, above = (np.bincount(mine.node[side], minlength=nodes) for side in tried.sides(*mine[1:]))
        good = left & (below.astype(float) ** 2 + above.astype(float) ** 2 < GAIN * size.astype(float) ** 2)
        planes.normal[good], planes.offset[good] = tried.normal[good], tried.offset[good]
        parted |= good
        left &= ~good
    return parted, planes


def _spread(members: Members, nodes: int) -> Array:
    """Covariances (k, D, D) of the centres in nodes, up to a factor."""
    columns = (members.low / 2 + members.high / 2).T
    away = [column - _means(column, members.node, nodes).take(members.node) for column in columns]
    found = np.empty((nodes, len(away), len(away)))
    for i, x in enumerate(away):
        for j, y in enumerate(away[: i + 1]):
            found[:, i, j] = found[:, j, i] = np.bincount(members.node, x * y, nodes)
    return found


def _means(values: Array, node: Indices, nodes: int) -> Array:
    """Mean of the values of each node."""
    return np.bincount(node, values, nodes) / np.maximum(np.bincount(node, minlength=nodes), 1)


def _medians(values: Array, node: Indices, nodes: int) -> Array:
    """Middle one of the values of each node."""
    sort = np.lexsort((values, node))
    there, begin, size = np.unique(node[sort], return_index=True, return_counts=True)
    found = np.zeros(nodes)
    found[there] = values[sort[begin + size // 2]]
    return found
