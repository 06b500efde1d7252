"""Fields of proxies: how they are declared, what numbers they accept, and what moves them.

A field's *tail* is the shape of its trailing axes, those of one proxy; where a tail names a size by a letter, proxies
of the type have different sizes, and one batch holds one size.
"""

from __future__ import annotations

from dataclasses import field
from math import prod
from typing import Any

import numpy as np

from refimpl.linear import Array, apply, as_floats, largest, quaternion_product, rotation_matrix

Tail = tuple[int | str, ...]


class ShapeError(ValueError):
    """A proxy was given numbers that mean no set; the text names the field and the value."""


class UnsupportedOperation(TypeError):
    """A proxy was asked for something its type does not have; the text names the type that does."""


IDENTITY = (0.0, 0.0, 0.0, 1.0)
"""The quaternion of no rotation."""


def number(*, minimum: float | None = None, open_end: bool = False, default: Any = None) -> Any:
    """Declare a field of one number per proxy, with the least value it may have."""
    rules = {"tail": (), "minimum": minimum, "open_end": open_end, "length": True}
    return field(metadata=rules) if default is None else field(metadata=rules, default=default)


def vector(
    *,
    width: int = 3,
    minimum: float | None = None,
    open_end: bool = False,
    nonzero: bool = False,
    length: bool = True,
    default: Any = None,
) -> Any:
    """Declare a field of `width` numbers per proxy; `length` tells whether they are lengths, which scale."""
    rules = {"tail": (width,), "minimum": minimum, "open_end": open_end, "nonzero": nonzero, "length": length}
    return field(metadata=rules) if default is None else field(metadata=rules, default=default)


def rows(size: str, width: int | str = 0, *, nonzero: bool = False, length: bool = True) -> Any:
    """Declare a field of as many rows of `width` numbers (0: single numbers) as the proxy's `size` says."""
    tail: Tail = (size, width) if width else (size,)
    return field(metadata={"tail": tail, "nonzero": nonzero, "length": length})


def count_of(tail: tuple[int, ...]) -> int:
    """How many numbers a tail holds."""
    return prod(tail)


def shifted(value: Array, exponent: Any, ends: int = 0) -> Array:
    """Give value · 2^exponent, the exponent (...) having `ends` trailing axes less than the value."""
    power = np.asarray(exponent)
    return np.asarray(np.ldexp(value, power.reshape(power.shape + (1,) * ends)))


def as_positive(factor: Any) -> Array:
    """Check a scaling factor: one positive number per proxy."""
    value = as_floats(factor)
    if not np.all(np.isfinite(value) & (value > 0)):
        raise UnsupportedOperation(f"a scaling factor must be positive and finite, got {value.tolist()!r}")
    return value


def as_offset(offset: Any, dimension: int = 3) -> Array:
    """Check a translation: vectors (..., dimension), finite."""
    v = as_floats(offset)
    if v.ndim == 0 or v.shape[-1] != dimension or not np.all(np.isfinite(v)):
        wanted = ", ".join("xyz"[:dimension])
        raise ShapeError(f"a translation is a finite vector ({wanted}), got {np.asarray(offset).tolist()!r}")
    return v


def as_quaternion(rotation: Any) -> Array:
    """Check a rotation: a quaternion (x, y, z, w), finite and not zero."""
    q = as_floats(rotation)
    if q.ndim == 0 or q.shape[-1] != 4 or not np.all(np.isfinite(q)) or np.any(np.all(q == 0, axis=-1)):
        raise ShapeError(f"a rotation is a non-zero quaternion (x, y, z, w), got {np.asarray(rotation).tolist()!r}")
    return q


def turned(rotation: Any, v: Array) -> Array:
    """Turn vectors about the origin by a quaternion, which is checked."""
    return apply(rotation_matrix(as_quaternion(rotation)), v)


def turned_frame(rotation: Any, own: Array) -> Array:
    """Quaternion of a frame `own` that is turned about the origin by `rotation`."""
    q = as_quaternion(rotation)
    return quaternion_product(q / largest(q)[..., None], own / largest(own)[..., None])
