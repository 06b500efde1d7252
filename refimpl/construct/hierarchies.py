"""Hierarchies of bounding volumes: each node's volume contains all points below it, proven for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.construct.bounding import KINDS
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.linear import Array
from refimpl.proxy import Proxy

MOST_NODES = 1 << 16


@dataclass(frozen=True)
class Hierarchy:
    """A binary tree of bounding volumes; the root is node 0.

    Attributes
    ----------
    volumes : one proxy for each node
    children : (m, 2) int
        Nodes below each; −1 for leaves.
    items : for each node the points (indices) below it
    """

    volumes: list[Proxy]
    children: NDArray[np.int64]
    items: list[NDArray[np.int64]]

    @property
    def leaves(self) -> list[int]:
        """Nodes without children."""
        return np.flatnonzero(self.children[:, 0] < 0).tolist()


def hierarchy(source: Any, kind: str = "aabb", leaf: int = 8) -> Hierarchy:
    """Hierarchy of bounding volumes of one kind over points.

    Points are halved at the median of the axis along which they spread most, from the top down (Ericson, Real-Time
    Collision Detection, 6.2).

    Parameters
    ----------
    source
        See `points_of`.
    kind : one of `KINDS`
        Of flat or single points not every kind has a volume; a leaf of these raises.
    leaf : int
        At most so many points are a leaf.
    """
    if kind not in KINDS:
        raise ConstructionError(f"there is no bounding volume {kind!r}; there are {', '.join(KINDS)}")
    if leaf < 1:
        raise ConstructionError(f"leaf: at least one point, got {leaf}")
    points = points_of(source)
    if 2 * len(points) // leaf > MOST_NODES:
        raise ConstructionError(f"leaf: {len(points)} points in leaves of {leaf} are more than {MOST_NODES} nodes")
    return _built(points, KINDS[kind], leaf)


def _built(points: Array, build: Callable[[Any], Proxy], leaf: int) -> Hierarchy:
    items = [np.arange(len(points))]
    volumes: list[Proxy] = []
    children: list[tuple[int, int]] = []
    for node in _growing(items):
        own = points[node]
        volumes.append(build(own))
        extent = np.ptp(own, axis=0)
        if len(own) <= leaf or not np.any(extent):
            children.append((-1, -1))
            continue
        order = np.argsort(own[:, int(np.argmax(extent))], kind="stable")
        half = len(own) // 2
        children.append((len(items), len(items) + 1))
        items += [np.sort(node[order[:half]]), np.sort(node[order[half:]])]
    return Hierarchy(volumes, np.array(children, dtype=np.int64), items)


def _growing(items: list[NDArray[np.int64]]) -> Any:
    """Items of a list that grows meanwhile."""
    place = 0
    while place < len(items):
        yield items[place]
        place += 1
