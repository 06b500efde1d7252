"""The door of the formulas: batches, exact scaling, twice the precision, and fractions where that is not enough.

A formula takes and gives `Numbers` (`refimpl.impacts.numbers`) with one batch axis. Doubles are scaled by powers of
two, row by row, so that no square overflows or vanishes; the laws of impacts do not depend on the units of length, time
and mass. Rows whose result is not a number, or whose numbers lie too far apart, are computed again in fractions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from refimpl.fields import ShapeError
from refimpl.impacts.numbers import Numbers
from refimpl.impacts.reading import Array, fractions, is_exact
from refimpl.impacts.twofold import Twofold

CHUNK = 2048
"""Rows that are computed at once, so that what is in between stays in the processor's cache."""
FAR = 200
"""Numbers that lie further apart than by this power of two are left to fractions."""
NOTHING = -(1 << 40)
"""Exponent of 0."""


@dataclass(frozen=True)
class Unit:
    """Powers of speed, length and inverse mass in the unit of a quantity."""

    speed: int = 0
    length: int = 0
    inverse_mass: int = 0
    own: bool = False
    """Of a vector whose length means nothing: each is scaled by itself."""

    def exponent(self, base: Scale) -> Array:
        """Exponents by which rows of such a quantity are scaled."""
        return np.asarray(self.speed * base.speed + self.length * base.length + self.inverse_mass * base.inverse_mass)


@dataclass
class Scale:
    """Exponents of two of the units of speed, length and inverse mass that fit each row."""

    speed: Array
    length: Array
    inverse_mass: Array


PURE = Unit()
SPEED, LENGTH, INVERSE_MASS = Unit(speed=1), Unit(length=1), Unit(inverse_mass=1)
TURNING = Unit(speed=1, length=-1)
INERTIA = Unit(length=2, inverse_mass=-1)
IMPULSE = Unit(speed=1, inverse_mass=-1)
ANGULAR_IMPULSE = Unit(speed=1, length=1, inverse_mass=-1)
ENERGY = Unit(speed=2, inverse_mass=-1)
DIRECTION = Unit(own=True)


@dataclass(frozen=True)
class Given:
    """A quantity that goes into a formula: its numbers, its unit, and how many axes one row of it has."""

    numbers: Array
    unit: Unit
    axes: int = 0

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape without the axes of one row."""
        return self.numbers.shape[: self.numbers.ndim - self.axes]

    def rows(self, batch: tuple[int, ...]) -> Array:
        """Numbers with one batch axis."""
        tail = self.numbers.shape[self.numbers.ndim - self.axes :]
        return np.broadcast_to(self.numbers, batch + tail).reshape(-1, *tail)


Formula: TypeAlias = Callable[..., tuple[Numbers, ...]]


def batch_shape(given: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Shape to which all batch shapes broadcast."""
    try:
        return np.broadcast_shapes(*given.values())
    except ValueError:
        shown = ", ".join(f"{name} {shape}" for name, shape in given.items())
        raise ShapeError(f"batch shapes do not broadcast: {shown}") from None


def evaluate(formula: Formula, given: Mapping[str, Given], units: Sequence[Unit | None]) -> tuple[Array, ...]:
    """Compute a formula for a batch.

    Parameters
    ----------
    formula : what takes the given quantities by name
    given : quantities
        If any holds fractions, all is computed in fractions.
    units : of the results, in order; None for truth values

    Returns
    -------
    tuple of arrays
        One for each unit, with the common batch shape; doubles nearest to the exact result but for a few units in the
        30th digit, or fractions.
    """
    batch = batch_shape({name: g.batch for name, g in given.items()})
    rows = {name: g.rows(batch) for name, g in given.items()}
    if any(is_exact(g.numbers) for g in given.values()):
        results: tuple[Array, ...] = formula(**{name: fractions(column) for name, column in rows.items()})
    else:
        count = int(np.prod(batch, dtype=int))
        ends = [*range(0, max(count, 1), CHUNK), count]
        parts = [
            _in_doubles(formula, {name: column[i:j] for name, column in rows.items()}, given, units)
            for i, j in pairwise(ends)
        ]
        results = tuple(np.concatenate(column) for column in zip(*parts, strict=True))
    return tuple(column.reshape(batch + column.shape[1:])[()] for column in results)


