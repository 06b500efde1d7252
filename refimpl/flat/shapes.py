"""Proxies of the plane of a few numbers: points, rays and segments, discs and axis-aligned rectangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.flat.base import Flat, turned_flat
from refimpl.flat.polygon import ConvexPolygon
from refimpl.linear import Array, scale
from refimpl.proxy import UnsupportedOperation, as_offset, number, vector
from refimpl.shapes import Point, Ray


@dataclass(frozen=True, eq=False, repr=False)
class FlatPoint(Flat, Point):
    """The set {position}.

    Parameters
    ----------
    position : (..., 2)
    """

    position: Array = vector(width=2)

    def _turned(self, cosine: Array, sine: Array) -> Self:
        return type(self)(turned_flat(cosine, sine, self.position))


@dataclass(frozen=True, eq=False, repr=False)
class FlatRay(Flat, Ray):
    """The set {origin + t·direction, t ≥ 0}; t counts in units of the direction's length.

    Parameters
    ----------
    origin : (..., 2)
    direction : (..., 2)
        Of any non-zero length.
    """

    origin: Array = vector(width=2)
    direction: Array = vector(width=2, nonzero=True)

    def _turned(self, cosine: Array, sine: Array) -> Self:
        return type(self)(turned_flat(cosine, sine, self.origin), turned_flat(cosine, sine, self.direction))


@dataclass(frozen=True, eq=False, repr=False)
class Disc(Flat):
    """The disc ‖x − center‖ ≤ radius.

    Parameters
    ----------
    center : (..., 2)
    radius : (...)
        Greater than 0: the disc of radius 0 is a `FlatPoint`.
    """

    center: Array = vector(width=2)
    radius: Array = number(minimum=0.0, open_end=True)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset, 2), self.radius)

    def _turned(self, cosine: Array, sine: Array) -> Self:
        return type(self)(turned_flat(cosine, sine, self.center), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), factor * self.radius)

    def _uneven(self) -> str:
        return "no flat type is an ellipse"


@dataclass(frozen=True, eq=False, repr=False)
class Segment(Flat):
    """Every point within `radius` of the segment from `p` to `q`.

    Parameters
    ----------
    p, q : (..., 2)
        End points; equal ones make a disc, or a point.
    radius : (...)
        At least 0, which it is if it is not given.
    """

    p: Array = vector(width=2)
    q: Array = vector(width=2)
    radius: Array = number(minimum=0.0, default=0.0)

    if TYPE_CHECKING:

        def __init__(self, p: ArrayLike, q: ArrayLike, radius: ArrayLike = 0.0) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The middle."""
        return self.p / 2 + self.q / 2

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset, 2)
        return type(self)(self.p + shift, self.q + shift, self.radius)

    def _turned(self, cosine: Array, sine: Array) -> Self:
        return type(self)(turned_flat(cosine, sine, self.p), turned_flat(cosine, sine, self.q), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.p), scale(factor, self.q), factor * self.radius)

    def _stretched(self, factors: Array) -> Self:
        if (self.radius == 0).all():
            return type(self)(factors * self.p, factors * self.q, self.radius)
        return super()._stretched(factors)

    def _uneven(self) -> str:
        return "its ends stop being halves of discs, unless its radius is 0; no flat type has that set"


@dataclass(frozen=True, eq=False, repr=False)
class Rectangle(Flat):
    """The axis-aligned rectangle lower ≤ x ≤ upper.

    Parameters
    ----------
    lower, upper : (..., 2)
        Corners, lower ≤ upper in both coordinates; equal ones make a segment or a point.
    """

    lower: Array = vector(width=2)
    upper: Array = vector(width=2)

    def _check_together(self) -> None:
        self._refuse("upper", self.upper, self.upper < self.lower, "must not be below Rectangle.lower")

    if TYPE_CHECKING:

        def __init__(self, lower: ArrayLike, upper: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.lower / 2 + self.upper / 2

    def to_polygon(self) -> ConvexPolygon:
        """Give the same set as a `ConvexPolygon` of four vertices, which can be rotated."""
        left, low, right, high = self.lower[..., 0], self.lower[..., 1], self.upper[..., 0], self.upper[..., 1]
        corners = [np.stack(corner, axis=-1) for corner in ((left, low), (right, low), (right, high), (left, high))]
        return ConvexPolygon.from_vertices(np.stack(corners, axis=-2))

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset, 2)
        return type(self)(self.lower + shift, self.upper + shift)

    def rotated(self, rotation: Any) -> Self:  # noqa: ARG002  there is none that works
        """Raise: an axis-aligned rectangle does not stay one."""
        raise UnsupportedOperation(
            "a Rectangle cannot be rotated: it stays aligned with the axes; use ConvexPolygon (Rectangle.to_polygon())"
        )

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.lower), scale(factor, self.upper))

    def _stretched(self, factors: Array) -> Self:
        return type(self)(factors * self.lower, factors * self.upper)
