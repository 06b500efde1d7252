"""A tree of axis-aligned boxes over many small things: triangles of a mesh, pieces of a solid, parts of a composite.

The tree is flat: items are sorted by halving them, again and again, at the median of their longest extent; level l
then holds the boxes around 2^l equal runs of that order. Questions walk down level by level, a whole front of nodes
at a time (Ericson, Real-Time Collision Detection, ch. 6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array, norm
from refimpl.signs import Indices

LEAF = 4  # items below which a node is not halved again
START = 3  # level of two trees at which pairs of nodes are first compared
SLACK = 2.0**-48  # boxes are widened by this part of their coordinates, far more than they are rounded


@dataclass(frozen=True)
class Boxes:
    """Boxes center ± half, both (n, 3)."""

    center: Array
    half: Array

    @classmethod
    def around(cls, lower: Array, upper: Array) -> Boxes:
        """Boxes from corners, widened by a few roundings."""
        slack = SLACK * np.maximum(np.abs(lower), np.abs(upper))
        return cls(lower / 2 + upper / 2, (upper / 2 - lower / 2) + slack)

    def at(self, index: Indices) -> Boxes:
        """Some of the boxes."""
        return Boxes(self.center[index], self.half[index])

    def moved(self, rotation: Array, translation: Array) -> Boxes:
        """Axis-aligned boxes around these after x ↦ rotation · x + translation."""
        center = self.center @ rotation.T + translation
        half = self.half @ np.abs(rotation).T
        return Boxes(center, half + SLACK * (np.abs(center) + half + np.abs(translation)))


def gaps(a: Boxes, b: Boxes) -> Array:
    """Distances of boxes, row by row; 0 where they meet."""
    between = np.maximum(np.abs(a.center - b.center) - (a.half + b.half), 0.0)
    return norm(between)


def reaches(a: Boxes, b: Boxes) -> Array:
    """Largest distances of any two points of boxes, row by row."""
    across = np.abs(a.center - b.center) + (a.half + b.half)
    return norm(across)


class BoxTree:
    """The tree.

    Parameters
    ----------
    lower, upper : (n, 3), n ≥ 1
        Corners of the items' boxes.

    Attributes
    ----------
    items : Boxes
        The items' own boxes, in the caller's order.
    order : (n,) int
        The items, sorted so that nodes are runs.
    levels : list of Boxes
        Level l has 2^l nodes; the runs of the last hold at most `LEAF` items.
    """

    def __init__(self, lower: Array, upper: Array) -> None:
        count = len(lower)
        self.items = Boxes.around(lower, upper)
        depth = max(0, int(np.ceil(np.log2(max(count / LEAF, 1)))))
        self.bounds: list[NDArray[np.int64]] = [
            np.arange(2**level + 1) * count // 2**level for level in range(depth + 1)
        ]
        self.order = np.arange(count)
        for bounds in self.bounds[:-1]:
            self._halve(bounds)
        low, high = lower[self.order], upper[self.order]
        self.levels = [
            Boxes.around(np.minimum.reduceat(low, ends[:-1]), np.maximum.reduceat(high, ends[:-1]))
            for ends in self.bounds
        ]

    def _halve(self, bounds: NDArray[np.int64]) -> None:
        """Sort every run along the axis in which its centres spread most."""
        self.order = self.order[along_widest(self.items.center[self.order], bounds[:-1])]

    def runs(self, nodes: Indices) -> tuple[Indices, Indices]:
        """Items of nodes of the last level, and for each the place of its node in `nodes`."""
        start, stop = self.bounds[-1][nodes], self.bounds[-1][nodes + 1]
        size = stop - start
        place = np.repeat(np.arange(len(nodes)), size)
        within = np.arange(len(place)) - np.repeat(np.cumsum(size) - size, size)
        return self.order[start[place] + within], place


def along_widest(center: Array, begin: Indices) -> Indices:
    """Permutation that sorts every run of centres (n, D) along the axis in which it spreads most.

    Parameters
    ----------
    center : (n, D)
    begin : (k,), ascending
        Where the runs begin; none is empty.
    """
    spread = np.maximum.reduceat(center, begin) - np.minimum.reduceat(center, begin)
    run = np.repeat(np.arange(len(begin)), np.diff(np.append(begin, len(center))))
    key = center[np.arange(len(center)), np.argmax(spread, axis=1)[run]]
    return np.lexsort((key, run))


def near_pairs(
    x: BoxTree, y: BoxTree, rotation: Array, translation: Array, bound: float, nearest: bool = True
) -> tuple[Indices, Indices, Array]:
    """Pairs of items that can be the nearest ones, or whose boxes come as near as `bound`.

    Parameters
    ----------
    x, y : BoxTree
    rotation, translation : (3, 3), (3,)
        Put the boxes of `y` into the frame of `x`.
    bound : float
        Only pairs no farther apart than this matter. With 0, these are the pairs that can meet.
    nearest : bool
        Leave out pairs that cannot be the nearest one.

    Returns
    -------
    items of x, items of y, gap between their boxes : (k,)
        In order of the gaps. Left out are pairs whose gap exceeds `bound`, or the farthest points of another pair.
    """
    depth = max(len(x.levels), len(y.levels))
    first = min(depth - 1, START)
    a, b = (np.arange(2 ** min(first, len(tree.levels) - 1)) for tree in (x, y))
    a, b = np.repeat(a, len(b)), np.tile(b, len(a))
    for step in range(first, depth):
        i, j = min(step, len(x.levels) - 1), min(step, len(y.levels) - 1)
        if step > first:
            a, b = _children(a, b, step < len(x.levels), step < len(y.levels))
        bound, keep, _ = _within(x.levels[i].at(a), y.levels[j].at(b).moved(rotation, translation), bound, nearest)
        a, b = a[keep], b[keep]
    a, b = _all_items(x, a, y, b)
    _, keep, gap = _within(x.items.at(a), y.items.at(b).moved(rotation, translation), bound, nearest)
    keep = keep[np.argsort(gap[keep], kind="stable")]
    return a[keep], b[keep], gap[keep]


def _within(a: Boxes, b: Boxes, bound: float, nearest: bool) -> tuple[float, Indices, Array]:
    gap = gaps(a, b)
    if nearest and bound > 0:
        bound = min(bound, float(np.min(reaches(a, b), initial=np.inf)))
    return bound, np.flatnonzero(gap <= bound), gap


def _children(a: Indices, b: Indices, split_a: bool = True, split_b: bool = True) -> tuple[Indices, Indices]:
    """Every child of a node with every child of its partner."""
    if split_a:
        a, b = np.concatenate([2 * a, 2 * a + 1]), np.concatenate([b, b])
    if split_b:
        a, b = np.concatenate([a, a]), np.concatenate([2 * b, 2 * b + 1])
    return a, b


def _all_items(x: BoxTree, a: Indices, y: BoxTree, b: Indices) -> tuple[Indices, Indices]:
    """Every item of a node of the last level with every item of its partner."""
    first, place = x.runs(a)
    second, again = y.runs(b[place])
    return first[again], second
