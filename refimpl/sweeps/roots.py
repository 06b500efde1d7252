"""First roots of polynomials with whole coefficients, isolated exactly, and signs of other polynomials at them.

Nothing here has to be believed: what is found is proven by `refimpl.proof.triangles`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from refimpl.proof.polynomials import Polynomial, bernstein, remainder, sign_on, trimmed, value

END = Fraction(1)


class Root:
    """The one root of a polynomial in (low, high], simple or at `high`; or low = high is the root.

    Attributes
    ----------
    polynomial : without leading zeros
        Replaced by a divisor of it when another polynomial turns out to have the root too, so that it divides all that
        are known to.
    """

    def __init__(self, polynomial: Polynomial, low: Fraction, high: Fraction) -> None:
        self.polynomial, self.low, self.high = polynomial, low, high
        self._positive = value(polynomial, low) > 0

    def halve(self) -> None:
        """Narrow the interval to half its width."""
        middle = (self.low + self.high) / 2
        at_middle = value(self.polynomial, middle)
        if at_middle and (at_middle > 0) == self._positive:
            self.low = middle
        else:
            self.high = middle

    def narrow(self, width: Fraction) -> None:
        """Narrow the interval to at most `width`."""
        while self.high - self.low > width:
            self.halve()

    def sign(self, p: Polynomial) -> int:
        """Sign of p at the root; where it is not 0, p keeps it on the interval as that is left."""
        sign = sign_on(p, self.low, self.high)
        if sign:
            return sign
        if self._is_root_of(p):
            return 0
        while not (sign := sign_on(p, self.low, self.high)):
            self.halve()
        return sign

    def _is_root_of(self, p: Polynomial) -> bool:
        common = divisor(self.polynomial, p)
        if len(common) == 1 or value(common, self.low) * value(common, self.high) > 0:
            return False
        if len(common) < len(self.polynomial):
            self.polynomial, self._positive = common, value(common, self.low) > 0
        return True


def divisor(p: Polynomial, q: Polynomial) -> Polynomial:
    """Greatest common divisor of two polynomials of which the first is not zero, up to a factor (Euclid)."""
    p, q = trimmed(p), trimmed(q)
    while q:
        p, q = q, primitive(remainder(p, q))
    return primitive(p)


def primitive(p: Polynomial) -> Polynomial:
    """The polynomial without the whole factor that its coefficients have in common."""
    content = math.gcd(*p)
    return tuple(c // content for c in p)


def simple(p: Polynomial) -> Polynomial:
    """A polynomial with the same roots, all simple: p by its common divisor with its derivative."""
    p = trimmed(p)
    multiple = divisor(p, tuple(i * c for i, c in enumerate(p))[1:])
    return _quotient(p, multiple) if len(multiple) > 1 else p


def _quotient(p: Polynomial, q: Polynomial) -> Polynomial:
    """Quotient p / q up to a factor, for a q that divides p."""
    rest = [Fraction(c) for c in p]
    found: list[Fraction] = []
    while len(rest) >= len(q):
        factor, shift = rest[-1] / q[-1], len(rest) - len(q)
        for i, c in enumerate(q):
            rest[shift + i] -= factor * c
        rest.pop()
        found.insert(0, factor)
    unit = math.lcm(*(c.denominator for c in found))
    return primitive(tuple(int(c * unit) for c in found))


def first_root(p: Polynomial, after: Fraction, until: Fraction = END) -> Root | None:
    """First root in (after, until] of a polynomial that is not 0 at `after`.

    Descartes' rule on an interval: the Bernstein coefficients change their sign as often as there are roots within it,
    or an even number of times more often. Intervals with more than one change are halved; of polynomials whose roots
    are all simple that comes to an end (Collins and Akritas 1976).
    """
    if _changes(bernstein(p, after, until)) > 1:
        p = simple(p)
    waiting = [(after, until)]
    while waiting:
        low, high = waiting.pop()
        coefficients = bernstein(p, low, high)
        count, at_end = _changes(coefficients), coefficients[-1] == 0
        if count > 1:
            middle = (low + high) / 2
            waiting += [(middle, high), (low, middle)]
        elif count == 1:
            return _alone(trimmed(p), low, high) if at_end else Root(trimmed(p), low, high)
        elif at_end:
            return Root(trimmed(p), low, high)
    return None


def _alone(p: Polynomial, low: Fraction, high: Fraction) -> Root:
    """The one root within (low, high), for a polynomial that also has one at `high`."""
    positive = value(p, low) > 0
    while True:
        middle = (low + high) / 2
        at_middle = value(p, middle)
        if at_middle == 0 or (at_middle > 0) != positive:
            return Root(p, low, middle)
        low = middle


def _changes(coefficients: Sequence[int]) -> int:
    """How often the sign changes along a sequence, zeros left out."""
    signs = [c > 0 for c in coefficients if c]
    return sum(a != b for a, b in pairwise(signs))


def earlier(a: Root, b: Root) -> Root:
    """The smaller of two roots; one of them if they are the same."""
    if a.sign(b.polynomial) == 0 and a.sign(_minus(b.low)) > 0 >= a.sign(_minus(b.high)):
        return a
    while a.low < b.high and b.low < a.high:
        a.halve()
        b.halve()
    return a if a.high <= b.low else b


def _minus(time: Fraction) -> Polynomial:
    """A polynomial with the sign of t − time."""
    return -time.numerator, time.denominator
