"""Boxes, aligned and turned."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.exact import Vector, along, dot, minus, number, require, times, vector
from oracles.repro.pieces.solids import Solid


def columns_of(rotation: Any) -> list[list[Any]]:
    """Columns of the rotation matrix of a quaternion (x, y, z, w) of any length: exactly rational."""
    x, y, z, w = (number(value) for value in rotation)
    square = x * x + y * y + z * z + w * w
    require(square, "a rotation must not be 0")
    return [
        times(1 / square, [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)]),
        times(1 / square, [2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)]),
        times(1 / square, [2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y]),
    ]


class Bricks(Solid):
    """centre + Σ tᵢ·axisᵢ with all |tᵢ| ≤ 1, for three axes at right angles."""

    def __init__(self, centre: Vector, axes: Sequence[Vector]) -> None:
        self.centre, self.axes = centre, axes

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at a corner."""
        return dot(n, self.centre) + sum(abs(dot(n, axis)) for axis in self.axes)

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point: what is left of it without its nearest point."""
        rest = minus(x, self.centre)
        for axis in self.axes:
            if any(axis):
                rest = along(rest, -min(max(dot(rest, axis) / dot(axis, axis), -1), 1), axis)
        return dot(rest, rest)

    def local(self, way: Vector) -> tuple[list[list[Any]], list[Any]]:
        """A way in shares of each axis, and what is left of it."""
        found, rest = [], list(way)
        for axis in self.axes:
            if any(axis):
                t = dot(way, axis) / dot(axis, axis)
                found.append([t])
                rest = along(rest, -t, axis)
        return found, rest


def box(shape: Any) -> Bricks:
    """All center + R y with |yᵢ| ≤ half_extentsᵢ."""
    half, columns = vector(shape["half_extents"]), columns_of(shape["rotation"])
    return Bricks(vector(shape["center"]), [times(h, column) for h, column in zip(half, columns, strict=True)])


def aabb(shape: Any) -> Bricks:
    """All x with lower ≤ x ≤ upper."""
    lower, upper = vector(shape["lower"]), vector(shape["upper"])
    half = times(Fraction(1, 2), minus(upper, lower))
    require(min(half) >= 0, "upper must not be below lower")
    return Bricks(minus(upper, half), [[half[0], 0, 0], [0, half[1], 0], [0, 0, half[2]]])
