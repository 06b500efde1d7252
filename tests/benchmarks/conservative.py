"""Continuous collision detection in doubles by inclusion, the common conservative method, to compare with.

Snyder 1992, Interval Analysis for Computer Graphics; Wang et al. 2021 made it the method of choice. The difference
of a point of the one set and a point of the other is a polynomial in the time and two parameters, linear in each: on a
box of these three its values lie in the box around those at the eight corners. Boxes whose values are away from 0 are
dropped, the others halved, until one has values within `TOLERANCE`, which counts as a collision. So no collision is
missed, and things that pass closer than that are often said to collide.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TOLERANCE = 1e-6
MOST_BOXES = 1 << 14
ROUNDING = 2.0**-44  # of the largest coordinate; many times what rounding adds up to
CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])


def collides(kind: str, start: Any, end: Any) -> bool:
    """Whether the method says that there is a collision; `kind` is "vertex-face" or "edge-edge"."""
    x, y = np.array(start, dtype=np.float64), np.array(end, dtype=np.float64)
    slack = ROUNDING * max(float(np.max(np.abs([x, y]))), 1e-300)
    boxes = np.array([[[0.0, 1.0]] * 3])
    while len(boxes):
        corners = boxes[:, np.arange(3), CORNERS]
        values = _differences(kind, x, y, corners)
        low, high = values.min(axis=1), values.max(axis=1)
        near = np.all((low <= slack) & (high >= -slack), axis=1)
        if kind == "vertex-face":
            near &= boxes[:, 1, 0] + boxes[:, 2, 0] <= 1
        boxes, low, high, values = boxes[near], low[near], high[near], values[near]
        if np.any(np.max(high - low, axis=1, initial=0.0) <= TOLERANCE) or len(boxes) > MOST_BOXES:
            return bool(len(boxes))
        boxes = _halved(boxes, values)
    return False


def _differences(kind: str, x: Array, y: Array, at: Array) -> Array:
    """Difference of the two sets' points at (time, parameter, parameter)."""
    t, u, v = (at[..., i, None] for i in range(3))
    a, b, c, d = (p + t * (q - p) for p, q in zip(x, y, strict=True))
    if kind == "vertex-face":
        return np.asarray(a - (b + u * (c - b) + v * (d - b)))
    return np.asarray(a + u * (b - a) - (c + v * (d - c)))


def _halved(boxes: Array, values: Array) -> Array:
    """Both halves of every box, cut across the parameter along which the values change most."""
    spread = []
    for i in range(3):
        one = CORNERS[:, i] == 1
        spread.append(np.max(np.abs(values[:, one] - values[:, ~one]), axis=(1, 2), initial=0.0))
    rows, which = np.arange(len(boxes)), np.argmax(np.stack(spread, axis=1), axis=1)
    middle = boxes[rows, which].mean(axis=1)
    left, right = boxes.copy(), boxes.copy()
    left[rows, which, 1] = middle
    right[rows, which, 0] = middle
    return np.concatenate([left, right])
