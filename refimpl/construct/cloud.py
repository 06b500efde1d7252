"""Many points, and polynomials over them: the exact greatest value, and the exact signs.

Only where doubles cannot decide, longer ones are asked, and of what these leave open, fractions. Points that are hard
to decide about are often one point, many times, of which one is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from refimpl.construct.enclosed import (
    EXTENDED,
    TINY,
    Enclosed,
    EnclosedExtended,
    EnclosedTwice,
    grain_of,
    grain_of_number,
)
from refimpl.construct.formulas import Polynomial, Shared, along
from refimpl.linear import Array, Bools

BLOCK = 1 << 14  # points that stay in the processor's cache from one operation to the next
Names: TypeAlias = NDArray[np.int64]
MANY = 4  # of so many points one has to be asked, for what is shared to be computed for all
MIX = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F))
QUICK: tuple[type[Enclosed], ...] = (Enclosed, EnclosedExtended) if EXTENDED else (Enclosed,)
LEAST = 2.0**-960  # what is smaller may have lost bits when it was scaled


class Greatest(NamedTuple):
    """A greatest value, and the point that has it."""

    value: Fraction
    point: int


class Cloud:
    """Points and a power of two that brings them to about 1.

    Parameters
    ----------
    points : (n, 3), finite
        In the units of the caller.
    beside : float
        Largest absolute coordinate of what the points are compared with.

    Attributes
    ----------
    exponent : int
        All that is computed is in units of 2^exponent.
    columns : (3, n)
        The coordinates in these units; where that underflows, they are off by less than 2⁻¹⁰⁷⁴.
    """

    def __init__(self, points: Array, beside: float = 0.0) -> None:
        self.points = points
        top = max(float(points.max(initial=0.0)), -float(points.min(initial=0.0)), beside)
        self.exponent = int(np.frexp(top)[1])
        self.unit = Fraction(2) ** self.exponent
        self.columns = scaled(np.ascontiguousarray(points.T), -self.exponent)
        small = self.exponent > 0 and bool(np.any((np.abs(self.columns) < LEAST) & (points.T != 0)))
        self._lost = TINY if small else 0.0
        self._kept: tuple[Polynomial, type[Enclosed], Any] | None = None

    def exact(self, index: int) -> list[Fraction]:
        """A point, in units of 2^exponent."""
        return [Fraction(c) / self.unit for c in self.points[index].tolist()]

    def inwards(self, number: float) -> Fraction:
        """Take a number of the caller's units into those of 2^exponent."""
        return Fraction(number) / self.unit

    def greatest(self, formula: Polynomial) -> Greatest:
        """Greatest value of a polynomial over all points, exactly; of several such points one."""
        return self._settled(formula, self._computed(formula, Enclosed, None))

    def _settled(self, formula: Polynomial, found: Enclosed, side: int = 1) -> Greatest:
        """The same, where the values in doubles are known, or for a side of −1 their opposites."""
        found = found if side > 0 else -found
        chosen = best = np.flatnonzero(found.may_be_greatest())
        for arithmetic in (*QUICK[1:], EnclosedTwice):
            if found.error == 0:
                return Greatest(found.exactly(int(best[0])), int(chosen[0]))
            if arithmetic is EnclosedTwice:
                chosen = chosen[self._distinct(chosen)[0]]
            if len(chosen) == 1:
                break
            found = self._computed(formula, arithmetic, chosen)
            best = np.flatnonzero(found.may_be_greatest())
            chosen = chosen[best]
        if found.error == 0:
            return Greatest(found.exactly(int(best[0])), int(chosen[0]))
        values = {i: formula(self.exact(i), Fraction) for i in chosen.tolist()}
        index = max(values, key=values.__getitem__)
        return Greatest(values[index], index)

    def highest(self, way: Sequence[Fraction]) -> Fraction:
        """Greatest height way·x, exactly; along an axis it is that of a coordinate, which no other drowns."""
        return self.extent(way)[1]

    def extent(self, way: Sequence[Fraction]) -> tuple[Fraction, Fraction]:
        """Least and greatest height way·x, exactly; along an axis those of a coordinate, which no other drowns."""
        counting = [i for i in range(3) if way[i] != 0]
        if len(counting) > 1:
            heights = self._computed(along(way), Enclosed, None)
            low, high = (self._settled(along([side * w for w in way]), heights, side).value for side in (-1, 1))
            return -low, high
        factor, column = way[counting[0]], self.points[:, counting[0]]
        ends = [self.inwards(float(end)) * factor for end in (column.min(), column.max())]
        return min(ends), max(ends)

    def not_positive(self, formula: Polynomial) -> Bools:
        """Where a polynomial is at most 0, exactly."""
        answer = np.zeros(len(self.points), dtype=bool)
        left = np.arange(len(self.points))
        for arithmetic in QUICK:
            least, more = self._signs(formula, arithmetic, left)
            answer[left[least]] = True
            left = left[~(least | more)]
            if not len(left):
                return answer
        first, same = self._distinct(left)
        answer[left] = self._decided(formula, left[first])[same]
        return answer

    def _decided(self, formula: Polynomial, names: Names) -> Bools:
        """The same of some points, by the slower arithmetics."""
        answer, more = self._signs(formula, EnclosedTwice, names)
        for i in np.flatnonzero(~(answer | more)).tolist():
            answer[i] = formula(self.exact(names[i]), Fraction) <= 0
        return answer

    def most_positive(self, formula: Polynomial, most: int) -> Names:
        """Some of the points at which a polynomial is more than 0; none only where there is none.

        They are what the quickest arithmetic that is sure of any is sure of: half of them those where the polynomial
        is most, half from all over the others.
        """
        left = np.arange(len(self.points))
        for arithmetic in QUICK:
            found = self._computed(formula, arithmetic, left)
            least, more = found.signs()
            outside = np.flatnonzero(more)
            if len(outside) > most:
                highest = np.argpartition(found.value[outside], -most // 2)[-most // 2 :]
                outside = outside[np.union1d(highest, np.arange(0, len(outside), 2 * len(outside) // most + 1))]
            if len(outside):
                return np.asarray(left[outside])
            left = left[~least]
            if not len(left):
                return np.asarray(left)
        left = left[self._distinct(left)[0]]
        return np.asarray(left[~self._decided(formula, left)][:most])

    def _signs(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> tuple[Bools, Bools]:
        signs: tuple[Bools, Bools] = self._computed(formula, arithmetic, chosen).signs()
        return signs

    def _computed(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> Any:
        """Values of a polynomial at some points (None: all), in one arithmetic; of a shared one by what is kept."""
        chosen = None if chosen is not None and len(chosen) == len(self.points) else chosen
        many = chosen is None or MANY * len(chosen) >= len(self.points)
        if not isinstance(formula, Shared) or arithmetic is Enclosed or not many:
            return arithmetic.joined(self._blocks(formula, arithmetic, chosen))
        if self._kept is None or self._kept[:2] != (formula.base, arithmetic):
            self._kept = formula.base, arithmetic, self._computed(formula.base, arithmetic, None)
        return self._kept[2][chosen] + self._computed(formula.rest, Enclosed, chosen)

    def _blocks(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> list[Enclosed]:
        """Values of the polynomial at some points (None: all), in one arithmetic, block by block."""
        columns = self.columns if chosen is None else self.columns[:, chosen]
        twice, lost = arithmetic is EnclosedTwice, self._lost
        grain = grain_of(columns) if twice and not lost else None
        of = _taking_in(arithmetic, twice)
        found = []
        for start in range(0, columns.shape[1], BLOCK):
            block = columns[:, start : start + BLOCK]
            x = [arithmetic(arithmetic.lifted(c), lost, grain) for c in block]
            found.append(_filled(formula(x, of), block.shape[1]))
        return found

    def _distinct(self, chosen: Names) -> tuple[Names, Names]:
        """Which of some points differ, nearly all of them, and to which of these each is equal."""
        given = np.ascontiguousarray(self.points.T[:, chosen]) if self._lost else self.columns[:, chosen]
        bits = given.view(np.uint64)
        mixed = (bits[0] * MIX[0] + bits[1]) * MIX[1] + bits[2]
        like, left = np.arange(len(chosen)), np.arange(len(chosen))
        for factor in (np.uint64(1), *MIX):  # of those with one hash of 16 bits the last is kept, and what equals it
            hashed = (mixed[left] * factor) >> np.uint64(48)
            last = np.zeros(1 << 16, dtype=np.int64)
            last[hashed] = left
            other = last[hashed]
            same = np.all([column[other] == column[left] for column in given], axis=0)
            like[left[same]] = other[same]
            like = like[like]
            left = np.flatnonzero(like == np.arange(len(like)))
        place = np.zeros(len(like), dtype=np.int64)
        place[left] = np.arange(len(left))
        return left, place[like]


def scaled(numbers: Array, exponent: int) -> Array:
    """Multiply by 2^exponent, in two steps where that is no double itself."""
    half = exponent // 2
    return np.asarray(numbers * 2.0**half * 2.0 ** (exponent - half))


def _taking_in(arithmetic: type[Enclosed], twice: bool) -> Callable[[Fraction], Enclosed]:
    """Constants of a formula in an arithmetic, each taken in once."""
    known: dict[Fraction, Enclosed] = {}

    def of(number: Fraction) -> Enclosed:
        if number not in known:
            known[number] = arithmetic.of(number, grain_of_number(number) if twice else None)
        return known[number]

    return of


def _filled(found: Enclosed, count: int) -> Enclosed:
    """The values of a polynomial in which no coordinate occurs are repeated."""
    if found.nearest.shape == (count,):
        return found
    zero = np.zeros(count)
    return type(found)(found.value + zero, found.error, found.grain)
