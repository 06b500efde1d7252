"""Boxes stored axis by axis, for comparisons of many scattered pairs of them."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from refimpl.linear import Array, Bools
from refimpl.signs import Indices


class Corners(NamedTuple):
    """Lower and upper corners of n boxes, both (D, n): one coordinate of all boxes is one piece of memory."""

    low: Array
    high: Array

    @classmethod
    def of(cls, lower: Array, upper: Array) -> Self:
        """Boxes given by arrays (n, D)."""
        return cls(np.ascontiguousarray(lower.T), np.ascontiguousarray(upper.T))

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.low)

    def in_units(self, exponent: int) -> Self:
        """The boxes in units of 2^exponent."""
        with np.errstate(under="ignore"):
            return type(self)(*(np.ldexp(side, -exponent) for side in self))

    def at(self, index: Indices) -> Self:
        """Some of the boxes."""
        return type(self)(*(np.stack([axis.take(index) for axis in side]) for side in self))

    @classmethod
    def empty(cls, dimension: int, count: int) -> Self:
        """Boxes without a point: their union with another is the other."""
        return cls(np.full((dimension, count), np.inf), np.full((dimension, count), -np.inf))


def meeting(a: Corners, i: Indices, b: Corners, j: Indices) -> Indices:
    """Places k at which the closed boxes i[k] of `a` and j[k] of `b` have a point in common.

    Axis by axis: what one axis parts is not looked at again.
    """
    kept = np.arange(len(i))
    for low_a, high_a, low_b, high_b in zip(*a, *b, strict=True):
        met = low_a.take(i) <= high_b.take(j)
        met &= low_b.take(j) <= high_a.take(i)
        some = np.flatnonzero(met)
        kept, i, j = kept.take(some), i.take(some), j.take(some)
    return kept


def all_meeting(a: Corners, some: slice, b: Corners, others: slice) -> Bools:
    """Whether each of some boxes of `a` has a point in common with each of others of `b`; one row for each of `a`."""
    found = np.ones((1, 1), dtype=bool)
    for low_a, high_a, low_b, high_b in zip(*a, *b, strict=True):
        found = found & (low_a[some, None] <= high_b[others])
        found &= low_b[others] <= high_a[some, None]
    return found
