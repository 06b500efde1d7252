"""Ellipsoids and cylinders."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.boxes import columns_of
from oracles.repro.pieces.exact import Vector, along, dot, minus, number, require, root, times, vector
from oracles.repro.pieces.rounds import Segment
from oracles.repro.pieces.solids import Solid


class Egg(Solid):
    """centre + Σ tᵢ·axisᵢ with Σ tᵢ² ≤ 1, for three axes at right angles."""

    def __init__(self, centre: Vector, axes: Sequence[Vector]) -> None:
        self.centre, self.axes = centre, axes

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x, or more by less than 2⁻¹⁵⁰ of it."""
        return dot(n, self.centre) + root(Fraction(sum(dot(n, axis) ** 2 for axis in self.axes)))[1]

    def square(self, x: Vector) -> Any:
        """Square of how far at most a point is: on the way to the centre, or down the gradient of Σ tᵢ²."""
        rest = minus(x, self.centre)
        t = [dot(rest, axis) / dot(axis, axis) for axis in self.axes]
        level = sum(c * c for c in t)
        if level <= 1:
            return 0
        inwards = dot(rest, rest) * (1 - 1 / root(Fraction(level))[1]) ** 2
        slope = [Fraction(0)] * 3
        for c, axis in zip(t, self.axes, strict=True):
            slope = along(slope, c / dot(axis, axis), axis)
        steep, bend = dot(slope, slope), sum((dot(slope, axis) / dot(axis, axis)) ** 2 for axis in self.axes)
        room = steep * steep - (level - 1) * bend  # after the move −m·slope, Σ tᵢ² is level − 2·steep·m + bend·m²
        if room < 0:
            return inwards
        return min(inwards, steep * ((level - 1) / (steep + root(Fraction(room))[0])) ** 2)

    def local(self, way: Vector) -> tuple[list[list[Any]], list[Any]]:
        """A way in shares of the axes."""
        return [[dot(way, axis) / dot(axis, axis) for axis in self.axes]], [0, 0, 0]


def ellipsoid(shape: Any) -> Solid:
    """All center + R y with Σ (yᵢ / radiiᵢ)² ≤ 1; a ball, where its radii are equal."""
    center, radii, columns = vector(shape["center"]), vector(shape["radii"]), columns_of(shape["rotation"])
    require(min(radii) > 0, "radii must be positive")
    if min(radii) == max(radii):
        return Segment(center, center, radii[0])
    return Egg(center, [times(r, column) for r, column in zip(radii, columns, strict=True)])


class Drum(Solid):
    """centre + t·half + a disc of radius `across` at right angles to `half`, with |t| ≤ 1."""

    def __init__(self, centre: Vector, half: Vector, across: Fraction) -> None:
        self.centre, self.half, self.across = centre, half, across

    def _split(self, x: Vector) -> tuple[Any, list[Any]]:
        """Share of `half` in a vector, and its part across."""
        t = dot(x, self.half) / dot(self.half, self.half)
        return t, along(x, -t, self.half)

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x, on the edge of one end, or more by less than 2⁻¹⁵⁰ of it."""
        _, flat = self._split(n)
        edge = root(Fraction(self.across**2 * dot(flat, flat)))[1]
        return dot(n, self.centre) + abs(dot(n, self.half)) + edge

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point, or a little more."""
        t, flat = self._split(minus(x, self.centre))
        beyond = max(abs(t) - 1, 0) ** 2 * dot(self.half, self.half)
        ratio = dot(flat, flat) / self.across**2
        return beyond + (dot(flat, flat) * (1 - 1 / root(Fraction(ratio))[1]) ** 2 if ratio > 1 else 0)

    def local(self, way: Vector) -> tuple[list[list[Any]], list[Any]]:
        """A way in shares of the axis, and of the radius."""
        t, flat = self._split(way)
        return [[t], times(1 / self.across, flat)], [0, 0, 0]


def cylinder(shape: Any) -> Drum:
    """Distance to the line pq ≤ radius, between the planes through p and q."""
    p, q, radius = vector(shape["p"]), vector(shape["q"]), number(shape["radius"])
    half = times(Fraction(1, 2), minus(q, p))
    require(any(half) and radius > 0, "a cylinder has a height and a radius")
    return Drum(minus(q, half), half, radius)
