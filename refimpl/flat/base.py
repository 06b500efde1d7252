"""What the proxies of the plane share: vectors of two numbers, and turning by an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from refimpl.fields import ShapeError
from refimpl.linear import Array, as_floats
from refimpl.proxy import Proxy


@dataclass(frozen=True, eq=False, repr=False)
class Flat(Proxy):
    """A closed set of points (x, y) of the plane; all vectors have two numbers."""

    dimension: ClassVar[int] = 2

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin by the angle `rotation` (...) in radians, anticlockwise."""
        angle = as_floats(rotation)
        if not np.all(np.isfinite(angle)):
            raise ShapeError(f"a rotation in the plane is a finite angle in radians, got {angle.tolist()!r}")
        return self._turned(np.cos(angle), np.sin(angle))

    def _turned(self, cosine: Array, sine: Array) -> Self:
        raise NotImplementedError


def turned_flat(cosine: Array, sine: Array, v: Array) -> Array:
    """Vectors (..., 2) turned anticlockwise; the angle's arrays have as many axes as the vectors, without the last."""
    x, y = v[..., 0], v[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
