"""Convex proxies as the search sees them: support points in floats, and how to say them exactly.

Nothing here has to be believed: what is found is handed on as a certificate. Shapes are told apart by the names of
their types. All is in the coordinates of the world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.proof.claims import Place, Weights
from refimpl.proof.points import (
    Vector,
    along,
    dot,
    doubles,
    exact,
    opposite,
)

INWARDS = 1.0 - 2.0**-51  # a support point of a curved proxy is drawn in by this, so that rounding leaves it inside
Mix = Sequence[tuple[int, Any]]
"""Weights of numbered corners."""


class Body:
    """A convex core with support points, widened by a ball."""

    radius = Fraction(0)

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        raise NotImplementedError

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point along n, and its number if it is a corner."""
        raise NotImplementedError

    def lowest(self, n: Vector) -> tuple[Vector, Mix]:
        """Point that is least far along n, as exactly as it can be said, and the corners that it is made of."""
        point, _ = self.support(scaled(opposite(n)))
        return exact(point), ()

    def normals(self) -> list[Vector]:
        """Directions across flat parts of the surface, which a certificate may have to hit exactly."""
        return []

    def faces(self, n: Vector) -> Weights:  # noqa: ARG002
        """Shares that a certificate needs for the support along n."""
        return ()

    def place(self, point: Vector, mix: Mix = ()) -> Place:  # noqa: ARG002
        """How a certificate says where `point` is, which is the mean of some corners."""
        return doubles(point)


class Curved(Body):
    """centre + Σ tᵢ·axisᵢ, with t in the unit ball (an ellipsoid), or t₀, t₁ in the unit disc and |t₂| ≤ 1."""

    def __init__(self, centre: Vector, axes: Sequence[Vector], flat: bool) -> None:
        self.exact = centre, axes
        self.centre, self.axes, self.flat = doubles(centre), [doubles(axis) for axis in axes], flat

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        return float(max(abs(c) + sum(abs(axis[i]) for axis in self.axes) for i, c in enumerate(self.centre)))

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point, and its number."""
        t = [dot(n, axis) for axis in self.axes]
        top = math.copysign(1.0, t[2])
        if self.flat:
            t[2] = 0.0
        size = math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
        t = [INWARDS * c / size if size else 0.0 for c in t]
        if self.flat:
            t[2] = top * INWARDS
        point = self.centre
        for c, axis in zip(t, self.axes, strict=True):
            point = along(point, c, axis)
        return point, -1

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return [self.exact[1][2], opposite(self.exact[1][2])] if self.flat else []


class Corners(Body):
    """The hull of corners."""

    def __init__(self, corners: Sequence[Vector], radius: Fraction = Fraction(0)) -> None:
        self.corners, self.radius = corners, radius
        self.floats = np.array([doubles(corner) for corner in corners])
        self.flat: list[Vector] = []

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return self.flat

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        return float(np.max(np.abs(self.floats)))

    def corner(self, i: int) -> Vector:
        """Exact corner."""
        return self.corners[i]

    def heights(self, n: Vector) -> Any:
        """Scalar products of all corners with n, in floats."""
        return self.floats[:, 0] * n[0] + self.floats[:, 1] * n[1] + self.floats[:, 2] * n[2]

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point, and its number."""
        i = int(np.argmax(self.heights(n)))
        return tuple(self.floats[i].tolist()), i

    def farthest(self, n: Vector) -> int:
        """Farthest corner along n, exactly."""
        heights = self.heights(scaled(n))
        slack = 1e-13 * max(self.extent, float(np.max(np.abs(heights))))
        near = np.nonzero(heights >= np.max(heights) - slack)[0].tolist()
        return max(near, key=lambda i: dot(n, self.corner(i))) if len(near) > 1 else int(near[0])

    def lowest(self, n: Vector) -> tuple[Vector, Mix]:
        """Least far point, exactly."""
        i = self.farthest(opposite(exact(n)))
        return self.corner(i), [(i, 1)]

    def mean(self, mix: Mix) -> Vector:
        """Weighted mean of corners, exactly."""
        total, sum_of = (Fraction(0),) * 3, sum(weight for _, weight in mix)
        for i, weight in mix:
            total = along(total, Fraction(weight) / sum_of, self.corner(i))
        return total


def exactly(mix: Mix) -> Weights:
    """Weights as a certificate says them, without rounding."""
    return tuple((i, weight) for i, weight in mix if weight)


class Vertices(Corners):
    """A polytope given by vertices: a certificate says a point by their weights."""

    def place(self, point: Vector, mix: Mix = ()) -> Place:  # noqa: ARG002
        """How a certificate says the point."""
        largest = max(weight for _, weight in mix)
        return exactly([(i, float(Fraction(weight) / largest)) for i, weight in mix])


def numbered(atom: int, weights: Weights) -> tuple[tuple[int, Weights], ...]:
    """Shares of an atom's planes as a claim says them; nothing for atoms without planes."""
    return ((atom, weights),) if weights else ()


def placed(y: Vector, position: Vector, columns: Sequence[Vector]) -> Vector:
    """Point position + R y."""
    x = position
    for c, column in zip(y, columns, strict=True):
        x = along(x, c, column)
    return x


def scaled(n: Vector) -> Vector:
    """Doubles along n."""
    largest = max(abs(Fraction(c)) for c in n)
    x, y, z = (Fraction(c) / largest for c in n)
    return doubles((x, y, z))
