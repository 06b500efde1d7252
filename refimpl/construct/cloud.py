"""Many points, and polynomials over them: the exact greatest value, and the exact signs.

Only where doubles cannot decide, twofold doubles are asked, and of what these leave open, fractions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from refimpl.construct.enclosed import TINY, Enclosed, EnclosedTwice, grain_of, grain_of_number
from refimpl.construct.formulas import Polynomial, along
from refimpl.impacts.twofold import Twofold
from refimpl.linear import Array, Bools

BLOCK = 1 << 14  # points that stay in the processor's cache from one operation to the next
MIX = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F))
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
        chosen = np.flatnonzero(found.may_be_greatest())
        if found.error == 0:
            return Greatest(found.exactly(int(chosen[0])), int(chosen[0]))
        if len(chosen) > 1:
            found = self._computed(formula, EnclosedTwice, chosen)
            best = np.flatnonzero(found.may_be_greatest())
            chosen = chosen[best]
            if found.error == 0:
                return Greatest(found.exactly(int(best[0])), int(chosen[0]))
        values = {i: formula(self.exact(i), Fraction) for i in self._different(chosen)}
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
        left: Any = None
        for arithmetic in (Enclosed, EnclosedTwice):
            least, more = self._signs(formula, arithmetic, left)
            names = np.arange(len(self.points)) if left is None else left
            answer[names[least]] = True
            left = names[~(least | more)]
            if not len(left):
                return answer
        known: dict[bytes, bool] = {}  # points that are hard to decide about are often one point, many times
        for i in left.tolist():
            key = self.points[i].tobytes()
            if key not in known:
                known[key] = formula(self.exact(i), Fraction) <= 0
            answer[i] = known[key]
        return answer

    @cached_property
    def _grain(self) -> int:
        """All coordinates are whole multiples of 2^grain."""
        return grain_of(self.columns)

    def _signs(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> tuple[Bools, Bools]:
        parts = [part.signs() for part in self._blocks(formula, arithmetic, chosen)]
        least, more = (np.concatenate(sides) for sides in zip(*parts, strict=True))
        return least, more

    def _computed(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> Any:
        return arithmetic.joined(self._blocks(formula, arithmetic, chosen))

    def _blocks(self, formula: Polynomial, arithmetic: type[Enclosed], chosen: Any) -> list[Enclosed]:
        """Values of the polynomial at some points (None: all), in one arithmetic, block by block."""
        columns = self.columns if chosen is None else self.columns[:, chosen]
        twice, lost = arithmetic is EnclosedTwice, self._lost
        grain = None
        if twice and not lost:
            grain = grain_of(columns) if columns.shape[1] <= BLOCK else self._grain
        of = _taking_in(arithmetic, twice)
        found = []
        for start in range(0, columns.shape[1], BLOCK):
            block = columns[:, start : start + BLOCK]
            x = [arithmetic(Twofold(c) if twice else c, lost, grain) for c in block]
            found.append(_filled(formula(x, of), block.shape[1]))
        return found

    def _different(self, chosen: NDArray[np.int64]) -> list[int]:
        """The same points without repetition, as far as a hash of their coordinates tells them apart for sure."""
        given = np.ascontiguousarray(self.points[chosen])
        bits = given.view(np.uint64)
        mixed = (bits[:, 0] * MIX[0] + bits[:, 1]) * MIX[1] + bits[:, 2]
        _, first, back = np.unique(mixed, return_index=True, return_inverse=True)
        alone = np.any(given != given[first][back], axis=1)  # two points with one hash: both are kept
        return [int(i) for i in chosen[np.union1d(first, np.flatnonzero(alone))]]


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
