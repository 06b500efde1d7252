"""Bounding volumes of many points, beside trimesh's: ``python -m tests.benchmarks.construct [--points N] [kinds]``.

Seconds of processor time, in one thread, the least of two runs each, in turns. What is asked of a million points: half
a second for spheres, boxes along the axes and k-DOPs, five for turned boxes. Each volume is then held against all
points by `contains`. trimesh takes arrays of points as well (`trimesh.PointCloud`), and first computes their hull.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from refimpl.construct import KINDS, contains
from refimpl.linear import Array

ASKED = {"aabb": 0.5, "sphere": 0.5, "fast_sphere": 0.5, "kdop6": 0.5, "kdop14": 0.5, "kdop18": 0.5, "kdop26": 0.5,
         "box": 5.0, "least_box": 5.0}  # fmt: skip
PRIMITIVES = {"aabb": "bounds", "sphere": "bounding_sphere", "least_box": "bounding_box_oriented",
              "cylinder": "bounding_cylinder", "hull": "convex_hull"}  # fmt: skip
REPEATS = 2


def clouds(count: int) -> dict[str, Array]:
    """Points as they come, far from the origin, all on a sphere or a circle, few many times, and of a mesh's grid."""
    rng = np.random.default_rng(0)
    normal = rng.normal(size=(count, 3))
    angle = rng.random(count) * 2 * np.pi
    turn = np.linalg.qr(normal[:3])[0]
    return {
        "normal": normal,
        "far away": normal + 1e6,
        "on a sphere": normal / np.linalg.norm(normal, axis=1)[:, None],
        "on a circle": np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1) @ turn,
        "corners of a cube": rng.choice([-1.0, 1.0], size=(count, 3)) @ turn + 0.3,
        "coplanar grid": np.stack([*rng.integers(0, 1000, size=(2, count)), np.full(count, 7)], axis=1).astype(float),
    }


def seconds(work: Callable[[], object]) -> float:
    """Processor time of one run."""
    start = time.process_time()
    work()
    return time.process_time() - start


def theirs(kind: str, points: Array) -> Callable[[], object] | None:
    """The same of trimesh, where it has it; each run with a cloud of its own, as it keeps what it has computed."""
    try:
        trimesh: Any = import_module("trimesh")
    except ImportError:
        return None
    name = PRIMITIVES.get(kind)
    return None if name is None else lambda: getattr(trimesh.PointCloud(points), name)


def least(*work: Callable[[], object] | None) -> list[str]:
    """Least times of several, which take turns; what is missing or raises is a dash or its error."""
    best: list[float | str] = ["–" if one is None else np.inf for one in work]
    for _ in range(REPEATS):
        for i, one in enumerate(work):
            if one is None or isinstance(best[i], str):
                continue
            try:
                best[i] = min(float(best[i]), seconds(one))
            except Exception as error:  # whatever a library raises
                best[i] = type(error).__name__
    return [one if isinstance(one, str) else f"{one:.3f}" for one in best]


def main() -> None:
    parser = argparse.ArgumentParser(description="Times of bounding volumes.")
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("kinds", nargs="*", help="names out of refimpl.construct.KINDS", default=[])
    options = parser.parse_args()
    kinds = options.kinds or [*ASKED, "capsule", "cylinder", "ellipsoid"]
    table = Table(title=f"{options.points} points, seconds of processor time")
    for column in ("points", "volume", "refimpl", "asked", "trimesh", "contains all"):
        table.add_column(column)
    for name, points in clouds(options.points).items():
        for kind in kinds:
            try:
                whole = str(bool(contains(KINDS[kind](points), points).all()))
            except ValueError as error:
                table.add_row(name, kind, "–", "", "", str(error)[:40])
                continue
            ours, other = least(lambda k=kind, x=points: KINDS[k](x), theirs(kind, points))
            table.add_row(name, kind, ours, str(ASKED.get(kind, "")), other, whole)
    Console().print(table)


if __name__ == "__main__":
    main()
