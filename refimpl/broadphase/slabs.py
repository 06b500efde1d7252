"""Rays against axis-aligned boxes by slabs: which may meet, fast and never missing one; and which do, exactly.

Along each axis the ray is between two planes for an interval of times; it meets the box if the intervals have a time in
common (Kay and Kajiya 1986). Each time is off by two roundings at most, so doubles decide all but grazing rays; the
others are decided in rational numbers (the widening: Ize 2013, Robust BVH Ray Traversal).
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from refimpl.linear import Array, Bools

WIDER = 2.0**-50
"""More than the relative error of a difference, a quotient and a product by this."""
TINY = 2.0**-1070
"""More than a quotient loses by underflow."""


def rays_may_meet(origin: Array, direction: Array, length: Array, lower: Array, upper: Array) -> Bools:
    """Whether rays may meet boxes: always true where they do, and otherwise nearly always false.

    Parameters
    ----------
    origin, direction : (..., D)
        Finite, no direction zero.
    length : (...)
        The ray is {origin + t·direction, 0 ≤ t ≤ length}.
    lower, upper : (..., D)
        Closed boxes, perhaps infinite. All leading axes broadcast.
    """
    first, last, lost = clipped(origin, direction, length, lower, upper)
    return lost | (first <= last)


def clipped(origin: Array, direction: Array, length: Array, lower: Array, upper: Array) -> tuple[Array, Array, Bools]:
    """First and last times of rays in boxes, as an interval that is too wide by rounding; arguments as above.

    Returns
    -------
    first, last : (...)
        first > last where a ray misses the box.
    lost : (...) bool
        Where the times overflow and mean nothing.
    """
    first, last, lost = _times(origin, direction, lower, upper)
    return _earlier(first), _later(np.minimum(last, length)), lost


def rays_meet(origin: Array, direction: Array, length: Array, lower: Array, upper: Array) -> Bools:
    """Whether rays meet boxes, decided for the numbers as they are stored; all arrays have one common leading axis."""
    first, last, lost = _times(origin, direction, lower, upper)
    last = np.minimum(last, length)
    may = lost | (_earlier(first) <= _later(last))
    found = ~lost & (_later(first) <= _earlier(last))
    for i in np.flatnonzero(may & ~found).tolist():
        o, d, low, up = (x[i].tolist() for x in (origin, direction, lower, upper))
        found[i] = _meets_exactly(o, d, low, up, float(length[i]))
    return found


def around_rays(origin: Array, direction: Array, length: Array) -> tuple[Array, Array]:
    """Boxes around rays {origin + t·direction, 0 ≤ t ≤ length}, all (N, D) and (N,); rounded outwards."""
    with np.errstate(over="ignore", invalid="ignore"):
        way = np.where(direction == 0, 0.0, direction * length[:, None])
        end = origin + way
        slack = np.where(direction == 0, 0.0, WIDER * (np.abs(origin) + np.abs(way)) + TINY)
        slack = np.where(length[:, None] > 0, slack, 0.0)
        lower = np.where(direction < 0, end - slack, origin)
        upper = np.where(direction > 0, end + slack, origin)
    return lower, upper


def _times(origin: Array, direction: Array, lower: Array, upper: Array) -> tuple[Array, Array, Bools]:
    """First (at least 0) and last time between all planes, and whether an overflow has made them worthless."""
    first: Array = np.zeros(())
    last: Array = np.full((), np.inf)
    lost: Bools = np.zeros((), dtype=bool)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        for k in range(origin.shape[-1]):
            o, d, low, up = origin[..., k], direction[..., k], lower[..., k], upper[..., k]
            inside = (low <= o) & (o <= up)
            enter, leave = (np.where(d < 0, up, low) - o) / d, (np.where(d < 0, low, up) - o) / d
            still = d == 0
            lost = lost | ~still & ((np.isinf(enter) & np.isfinite(low)) | (np.isinf(leave) & np.isfinite(up)))
            enter = np.where(still, np.where(inside, -np.inf, np.inf), enter)
            leave = np.where(still, np.where(inside, np.inf, -np.inf), leave)
            first, last = np.maximum(first, enter), np.minimum(last, leave)
    return first, last, lost


def _earlier(t: Array) -> Array:
    """A time that is before one with rounding errors."""
    return np.asarray(t - (WIDER * np.where(np.isinf(t), 0.0, np.abs(t)) + TINY))


def _later(t: Array) -> Array:
    """A time that is after one with rounding errors."""
    with np.errstate(over="ignore"):
        return np.asarray(t + (WIDER * np.where(np.isinf(t), 0.0, np.abs(t)) + TINY))


def _meets_exactly(
    origin: list[float], direction: list[float], lower: list[float], upper: list[float], length: float
) -> bool:
    """Decide one ray and one box in rational numbers."""
    first = Fraction(0)
    last = None if length == np.inf else Fraction(length)
    for o, d, low, up in zip(origin, direction, lower, upper, strict=True):
        if d == 0:
            if not low <= o <= up:
                return False
            continue
        enter, leave = (up, low) if d < 0 else (low, up)
        if np.isfinite(enter):
            first = max(first, (Fraction(enter) - Fraction(o)) / Fraction(d))
        if np.isfinite(leave):
            end = (Fraction(leave) - Fraction(o)) / Fraction(d)
            last = end if last is None else min(last, end)
    return last is None or first <= last
