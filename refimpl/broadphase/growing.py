"""Trees built from the top downwards, a level at a time: every node deals its objects out to its children."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.ranges import written_out
from refimpl.linear import Bools
from refimpl.signs import Indices


class Divider(Protocol):
    """How the nodes of one level deal out their objects."""

    fan: int

    def final(self) -> Bools:
        """Nodes of the present level that stay whole, whatever they hold."""
        ...

    def deal(self, node: Indices, owner: Indices, rows: Indices) -> Indices:
        """Give each object one of `fan` children.

        Parameters
        ----------
        node : (k,)
            Numbers, within the level, of the nodes that are divided.
        owner : (m,), ascending
            For each object of theirs, the place of its node in `node`.
        rows : (m,)
            The objects.
        """
        ...

    def descend(self, node: Indices, child: Indices) -> None:
        """Go on to the next level: each of its nodes is the given child of the given node."""
        ...


def grow(groups: list[Indices], divider: Divider, leaf: int) -> Hierarchy:
    """Build a tree over the rows of each group, each with a root of its own.

    Parameters
    ----------
    groups : list of (n_g,) int, none empty
    divider : Divider
        In a state that fits the roots. It must part any two nodes that are not final in the end.
    leaf : int
        A node of no more objects is not divided.
    """
    order = np.concatenate([np.empty(0, dtype=np.int64), *groups])
    size = np.array([len(group) for group in groups], dtype=np.int64)
    start = np.cumsum(size) - size
    arity, rows, homes, before = [], [], [], 0
    while len(size):
        divided = (size > leaf) & ~divider.final()
        whole = np.flatnonzero(~divided)
        owner, place = written_out(start[whole], size[whole])
        rows.append(order[place])
        homes.append(before + whole[owner])
        before += len(size)
        node = np.flatnonzero(divided)
        owner, place = written_out(start[node], size[node])
        members = order[place]
        key = owner * divider.fan + divider.deal(node, owner, members)
        sort = np.argsort(key * len(key) + np.arange(len(key)))  # a stable sort that is faster than a stable sort
        order[place] = members[sort]
        number = np.bincount(key, minlength=len(node) * divider.fan)
        child = np.flatnonzero(number)
        parent = child // divider.fan
        divider.descend(node[parent], child % divider.fan)
        level = np.zeros(len(size), dtype=np.int64)
        level[node] = np.bincount(parent, minlength=len(node))
        arity.append(level)
        start = place[(np.cumsum(number) - number)[child]]
        size = number[child]
    tree = Hierarchy(arity)
    nothing = np.empty(0, dtype=np.int64)
    tree.hang(np.concatenate([nothing, *rows]), np.concatenate([nothing, *homes]))
    return tree
