"""What the formulas of impacts compute with: `Twofold` arrays, or object arrays of fractions.

A formula is written once. On doubles it runs as `Twofold` and is rounded at its end; on `fractions.Fraction` it is
exact. Arrays have the batch as their last axis: numbers (n), vectors (3, n), matrices (3, 3, n), so that a number times
a vector is what it looks like. Every sum over coordinates is written out, in one order for every batch size.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from refimpl.impacts.reading import fractions
from refimpl.impacts.twofold import Twofold
from refimpl.linear import Bools

Numbers: TypeAlias = Any
"""A `Twofold`, or an object array of fractions: what has the four operations, comparisons and indices."""

ROOT_BITS = 100
"""The root of a fraction is given to so many bits more than the fraction has."""


def choose(condition: Bools, yes: Numbers, no: Numbers) -> Numbers:
    """Take `yes` in the rows where the condition (n) holds, and `no` in all others."""
    if isinstance(yes, Twofold) or isinstance(no, Twofold):
        yes, no = (x if isinstance(x, Twofold) else Twofold(x) for x in (yes, no))
        return Twofold(np.where(condition, yes.high, no.high), np.where(condition, yes.lows, no.lows))
    yes, no = (x if np.asarray(x).dtype == object else fractions(x) for x in (yes, no))  # 1 / int would be a double
    return np.where(condition, yes, no)


def quotient(x: Numbers, y: Numbers) -> Numbers:
    """Divide, giving 0 where the divisor is 0: no impulse where nothing can be exchanged."""
    none = np.asarray(y == 0, dtype=bool)
    return choose(none, 0, x / choose(none, 1, y))


def root_above(x: Numbers) -> Numbers:
    """Square root of numbers ≥ 0: of a fraction the least multiple of a tiny unit that is not below the root."""
    if isinstance(x, Twofold):
        return x.root()
    return np.array([_root(Fraction(value)) for value in x], dtype=object)


def _root(square: Fraction) -> Fraction:
    product = square.numerator * square.denominator
    scale = 1 << (ROOT_BITS + product.bit_length())
    whole = product * scale * scale
    low = math.isqrt(whole)
    return Fraction(low + (low * low != whole), square.denominator * scale)


def known(difference: Numbers, terms: Any, bits: int) -> Numbers:
    """Give a difference where cancellation left it known, and not a number where it did not.

    A difference of `Twofold` numbers that is smaller than 2^−bits of its terms (`rough`) tells little. What is computed
    with "not a number" is found at the end, and that row is computed in fractions, which lose nothing.
    """
    if not isinstance(difference, Twofold):
        return difference
    lost = np.abs(difference.high) < 2.0**-bits * terms
    return Twofold(np.where(lost, np.nan, difference.high), np.where(lost, np.nan, difference.lows))


def rough(x: Numbers) -> Any:
    """Absolute values, in doubles where x is `Twofold`: enough to tell how much has cancelled."""
    return np.abs(x.high if isinstance(x, Twofold) else x)


def stack(parts: list[Numbers]) -> Numbers:
    """Put numbers together to vectors, or vectors to the rows of matrices."""
    if isinstance(parts[0], Twofold):
        return Twofold(np.stack([p.high for p in parts]), np.stack([p.lows for p in parts]))
    return np.stack(parts)


IDENTITY = np.eye(3, dtype=int)[:, :, None]


def dot(u: Numbers, v: Numbers) -> Numbers:
    """Scalar product."""
    terms = u * v
    return (terms[0] + terms[1]) + terms[2]


NEXT, LAST = [1, 2, 0], [2, 0, 1]


def cross(u: Numbers, v: Numbers) -> Numbers:
    """Vector product."""
    return u[NEXT] * v[LAST] - u[LAST] * v[NEXT]


def apply(matrix: Numbers, v: Numbers) -> Numbers:
    """Matrix times vector."""
    terms = matrix * v
    return (terms[:, 0] + terms[:, 1]) + terms[:, 2]
