"""Twice the precision of a double: arrays of unevaluated sums of two doubles.

The error of a rounded sum or product is itself a double, and a few further operations give it (Dekker, A Floating-Point
Technique for Extending the Available Precision, 1971; Knuth, The Art of Computer Programming 2, 4.2.2). Carried along
as a second, low part, it leaves relative errors of about 2⁻¹⁰³ an operation (bounds: Joldes, Muller and Popescu,
Tight and Rigorous Error Bounds for Basic Building Blocks of Double-Word Arithmetic, 2017). A formula that is computed
so and rounded once at its end gives nearly always the double nearest to the true value.

Only + − × ÷ and the root of single doubles are used, which IEEE 754 rounds exactly, so that one row of a batch is
the same as that row alone, bit for bit.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from refimpl.linear import Array, Bools

SPLITTER = 2.0**27 + 1  # cuts a double into two halves of 26 bits, whose products are exact

Pair: TypeAlias = tuple[Array, Array]


def exact_sum(a: Array, b: Array) -> Pair:
    """Rounded a + b, and its error (Knuth)."""
    total = np.asarray(a + b)
    of_b = np.asarray(total - a)
    rest = np.asarray(total - of_b)
    np.subtract(a, rest, out=rest)
    np.subtract(b, of_b, out=of_b)
    rest += of_b
    return total, rest


def renormalised(high: Array, low: Array) -> Pair:
    """Sum of two doubles of which the first is not the smaller, rounded, and its error (Dekker)."""
    total = np.asarray(high + low)
    rest = np.asarray(total - high)
    np.subtract(low, rest, out=rest)
    return total, rest


def exact_product(a: Array, b: Array) -> Pair:
    """Rounded a · b, and its error (Dekker, Veltkamp); needs factors below 2⁹⁹⁶."""
    product = np.asarray(a * b)
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    error = np.asarray(a_high * b_high)
    error -= product
    error += a_high * b_low
    error += a_low * b_high
    error += a_low * b_low
    return product, error


def _halves(a: Array) -> Pair:
    high = np.asarray(SPLITTER * a)
    low = np.asarray(high - a)
    high -= low
    return high, np.subtract(a, high, out=low)


class Twofold:
    """An array of numbers high + low, where high is the double nearest to the sum.

    Behaves like an array as far as the formulas of impacts need it: operators that broadcast, comparisons, indices. The
    error of a sum is small beside its terms; where they cancel, it need not be small beside the sum.

    Parameters
    ----------
    high : (...) doubles
    low : (...) doubles
        None where the numbers are doubles themselves, which spares half of the work.
    """

    __slots__ = ("high", "low")
    __array_ufunc__ = None  # an array on the left leaves the operation to this class
    __hash__ = None  # type: ignore[assignment]  # compares element by element, as arrays do

    def __init__(self, high: Any, low: Array | None = None) -> None:
        self.high: Array = np.asarray(high, dtype=np.float64)
        self.low = low

    @property
    def lows(self) -> Array:
        """Low parts, also where they are all 0."""
        return np.zeros(self.high.shape) if self.low is None else self.low

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.high.shape

    def __getitem__(self, index: Any) -> Twofold:
        """Part of the array."""
        return Twofold(self.high[index], None if self.low is None else np.asarray(self.low[index]))

    def __neg__(self) -> Twofold:
        return Twofold(-self.high, None if self.low is None else -self.low)

    def __add__(self, other: Any) -> Twofold:
        other = _twofold(other)
        high, error = exact_sum(self.high, other.high)
        if self.low is None and other.low is None:
            return Twofold(high, error)
        for low in (self.low, other.low):
            if low is not None:
                error += low
        return Twofold(*renormalised(high, error))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Twofold:
        return self + -_twofold(other)

    def __rsub__(self, other: Any) -> Twofold:
        return _twofold(other) + -self

    def __mul__(self, other: Any) -> Twofold:
        other = _twofold(other)
        high, error = exact_product(self.high, other.high)
        if self.low is None and other.low is None:
            return Twofold(high, error)
        if self.low is None or other.low is None:
            error += self.low * other.high if other.low is None else self.high * other.low
        else:
            error += self.high * other.low + self.low * other.high
        return Twofold(*renormalised(high, error))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Twofold:
        other = _twofold(other)
        first = np.asarray(self.high / other.high)
        near = other * first
        rest = self.high - near.high  # exact: the two are that close
        if self.low is not None:
            rest = rest + self.low
        return Twofold(*renormalised(first, (rest - near.lows) / other.high))

    def __rtruediv__(self, other: Any) -> Twofold:
        return _twofold(other) / self

    def root(self) -> Twofold:
        """Square root, of numbers ≥ 0: one step of Newton's from the root in doubles."""
        near = np.sqrt(self.high)
        rest = self - Twofold(*exact_product(near, near))
        return Twofold(*renormalised(near, rest.high / np.where(near > 0, 2 * near, 1.0)))

    def __eq__(self, other: Any) -> Bools:  # type: ignore[override]  # element by element, as arrays do
        other = _twofold(other)
        return np.asarray((self.high == other.high) & (self.lows == other.lows))

    def __lt__(self, other: Any) -> Bools:
        other = _twofold(other)
        return np.asarray((self.high < other.high) | ((self.high == other.high) & (self.lows < other.lows)))

    def __gt__(self, other: Any) -> Bools:
        return _twofold(other) < self

    def __le__(self, other: Any) -> Bools:
        return np.asarray((self < other) | (self == other))

    def __ge__(self, other: Any) -> Bools:
        return np.asarray((self > other) | (self == other))


def _twofold(value: Any) -> Twofold:
    return value if isinstance(value, Twofold) else Twofold(value)
