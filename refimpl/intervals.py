"""Sums that are rounded to one side, so that what is meant to contain does contain."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.linear import Array


def two_sum(a: Any, b: Any) -> tuple[Array, Array]:
    """Rounded sum and its exact error (Knuth, The Art of Computer Programming 2, 4.2.2)."""
    total = np.asarray(a + b)
    rest = total - a
    return total, np.asarray((a - (total - rest)) + (b - rest))


def plus_rounded(a: Any, b: Any, towards: float) -> Array:
    """Sum rounded towards −∞ or ∞: exact where the sum is a double."""
    total, error = two_sum(a, b)
    return _stepped(total, error, towards)


def _stepped(total: Array, error: Array, towards: float) -> Array:
    """Next double towards one side, where the error says that the exact sum lies there."""
    missed = error > 0 if towards > 0 else error < 0
    return np.asarray(np.where(missed, np.nextafter(total, towards), total))


def sum_rounded(terms: Array, towards: float) -> Array:
    """Sum of three numbers over the last axis, rounded towards −∞ or ∞ by at most a few units in the last place."""
    first, lost = two_sum(terms[..., 0], terms[..., 1])
    second, also_lost = two_sum(first, terms[..., 2])
    small = plus_rounded(lost, also_lost, towards)
    return plus_rounded(second, small, towards)
