"""The shortest vector that satisfies linear constraints in space, for a batch of systems."""

from __future__ import annotations

import numpy as np

from refimpl.linear import Array, Bools, cross, dot, norm, scale
from refimpl.signs import Indices

SUBSETS = ((3,), (3, 0), (3, 1), (3, 2), (3, 0, 1), (3, 0, 2), (3, 1, 2))
"""Which of three constraints that hold the vector so far, and of a fourth one that is broken, may hold it next."""

ROUNDED = 1e-13  # part of a level, or of the vector, by which rounding may miss a plane
THIN = 1e-12  # determinants below say that constraints are the same, or contradict


def shortest(normals: Array, levels: Array) -> tuple[Array, Bools]:
    """Shortest vectors t with normals·t ≥ levels, and which systems have one.

    The constraint that is broken most joins, and of those that held the vector so far, at most two stay: the dual
    method of Goldfarb and Idnani (1983), with its small systems solved by trial. The vector only grows, so it ends.

    Parameters
    ----------
    normals : (n, c, 3)
        Of unit length.
    levels : (n, c)
        −inf where there is no constraint.

    Returns
    -------
    (n, 3), (n,) bool
    """
    count, constraints = levels.shape
    t, possible = np.zeros((count, 3)), np.ones(count, dtype=bool)
    if not constraints:
        return t, possible
    size = np.max(np.abs(np.where(np.isfinite(levels), levels, 0.0)), axis=1)
    active = np.full((count, 3), -1)
    rows = np.arange(count)
    for _ in range(8 * constraints + 8):
        slack = dot(normals[rows], t[rows, None, :]) - levels[rows]
        worst = np.argmin(slack, axis=1)
        broken = slack[np.arange(len(rows)), worst] < -ROUNDED * (size[rows] + norm(t[rows]))
        rows, worst = rows[broken], worst[broken]
        if not len(rows):
            return t, possible
        chosen = np.concatenate([active[rows], worst[:, None]], axis=1)
        t[rows], active[rows], held = _held(normals[rows], levels[rows], chosen, ROUNDED * size[rows])
        possible[rows[~held]] = False
        rows = rows[held]
    possible[rows] = False
    return t, possible


def _held(normals: Array, levels: Array, chosen: Indices, slack: Array) -> tuple[Array, Indices, Bools]:
    """Shortest vectors for up to four constraints (−1: none) of which the last holds, and those that hold them."""
    count = len(chosen)
    there = chosen >= 0
    n = np.take_along_axis(normals, np.maximum(chosen, 0)[:, :, None], axis=1)
    level = np.where(there, np.take_along_axis(levels, np.maximum(chosen, 0), axis=1), -np.inf)
    best, active, held = np.zeros((count, 3)), np.full((count, 3), -1), np.zeros(count, dtype=bool)
    for subset in SUBSETS:
        usable = np.all(there[:, subset], axis=1) & ~held
        finite = np.where(there, level, 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            t, right = _meeting([n[:, i] for i in subset], [finite[:, i] for i in subset])
            give = slack + ROUNDED * norm(t)
            fits = np.all((dot(n, t[:, None, :]) >= level - give[:, None]) | ~there, axis=1)
        good = usable & right & fits
        best[good] = t[good]
        active[good] = -1
        for place, i in enumerate(subset):
            active[good, place] = chosen[good, i]
        held |= good
    return best, active, held


def _meeting(n: list[Array], level: list[Array]) -> tuple[Array, Bools]:
    """Shortest vectors on one, two or three planes, and whether all planes push it outwards."""
    if len(n) == 1:
        return scale(level[0], n[0]), level[0] >= 0
    if len(n) == 2:
        g = dot(n[0], n[1])
        det = (1 - g) * (1 + g)
        first, second = (level[0] - g * level[1]) / det, (level[1] - g * level[0]) / det
        return scale(first, n[0]) + scale(second, n[1]), (det > THIN) & (first >= 0) & (second >= 0)
    sides = [cross(n[1], n[2]), cross(n[2], n[0]), cross(n[0], n[1])]
    det = dot(n[0], sides[0])
    t = scale(1 / det, scale(level[0], sides[0]) + scale(level[1], sides[1]) + scale(level[2], sides[2]))
    right = np.abs(det) > THIN
    for side in sides:
        right &= dot(t, side) / det >= 0
    return t, right
