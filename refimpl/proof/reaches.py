"""Support points of convex proxies in integers, as exact as one likes: those of round ones lie a little inside.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from refimpl.proof.bodies import Body, Corners, Mix
from refimpl.proof.exact import Vertex
from refimpl.proof.points import Vector, along, dot, minus, opposite, rationals, root, turned
from refimpl.proof.solids import body
from refimpl.shapes import Cylinder, Ellipsoid, Proxy

BITS = 100  # round proxies are drawn in by 2^-BITS of themselves
GUARD = 12  # and their points rounded to so many bits more
SHORT = 120  # bits of a direction along which a round proxy is asked for its farthest point


class Round:
    """centre + the sum of t·half over half an axis, |t| ≤ 1, and of a disc or ellipsoid."""

    def __init__(self, centre: Vector, axes: Sequence[Vector], half: Vector | None, radius: Fraction) -> None:
        self.centre, self.axes, self.half, self.radius = centre, axes, half, radius

    @property
    def thin(self) -> Fraction:
        """Square of the least extent."""
        ways = [*self.axes, *([self.half] if self.half else [])]
        squares = [dot(way, way) for way in ways]
        return Fraction(min([*squares, *([self.radius**2] if self.radius else [])]))

    def offset(self, n: Vector) -> tuple[Vector, Fraction]:
        """Farthest point along n, seen from the centre, or one a little nearer; and no less than how far there is."""
        if self.half is None:
            heights = [dot(n, axis) for axis in self.axes]
            size = _above(sum(h * h for h in heights))
            found: Vector = (Fraction(0),) * 3
            for height, axis in zip(heights, self.axes, strict=True):
                found = along(found, Fraction(height) / size, axis)
            return found, size
        rate, square = dot(n, self.half), dot(self.half, self.half)
        across = along(n, -Fraction(rate) / square, self.half)
        end = self.half if rate > 0 else opposite(self.half)
        if not any(across):
            return end, Fraction(abs(rate))
        size = _above(dot(across, across))
        return along(end, self.radius / size, across), abs(rate) + self.radius * size


def _above(square: Any) -> Fraction:
    """The root of a number, or by less than 2^-120 of it more."""
    return root(Fraction(square), 120)[1]


def _round(shape: Proxy) -> Round | None:
    if isinstance(shape, Cylinder):
        p, q = rationals(shape.p), rationals(shape.q)
        half = along((0, 0, 0), Fraction(1, 2), minus(q, p))
        return Round(along(p, 1, half), [], half, Fraction(shape.radius.tolist()))
    if isinstance(shape, Ellipsoid) and len(set(shape.radii.tolist())) > 1:
        axes = zip(rationals(shape.radii), turned(shape.rotation), strict=True)
        return Round(rationals(shape.center), [along((0, 0, 0), r, axis) for r, axis in axes], None, Fraction(0))
    return None


class Reach:
    """Support points of a bounded convex proxy, times `unit`; with its ball, if `widened`."""

    def __init__(self, shape: Proxy, widened: bool) -> None:
        self.body: Body = body(shape)
        self.round = _round(shape)
        self.radius = self.body.radius if widened else Fraction(0)
        corners: list[Vector] = [self.round.centre] if self.round else []
        if isinstance(self.body, Corners):
            corners = [self.body.corner(i) for i in range(len(self.body.floats))]
        thin = self.round.thin if self.round else self.radius**2
        grid = 1 << max(0, BITS + GUARD + _exponent(thin)) if thin else 1
        self.unit = math.lcm(grid, *(Fraction(c).denominator for corner in corners for c in corner))
        self.corners = [_whole(corner, self.unit) for corner in corners]

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point along n, and its number if it is a corner."""
        if self.round is None:
            assert isinstance(self.body, Corners)
            i = self.body.farthest(n)
            if not self.radius:
                return self.corners[i], i
            n = _short(n)
            return self._drawn(i, along((0, 0, 0), self.radius / _above(dot(n, n)), n)), i
        return self._drawn(0, self.round.offset(_short(n))[0]), -1

    def _drawn(self, i: int, offset: Vector) -> Vector:
        inwards = self.unit * (1 - Fraction(1, 1 << BITS))
        x, y, z = (c + int(inwards * o) for c, o in zip(self.corners[i], offset, strict=True))
        return x, y, z

    def extreme(self, n: Vector) -> tuple[Vector, Mix, Fraction]:
        """Farthest point along n, its corner if it is one, and how much farther at most the proxy reaches, times ‖n‖.

        It is 0, and the point exact, where the roots are rational.
        """
        if self.round is not None:
            offset, level = self.round.offset(n)
            return along(self.round.centre, 1, offset), (), level - dot(n, offset)
        assert isinstance(self.body, Corners)
        i, square = self.body.farthest(n), dot(n, n)
        length = root(Fraction(square))[1]
        offset = along((0, 0, 0), self.radius / length, n)
        return along(self.body.corner(i), 1, offset), [(i, 1)], self.radius * length - dot(n, offset)


def _exponent(square: Fraction) -> int:
    """Bits that the inverse of a length has, or more; the length's square is given."""
    return (square.denominator.bit_length() - square.numerator.bit_length()) // 2 + 2


def _whole(point: Vector, unit: int) -> Vector:
    x, y, z = (int(Fraction(c) * unit) for c in point)
    return x, y, z


def _short(n: Vector) -> Vector:
    """Integers of no more than `SHORT` bits along about the same direction."""
    bits = max(abs(int(c)) for c in n).bit_length() - SHORT
    return n if bits <= 0 else (int(n[0]) >> bits, int(n[1]) >> bits, int(n[2]) >> bits)


class Pairs:
    """A ⊖ B by support points of both, in integers; `way` is the translation of B in the same unit.

    By no more than `slack` it may reach farther than they do.
    """

    def __init__(self, a: Proxy, b: Proxy, way: Vector, widened: bool) -> None:
        self.reaches = Reach(a, widened), Reach(b, widened)
        units = self.reaches[0].unit, self.reaches[1].unit
        self.unit = math.lcm(*units, *(Fraction(c).denominator for c in way))
        self.factors = self.unit // units[0], self.unit // units[1]
        self.way = _whole(way, self.unit)
        drawn = any(reach.round or reach.radius for reach in self.reaches)
        size = sum(Fraction(reach.body.extent) + reach.body.radius for reach in self.reaches)
        self.slack = int(size * self.unit) >> BITS - 4 if drawn else 0

    def support(self, n: Vector) -> Vertex:
        """Farthest a − b along n."""
        (a, i), (b, j) = self.reaches[0].support(n), self.reaches[1].support(opposite(n))
        on_a, on_b = (
            (factor * p[0], factor * p[1], factor * p[2]) for factor, p in zip(self.factors, (a, b), strict=True)
        )
        return Vertex(minus(on_a, on_b), on_a, on_b, i, j)

    def mean(self, vertices: Sequence[Vertex], weights: Sequence[Any]) -> tuple[tuple[Vector, Mix], tuple[Vector, Mix]]:
        """Means of the points of A and of B, and the corners that they are made of."""
        total = self.unit * sum(weights)
        ends = []
        for points, numbers in (
            ([v.a for v in vertices], [v.i for v in vertices]),
            ([v.b for v in vertices], [v.j for v in vertices]),
        ):
            mean: Vector = (Fraction(0),) * 3
            mix: dict[int, Any] = {}
            for point, number, weight in zip(points, numbers, weights, strict=True):
                mean = along(mean, Fraction(weight) / total, point)
                mix[number] = mix.get(number, 0) + weight
            ends.append((mean, list(mix.items())))
        return ends[0], ends[1]
