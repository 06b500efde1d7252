"""What all proxies share: validation, batches, rows of numbers, and the checks of transformations.

The numbers stored are the shape: a double is an exact rational. Fields are arrays whose leading axes are batch
axes; fields broadcast together.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Self

import numpy as np

from refimpl.linear import (
    Array,
    as_floats,
    largest,
)


class ShapeError(ValueError):
    """A proxy was given numbers that mean no set; the text names the field and the value."""


class UnsupportedOperation(TypeError):
    """A proxy was asked for something its type does not have; the text names the type that does."""


def number(*, minimum: float | None = None, open_end: bool = False) -> Any:
    """Declare a field of one number per proxy, with the least value it may have."""
    return field(metadata={"width": 0, "minimum": minimum, "open_end": open_end})


def vector(*, width: int = 3, minimum: float | None = None, nonzero: bool = False) -> Any:
    """Declare a field of `width` numbers per proxy."""
    return field(metadata={"width": width, "minimum": minimum, "nonzero": nonzero})


_LAYOUTS: dict[type[Proxy], tuple[tuple[str, int], ...]] = {}


def _layout(kind: type[Proxy]) -> tuple[tuple[str, int], ...]:
    """Names and widths of a type's fields, in order; width 0 is a single number."""
    if kind not in _LAYOUTS:
        _LAYOUTS[kind] = tuple((f.name, f.metadata["width"]) for f in fields(kind))
    return _LAYOUTS[kind]


