"""Where a ray first enters an ellipsoid or a cylinder, in exact rational arithmetic; irrational times are enclosed.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from refimpl.proof.points import ZERO, Vector, along, dot, minus, opposite, rationals, root, turned
from refimpl.proof.rays import Hit, Miss, moment
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


class _Tube:
    """A cylinder as a ray meets it: `across` of a point of the ray is its offset from the axis."""

    def __init__(self, origin: Vector, way: Vector, shape: Cylinder) -> None:
        p = rationals(shape.p)
        self.way, self.start = way, minus(origin, p)
        self.axis, radius = minus(rationals(shape.q), p), Fraction(shape.radius.tolist())
        self.square = dot(self.axis, self.axis)
        u, v = self._aside(way), self._aside(self.start)
        self.form = Quadratic(dot(u, u), dot(u, v), dot(v, v) - radius * radius)
        self.nearest = -self.form.b / self.form.a if self.form.a else None

    def _aside(self, v: Vector) -> Vector:
        return along(v, -dot(v, self.axis) / self.square, self.axis)

    def inwards(self, time: Fraction) -> Vector:
        """From the ray to the axis."""
        return opposite(self._aside(along(self.start, time, self.way)))

    def between(self) -> tuple[Fraction, Fraction | None] | Vector:
        """Times between the planes of the caps, or the direction in which these are."""
        height, climb = dot(self.start, self.axis), dot(self.way, self.axis)
        if climb == 0:
            if 0 <= height <= self.square:
                return Fraction(0), None
            return self.axis if height < 0 else opposite(self.axis)
        first, last = sorted((-height / climb, (self.square - height) / climb))
        if last < 0:
            return self.axis if climb < 0 else opposite(self.axis)
        return max(first, Fraction(0)), last


def cylinder(origin: Vector, way: Vector, shape: Cylinder) -> Hit | Miss:
    """First time between the planes of the caps and within the tube, both of which are intervals of time."""
    tube = _Tube(origin, way, shape)
    between = tube.between()
    if len(between) == 3:
        return Miss(between)
    first, last = between
    up = tube.axis if dot(way, tube.axis) > 0 else opposite(tube.axis)
    if tube.form.at(first) <= 0:
        return moment(first, up)
    if tube.nearest is None or tube.form.at(tube.nearest) > 0:
        return Miss(tube.inwards(tube.nearest or first))
    within = tube.nearest if last is None else min(tube.nearest, last)
    if first <= within and tube.form.at(within) <= 0:
        low, high = tube.form.entry()
        return Hit(low, high, within, tube.inwards)
    # between the planes only after it left the tube, or before it comes to it: across the ray, by plane and tube
    inwards = tube.inwards(max(first, within))
    if within < first == 0:
        return Miss(inwards)
    return Miss(along(along(ZERO, dot(up, way), inwards), -dot(inwards, way), up))
