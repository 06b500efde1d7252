"""Smallest enclosing circle of points in a plane, in doubles: it only proposes (Welzl 1991, by farthest points)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from refimpl.linear import Array

ROUNDS = 64


def smallest_circle(points: Array) -> tuple[Array, float]:
    """Centre (2,) and radius of a circle about points (n, 2) that is the smallest, up to rounding."""
    kept = [int(np.argmin(points[:, 0]))]
    center, radius = points[kept[0]], 0.0
    for _ in range(ROUNDS):
        gap = points - center
        square = gap[:, 0] ** 2 + gap[:, 1] ** 2
        far = int(np.argmax(square))
        if square[far] <= radius * radius * (1 + 1e-12) or far in kept:
            break
        center, radius, kept = _of_few(points, [*kept, far])
    return center, radius


def _of_few(points: Array, names: list[int]) -> tuple[Array, float, list[int]]:
    """Smallest circle of at most four points, by all pairs and triples, and the points that it touches."""
    best = (points[names[0]], np.inf, names)
    for count in (2, 3):
        for chosen in combinations(names, count):
            corner = points[list(chosen)]
            center = _center(corner)
            if center is None:
                continue
            radius = float(np.hypot(*(corner[0] - center)))
            reach = float(np.max(np.hypot(*(points[names] - center).T)))
            if reach <= radius * (1 + 1e-12) and radius < best[1]:
                best = (center, radius, list(chosen))
    return best


def _center(corners: Array) -> Array | None:
    start, edges = corners[0], corners[1:] - corners[0]
    if len(edges) == 1:
        return np.asarray(start + edges[0] / 2)
    (a, b), (c, d) = edges
    twice = 2 * (a * d - b * c)
    if twice == 0:
        return None
    p, q = a * a + b * b, c * c + d * d
    return np.asarray(start + np.array([(d * p - b * q) / twice, (a * q - c * p) / twice]))
