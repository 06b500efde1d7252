"""Public libraries that find all pairs of many boxes or balls, as they are called from Python; for comparison only."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from refimpl.linear import Array


class Rival(NamedTuple):
    """A library: makes what it is to be given of centres (N, 3) and a radius; builds; finds all pairs, and counts them.

    What it is given is made before the clock runs.
    """

    prepare: Callable[[Array, float], Any]
    build: Callable[[Any], Any]
    count: Callable[[Any], int]


def as_given(center: Array, radius: float) -> tuple[Array, float]:
    """Centres, and the distance at which balls touch."""
    return center, 2 * radius


def kd_tree_of_balls() -> Rival:
    """Pairs of balls of one radius, by the distances of centres."""
    return Rival(
        as_given,
        lambda given: (cKDTree(given[0]), given[1]),
        lambda made: len(made[0].query_pairs(made[1], output_type="ndarray")),
    )


def kd_tree_of_boxes() -> Rival:
    """Pairs of cubes of one size, by the largest differences of centres: the same pairs as those of boxes."""
    return Rival(
        as_given,
        lambda given: (cKDTree(given[0]), given[1]),
        lambda made: len(made[0].query_pairs(made[1], p=np.inf, output_type="ndarray")),
    )


def fcl_manager() -> Rival:
    """FCL's tree; it calls a function in Python for each pair of balls that its tree proposes."""
    fcl = importlib.import_module("fcl")

    def prepare(center: Array, radius: float) -> Any:
        ball = fcl.Sphere(radius)
        return [fcl.CollisionObject(ball, fcl.Transform(c)) for c in center]

    def build(objects: Any) -> Any:
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects(objects)
        manager.setup()
        return manager

    def count(manager: Any) -> int:
        found: list[None] = []

        def meet(_a: Any, _b: Any, _data: Any) -> bool:
            found.append(None)
            return False

        manager.collide(None, meet)
        return len(found)

    return Rival(prepare, build, count)


def r_tree() -> Rival:
    """libspatialindex: one R-tree in bulk, and one call for all boxes."""
    index = importlib.import_module("rtree.index")

    def prepare(center: Array, radius: float) -> Any:
        return np.arange(len(center), dtype=np.int64), center - radius, center + radius

    def build(given: Any) -> Any:
        return index.Index(given, properties=index.Property(dimension=3), interleaved=True), given[1:]

    def count(made: Any) -> int:
        tree, ends = made
        _, counts = tree.intersection_v(*ends)
        return int((np.sum(counts) - len(counts)) // 2)

    return Rival(prepare, build, count)


RIVALS: dict[str, Callable[[], Rival]] = {
    "scipy cKDTree, balls": kd_tree_of_balls,
    "scipy cKDTree, boxes": kd_tree_of_boxes,
    "FCL DynamicAABBTree": fcl_manager,
    "rtree": r_tree,
}


def available() -> dict[str, Rival]:
    """Those that can be imported."""
    found = {}
    for name, make in RIVALS.items():
        try:
            found[name] = make()
        except ImportError:
            continue
    return found
