"""Records of arrays: validation, batches, rows of numbers; what proxies and motions are made of.

A record's fields (`refimpl.fields`) are arrays whose leading axes are batch axes; fields broadcast together.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar, NoReturn, Self

import numpy as np

from refimpl.fields import ShapeError, Tail, UnsupportedOperation, count_of
from refimpl.linear import Array, as_floats

_LAYOUTS: dict[type[Record], tuple[tuple[str, Tail], ...]] = {}


def _layout(kind: type[Record]) -> tuple[tuple[str, Tail], ...]:
    """Names and tails of a type's fields, in order."""
    if kind not in _LAYOUTS:
        _LAYOUTS[kind] = tuple((f.name, f.metadata["tail"]) for f in fields(kind))
    return _LAYOUTS[kind]


@dataclass(frozen=True, eq=False, repr=False)
class Record:
    """Arrays with common batch axes: validated, sliced, broadcast, packed into rows of numbers."""

    header: ClassVar[int] = 0
    """How many sizes lead a packed row: none, where all records of the type have one size."""

    def __post_init__(self) -> None:
        self._fill([getattr(self, name) for name, _ in _layout(type(self))])

    def _fill(self, values: Sequence[Any]) -> None:
        """Validate the fields' values, one by one and together, and store them."""
        columns = []
        sizes: dict[str, int] = {}
        for spec, given in zip(fields(self), values, strict=True):
            value = self._numbers(spec.name, given)
            self._fit(spec.name, value, spec.metadata["tail"], sizes)
            self._check(spec, value)
            columns.append(value)
        self._store(columns)
        self._check_together()

    def _label(self, name: str) -> str:
        """Name of a field as the caller knows it."""
        return name

    def _name(self, name: str) -> str:
        return f"{type(self).__name__}.{self._label(name)}"

    def _numbers(self, name: str, value: Any) -> Array:
        try:
            return as_floats(value)
        except (TypeError, ValueError, OverflowError) as error:
            raise ShapeError(f"{self._name(name)}: not an array of real numbers: {value!r} ({error})") from None

    def _fit(self, name: str, value: Array, tail: Tail, sizes: dict[str, int]) -> None:
        """Check the trailing axes; the first field that has a size fixes it for the others."""
        fixed: Tail = tail
        if value.ndim >= len(tail):
            ends = value.shape[value.ndim - len(tail) :]
            fixed = tuple(
                sizes.setdefault(want, have) if isinstance(want, str) else want
                for want, have in zip(tail, ends, strict=True)
            )
            if ends == fixed and 0 not in ends:
                return
        wanted = " × ".join(str(sizes.get(n, n) if isinstance(n, str) else n) for n in fixed)
        text = f"{self._name(name)}: expected {wanted} numbers, got an array of shape {value.shape}"
        raise ShapeError(text + self._hint(name, value))

    def _hint(self, name: str, value: Array) -> str:
        """What an array of a wrong shape may be meant as; empty where nothing suggests itself."""
        del name, value
        return ""

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
        tails = [c.shape[c.ndim - len(t) :] for c, (_, t) in zip(columns, layout, strict=True)]
        batches = [c.shape[: c.ndim - len(t)] for c, (_, t) in zip(columns, layout, strict=True)]
        try:  # numpy takes longer over broadcasting than over the rest, and most have their shape already
            batch = batches[0] if all(b == batches[0] for b in batches) else np.broadcast_shapes(*batches)
        except ValueError:
            named = ", ".join(f"{self._label(n)} {b}" for (n, _), b in zip(layout, batches, strict=True))
            raise ShapeError(f"{type(self).__name__}: batch shapes do not broadcast: {named}") from None
        for (name, _), tail, column in zip(layout, tails, columns, strict=True):
            shape = (*batch, *tail)
            full = np.asarray(column).view() if column.shape == shape else np.broadcast_to(column, shape)
            full.flags.writeable = False
            object.__setattr__(self, name, full)

    @classmethod
    def _trusted(cls, *columns: Array) -> Self:
        """Build without validation, from arrays that this package computed from a valid shape."""
        shape = object.__new__(cls)
        shape._store([np.asarray(c) for c in columns])
        return shape

    def _columns(self) -> list[tuple[Array, int]]:
        """Fields in order, each with its number of trailing axes."""
        return [(getattr(self, name), len(tail)) for name, tail in _layout(type(self))]

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        """Apply one change of batch axes to every field; `change` takes an array and its number of trailing axes."""
        return self._trusted(*(change(value, ends) for value, ends in self._columns()))

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Leading axes shared by all fields; ``()`` for a single record."""
        name, tail = _layout(type(self))[0]
        shape: tuple[int, ...] = getattr(self, name).shape
        return shape[: len(shape) - len(tail)]

    def __getitem__(self, index: Any) -> Self:
        """Records at `index` of the batch axes."""
        if not isinstance(index, tuple):
            index = (index,)
        return self._mapped(
            lambda value, ends: value[(*index, Ellipsis, *(slice(None),) * ends)] if ends else value[index]
        )

    def broadcast_to(self, batch: tuple[int, ...]) -> Self:
        """Repeat along new batch axes, without copying."""
        if batch == self.batch_shape:
            return self
        return self._mapped(
            lambda value, ends: np.broadcast_to(value, (*batch, *value.shape[value.ndim - ends :])),
        )

    def flattened(self) -> Self:
        """Give the same records with one batch axis; what all of them share is not copied."""
        if len(self.batch_shape) == 1:
            return self
        count = int(np.prod(self.batch_shape, dtype=int))

        def flat(value: Array, ends: int) -> Array:
            axes = value.ndim - ends
            tail = value.shape[axes:]
            if count and all(step == 0 or n == 1 for step, n in zip(value.strides[:axes], value.shape, strict=False)):
                return np.broadcast_to(value[(0,) * axes], (count, *tail))
            return value.reshape((count, *tail))

        return self._mapped(flat)

    def __repr__(self) -> str:
        """Name every field in full precision; a large batch is named by its shape."""
        if np.prod(self.batch_shape, dtype=int) > 4:
            return f"{type(self).__name__}(<batch of shape {self.batch_shape}>)"
        values = ", ".join(f"{self._label(name)}={getattr(self, name).tolist()!r}" for name, _ in _layout(type(self)))
        return f"{self._constructor()}({values})"

    def _constructor(self) -> str:
        """Name of the call that builds the record from its fields."""
        return type(self).__name__

    def __len__(self) -> int:
        if not self.batch_shape:
            raise TypeError(f"a single {type(self).__name__} has no length")
        return self.batch_shape[0]

    @property
    def sizes(self) -> tuple[int, ...]:
        """The numbers that lead a packed row and say how long its parts are; none for a type of one size."""
        return ()

    @classmethod
    def _tails(cls, sizes: tuple[int, ...]) -> list[tuple[int, ...]]:  # noqa: ARG003  types of one size need none
        """Tails of the fields of a record of these sizes."""
        return [tuple(int(n) for n in tail) for _, tail in _layout(cls)]

    @classmethod
    def width(cls) -> int:
        """How many numbers one record of this type is; types of no fixed size have none."""
        if cls.header:
            raise UnsupportedOperation(f"a {cls.__name__} has no fixed width: ask a single one for its `storage`")
        return sum(count_of(tail) for tail in cls._tails(()))

    @property
    def storage(self) -> int:
        """How many numbers one record of this batch is."""
        return sum(count_of(tail) for tail in type(self)._tails(self.sizes))

    def pack(self) -> Array:
        """All fields side by side, in the constructor's order, after the sizes; shape (..., width)."""
        batch = self.batch_shape
        sizes = self.sizes
        parts = [np.broadcast_to(np.array(sizes, dtype=np.float64), (*batch, len(sizes)))] if sizes else []
        for (value, _), tail in zip(self._columns(), type(self)._tails(sizes), strict=True):
            parts.append(value.reshape((*batch, count_of(tail))))
        return np.concatenate(parts, axis=-1)

    @classmethod
    def unpack(cls, rows: Array) -> Self:
        """Build from the rows that `pack` gives; validated like any constructor call."""
        numbers = np.asarray(rows, dtype=np.float64)
        sizes = cls._read_sizes(numbers)
        wanted = cls.header + sum(count_of(tail) for tail in cls._tails(sizes))
        if numbers.ndim == 0 or numbers.shape[-1] != wanted:
            cls._refuse_rows(f"expected rows of {wanted} numbers, got an array of shape {numbers.shape}")
        return cls._validated(*cls._parts(numbers, sizes))

    @classmethod
    def _validated(cls, *columns: Array) -> Self:
        """Call the constructor that takes the fields in order."""
        return cls(*columns)

    @classmethod
    def _read_sizes(cls, numbers: Array) -> tuple[int, ...]:
        """Sizes that lead the rows, the same in all of them."""
        if not cls.header:
            return ()
        if numbers.ndim == 0 or numbers.shape[-1] < cls.header:
            cls._refuse_rows(f"expected {cls.header} sizes first, got an array of shape {numbers.shape}")
        leading = numbers[..., : cls.header].reshape(-1, cls.header)
        if not len(leading):
            cls._refuse_rows("a batch of none has no sizes")
        first = leading[0]
        if not np.all(leading == first):
            cls._refuse_rows("the rows of one batch must have the same sizes")
        if not np.all((first >= 0) & (first < 2**31) & (first == np.floor(first))):
            cls._refuse_rows(f"sizes must be whole numbers, got {first.tolist()!r}")
        return tuple(int(n) for n in first)

    @classmethod
    def _refuse_rows(cls, why: str) -> NoReturn:
        raise ShapeError(f"{cls.__name__}.unpack: {why}")

    def identity(self) -> tuple[tuple[Hashable, ...], Array]:
        """What two records of one type are put in order by: a form, and a row of numbers for each proxy.

        The form is the same for all records of a batch; records of one form mean the same where their rows are.
        """
        return self.sizes, self.pack()

    def rebuilt(self, rows: Array) -> Self:
        """Give a record of the same sizes from other packed rows, which are trusted and not validated."""
        return self._trusted(*self._parts(rows, self.sizes))

    @classmethod
    def _split(cls, rows: Array) -> list[Array]:
        """Fields of packed rows, for types of one size."""
        return cls._parts(rows, ())

    @classmethod
    def _parts(cls, rows: Array, sizes: tuple[int, ...]) -> list[Array]:
        parts, start = [], cls.header
        for tail in cls._tails(sizes):
            end = start + count_of(tail)
            parts.append(rows[..., start:end].reshape((*rows.shape[:-1], *tail)))
            start = end
        return parts