@dataclass(frozen=True, eq=False, repr=False)
class Proxy:
    """What all proxies share: validation, batches, packing into rows of numbers, isometries."""

    is_solid: ClassVar[bool] = True

    def __post_init__(self) -> None:
        columns = []
        for spec in fields(self):
            width = spec.metadata["width"]
            value = self._numbers(spec.name, getattr(self, spec.name))
            if width and (value.ndim == 0 or value.shape[-1] != width):
                raise ShapeError(
                    f"{self._name(spec.name)}: expected {width} numbers, got an array of shape {value.shape}"
                )
            self._check(spec, value)
            columns.append(value)
        self._store(columns)
        self._check_together()

    def _name(self, name: str) -> str:
        return f"{type(self).__name__}.{name}"

    def _numbers(self, name: str, value: Any) -> Array:
        try:
            return as_floats(value)
        except (TypeError, ValueError, OverflowError) as error:
            raise ShapeError(f"{self._name(name)}: not an array of real numbers: {value!r} ({error})") from None

    def _check(self, spec: Any, value: Array) -> None:
        rules = spec.metadata
        self._refuse(spec.name, value, ~np.isfinite(value), "must be finite")
        if rules.get("minimum") is not None:
            low = rules["minimum"]
            if rules.get("open_end"):
                self._refuse(spec.name, value, value <= low, f"must be greater than {low:g}")
            else:
                self._refuse(spec.name, value, value < low, f"must be at least {low:g}")
        if rules.get("nonzero"):
            self._refuse(spec.name, value, np.all(value == 0, axis=-1), "must not be zero")

    def _refuse(self, name: str, value: Array, bad: Any, why: str) -> None:
        if np.any(bad):
            where = tuple(int(i) for i in np.argwhere(bad)[0])
            at = f" at index {where}" if where else ""
            raise ShapeError(f"{self._name(name)} {why}, got {np.asarray(value)[where].tolist()!r}{at}")

    def _check_together(self) -> None:
        """Check what no field can check alone."""

    def _store(self, columns: list[Array]) -> None:
        """Give every field the common batch shape, and close it against writing."""
        layout = _layout(type(self))
        batches = [c.shape[:-1] if w else c.shape for c, (_, w) in zip(columns, layout, strict=True)]
        try:
            batch = np.broadcast_shapes(*batches)
        except ValueError:
            named = ", ".join(f"{n} {b}" for (n, _), b in zip(layout, batches, strict=True))
            raise ShapeError(f"{type(self).__name__}: batch shapes do not broadcast: {named}") from None
        for (name, width), column in zip(layout, columns, strict=True):
            full = np.broadcast_to(column, (*batch, width) if width else batch)
            full.flags.writeable = False
            object.__setattr__(self, name, full)

    @classmethod
    def _trusted(cls, *columns: Array) -> Self:
        """Build without validation, from arrays that this package computed from a valid shape."""
        shape = object.__new__(cls)
        shape._store([np.asarray(c) for c in columns])
        return shape

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Leading axes shared by all fields; ``()`` for a single proxy."""
        name, width = _layout(type(self))[0]
        shape: tuple[int, ...] = getattr(self, name).shape
        return shape[:-1] if width else shape

    def __getitem__(self, index: Any) -> Self:
        """Proxies at `index` of the batch axes."""
        if not isinstance(index, tuple):
            index = (index,)
        columns = []
        for name, width in _layout(type(self)):
            value = getattr(self, name)
            columns.append(value[(*index, Ellipsis, slice(None))] if width else value[index])
        return self._trusted(*columns)

    def __repr__(self) -> str:
        """Name every field in full precision; a large batch is named by its shape."""
        if np.prod(self.batch_shape, dtype=int) > 4:
            return f"{type(self).__name__}(<batch of shape {self.batch_shape}>)"
        values = ", ".join(f"{name}={getattr(self, name).tolist()!r}" for name, _ in _layout(type(self)))
        return f"{type(self).__name__}({values})"

    def __len__(self) -> int:
        if not self.batch_shape:
            raise TypeError(f"a single {type(self).__name__} has no length")
        return self.batch_shape[0]

    @classmethod
    def width(cls) -> int:
        """How many numbers one proxy of this type is."""
        return sum(max(w, 1) for _, w in _layout(cls))

    def pack(self) -> Array:
        """All fields side by side, in the constructor's order; shape (..., width)."""
        parts = [getattr(self, n) if w else getattr(self, n)[..., None] for n, w in _layout(type(self))]
        return np.concatenate(parts, axis=-1)

    @classmethod
    def unpack(cls, rows: Array) -> Self:
        """Build from the rows that `pack` gives; validated like any constructor call."""
        return cls(*cls._split(np.asarray(rows, dtype=np.float64)))

    @classmethod
    def _split(cls, rows: Array) -> list[Array]:
        parts, start = [], 0
        for _, width in _layout(cls):
            parts.append(rows[..., start : start + width] if width else rows[..., start])
            start += max(width, 1)
        return parts

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent, per proxy."""
        return largest(self.pack())

    @property
    def reference_point(self) -> Array:
        """A point by which the proxy is placed: its centre where it has one; shape (..., 3)."""
        raise NotImplementedError

    def translated(self, offset: Any) -> Self:
        """Move by `offset` (..., 3)."""
        raise NotImplementedError

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin by the quaternion `rotation` (..., 4), x y z w, of any non-zero length."""
        raise NotImplementedError

    def scaled(self, factor: Any) -> Self:
        """Scale uniformly about the origin by `factor` > 0."""
        scale_by = as_positive(factor)
        if len(np.shape(scale_by)) > len(self.batch_shape):
            name = type(self).__name__
            raise UnsupportedOperation(
                f"a {name} scales uniformly, by one factor for each proxy: {np.asarray(factor).tolist()!r} is uneven; "
                "scale a mesh or a hull instead, or build each shape from its own numbers"
            )
        return self._scaled(scale_by)

    def _scaled(self, factor: Array) -> Self:
        raise NotImplementedError

    def transformed(self, rotation: Any, translation: Any) -> Self:
        """Turn about the origin, then move: the isometry x ↦ R x + translation."""
        return self.rotated(rotation).translated(translation)


def as_positive(factor: Any) -> Array:
    """Check a scaling factor: one positive number per proxy."""
    value = as_floats(factor)
    if not np.all(np.isfinite(value) & (value > 0)):
        raise UnsupportedOperation(f"a scaling factor must be positive and finite, got {value.tolist()!r}")
    return value


def as_offset(offset: Any) -> Array:
    """Check a translation: vectors (..., 3), finite."""
    v = as_floats(offset)
    if v.ndim == 0 or v.shape[-1] != 3 or not np.all(np.isfinite(v)):
        raise ShapeError(f"a translation is a finite vector (x, y, z), got {np.asarray(offset).tolist()!r}")
    return v


def as_quaternion(rotation: Any) -> Array:
    """Check a rotation: a quaternion (x, y, z, w), finite and not zero."""
    q = as_floats(rotation)
    if q.ndim == 0 or q.shape[-1] != 4 or not np.all(np.isfinite(q)) or np.any(np.all(q == 0, axis=-1)):
        raise ShapeError(f"a rotation is a non-zero quaternion (x, y, z, w), got {np.asarray(rotation).tolist()!r}")
    return q
