"""Ellipsoids in two cores whose difference holds a ball: for depths that whole circles of directions share.

A polytope of points approaches a circle only with the square of the number of its corners; the linear image of a
ball that touches it all round proves the depth at once. Nothing here has to be believed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from refimpl.proof.bodies import Body, Corners, Curved, Vertices
from refimpl.proof.claims import Inscribed, Place
from refimpl.proof.points import Vector, along, dot, doubles, exact, frame, minus, opposite
from refimpl.shapes import AABB, Box, Capsule

ROOM = 1.0 - 2.0**-48  # rounding stays below this
Matrix = NDArray[np.float64]


class Image(NamedTuple):
    """A linear image of the ball around a point of a core: semi-axes, and the number that shows it to lie inside."""

    centre: Vector
    axes: list[tuple[Vector, Vector]]  # exact direction and length, unit vector
    share: Any
    place: Place
    slants: bool = False  # a cylinder: the third axis may go with any unit vector

    def slanted(self, way: Matrix) -> Iterator[Image]:
        """The same with the caps' planes cut at a slant, so that it comes nearer to the rims in a direction."""
        yield self
        if not self.slants:
            return
        u, v, w = (np.array(unit) for _, unit in self.axes)
        aside = (way @ u) * u + (way @ v) * v
        aside *= math.copysign(1.0, way @ w) / max(math.sqrt(aside @ aside), 1e-300)
        (radius, height), tilt = ((np.linalg.norm(doubles(self.axes[i][0])) for i in (0, 2)), abs(float(way @ w)))
        if not height:  # a disc: its two caps are one
            return
        for slant in (2 * tilt * radius / height, 16 * tilt * radius / height, 0.1, 1.0, 10.0):
            third = w + slant * aside
            third /= math.sqrt(third @ third)
            yield self._replace(axes=[*self.axes[:2], (self.axes[2][0], tuple(third.tolist()))])

    def matrix(self) -> Matrix:
        """Symmetric matrix of the image."""
        total = np.zeros((3, 3))
        for axis, unit in self.axes:
            total += np.outer(doubles(axis), unit)
        return total

    def columns(self, turn: Matrix) -> tuple[Vector, Vector, Vector]:
        """Columns of the matrix times a rotation; each is exactly a sum of the axes."""
        found: list[Vector] = []
        units = np.array([unit for _, unit in self.axes]).reshape(-1, 3) @ turn
        for j in range(3):
            column: Vector = (0, 0, 0)
            for (axis, _), weights in zip(self.axes, units, strict=True):
                column = along(column, Fraction(float(weights[j]) * ROOM), axis)
            found.append(column)
        return found[0], found[1], found[2]


def _unit(axis: Vector) -> Vector:
    v = np.array(doubles(axis))
    return tuple((v / np.sqrt(v @ v)).tolist()) if v.any() else (0.0, 0.0, 0.0)


def _shrunk(axes: list[Vector], centre: Vector, target: Vector) -> tuple[Vector, list[Vector]]:
    """Half edges and the centre of the largest sub-box around the point of a box that is nearest to a target."""
    kept = []
    for axis in axes:
        square = dot(axis, axis)
        share = Fraction(0) if square == 0 else Fraction(dot(minus(target, centre), axis)) / square
        share = max(Fraction(-1), min(Fraction(1), share))
        centre = along(centre, share, axis)
        kept.append(along((0, 0, 0), 1 - abs(share), axis))
    return centre, kept


def image(shape: Any, core: Body, target: Vector) -> Image | None:
    """A large linear image of the ball in a core, around the point near to a target."""
    if isinstance(core, Curved):
        centre, axes = core.exact
        axes = [exact(axis) for axis in axes]
        if core.flat:
            centre, (height,) = _shrunk([axes[2]], centre, target)
            axes = [axes[0], axes[1], height]
        return Image(centre, [(axis, _unit(axis)) for axis in axes], 1, centre, core.flat)
    if isinstance(shape, AABB | Box):
        middle, half, ways = frame(shape)
        centre, kept = _shrunk([along((0, 0, 0), h, way) for h, way in zip(half, ways, strict=True)], middle, target)
        return Image(centre, [(axis, _unit(axis)) for axis in kept], 0, centre)
    if isinstance(shape, Capsule):
        p, q = exact(shape.p.tolist()), exact(shape.q.tolist())
        half_way = along((0, 0, 0), Fraction(1, 2), minus(q, p))
        centre, (kept_half,) = _shrunk([half_way], along(p, 1, half_way), target)
        return Image(centre, [(kept_half, _unit(kept_half))], 0, centre)
    if isinstance(core, Corners) and len(core.corners) == 1 and not isinstance(core, Vertices):
        return Image(core.corner(0), [], 0, core.corner(0))
    return None


def _turns(p: Matrix, q: Matrix, normal: Vector) -> Iterator[Matrix]:
    """Rotations of the ball before q is applied, so that both images of the directions that matter are parallel.

    Where P and Q take a direction to parallel vectors, the support of the sum is the sum of the supports (Procrustes).
    """
    n = np.array(normal)
    n /= np.sqrt(n @ n)
    turn = np.eye(3)
    yield turn
    for power in (0, 1, 4, 16):
        sizes, ways = np.linalg.eigh((p + q @ turn) @ (p + q @ turn).T)
        weights = (max(sizes[0], 1e-300) / np.maximum(sizes, 1e-300)) ** power
        for focus in (0.0, 1e3):
            both = np.column_stack([ways, n])
            weighed = q.T @ both * np.append(weights, focus)
            left, _, right = np.linalg.svd(weighed @ (p.T @ both).T)
            turn = left @ right
            yield turn


