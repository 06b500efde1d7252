"""Public libraries that find all pairs of many boxes or balls, as they are called from Python; for comparison only."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from refimpl.linear import Array

Rival = tuple[Callable[[Array, float], Any], Callable[[Any], int]]
"""Builds for centres (N, 3) and a radius; and finds all pairs and says how many."""


def kd_tree_of_balls() -> Rival:
    """Pairs of balls of one radius, by the distances of centres."""
    return lambda c, r: (cKDTree(c), 2 * r), lambda made: len(made[0].query_pairs(made[1], output_type="ndarray"))


def kd_tree_of_boxes() -> Rival:
    """Pairs of cubes of one size, by the largest differences of centres: the same pairs as those of boxes."""
    return (
        lambda c, r: (cKDTree(c), 2 * r),
        lambda made: len(made[0].query_pairs(made[1], p=np.inf, output_type="ndarray")),
    )


def fcl_manager() -> Rival:
    """FCL's tree; it calls a function in Python for each pair of balls that its tree proposes."""
    fcl = importlib.import_module("fcl")

    def build(center: Array, radius: float) -> Any:
        ball = fcl.Sphere(radius)
        objects = [fcl.CollisionObject(ball, fcl.Transform(c)) for c in center]
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects(objects)
        manager.setup()
        return manager

    def query(manager: Any) -> int:
        found: list[None] = []

        def meet(_a: Any, _b: Any, _data: Any) -> bool:
            found.append(None)
            return False

        manager.collide(None, meet)
        return len(found)

    return build, query


def r_tree() -> Rival:
    """libspatialindex: one R-tree in bulk, and one call for all boxes."""
    index = importlib.import_module("rtree.index")

    def build(center: Array, radius: float) -> Any:
        lower, upper = center - radius, center + radius
        numbers = np.arange(len(center), dtype=np.int64)
        properties = index.Property(dimension=3)
        ends = [np.ascontiguousarray(x) for x in (lower, upper)]
        return index.Index((numbers, *ends), properties=properties, interleaved=True), ends

    def query(made: Any) -> int:
        tree, ends = made
        _, counts = tree.intersection_v(*ends)
        return int((np.sum(counts) - len(counts)) // 2)

    return build, query


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
