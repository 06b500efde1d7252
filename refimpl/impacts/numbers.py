"""What the formulas of impacts compute with: `Twofold` arrays, or object arrays of fractions.

A formula is written once. On doubles it runs as `Twofold` and is rounded at its end; on `fractions.Fraction` it is
exact. Arrays have the batch as their first axis; vectors (n, 3) and matrices (n, 3, 3) have further ones. Every sum
over coordinates is written out, in one order for every batch size.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from refimpl.impacts.twofold import Twofold
from refimpl.linear import Bools

Numbers: TypeAlias = Any
"""A `Twofold`, or an object array of fractions: what has the four operations, comparisons and indices."""

ROOT_BITS = 100
"""The root of a fraction is given to so many bits more than the fraction has."""


def choose(condition: Bools, yes: Numbers, no: Numbers) -> Numbers:
    """Take `yes` in the rows where the condition holds, and `no` in all others."""
    kinds = [x for x in (yes, no) if isinstance(x, Twofold)]
    if kinds:
        yes, no = (x if isinstance(x, Twofold) else Twofold(x) for x in (yes, no))
        rows = _like(condition, np.broadcast_shapes(yes.shape, no.shape))
        return Twofold(np.where(rows, yes.high, no.high), np.where(rows, yes.low, no.low))
    return np.where(_like(condition, np.broadcast_shapes(np.shape(yes), np.shape(no))), yes, no)


def _like(condition: Bools, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    return np.reshape(condition, condition.shape + (1,) * (len(shape) - condition.ndim))


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


def known(difference: Numbers, terms: Numbers, bits: int) -> Numbers:
    """Give a difference where cancellation left it known, and not a number where it did not.

    A difference of `Twofold` numbers that is smaller than 2^−bits of its terms tells little; what is computed with
    "not a number" is found at the end, and that row is computed in fractions. Those cancel nothing.
    """
    if not isinstance(difference, Twofold):
        return difference
    lost = np.abs(difference.high) < 2.0**-bits * np.abs(terms.high)
    return Twofold(np.where(lost, np.nan, difference.high), np.where(lost, np.nan, difference.low))


def size(x: Numbers) -> Numbers:
    """Absolute value."""
    return choose(np.asarray(x < 0, dtype=bool), -x, x)


def stack(parts: list[Numbers], axis: int = -1) -> Numbers:
    """Put numbers or vectors side by side."""
    if isinstance(parts[0], Twofold):
        return Twofold(np.stack([p.high for p in parts], axis), np.stack([p.low for p in parts], axis))
    return np.stack(parts, axis)


def dot(u: Numbers, v: Numbers) -> Numbers:
    """Scalar product."""
    terms = u * v
    return (terms[:, 0] + terms[:, 1]) + terms[:, 2]


def spread(u: Numbers, v: Numbers) -> Numbers:
    """Sum of the absolute values of a scalar product's terms: what it may have cancelled from."""
    terms = size(u * v)
    return (terms[:, 0] + terms[:, 1]) + terms[:, 2]


NEXT, LAST = [1, 2, 0], [2, 0, 1]


def cross(u: Numbers, v: Numbers) -> Numbers:
    """Vector product."""
    return u[:, NEXT] * v[:, LAST] - u[:, LAST] * v[:, NEXT]


def scaled(factor: Numbers, v: Numbers) -> Numbers:
    """Each vector times its own factor."""
    return factor[:, None] * v


def apply(matrix: Numbers, v: Numbers) -> Numbers:
    """Matrix times vector."""
    terms = matrix * v[:, None, :]
    return (terms[:, :, 0] + terms[:, :, 1]) + terms[:, :, 2]
