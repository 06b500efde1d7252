"""What the rows of the harness are to the engine: balls, rods, planes and bricks."""

from __future__ import annotations

import math
from typing import NamedTuple

from oracles.engine import Kind, Row
from oracles.planted.vectors import UNITS, Axes, Vec, add, along, dot, largest, length, square_to, sub, times, unit
from oracles.planted.vectors import cross as crossed
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point


class Ball(NamedTuple):
    """A ball, or a point where the radius is 0."""

    center: Vec
    radius: float

    @property
    def size(self) -> float:
        """Largest number."""
        return max(largest(self.center), self.radius)


class Rod(NamedTuple):
    """A capsule: all that is within the radius of the segment pq."""

    p: Vec
    q: Vec
    radius: float

    @property
    def size(self) -> float:
        """Largest number."""
        return max(largest(self.p, self.q), self.radius)

    @property
    def axis(self) -> Vec:
        """Direction from p to q; 0 of a ball."""
        return unit(sub(self.q, self.p))


class Plane(NamedTuple):
    """A half-space: n·x + offset ≤ 0, with n of length 1."""

    normal: Vec
    offset: float

    def height(self, point: Vec) -> float:
        """How far above the plane a point is."""
        return dot(self.normal, point) + self.offset


class Brick(NamedTuple):
    """A box: centre, half extents, and three axes of length 1."""

    center: Vec
    half: Vec
    axes: Axes

    @property
    def size(self) -> float:
        """Largest number."""
        return max(largest(self.center), largest(self.half))

    def into(self, point: Vec) -> Vec:
        """Coordinates of a point in the box's own frame."""
        way = sub(point, self.center)
        return (dot(way, self.axes[0]), dot(way, self.axes[1]), dot(way, self.axes[2]))

    def turn(self, own: Vec) -> Vec:
        """A direction of the box's own frame in the world."""
        return along(along(times(own[0], self.axes[0]), own[1], self.axes[1]), own[2], self.axes[2])

    def out(self, own: Vec) -> Vec:
        """A point of the box's own frame in the world."""
        return add(self.center, self.turn(own))

    def reach(self, direction: Vec) -> float:
        """Half the width along a direction of length 1."""
        return sum(h * abs(dot(direction, axis)) for h, axis in zip(self.half, self.axes, strict=True))

    def support(self, direction: Vec) -> Vec:
        """The corner that is farthest along a direction."""
        x, y, z = (math.copysign(h, dot(direction, a)) for h, a in zip(self.half, self.axes, strict=True))
        return self.out((x, y, z))

    def corners(self) -> list[Vec]:
        """All eight corners."""
        a, b, c = self.half
        return [self.out((x, y, z)) for x in (-a, a) for y in (-b, b) for z in (-c, c)]


Shape = Ball | Rod | Plane | Brick


class Gap(NamedTuple):
    """Signed distance, witness points, and the normal from A to B."""

    distance: float
    on_a: Vec
    on_b: Vec
    normal: Vec


class Reading:
    """Makes shapes of rows."""

    def read(self, kind: Kind, row: Row) -> Shape:
        """Give the shape of a row of numbers."""
        if kind is Capsule:
            return Rod(_vec(row, 0), _vec(row, 3), row[6])
        if kind is HalfSpace:
            return self.plane(_vec(row, 0), row[3])
        if kind is AABB:
            return self.upright(_vec(row, 0), _vec(row, 3))
        if kind is Box:
            x, y, z, w = row[6:10]
            return Brick(_vec(row, 0), _vec(row, 3), self.axes(x, y, z, w))
        return Ball(_vec(row, 0), 0.0 if kind is Point else row[3])

    def plane(self, normal: Vec, k: float) -> Plane:
        """Half-space with a normal of any length."""
        size = length(normal)
        return Plane(unit(normal), k / size)

    def upright(self, lower: Vec, upper: Vec) -> Brick:
        """Axis-aligned box."""
        return Brick(times(0.5, add(lower, upper)), times(0.5, sub(upper, lower)), UNITS)

    def axes(self, x: float, y: float, z: float, w: float) -> Axes:
        """Columns of the rotation matrix of a quaternion of any length."""
        size = math.hypot(x, y, z, w)
        x, y, z, w = x / size, y / size, z / size, w / size
        return (
            (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
            (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
            (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)),
        )


def core_of(rod: Rod) -> Brick:
    """The segment inside a rod, as a box without width."""
    first = rod.axis if rod.axis != (0.0, 0.0, 0.0) else UNITS[0]
    second = square_to(first)
    half = length(sub(rod.q, rod.p)) / 2
    return Brick(times(0.5, add(rod.p, rod.q)), (half, 0.0, 0.0), (first, second, crossed(first, second)))


def _vec(row: Row, at: int) -> Vec:
    return (row[at], row[at + 1], row[at + 2])
