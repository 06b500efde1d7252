"""Proxies of a few numbers: points and rays, balls and capsules, half-spaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import Array, dot, largest, norm, power_of_two, scale
from refimpl.proxy import Proxy, as_offset, number, shifted, turned, vector
from refimpl.shapes.curved import Ellipsoid


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
        return type(self)(self.position + as_offset(offset, self.dimension))

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return type(self)(turned(rotation, self.position))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.position))

    def _stretched(self, factors: Array) -> Self:
        return type(self)(factors * self.position)


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
        return type(self)(self.origin + as_offset(offset, self.dimension), self.direction)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin of the coordinates."""
        return type(self)(turned(rotation, self.origin), turned(rotation, self.direction))

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.origin), scale(factor, self.direction))

    def _stretched(self, factors: Array) -> Self:
        return type(self)(factors * self.origin, factors * self.direction)

    def times_power(self, exponent: Any) -> Self:
        """Scale the origin by 2^exponent; the direction is brought to about 1, and times change with it."""
        own = power_of_two(largest(self.direction))
        return self._trusted(shifted(self.origin, np.asarray(exponent), 1), shifted(self.direction, -own, 1))


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
        return type(self)(turned(rotation, self.center), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.center), factor * self.radius)

    def to_ellipsoid(self) -> Ellipsoid:
        """Give the same set as an `Ellipsoid`, which can be stretched."""
        return Ellipsoid(self.center, scale(self.radius, np.ones(3)))

    def _uneven(self) -> str:
        return "it becomes an Ellipsoid (Sphere.to_ellipsoid())"


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
        return type(self)(turned(rotation, self.p), turned(rotation, self.q), self.radius)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(scale(factor, self.p), scale(factor, self.q), factor * self.radius)

    def _stretched(self, factors: Array) -> Self:
        if np.all(self.radius == 0):
            return type(self)(factors * self.p, factors * self.q, self.radius)
        return super()._stretched(factors)

    def _uneven(self) -> str:
        return (
            "its ends stop being halves of balls, unless its radius is 0; no type has that set, "
            "a Composite of a Cylinder and two Ellipsoids comes nearest"
        )


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
        return type(self)(turned(rotation, self.normal), self.k)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(self.normal, factor * self.k)

    def _stretched(self, factors: Array) -> Self:
        return type(self)(self.normal / factors, self.k)

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent; the normal is brought to about 1."""
        own = power_of_two(largest(self.normal))
        return self._trusted(shifted(self.normal, -own, 1), np.ldexp(self.k, np.asarray(exponent) - own))
