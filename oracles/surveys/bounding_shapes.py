"""Bounding volumes as engines give them, read exactly, and how far points are outside of them.

Whatever frame an engine states is taken as it is: points are in a box where its own transformation takes them into the
extents.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from refimpl.linear import Array
from refimpl.proof.points import round_down
from refimpl.proof.vectors import cross, dot, minus, root, times

Exact = list[Fraction]


def numbers(value: Any, width: int, most: int) -> Array:
    """Read at most so many rows of finite numbers; raises ValueError or TypeError for anything else."""
    found = np.array(value, dtype=np.float64)
    if found.ndim != 2 or found.shape[1] != width or not 0 < len(found) <= most or not np.all(np.isfinite(found)):
        raise ValueError(f"expected 1 to {most} rows of {width} finite numbers, got an array of shape {found.shape}")
    return found


def exact(value: Any, count: int) -> Exact:
    """Read so many finite numbers."""
    if len(value) != count:
        raise ValueError(f"expected {count} numbers, got {len(value)}")
    return [_number(v) for v in value]


def _number(value: Any) -> Fraction:
    if not math.isfinite(value):
        raise ValueError(f"expected a finite number, got {value!r}")
    return Fraction(value)


def _farthest(distances: Sequence[float]) -> tuple[float, int]:
    which = max(range(len(distances)), key=distances.__getitem__)
    return distances[which], which


def _length(square: Fraction) -> Fraction:
    return root(square)[0]


class Ball(NamedTuple):
    """‖x − center‖ ≤ radius."""

    center: Exact
    radius: Fraction

    def beyond(self, points: Array) -> tuple[float, int]:
        """How far at least the farthest point is outside (0: none is), and which one."""
        found = []
        for x in points.tolist():
            gap = minus([Fraction(v) for v in x], self.center)
            square = dot(gap, gap)
            inside = square <= self.radius**2
            found.append(0.0 if inside else max(5e-324, round_down(_length(square) - self.radius)))
        return _farthest(found)


class Affine(NamedTuple):
    """|rows·x + shift| ≤ half, in each of three coordinates."""

    rows: list[Exact]
    shift: Exact
    half: Exact

    def beyond(self, points: Array) -> tuple[float, int]:
        """How far at least the farthest point is outside (0: none is), and which one."""
        found = []
        for x in points.tolist():
            place = [Fraction(v) for v in x]
            over = max(abs(dot(row, place) + t) - h for row, t, h in zip(self.rows, self.shift, self.half, strict=True))
            found.append(max(5e-324, round_down(over)) if over > 0 else 0.0)
        return _farthest(found)

    def volume(self) -> float:
        """Of a box whose rows have length 1."""
        return float(8 * self.half[0] * self.half[1] * self.half[2])


class Barrel(NamedTuple):
    """Within `radius` of the line pq and between the planes through p and q."""

    p: Exact
    q: Exact
    radius: Fraction

    def beyond(self, points: Array) -> tuple[float, int]:
        """How far at least the farthest point is outside of the side or of an end (0: none is), and which one."""
        way = minus(self.q, self.p)
        square = dot(way, way)
        found = []
        for x in points.tolist():
            place = [Fraction(v) for v in x]
            side = cross(minus(place, self.p), way)
            across = dot(side, side) / square
            over = max(dot(minus(place, self.q), way), -dot(minus(place, self.p), way))
            far = [_length(across) - self.radius] if across > self.radius**2 else []
            far += [over / root(square)[1]] if over > 0 else []
            found.append(max(5e-324, *(round_down(v) for v in far)) if far else 0.0)
        return _farthest(found)

    def volume(self) -> float:
        """π r² h."""
        way = minus(self.q, self.p)
        return math.pi * float(self.radius**2 * _length(dot(way, way)))


def ball_of(answer: Mapping[str, Any]) -> Ball:
    """Read a sphere: center, radius."""
    return Ball(exact(answer["center"], 3), _positive(answer["radius"]))


def _positive(value: Any) -> Fraction:
    number = _number(value)
    if number < 0:
        raise ValueError(f"expected a length of at least 0, got {value!r}")
    return number


def brick_of(answer: Mapping[str, Any]) -> Affine:
    """Read a box: center, half_extents and rotation (a quaternion), or to_origin (three rows of four) and extents."""
    if "to_origin" in answer:
        rows = [exact(row, 4) for row in answer["to_origin"]]
        if len(rows) != 3:
            raise ValueError("expected three rows of four numbers")
        return Affine(
            [row[:3] for row in rows], [row[3] for row in rows], [_positive(v) / 2 for v in answer["extents"]]
        )
    center, half = exact(answer["center"], 3), [_positive(v) for v in answer["half_extents"]]
    x, y, z, w = exact(answer["rotation"], 4)
    size = x * x + y * y + z * z + w * w
    columns = [
        [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), w * w + y * y - x * x - z * z, 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y],
    ]
    rows = [times(1 / size, column) for column in columns]
    return Affine(rows, [-dot(row, center) for row in rows], half)


def barrel_of(answer: Mapping[str, Any]) -> Barrel:
    """Read a cylinder: p, q, radius, or center, axis (of length 1), height and radius."""
    if "axis" in answer:
        center, axis = exact(answer["center"], 3), exact(answer["axis"], 3)
        half = times(_positive(answer["height"]) / 2, axis)
        p, q = minus(center, half), minus(center, times(-1, half))
    else:
        p, q = exact(answer["p"], 3), exact(answer["q"], 3)
    if p == q:
        raise ValueError("expected a cylinder with an axis")
    return Barrel(p, q, _positive(answer["radius"]))


class Ground(NamedTuple):
    """Points that a hull has to contain."""

    points: Array

    def beyond_hull(self, corners: Array) -> tuple[float, int]:
        """How far at least the farthest point is behind a face of the hull of some corners, and which one."""
        from refimpl.construct.cloud import Cloud  # noqa: PLC0415  slow to import
        from refimpl.construct.facets import sides_around  # noqa: PLC0415

        there = {tuple(row) for row in corners.tolist()}
        others = np.array([i for i, row in enumerate(self.points.tolist()) if tuple(row) not in there], dtype=int)
        if not len(others):
            return 0.0, 0
        cloud = Cloud(self.points[others], float(np.max(np.abs(corners))))
        found = (0.0, 0)
        for side in sides_around(corners, cloud)[0]:
            for formula in side.formulas():
                value, which = cloud.greatest(formula)
                steep = _steepness(formula)
                found = max(found, (round_down(value * cloud.unit / steep) if value > 0 else 0.0, int(others[which])))
        return found


def _steepness(height: Any) -> Fraction:
    """Length of the gradient of a height over space, from above."""
    zero = height([Fraction(0)] * 3, Fraction)
    slope = [height([Fraction(i == j) for j in range(3)], Fraction) - zero for i in range(3)]
    return root(dot(slope, slope))[1]
