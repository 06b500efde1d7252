"""What all proxies share: the arrays of a record (`refimpl.record`), and isometries with their checks.

The numbers stored are the shape: a double is an exact rational.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar, Self

import numpy as np

from refimpl.fields import (
    ShapeError,
    UnsupportedOperation,
    as_offset,
    as_positive,
    as_quaternion,
    count_of,
    number,
    rows,
    shifted,
    turned,
    turned_frame,
    vector,
)
from refimpl.linear import Array, largest
from refimpl.record import Record

__all__ = [
    "Proxy",
    "ShapeError",
    "UnsupportedOperation",
    "as_offset",
    "as_positive",
    "as_quaternion",
    "number",
    "rows",
    "shifted",
    "turned",
    "turned_frame",
    "vector",
]


@dataclass(frozen=True, eq=False, repr=False)
class Proxy(Record):
    """What all proxies share: the arrays of a record, and isometries of the set that they mean."""

    is_solid: ClassVar[bool] = True
    dimension: ClassVar[int] = 3
    """How many coordinates its points have."""

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent, per proxy; a direction's length is no length of the scene."""
        tails = type(self)._tails(self.sizes)
        lengths = [
            getattr(self, spec.name).reshape((*self.batch_shape, count_of(tail)))
            for spec, tail in zip(fields(self), tails, strict=True)
            if spec.metadata["length"]
        ]
        return largest(np.concatenate(lengths, axis=-1))

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
                f"a {name} is scaled uniformly, by one factor for each proxy: {np.asarray(factor).tolist()!r} is "
                "uneven; use `stretched` with a factor for each axis"
            )
        return self._scaled(scale_by)

    def _scaled(self, factor: Array) -> Self:
        raise NotImplementedError

    def stretched(self, factors: Any) -> Self:
        """Scale about the origin by `factors` (..., 3) > 0, one for each axis.

        Raises
        ------
        UnsupportedOperation
            Where the result is no proxy of this type; the text names the type that it is.
        """
        value = as_positive(factors)
        if value.ndim == 0 or value.shape[-1] != self.dimension:
            raise UnsupportedOperation(
                f"stretching takes {self.dimension} factors, one for each axis, got {value.tolist()!r}"
            )
        return self._stretched(value)

    def _stretched(self, factors: Array) -> Self:
        even = np.all(factors == factors[..., :1], axis=-1)
        if not np.all(even):
            raise UnsupportedOperation(
                f"a {type(self).__name__} cannot be stretched by {factors.tolist()!r}: {self._uneven()}"
            )
        return self._scaled(factors[..., 0])

    def _uneven(self) -> str:
        """Say which type has what uneven scaling makes of this one."""
        return "no type has what uneven scaling makes of it"

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent (...), exactly: lengths are multiplied, directions are not.

        Directions and normals, whose length means nothing, are brought to about 1 by powers of two, so that no
        product with them overflows or vanishes.
        """
        power = np.asarray(exponent)
        return self._trusted(
            *(
                shifted(getattr(self, spec.name), power, len(spec.metadata["tail"]))
                if spec.metadata["length"]
                else getattr(self, spec.name)
                for spec in fields(self)
            )
        )

    def transformed(self, rotation: Any, translation: Any) -> Self:
        """Turn about the origin, then move: the isometry x ↦ R x + translation."""
        return self.rotated(rotation).translated(translation)
