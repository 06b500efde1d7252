"""Powers of two: a pair of proxies is scaled by one, exactly, so that squares neither overflow nor vanish."""

from __future__ import annotations

import math

from . import kernel
from .polytopes import Row
from .vectors import Vector, times

STEP = 1000
"""Powers of two beyond ±1000 are taken in two steps, so that neither overflows."""
NOTHING = -10_000
"""Exponent of the size of what has none, and far from all others."""
Powers = tuple[float, float]


@kernel
def exponent_of(row: Row, at: int, count: int) -> int:
    """Exponent e of the largest of `count` numbers from `at`: 2^−e brings it to between 1/2 and 1."""
    most = 0.0
    for i in range(at, at + count):
        most = max(most, abs(row[i]))
    return math.frexp(most)[1] if most > 0.0 else NOTHING


@kernel
def larger(exponent: int, other: int) -> int:
    """Exponent of the larger of two sizes; 0 where neither has any."""
    found = max(exponent, other)
    return 0 if found < NOTHING // 2 else found


@kernel
def power(exponent: int) -> float:
    """2^exponent, by repeated squaring."""
    factor, found, n = 2.0 if exponent > 0 else 0.5, 1.0, abs(exponent)
    while n > 0:
        if n & 1:
            found *= factor
        factor *= factor
        n >>= 1
    return found


@kernel
def powers(exponent: int) -> Powers:
    """Two factors that make 2^exponent, of which neither overflows."""
    first = max(min(exponent, STEP), -STEP)
    return power(first), power(exponent - first)


@kernel
def scaled(v: Vector, by: Powers) -> Vector:
    """Vector times two factors."""
    return times(by[1], times(by[0], v))
