"""Where a ray first enters an ellipsoid or a cylinder, in exact rational arithmetic; irrational times are enclosed.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from refimpl.proof.points import ZERO, Vector, along, dot, minus, opposite, rationals, root, turned
from refimpl.proof.rays import Hit, Miss
from refimpl.shapes import Cylinder, Ellipsoid


class Quadratic(NamedTuple):
    """Times with a t² + 2 b t + c ≤ 0, where a ≥ 0."""

    a: Fraction
    b: Fraction
    c: Fraction

    def at(self, t: Fraction) -> Fraction:
        """Value at a time."""
        return (self.a * t + 2 * self.b) * t + self.c

    def entry(self) -> tuple[Fraction, Fraction]:
        """Enclose the first of two positive roots."""
        low, high = root(self.b * self.b - self.a * self.c)
        return self.c / (high - self.b), self.c / (low - self.b)


def ellipsoid(origin: Vector, way: Vector, shape: Ellipsoid) -> Hit | Miss:
    """First entry: in the coordinates in which the ellipsoid is the unit ball, that of a ball."""
    radii, columns = rationals(shape.radii), turned(shape.rotation)
    start, rate = minus(origin, rationals(shape.center)), way
    rows = [along(ZERO, 1 / r, column) for r, column in zip(radii, columns, strict=True)]

    def local(v: Vector) -> Vector:
        return dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)

    def normal(time: Fraction) -> Vector:
        y = local(along(start, time, rate))
        return opposite(along(along(along(ZERO, y[0], rows[0]), y[1], rows[1]), y[2], rows[2]))

    u, v = local(rate), local(start)
    form = Quadratic(dot(u, u), dot(u, v), dot(v, v) - 1)
    if form.c <= 0:
        return Hit(Fraction(0), Fraction(0), Fraction(0), normal)
    if form.b >= 0:
        return Miss(normal(Fraction(0)))
    middle = -form.b / form.a
    if form.at(middle) > 0:
        return Miss(normal(middle))
    low, high = form.entry()
    return Hit(low, high, middle, normal)


def cylinder(origin: Vector, way: Vector, shape: Cylinder) -> Hit | Miss:
    """First time between the planes of the caps and within the tube, both of which are intervals of time."""
    p, axis, radius = rationals(shape.p), minus(rationals(shape.q), rationals(shape.p)), Fraction(shape.radius.tolist())
    square, start = dot(axis, axis), minus(origin, p)

    def across(v: Vector) -> Vector:
        return along(v, -dot(v, axis) / square, axis)

    def side(time: Fraction) -> Vector:
        """From the ray to the axis."""
        return opposite(across(along(start, time, way)))

    height, climb = dot(start, axis), dot(way, axis)
    up = (
        axis if climb > 0 or (climb == 0 and height < 0) else opposite(axis)
    )  # into the first cap, for a ray that hits it
    if climb == 0:
        if not 0 <= height <= square:
            return Miss(up)
        first, last = Fraction(0), None
    else:
        ends = sorted((-height / climb, (square - height) / climb))
        if ends[1] < 0:
            return Miss(opposite(up))
        first, last = max(ends[0], Fraction(0)), ends[1]
    u, v = across(way), across(start)
    tube = Quadratic(dot(u, u), dot(u, v), dot(v, v) - radius * radius)
    if tube.at(first) <= 0:
        return Hit(first, first, first, lambda _: up)
    middle = -tube.b / tube.a if tube.a else first
    if tube.a == 0 or tube.at(middle) > 0:
        return Miss(side(middle))
    if middle < first:  # out of the tube before it comes between the planes: across both
        outwards = opposite(side(first))
        rising, falling = dot(outwards, way), dot(up, way)
        if first == 0:
            return Miss(side(first))
        return Miss(opposite(along(along(ZERO, falling, outwards), -rising, up)))
    low, high = tube.entry()
    within = middle if last is None else min(middle, last)
    if tube.at(within) > 0:  # it leaves the planes before it comes into the tube
        inwards = side(within)
        sinking, leaving = dot(inwards, way), dot(up, way)
        return Miss(along(along(ZERO, leaving, inwards), -sinking, up))
    return Hit(low, high, within, side)