@np.errstate(all="ignore")
def _in_doubles(
    formula: Formula, rows: dict[str, Array], given: Mapping[str, Given], units: Sequence[Unit | None]
) -> list[Array]:
    base = _scale(rows, given)
    far = np.zeros(len(base.speed), dtype=bool)
    scaled = {}
    for name, column in rows.items():
        own = given[name].unit
        exponent = _exponent(column) if own.own else own.exponent(base)
        scaled[name] = Twofold(_shifted(column, -exponent))
        far |= _is_far(scaled[name].high, own)
    found = formula(**scaled)
    columns: list[Array] = []
    for value, unit in zip(found, units, strict=True):
        if unit is None:
            columns.append(np.array(value))
        else:
            far |= ~_every(np.isfinite(value.high))
            columns.append(_shifted(value.high, unit.exponent(base)) + 0.0)
    if far.any():
        exact = formula(**{name: fractions(column[far]) for name, column in rows.items()})
        for column, value in zip(columns, exact, strict=True):
            column[far] = value if column.dtype == bool else _rounded(value)
    return columns


def _scale(rows: dict[str, Array], given: Mapping[str, Given]) -> Scale:
    """Units that bring the largest of each kind in a row to about 1.

    A body of inverse mass w and inertia I is about √(w·I) large, and what turns by ω moves at ω times the length.
    """
    count = len(next(iter(rows.values())))

    def largest(*kinds: tuple[Unit, Callable[[Array], Array]]) -> Array:
        found = np.full(count, NOTHING)
        for name, column in rows.items():
            for unit, exponent in kinds:
                if given[name].unit == unit:
                    moved = np.where(_every(column == 0), NOTHING, exponent(_exponent(column)))
                    found = np.maximum(found, moved)
        return np.where(found == NOTHING, 0, found)

    inverse_mass = largest((INVERSE_MASS, lambda e: e))
    length = largest((LENGTH, lambda e: e), (INERTIA, lambda e: (e + inverse_mass) // 2))
    return Scale(largest((SPEED, lambda e: e), (TURNING, lambda e: e + length)), length, inverse_mass)


def _every(truth: Array) -> Array:
    """Whether it holds for all numbers of a row."""
    return np.asarray(truth.reshape(len(truth), -1).all(axis=1))


def _exponent(column: Array) -> Array:
    """Power of two next above the largest number of each row; 0 where all are 0."""
    wide = np.abs(column.reshape(len(column), -1)).max(axis=1)
    return np.asarray(np.frexp(wide)[1], dtype=np.int64)


def _shifted(column: Array, exponent: Array) -> Array:
    """Rows times a power of two, exactly unless a double cannot hold it."""
    power = np.clip(exponent, -5000, 5000).astype(np.int32)
    return np.asarray(np.ldexp(column, power.reshape(power.shape + (1,) * (column.ndim - 1))))


def _is_far(scaled: Array, unit: Unit) -> Array:
    """Where scaled numbers are so large, or, where it matters, so small that products would lose digits."""
    wide = np.abs(scaled.reshape(len(scaled), -1)).max(axis=1)
    far = wide > 2.0**FAR
    if unit in (LENGTH, INVERSE_MASS, INERTIA):
        far = far | ((wide > 0) & (wide < 2.0**-FAR))
    return np.asarray(far)


def _rounded(exact: Array) -> Array:
    """Doubles nearest to fractions; infinite where no double is near."""
    flat = [_double(value) for value in exact.reshape(-1)]
    return np.array(flat, dtype=np.float64).reshape(exact.shape)


def _double(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
