"""A shape that helps little is put where more is missing, which small changes cannot do."""

from __future__ import annotations

import numpy as np

from refimpl.construct.adjusting import Target, adjusted, loss_at
from refimpl.construct.primitives import Family
from refimpl.linear import Array

TRIES = 2
"""Shapes that are moved in vain before it is given up."""
MOVES = 6
ROUNDS = 25


def relocated(family: Family, rows: Array, loss: float, target: Target) -> Array:
    """Rows after moves of single shapes, each followed by an adjustment, that lower the loss."""
    vain = 0
    for _ in range(MOVES):
        if vain == TRIES or len(rows) < 2:
            break
        order = np.argsort(losses_without(family, rows, target))
        others = np.delete(rows, order[vain], axis=0)
        moved = np.concatenate([others, family.ball(*largest_gap(family, others, target))[None]])
        moved, after = adjusted(family, moved, target, ROUNDS)
        if after < loss:
            rows, loss, vain = moved, after, 0
        else:
            vain += 1
    return rows


def losses_without(family: Family, rows: Array, target: Target) -> Array:
    """The loss without each of the shapes; there are at least two."""
    heights = family.heights(rows, target.points)
    nearest = np.argmin(heights, axis=1)
    least, second = np.partition(heights, 1, axis=1)[:, :2].T
    return np.array([loss_at(target, np.where(nearest == i, second, least), 1.0)[0] for i in range(len(rows))])


def largest_gap(family: Family, rows: Array, target: Target) -> tuple[Array, float]:
    """Centre and radius of a large ball in what the solid has and the shapes do not cover."""
    room = np.minimum(np.min(family.heights(rows, target.points), axis=1), target.depth)
    best = int(np.argmax(room))
    return target.points[best], max(float(room[best]), float(np.min(target.edge)) / 2)
