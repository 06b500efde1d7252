"""Symmetric positive definite 3 × 3 matrices: their LDLᵀ factors, which need no root, and equations solved by them.

Golub and Van Loan, Matrix Computations, 4.1. Stable without exchanging rows; the accuracy depends on how much of a
diagonal element is left as its pivot, so that a matrix may be graded, but not nearly singular, without loss.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from refimpl.impacts.numbers import Numbers, known, rough, stack
from refimpl.impacts.reading import Array, fractions, is_exact
from refimpl.linear import Bools

PIVOT_BITS = 40
"""A pivot that is smaller than its diagonal element by more bits than these is left to fractions."""


@dataclass(frozen=True)
class Factors:
    """Matrices M = L D Lᵀ (3, 3, n): the elements of L below its diagonal of ones, and 1 over the pivots D."""

    below: tuple[Numbers, Numbers, Numbers]
    over_pivots: tuple[Numbers, Numbers, Numbers]

    def solve(self, v: Numbers) -> Numbers:
        """Solve M x = v for vectors (3, n), or for all columns of (3, k, n)."""
        l10, l20, l21 = self.below
        r0, r1, r2 = self.over_pivots
        y0 = v[0]
        y1 = v[1] - l10 * y0
        y2 = v[2] - (l20 * y0 + l21 * y1)
        x2 = y2 * r2
        x1 = y1 * r1 - l21 * x2
        x0 = y0 * r0 - (l10 * x1 + l20 * x2)
        return stack([x0, x1, x2])


def factors(m: Numbers) -> Factors:
    """Factors of symmetric positive definite matrices (3, 3, n)."""
    over_0 = 1 / m[0, 0]
    l10, l20 = m[1, 0] * over_0, m[2, 0] * over_0
    over_1 = 1 / known(m[1, 1] - l10 * m[1, 0], rough(m[1, 1]), PIVOT_BITS)
    rest = m[2, 1] - l20 * m[1, 0]
    l21 = rest * over_1
    over_2 = 1 / known(m[2, 2] - (l20 * m[2, 0] + l21 * rest), rough(m[2, 2]), PIVOT_BITS)
    return Factors((l10, l20, l21), (over_0, over_1, over_2))


def is_definite(matrices: Array) -> Bools:
    """Whether symmetric matrices (..., 3, 3) are positive definite, exactly.

    Doubles decide where the pivots are far from rounding, fractions decide the rest.
    """
    rows = matrices.reshape(-1, 3, 3)
    if is_exact(rows):
        found = np.array([_is_definite(m) for m in rows], dtype=bool)
    else:
        found, sure = _by_doubles(np.moveaxis(rows, 0, -1))
        for i in np.flatnonzero(~sure):
            found[i] = _is_definite(fractions(rows[i]))
    return found.reshape(matrices.shape[:-2])


@np.errstate(all="ignore")
def _by_doubles(m: Array) -> tuple[Bools, Bools]:
    """Whether the pivots are positive, and whether that is sure: none is close to what rounding could have left."""
    f = factors(m)
    diagonal = np.stack([m[i, i] for i in range(3)])
    share = 1 / (np.stack(f.over_pivots) * diagonal)
    found = (diagonal > 0).all(axis=0) & (share > 0).all(axis=0)
    in_range = ((diagonal > 1e-200) & (diagonal < 1e200)).all(axis=0)
    return found, found & in_range & (share > 1e-6).all(axis=0)


def _is_definite(m: Array) -> bool:
    """By the signs of the leading minors (Sylvester)."""
    (a, b, c), (_, d, e), (_, _, f) = m.tolist()
    second: Fraction = a * d - b * b
    return bool(a > 0 and second > 0 and (a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)) > 0)
