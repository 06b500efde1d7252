"""Area, centroid and radius of gyration of flat proxies of uniform density: the mass properties of the plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.flat.difference import outline_of
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, Rectangle, Segment
from refimpl.linear import Array, dot, norm, power_of_two, scale
from refimpl.proxy import Proxy, UnsupportedOperation


@dataclass(frozen=True)
class AreaProperties:
    """What a flat proxy of density 1 opposes to forces in the plane.

    Attributes
    ----------
    area : (...), length²
        0 of what is only a segment or a point; infinite beyond the largest float.
    centroid : (..., 2), length
    gyration : (...), length²
        Square of the radius of gyration about the centroid, which is the mean of the squared distance from there: times
        the mass, the moment of inertia about the axis that stands on the plane there. Of a `Segment` without a radius
        that of a thin rod; of a polygon without area 0.
    """

    area: Array
    centroid: Array
    gyration: Array

    @property
    def moment(self) -> Array:
        """Polar second moment of area about the centroid (...), length⁴."""
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(self.area * self.gyration)[()]


def area_properties(shape: Proxy) -> AreaProperties:
    """Area, centroid and radius of gyration of a flat solid.

    Raises
    ------
    UnsupportedOperation
        For a point or a ray, and for proxies of space, which have `refimpl.mass_properties`.
    """
    rule = RULES.get(type(shape))
    if rule is None:
        raise UnsupportedOperation(f"a {type(shape).__name__} has no area: it is not a bounded flat solid")
    exponent = power_of_two(shape.magnitude)
    found = rule(shape.times_power(-exponent))
    with np.errstate(over="ignore", under="ignore"):
        return AreaProperties(
            np.ldexp(found.area, 2 * exponent)[()],
            np.ldexp(found.centroid, exponent[..., None]),
            np.ldexp(found.gyration, 2 * exponent)[()],
        )


def _disc(s: Disc) -> AreaProperties:
    return AreaProperties(math.pi * s.radius**2, s.center, s.radius**2 / 2)


def _rectangle(b: Rectangle) -> AreaProperties:
    sides = b.upper - b.lower
    return AreaProperties(sides[..., 0] * sides[..., 1], b.reference_point, dot(sides, sides) / 12)


def _segment(s: Segment) -> AreaProperties:
    """A bar of the length by twice the radius, and two halves of a disc, whose centroids lie 4 r / 3 π outwards.

    Both areas are taken by the radius, so that a rod without any has a weight, too.
    """
    length, r = norm(s.q - s.p), s.radius
    bar, halves = 2 * length, math.pi * r
    of_bar = bar * (length**2 + 4 * r**2) / 12
    of_halves = halves * (r**2 / 2 + length**2 / 4 + length * (4 * r / (3 * math.pi)))
    whole = bar + halves
    return AreaProperties(r * whole, s.reference_point, (of_bar + of_halves) / np.where(whole > 0, whole, 1.0))


def _polygon(b: ConvexPolygon) -> AreaProperties:
    """Sums over the triangles from the first corner; for the gyration, from the centroid, where all have one sign.

    The sums go corner by corner, so that a row of a batch adds up as it does alone. Mirtich, Fast and Accurate
    Computation of Polyhedral Mass Properties, 1996, in the plane.
    """
    corners = outline_of(b).corners
    start = corners[..., 0, :]
    twice, first = np.zeros(start.shape[:-1]), np.zeros_like(start)
    for u, v in _sides(corners, start):
        cross = _cross(u, v)
        twice, first = twice + cross, first + scale(cross, u + v)
    middle = start + first / np.where(twice > 0, 3 * twice, 1.0)[..., None]
    moment = np.zeros_like(twice)
    for u, v in _sides(corners, middle):
        moment = moment + _cross(u, v) * (dot(u, u) + dot(u, v) + dot(v, v))
    flat = (twice == 0)[..., None]
    gyration = moment / np.where(twice > 0, 6 * twice, 1.0)
    return AreaProperties(twice / 2, np.where(flat, b.reference_point, middle), gyration)


def _sides(corners: Array, about: Array) -> Any:
    """Ends of each side, seen from a point."""
    count = corners.shape[-2]
    return ((corners[..., i, :] - about, corners[..., (i + 1) % count, :] - about) for i in range(count))


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


RULES: dict[type[Proxy], Callable[[Any], AreaProperties]] = {
    Disc: _disc,
    Segment: _segment,
    Rectangle: _rectangle,
    ConvexPolygon: _polygon,
}
