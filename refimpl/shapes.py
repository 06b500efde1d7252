"""The proxies: what is tested for collision, as immutable data.

Each constructor's docstring says which closed set its numbers mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import (
    Array,
    apply,
    dot,
    largest,
    norm,
    power_of_two,
    quaternion_product,
    rotation_matrix,
    scale,
)
from refimpl.proxy import (
    Proxy,
    ShapeError,
    UnsupportedOperation,
    as_offset,
    as_quaternion,
    number,
    vector,
)

__all__ = [
    "AABB",
    "Box",
    "Capsule",
    "HalfSpace",
    "Point",
    "Proxy",
    "Ray",
    "ShapeError",
    "Sphere",
    "UnsupportedOperation",
]


def _turn(rotation: Any, v: Array) -> Array:
    return apply(rotation_matrix(as_quaternion(rotation)), v)


@dataclass(frozen=True, eq=False, repr=False)
class Point(Proxy):
    """The set {position}.

    Parameters
    ----------
    position : (..., 3)
    """

    is_solid: ClassVar[bool] = False
    position: Array = vector()

    if TYPE_CHECKING:

        def __init__(self, position: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The position."""
        return self.position

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.position + as_offset(offset))

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.position))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.position))


@dataclass(frozen=True, eq=False, repr=False)
class Ray(Proxy):
    """The set {origin + t·direction, t ≥ 0}; t counts in units of the direction's length.

    Parameters
    ----------
    origin : (..., 3)
    direction : (..., 3)
        Of any non-zero length.
    """

    is_solid: ClassVar[bool] = False
    origin: Array = vector()
    direction: Array = vector(nonzero=True)

    if TYPE_CHECKING:

        def __init__(self, origin: ArrayLike, direction: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The origin."""
        return self.origin

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of the origin: the direction's length is no length of the scene."""
        return largest(self.origin)

    def at(self, t: Any) -> Array:
        """Points at times `t`."""
        return self.origin + scale(np.asarray(t, dtype=np.float64), self.direction)

    def translated(self, offset: Any) -> Self:
        """Move the origin by `offset`."""
        return type(self)(self.origin + as_offset(offset), self.direction)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin of the coordinates."""
        return type(self)(_turn(rotation, self.origin), _turn(rotation, self.direction))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.origin), scale(factor, self.direction))


@dataclass(frozen=True, eq=False, repr=False)
class Sphere(Proxy):
    """The ball ‖x − center‖ ≤ radius.

    Parameters
    ----------
    center : (..., 3)
    radius : (...)
        Greater than 0: the sphere of radius 0 is a `Point`.
    """

    center: Array = vector()
    radius: Array = number(minimum=0.0, open_end=True)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.radius)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.center), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), factor * self.radius)


@dataclass(frozen=True, eq=False, repr=False)
class Capsule(Proxy):
    """Every point within `radius` of the segment from `p` to `q`.

    Parameters
    ----------
    p, q : (..., 3)
        End points of the inner segment; equal ones make a ball.
    radius : (...)
        At least 0; a capsule of radius 0 is a segment.
    """

    p: Array = vector()
    q: Array = vector()
    radius: Array = number(minimum=0.0)

    if TYPE_CHECKING:

        def __init__(self, p: ArrayLike, q: ArrayLike, radius: ArrayLike) -> None: ...

    @property
    def reference_point(self) -> Array:
        """The middle of the segment."""
        return self.p / 2 + self.q / 2

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset)
        return type(self)(self.p + shift, self.q + shift, self.radius)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.p), _turn(rotation, self.q), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.p), scale(factor, self.q), factor * self.radius)


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpace(Proxy):
    """The set normal·x + k ≤ 0; the solid lies behind the plane, the normal points out of it.

    Parameters
    ----------
    normal : (..., 3)
        Of any non-zero length.
    k : (...)
        In units of the normal's length: the plane's signed distance from the origin is −k/‖normal‖.
    """

    normal: Array = vector(nonzero=True)
    k: Array = number()

    def _check_together(self) -> None:
        with np.errstate(over="ignore"):
            self._refuse("k", self.k, ~np.isfinite(self.magnitude), "puts the plane beyond the largest float")

    if TYPE_CHECKING:

        def __init__(self, normal: ArrayLike, k: ArrayLike) -> None: ...

    @property
    def magnitude(self) -> Array:
        """Distance of the plane from the origin: the normal's length is no length of the scene."""
        exponent = power_of_two(largest(self.normal))
        return np.abs(np.ldexp(self.k, -exponent)) / norm(np.ldexp(self.normal, -exponent[..., None]))

    @property
    def reference_point(self) -> Array:
        """The point of the plane nearest to the origin."""
        exponent = power_of_two(largest(self.normal))
        n = np.ldexp(self.normal, -exponent[..., None])
        return scale(-np.ldexp(self.k, -exponent) / dot(n, n), n)

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.normal, self.k - dot(self.normal, as_offset(offset)))

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(_turn(rotation, self.normal), self.k)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(self.normal, factor * self.k)


@dataclass(frozen=True, eq=False, repr=False)
class AABB(Proxy):
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


@dataclass(frozen=True, eq=False, repr=False)
class Box(Proxy):
    """The set center + R(rotation)·y with |y_i| ≤ half_extents_i.

    Parameters
    ----------
    center : (..., 3)
    half_extents : (..., 3)
        At least 0; zeros make the box flat.
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.
    """

    center: Array = vector()
    half_extents: Array = vector(minimum=0.0)
    rotation: Array = vector(width=4, nonzero=True)

    if TYPE_CHECKING:

        def __init__(self, center: ArrayLike, half_extents: ArrayLike, rotation: ArrayLike) -> None: ...

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate or extent: a quaternion's length is no length of the scene."""
        return np.maximum(largest(self.center), largest(self.half_extents))

    @property
    def reference_point(self) -> Array:
        """The centre."""
        return self.center

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return type(self)(self.center + as_offset(offset), self.half_extents, self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        q = as_quaternion(rotation)
        product = quaternion_product(q / largest(q)[..., None], self.rotation / largest(self.rotation)[..., None])
        return type(self)(_turn(rotation, self.center), self.half_extents, product)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), scale(factor, self.half_extents), self.rotation)
