"""Boxes: aligned with the axes, and turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.derived import Derived, of_hulls
from refimpl.fields import IDENTITY
from refimpl.hulls import hull_of_box
from refimpl.linear import Array, apply_inverse, rotation_matrix, scale
from refimpl.proxy import UnsupportedOperation, as_offset, turned, turned_frame, vector
from refimpl.shapes.convex import ConvexPolyhedron
from refimpl.shapes.polytope import Polytope


@dataclass(frozen=True, eq=False, repr=False)
class AABB(Polytope):
    """The axis-aligned box lower ≤ x ≤ upper.

    Parameters
    ----------
    lower, upper : (..., 3)
        Corners, lower ≤ upper in every coordinate; equal ones make the box flat.
    """

    lower: Array = vector()
    upper: Array = vector()

    def _check_together(self) -> None:
        self._refuse("upper", self.upper, self.upper < self.lower, "must not be below AABB.lower")

    if TYPE_CHECKING:

        def __init__(self, lower: ArrayLike, upper: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.lower / 2 + self.upper / 2

    def _derive(self) -> Derived:
        return of_hulls(hull_of_box(self.lower, self.upper))

    def to_box(self) -> Box:
        """The same set as a `Box`, which can be rotated; its centre and extents are rounded."""
        identity = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (*self.batch_shape, 4))
        return Box._trusted(self.reference_point, self.upper / 2 - self.lower / 2, identity)

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset)
        return type(self)(self.lower + shift, self.upper + shift)

    def rotated(self, rotation: Any) -> Self:  # noqa: ARG002  there is none that works
        """Raise: an axis-aligned box does not stay one."""
        raise UnsupportedOperation("an AABB cannot be rotated: it stays aligned with the axes; use Box (AABB.to_box())")

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.lower), scale(factor, self.upper))

    def _stretched(self, factors: Array) -> Self:
        return type(self)(factors * self.lower, factors * self.upper)


@dataclass(frozen=True, eq=False, repr=False)
class Box(Polytope):
    """The set center + R(rotation)·y with |y_i| ≤ half_extents_i.

    Parameters
    ----------
    center : (..., 3)
    half_extents : (..., 3)
        At least 0; zeros make the box flat.
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.
        By default none.
    """

    center: Array = vector()
    half_extents: Array = vector(minimum=0.0)
    rotation: Array = vector(width=4, nonzero=True, length=False, default=IDENTITY)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, half_extents: ArrayLike, rotation: ArrayLike = ...) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.half_extents, self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(turned(rotation, self.center), self.half_extents, turned_frame(rotation, self.rotation))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), scale(factor, self.half_extents), self.rotation)

    def _stretched(self, factors: Array) -> Self:
        axes = np.abs(rotation_matrix(self.rotation))
        if not np.all((axes == 0) | (axes == 1)):
            return super()._stretched(factors)
        return type(self)(factors * self.center, apply_inverse(axes, factors) * self.half_extents, self.rotation)

    def _uneven(self) -> str:
        return "turned against the axes, it becomes a parallelepiped: use ConvexPolyhedron (Box.to_convex_polyhedron())"

    def _derive(self) -> Derived:
        """Hull of the box about the origin, before it is turned and moved."""
        return of_hulls(hull_of_box(-self.half_extents, self.half_extents))

    def to_convex_polyhedron(self) -> ConvexPolyhedron:
        """Give the same set as a `ConvexPolyhedron` of six planes, which can be stretched."""
        sides = np.concatenate([np.eye(3), -np.eye(3)])
        batch = self.batch_shape
        normals = np.broadcast_to(sides, (*batch, 6, 3))
        reach = np.concatenate([self.half_extents, self.half_extents], axis=-1)
        planes = np.concatenate([normals, -reach[..., None]], axis=-1)
        return ConvexPolyhedron(planes, self.center, self.rotation)
