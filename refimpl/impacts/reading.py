"""Reading the numbers of an impact: doubles or fractions, checked, with errors that name the field and the value."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from refimpl.fields import ShapeError

Array: TypeAlias = NDArray[Any]
"""Of doubles, or of fractions (dtype object)."""


def is_exact(array: Array) -> bool:
    """Whether an array holds fractions."""
    return array.dtype == object


def fractions(array: Any) -> Array:
    """Array of the same numbers, as fractions: a double is one."""
    array = np.asarray(array)
    found = np.empty(array.shape, dtype=object)
    numbers = (x.item() if isinstance(x, np.generic) else x for x in array.reshape(-1).tolist())
    found.reshape(-1)[:] = [Fraction(x) for x in numbers]
    return found


def real(name: str, value: Any, *tail: int) -> Array:
    """Read finite real numbers.

    Parameters
    ----------
    name : what an error calls the value
    value : anything array-like
        With a `fractions.Fraction` in it, all become fractions; without, doubles.
    tail : sizes of the trailing axes

    Returns
    -------
    (..., *tail)
        An array of its own.
    """
    array = np.array(value)
    if array.dtype == object:
        array = _read_fractions(name, array)
    elif array.dtype.kind in "iuf":
        array = np.asarray(np.array(array, dtype=np.float64) + 0.0)
        refuse(name, array, ~np.isfinite(array), "must be finite")
    else:
        raise ShapeError(f"{name}: expected real numbers, got {value!r}")
    if array.shape[max(array.ndim - len(tail), 0) :] != tail:
        wanted = " × ".join(map(str, tail))
        raise ShapeError(f"{name}: expected {wanted} numbers, got an array of shape {array.shape}")
    return array


def _read_fractions(name: str, array: Array) -> Array:
    for number in array.reshape(-1):
        if isinstance(number, bool) or not isinstance(number, int | float | np.integer | np.floating | Fraction):
            raise ShapeError(f"{name}: expected real numbers, got {number!r}")
        refuse(name, np.asarray(number), not (isinstance(number, Fraction) or np.isfinite(number)), "must be finite")
    return fractions(array)


def refuse(name: str, array: Array, bad: Any, why: str) -> None:
    """Raise an error if anything is bad, showing the first that is."""
    bad = np.asarray(bad, dtype=bool)
    if not bad.any():
        return
    first = array[np.unravel_index(int(np.argmax(bad)), bad.shape)]
    shown = first.tolist() if isinstance(first, np.ndarray) else first
    raise ShapeError(f"{name}: {why}, got {shown}")


def at_least_zero(name: str, value: Any) -> Array:
    """Read numbers ≥ 0."""
    array = real(name, value)
    refuse(name, array, array < 0, "must be at least 0")
    return array


def share(name: str, value: Any) -> Array:
    """Read numbers from 0 to 1."""
    array = real(name, value)
    refuse(name, array, (array < 0) | (array > 1), "must be from 0 to 1")
    return array


def direction(name: str, value: Any) -> Array:
    """Read vectors (..., 3) that are not zero, of any length."""
    array = real(name, value, 3)
    refuse(name, array, (array == 0).all(axis=-1), "must not be zero")
    return array


Reader: TypeAlias = Callable[..., Array]
