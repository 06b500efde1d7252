"""Curved solids: ellipsoids and cylinders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.fields import IDENTITY
from refimpl.linear import Array, rotation_matrix, scale
from refimpl.principal import principal_axes, quaternion_of
from refimpl.proxy import Proxy, as_offset, number, turned, turned_frame, vector


@dataclass(frozen=True, eq=False, repr=False)
class Ellipsoid(Proxy):
    """The set center + R(rotation)·y with Σ (y_i / radii_i)² ≤ 1.

    Parameters
    ----------
    center : (..., 3)
    radii : (..., 3)
        Greater than 0.
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.
    """

    center: Array = vector()
    radii: Array = vector(minimum=0.0, open_end=True)
    rotation: Array = vector(width=4, nonzero=True, length=False, default=IDENTITY)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, radii: ArrayLike, rotation: ArrayLike = ...) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.radii, self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(turned(rotation, self.center), self.radii, turned_frame(rotation, self.rotation))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), scale(factor, self.radii), self.rotation)

    def _stretched(self, factors: Array) -> Self:
        """Stretch: an ellipsoid stays one, with other principal axes."""
        matrix = factors[..., :, None] * rotation_matrix(self.rotation) * self.radii[..., None, :]
        axes, radii = principal_axes(matrix)
        return type(self)(factors * self.center, radii, quaternion_of(axes))


@dataclass(frozen=True, eq=False, repr=False)
class Cylinder(Proxy):
    """Every point within `radius` of the line pq and between the planes through `p` and `q` normal to pq.

    Parameters
    ----------
    p, q : (..., 3)
        Centres of the two end discs; they differ.
    radius : (...)
        Greater than 0.
    """

    p: Array = vector()
    q: Array = vector()
    radius: Array = number(minimum=0.0, open_end=True)

    def _check_together(self) -> None:
        same = np.all(self.p == self.q, axis=-1)
        self._refuse("q", self.q, same, "must differ from Cylinder.p: between equal ends there is no axis")

    if TYPE_CHECKING:

        def __init__(self, p: ArrayLike, q: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The middle of the axis."""
        return self.p / 2 + self.q / 2

    def translated(self, offset: Any) -> Self:
        """Move by `offset`; raises `ShapeError` where that rounds both ends to one point."""
        shift = as_offset(offset)
        return type(self)(self.p + shift, self.q + shift, self.radius)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(turned(rotation, self.p), turned(rotation, self.q), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.p), scale(factor, self.q), factor * self.radius)

    def _stretched(self, factors: Array) -> Self:
        """Stretch along an axis of the coordinates, evenly across it."""
        lies_along = np.argmax(self.p != self.q, axis=-1)[..., None]
        aligned = np.sum(self.p != self.q, axis=-1) == 1
        first, second = (
            np.take_along_axis(*_same_batch(factors, (lies_along + i) % 3), axis=-1)[..., 0] for i in (1, 2)
        )
        if not np.all(aligned & (first == second)):
            return super()._stretched(factors)
        return type(self)(factors * self.p, factors * self.q, first * self.radius)

    def _uneven(self) -> str:
        return (
            "unless its axis is one of the coordinates' and both factors across it are equal, its cross-section "
            "becomes an ellipse or its ends slanted, which no type has; a ConvexPolyhedron comes near"
        )


def _same_batch(v: Array, index: Any) -> tuple[Array, Any]:
    batch = np.broadcast_shapes(v.shape[:-1], index.shape[:-1])
    return np.broadcast_to(v, (*batch, 3)), np.broadcast_to(index, (*batch, 1))
