"""Spheres, capsules and boxes as rows of numbers that can be varied: heights of points over them, and derivatives.

A height changes with a shape as the surface's nearest point moves: by minus its velocity along the outward normal. So
the derivative needs only that point and the normal there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array, apply, apply_inverse, cross, dot, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy
from refimpl.shapes import Box, Capsule, Sphere

LEAST = 1e-6  # of the mesh's size: no radius and no half extent becomes smaller


@dataclass(frozen=True)
class Family:
    """One kind of shape by its numbers.

    Attributes
    ----------
    heights
        From rows (k, w) and points (n, 3) to signed distances (n, k).
    slopes
        From rows (n, w) and points (n, 3), row by row, to the derivatives (n, w) of the heights.
    proxy
        From one row (w,) to the proxy.
    ball
        From a centre and a radius to a row (w,) of a shape in that ball.
    lengths : slice
        The numbers that are at least `LEAST`: radius or half extents.
    """

    heights: Callable[[Array, Array], Array]
    slopes: Callable[[Array, Array], Array]
    proxy: Callable[[Array], Proxy]
    ball: Callable[[Array, float], Array]
    lengths: slice


# ------------------------------------------------------------------------------------------- spheres: center, radius


def _over_spheres(rows: Array, points: Array) -> Array:
    return np.sqrt(squared_distances(points, rows[:, :3])) - rows[:, 3]


def squared_distances(x: Array, y: Array) -> Array:
    """Squares (n, m) of the distances of n points from m, good to rounding of the largest one."""
    middle = np.mean(y, axis=0)
    x, y = x - middle, y - middle
    return np.maximum(dot(x, x)[:, None] + dot(y, y) - 2 * (x @ y.T), 0.0)


def _slopes_of_spheres(rows: Array, points: Array) -> Array:
    out, _ = unit_or(points - rows[:, :3], np.eye(3)[0])
    return np.concatenate([-out, np.full((len(points), 1), -1.0)], axis=1)


# ------------------------------------------------------------------------------------------- capsules: p, q, radius


def _over_capsules(rows: Array, points: Array) -> Array:
    p, along = rows[:, :3], rows[:, 3:6] - rows[:, :3]
    length = dot(along, along)
    rise = points @ along.T - dot(p, along)
    share = np.clip(rise / np.where(length > 0, length, 1.0), 0.0, 1.0)
    squared = squared_distances(points, p) + share * (share * length - 2 * rise)
    return np.sqrt(np.maximum(squared, 0.0)) - rows[:, 6]


def _slopes_of_capsules(rows: Array, points: Array) -> Array:
    p, q = rows[:, :3], rows[:, 3:6]
    length = dot(q - p, q - p)
    share = np.clip(dot(points - p, q - p) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    out, _ = unit_or(points - p - scale(share, q - p), np.eye(3)[0])
    return np.concatenate([scale(share - 1, out), scale(-share, out), np.full((len(points), 1), -1.0)], axis=1)


# ------------------------------------------------------------------------------------------- boxes: center, half, turn


def _over_boxes(rows: Array, points: Array) -> Array:
    turns = rotation_matrix(rows[:, 6:])
    outside, inside = np.zeros((len(points), len(rows))), np.full((len(points), len(rows)), -np.inf)
    for i in range(3):
        axes = turns[:, :, i]
        beyond = np.abs(points @ axes.T - dot(rows[:, :3], axes)) - rows[:, 3 + i]
        outside += np.maximum(beyond, 0.0) ** 2
        np.maximum(inside, beyond, out=inside)
    return np.asarray(np.sqrt(outside) + np.minimum(inside, 0.0))


def _slopes_of_boxes(rows: Array, points: Array) -> Array:
    turn, half = rotation_matrix(rows[:, 6:]), rows[:, 3:6]
    local = apply_inverse(turn, points - rows[:, :3])
    sign, beyond = np.where(local < 0, -1.0, 1.0), np.abs(local) - half
    nearest_face = np.eye(3)[np.argmax(beyond, axis=1)]
    out, _ = unit_or(np.maximum(beyond, 0.0), np.eye(3)[0])
    out = np.where(np.any(beyond > 0, axis=1)[:, None], out, nearest_face)
    foot = np.where(out > 0, half, np.minimum(np.abs(local), half)) * sign
    normal = apply(turn, out * sign)
    spin = -cross(apply(turn, foot), normal)
    return np.concatenate([-normal, -out, _by_quaternion(rows[:, 6:], spin)], axis=1)


def _by_quaternion(quaternion: Array, spin: Array) -> Array:
    """Derivatives by a quaternion's numbers (x, y, z, w), from those by a turn about the three axes."""
    v, w = quaternion[:, :3], quaternion[:, 3]
    size = 2 / (dot(v, v) + w * w)
    return scale(size, np.concatenate([scale(w, spin) + cross(spin, v), -dot(spin, v)[:, None]], axis=1))


def _box(row: Array) -> Proxy:
    return Box(row[:3], row[3:6], row[6:] / np.max(np.abs(row[6:])))


SPHERES = Family(
    _over_spheres,
    _slopes_of_spheres,
    lambda row: Sphere(row[:3], row[3]),
    lambda center, radius: np.array([*center, radius]),
    slice(3, 4),
)
CAPSULES = Family(
    _over_capsules,
    _slopes_of_capsules,
    lambda row: Capsule(row[:3], row[3:6], row[6]),
    lambda center, radius: np.array([*(center - 0.2 * radius), *(center + 0.2 * radius), 0.6 * radius]),
    slice(6, 7),
)
BOXES = Family(
    _over_boxes,
    _slopes_of_boxes,
    _box,
    lambda center, radius: np.array([*center, *[0.5 * radius] * 3, 0.0, 0.0, 0.0, 1.0]),
    slice(3, 6),
)
