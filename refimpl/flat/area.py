"""Area, centroid and polar moment of flat proxies of uniform density 1: the mass properties of the plane."""

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
        0 of what is only a segment or a point.
    centroid : (..., 2), length
    moment : (...), length⁴
        Polar second moment of area about the centroid: times the density, the moment of inertia about the axis that
        stands on the plane there.
    """

    area: Array
    centroid: Array
    moment: Array


def area_properties(shape: Proxy) -> AreaProperties:
    """Area, centroid and polar moment of a flat solid.

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
    return AreaProperties(
        np.ldexp(found.area, 2 * exponent)[()],
        np.ldexp(found.centroid, exponent[..., None]),
        np.ldexp(found.moment, 4 * exponent)[()],
    )


def _disc(s: Disc) -> AreaProperties:
    area = math.pi * s.radius**2
    return AreaProperties(area, s.center, area * s.radius**2 / 2)


def _rectangle(b: Rectangle) -> AreaProperties:
    sides = b.upper - b.lower
    area = sides[..., 0] * sides[..., 1]
    return AreaProperties(area, b.reference_point, area * dot(sides, sides) / 12)


def _segment(s: Segment) -> AreaProperties:
    """A bar of the length by twice the radius, and two halves of a disc, whose centroids lie 4 r / 3 π outwards."""
    length, r = norm(s.q - s.p), s.radius
    bar, halves = 2 * r * length, math.pi * r**2
    of_bar = bar * (length**2 + 4 * r**2) / 12
    of_halves = halves * (r**2 / 2 + length**2 / 4 + length * (4 * r / (3 * math.pi)))
    return AreaProperties(bar + halves, s.reference_point, of_bar + of_halves)


def _polygon(b: ConvexPolygon) -> AreaProperties:
    """Sums over the triangles from the first corner; for the moment, from the centroid, where all have one sign.

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
    return AreaProperties(twice / 2, np.where(flat, b.reference_point, middle), moment / 12)


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
