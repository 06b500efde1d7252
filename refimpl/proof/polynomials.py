"""Polynomials in time with whole coefficients, and their signs: part of what has to be believed.

A polynomial is a tuple of integers, the constant first, of degree 3 at most; factors > 0 mean nothing, as only signs
are asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

Polynomial: TypeAlias = tuple[int, ...]
MAX_DEGREE = 3


def value(p: Polynomial, time: Fraction) -> int:
    """Positive multiple of p(time)."""
    x, y = time.numerator, time.denominator
    total, power = 0, 1
    for c in reversed(p):
        total = total * x + c * power
        power *= y
    return total


def bernstein(p: Polynomial, low: Fraction, high: Fraction) -> Sequence[int]:
    """Coefficients, times something positive, of p as a mean of its Bernstein polynomials on [low, high].

    They are the values of p's polar form, the function that is linear in each of its n arguments, symmetric, and p(t)
    when all arguments are t: the j-th has `high` j times and `low` n − j times. On [low, high] p is a mean of them with
    weights > 0 but at the ends, where it is the first and the last (Farin, Curves and Surfaces for CAGD, ch. 3 to 5).
    """
    y = low.denominator * high.denominator
    a, b = low.numerator * high.denominator, high.numerator * low.denominator
    match p:
        case (c,):
            return (c,)
        case c, d:
            c *= y
            return c + d * a, c + d * b
        case c, d, e:
            c, d = 2 * c * y * y, d * y
            return c + 2 * a * (d + e * a), c + d * (a + b) + 2 * e * a * b, c + 2 * b * (d + e * b)
        case c, d, e, f:
            c, d, e = 3 * c * y * y * y, d * y * y, e * y
            aa, ab, bb = a * a, a * b, b * b
            f *= 3
            return (
                c + 3 * (d * a + e * aa) + f * aa * a,
                c + d * (2 * a + b) + e * (aa + 2 * ab) + f * aa * b,
                c + d * (a + 2 * b) + e * (2 * ab + bb) + f * ab * b,
                c + 3 * (d * b + e * bb) + f * bb * b,
            )
    raise AssertionError("no polynomial of degree 0 to 3")


def sign_on(p: Polynomial, low: Fraction, high: Fraction) -> int:
    """1 or −1 if p has that sign on all of [low, high] and its Bernstein coefficients show it; else 0."""
    coefficients = bernstein(p, low, high)
    if min(coefficients) > 0:
        return 1
    return -1 if max(coefficients) < 0 else 0


def trimmed(p: Sequence[int]) -> Polynomial:
    """The polynomial without leading zeros; () for the zero polynomial."""
    end = len(p)
    while end and p[end - 1] == 0:
        end -= 1
    return tuple(p[:end])


def remainder(p: Polynomial, divisor: Polynomial) -> Polynomial:
    """Multiple (not by 0) of what is left of p after division; `divisor` has no leading zeros, and is not ()."""
    rest = trimmed(p)
    while len(rest) >= len(divisor):
        shift, lead = len(rest) - len(divisor), rest[-1]
        scaled = [divisor[-1] * c for c in rest]
        for i, c in enumerate(divisor):
            scaled[shift + i] -= lead * c
        rest = trimmed(scaled)
    return rest