def _largest_ball(centre: Matrix, matrix: Matrix) -> tuple[float, float]:
    """Radius of the largest ball around 0 in the ellipsoid {centre + matrix·u}, and the share that shows it.

    In principal axes, the nearest boundary point is where Σ dᵢ² sᵢ² / (sᵢ² − μ)² comes to 1 for a μ up to the smallest
    sᵢ² (Eberly, Distance from a Point to an Ellipsoid); if it does not, that axis makes up for the rest.
    """
    left, sizes, _ = np.linalg.svd(matrix)
    d, s = (left.T @ centre).tolist(), [float(x * x) for x in sizes]
    if s[2] <= 0 or sum(x * x / y for x, y in zip(d, s, strict=True)) >= 1:
        return 0.0, 0.0
    low, high = 0.0, s[2]
    for _ in range(80):
        mu = 0.5 * (low + high)
        full = all(x > mu for x in s) and sum(x * x * y / (y - mu) ** 2 for x, y in zip(d, s, strict=True)) <= 1
        low, high = (mu, high) if full else (low, mu)
    y = [-x * z / (z - low) if z > low else 0.0 for x, z in zip(d, s, strict=True)]
    y[2] = math.copysign(math.sqrt(max(0.0, s[2] * (1 - y[0] ** 2 / s[0] - y[1] ** 2 / s[1]))), y[2])
    radius = math.sqrt(sum((u + v) ** 2 for u, v in zip(d, y, strict=True))) * ROOM * ROOM
    return radius, _roomiest([x * x / z for x, z in zip(d, s, strict=True)], [radius * radius / z for z in s])


def _roomiest(c: list[float], p: list[float]) -> float:
    """Share for which the matrix of `sets.ball_in_ball` is farthest from losing its sign."""

    def room(share: float) -> float:
        return min(1 - share - sum(x + x * y / (share - y) for x, y in zip(c, p, strict=True)), share - p[2])

    low, high = math.nextafter(p[2], math.inf), max(1.0, 2 * p[2])
    for _ in range(90):
        one, two = low + (high - low) * 0.382, low + (high - low) * 0.618
        low, high = (one, high) if one <= p[2] or room(one) < room(two) else (low, two)
    return 0.5 * (low + high)


def ball_around_point(bodies: tuple[Body, Body]) -> Iterator[Inscribed]:
    """Claim of the largest ball around a point, or a ball's centre, in a cylinder: as deep as the point is."""
    for side in (0, 1):
        point, solid = bodies[side], bodies[1 - side]
        alone = isinstance(point, Corners) and len(point.corners) == 1 and not isinstance(point, Vertices)
        if not (alone and isinstance(point, Corners) and isinstance(solid, Curved) and solid.flat):
            continue
        centre, axes = solid.exact
        x, third = point.corner(0), exact(axes[2])
        offset = minus(x, centre)
        above = Fraction(dot(offset, third)) / dot(third, third)
        aside = math.hypot(*doubles(along(offset, -above, third)))
        breadth, height = math.hypot(*doubles(exact(axes[0]))), math.hypot(*doubles(third))
        rounding = 2.0**-50 * (breadth + height + aside)
        radius = min(breadth - aside, height * (1.0 - abs(float(above)))) - rounding
        if radius > 0:
            sign = Fraction(radius) if side else Fraction(-radius)
            ball = (sign, Fraction(0), Fraction(0)), (Fraction(0), sign, Fraction(0)), (Fraction(0), Fraction(0), sign)
            none: Vector = (0, 0, 0)
            share = radius * (radius + aside) / breadth**2  # that of two circles which touch from inside
            parts = [(x, (none, none, none), 0), (x, ball, share)]
            (a, p, share_a), (b, q, share_b) = parts[::-1] if side else parts
            yield Inscribed(a, p, b, q, radius, (share_a, share_b, 1))


def inscribed(shapes: tuple[Any, Any], bodies: tuple[Body, Body], normal: Vector, enough: float) -> Iterator[Inscribed]:
    """Claims of a depth, best last, up to `enough`; `normal` is the direction of the least depth found."""
    first = image(shapes[0], bodies[0], exact(shapes[1].reference_point.tolist()))
    second = image(shapes[1], bodies[1], first.centre) if first else None
    first = image(shapes[0], bodies[0], second.centre) if second else None
    if first is None or second is None:
        return
    across = np.array(doubles(minus(first.centre, second.centre)))
    both = first.matrix() + second.matrix()
    best = 0.0
    for way in np.linalg.eigh(both @ both.T)[1][:, :2].T:
        for one, other in product(first.slanted(way), second.slanted(way)):
            p, q = one.matrix() * ROOM, other.matrix() * ROOM
            for turn in _turns(p, q, normal):
                radius, share = _largest_ball(across, p + q @ turn)
                if radius > best:
                    best = radius
                    columns = other.columns(turn)
                    others = opposite(columns[0]), opposite(columns[1]), opposite(columns[2])
                    shares = one.share, other.share, share
                    yield Inscribed(one.place, one.columns(np.eye(3)), other.place, others, radius, shares)
                if best >= enough:
                    return
