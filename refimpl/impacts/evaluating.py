"""The door of the formulas: batches, exact scaling, twice the precision, and fractions where that is not enough.

A formula takes and gives `Numbers` (`refimpl.impacts.numbers`), whose one batch axis is the last. Doubles are scaled by
powers of two, row by row, so that no square overflows or vanishes; the laws of impacts do not depend on the units of
length, time and mass. Rows whose result is not a number, or whose numbers lie too far apart, are computed again in
fractions.
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
        results = [_rows(column) for column in _in_fractions(formula, rows)]
    else:
        count = int(np.prod(batch, dtype=int))
        ends = [*range(0, max(count, 1), CHUNK), count]
        parts = [
            _in_doubles(formula, {name: column[i:j] for name, column in rows.items()}, given, units)
            for i, j in pairwise(ends)
        ]
        results = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return tuple(column.reshape(batch + column.shape[1:])[()] for column in results)


@np.errstate(all="ignore")
def _in_doubles(
    formula: Formula, rows: dict[str, Array], given: Mapping[str, Given], units: Sequence[Unit | None]
) -> list[Array]:
    columns = {name: _columns(column) for name, column in rows.items()}
    widths = {
        name: np.abs(column).max(axis=tuple(range(column.ndim - 1)), initial=0.0) for name, column in columns.items()
    }
    base = _scale(widths, given)
    far = np.zeros(base.speed.shape, dtype=bool)
    scaled = {}
    for name, width in widths.items():
        unit = given[name].unit
        exponent = -(_exponent(width) if unit.own else unit.exponent(base))
        scaled[name] = Twofold(_shifted(columns[name], exponent))
        far |= _is_far(_shifted(width, exponent), unit)
    found = formula(**scaled)
    results: list[Array] = []
    for value, kind in zip(found, units, strict=True):
        if kind is None:
            results.append(np.array(value))
        else:
            far |= ~np.isfinite(value.high).all(axis=tuple(range(value.high.ndim - 1)))
            results.append(_rows(_shifted(value.high, kind.exponent(base)) + 0.0))
    if far.any():
        exact = _in_fractions(formula, {name: column[far] for name, column in rows.items()})
        for result, value in zip(results, exact, strict=True):
            result[far] = value if result.dtype == bool else _rounded(_rows(value))
    return results


def _in_fractions(formula: Formula, rows: dict[str, Array]) -> tuple[Numbers, ...]:
    return formula(**{name: _columns(fractions(column)) for name, column in rows.items()})


def _columns(rows: Array) -> Array:
    """Bring the batch axis to the end."""
    return np.ascontiguousarray(np.moveaxis(rows, 0, -1))


def _rows(columns: Array) -> Array:
    """Bring the batch axis to the front."""
    return np.ascontiguousarray(np.moveaxis(columns, -1, 0))


def _scale(widths: dict[str, Array], given: Mapping[str, Given]) -> Scale:
    """Units that bring the largest of each kind in a row to about 1.

    A body of inverse mass w and inertia I is about √(w·I) large, and what turns by ω moves at ω times the length.
    """

    def largest(*kinds: tuple[Unit, Array | int]) -> Array:
        """Over all quantities of these kinds; each adds something to the exponents."""
        found = np.full(np.shape(next(iter(widths.values()))), NOTHING)
        for name, width in widths.items():
            for unit, more in kinds:
                if given[name].unit == unit:
                    exponent = _exponent(width) + more
                    exponent = exponent // 2 if unit == INERTIA else exponent
                    found = np.maximum(found, np.where(width == 0, NOTHING, exponent))
        return np.where(found == NOTHING, 0, found)

    inverse_mass = largest((INVERSE_MASS, 0))
    length = largest((LENGTH, 0), (INERTIA, inverse_mass))
    return Scale(largest((SPEED, 0), (TURNING, length)), length, inverse_mass)


def _exponent(width: Array) -> Array:
    """Power of two next above each number; 0 of 0."""
    return np.asarray(np.frexp(width)[1], dtype=np.int64)


def _shifted(column: Array, exponent: Array) -> Array:
    """Give numbers times a power of two for each row, exactly unless a double cannot hold it."""
    return np.asarray(np.ldexp(column, np.clip(exponent, -5000, 5000).astype(np.int32)))


def _is_far(width: Array, unit: Unit) -> Array:
    """Where scaled numbers are so large, or, where it matters, so small that products would lose digits."""
    far = width > 2.0**FAR
    if unit in (LENGTH, INVERSE_MASS, INERTIA):
        far = far | ((width > 0) & (width < 2.0**-FAR))
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
