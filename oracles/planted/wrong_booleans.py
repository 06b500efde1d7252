"""Wrong early rejects: whether two shapes meet, and nothing else."""

from __future__ import annotations

import math

from oracles.claims import FALSE, MISSED
from oracles.planted.gjk import Corner, Simplex
from oracles.planted.mutant import Planted, wrong
from oracles.planted.shapes import Ball, Brick, Gap, Plane, Rod
from oracles.planted.vectors import UNITS, Axes, Vec, add, along, cross, dot, largest, length, sub, times
from oracles.scene import BOOLEAN


@wrong(BOOLEAN, "Sphere–Sphere", MISSED)
class SumOfSquares(Planted):
    """The square of the distance is held against the sum of squares of the radii, not the square of their sum."""

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        way = sub(b.center, a.center)
        return super().ball_ball(a, b)._replace(distance=dot(way, way) - (a.radius**2 + b.radius**2))


@wrong(BOOLEAN, "Point–Capsule", FALSE)
class BoundsOnly(Planted):
    """An early exit: what is in the box around the rod counts as in the rod."""

    def ball_rod(self, a: Ball, b: Rod) -> Gap:
        over = [
            max(min(p, q) - b.radius - c, c - max(p, q) - b.radius) for p, q, c in zip(b.p, b.q, a.center, strict=True)
        ]
        return super().ball_rod(a, b)._replace(distance=max(over))


@wrong(BOOLEAN, "Sphere–Capsule", FALSE)
class AbsoluteSlack(Planted):
    """An absolute epsilon where a relative one is needed: a gap of a millionth is none."""

    def ball_rod(self, a: Ball, b: Rod) -> Gap:
        gap = super().ball_rod(a, b)
        return gap._replace(distance=gap.distance - 1e-6)


@wrong(BOOLEAN, "Point–Box", FALSE, MISSED)
class RotationIgnored(Planted):
    """A wrong frame: the box is tested as if it were not turned."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        return super().ball_brick(a, b._replace(axes=UNITS))


@wrong(BOOLEAN, "Sphere–Box", FALSE)
class CornersSquare(Planted):
    """A wrong region: near edges and corners the box grown by the radius is taken for the rounded one."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        over = max(abs(c) - h for c, h in zip(b.into(a.center), b.half, strict=True))
        return super().ball_brick(a, b)._replace(distance=over - a.radius)


@wrong(BOOLEAN, "Capsule–Capsule", MISSED)
class EndsOnly(Planted):
    """A dropped case: only the ends of the segments are tried."""

    def crossing(self, p: Vec, d: Vec, q: Vec, e: Vec) -> list[tuple[Vec, Vec]]:
        return []


@wrong(BOOLEAN, "Capsule–AABB", MISSED)
class Sampled(Planted):
    """The rod is tested as three balls: at its ends and in its middle."""

    def rod_brick(self, a: Rod, b: Brick) -> Gap:
        places = (a.p, a.q, times(0.5, add(a.p, a.q)))
        return min(self.ball_brick(Ball(place, a.radius), b) for place in places)


@wrong(BOOLEAN, "Capsule–Box", FALSE)
class AroundTheMiddle(Planted):
    """An early exit: a box that reaches the ball around its own corners is taken for one that meets."""

    def rod_brick(self, a: Rod, b: Brick) -> Gap:
        return self.ball_rod(Ball(b.center, length(b.half)), a)


@wrong(BOOLEAN, "Point–HalfSpace", FALSE)
class Margin(Planted):
    """A margin of a thousandth around the half-space counts as inside."""

    def above(self, low: Vec, radius: float, plane: Plane) -> Gap:
        return super().above(low, radius + 1e-3, plane)


@wrong(BOOLEAN, "HalfSpace–Box", FALSE)
class ByBoundingBall(Planted):
    """An early exit: the ball around the box decides."""

    def plane_brick(self, a: Plane, b: Brick) -> Gap:
        return super().plane_brick(a, b)._replace(distance=a.height(b.center) - length(b.half))


@wrong(BOOLEAN, "AABB–AABB", FALSE)
class TwoAxes(Planted):
    """A dropped case: the third axis is not tried."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        gaps = [abs(m) - (ha + hb) for m, ha, hb in zip(sub(b.center, a.center), a.half, b.half, strict=True)]
        return super().upright_upright(a, b)._replace(distance=max(gaps[:2]))


@wrong(BOOLEAN, "Box–Box", FALSE)
class CrossAxisMissing(Planted):
    """One of the fifteen axes is missing: that of the third edges of both."""

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        missing = cross(a.axes[2], b.axes[2])
        return [n for n in super().edge_axes(a, b) if length(cross(n, missing)) > 1e-9 * length(missing)]


@wrong(BOOLEAN, "Box–Box", FALSE)
class ThirdFaceMissing(Planted):
    """One of the fifteen axes is missing: the third face normal of B."""

    def axes_to_try(self, a: Brick, b: Brick) -> list[Vec]:
        axes = super().axes_to_try(a, b)
        return axes[:5] + axes[6:]


@wrong(BOOLEAN, "AABB–Box", MISSED)
class GjkThreeSteps(Planted):
    """An early exit in GJK: after three steps boxes that were not yet found to meet are told apart."""

    def most_steps(self) -> int:
        return 3

    def gjk(self, a: Brick, b: Brick) -> tuple[Vec, Vec, bool]:
        return (*super().gjk(a, b)[:2], True)


@wrong(BOOLEAN, "Sphere–AABB", MISSED)
class DeepInsideMissed(Planted):
    """A dropped case: a ball wholly inside touches no face, and so is not found."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(distance=1.0) if gap.distance < -2 * a.radius else gap


@wrong(BOOLEAN, "Sphere–HalfSpace", MISSED)
class FarAwayRounded(Planted):
    """Wrong only above 1e5: what stands there has to be a hundredth deep to be found."""

    def ball_plane(self, a: Ball, b: Plane) -> Gap:
        gap = super().ball_plane(a, b)
        return gap._replace(distance=gap.distance + 0.01) if largest(a.center) > 1e5 else gap


@wrong(BOOLEAN, "Capsule–HalfSpace", MISSED)
class MiddleOnly(Planted):
    """Only the middle of the rod is held against the plane."""

    def lower_end(self, rod: Rod, plane: Plane) -> Vec:
        return along(rod.p, 0.5, sub(rod.q, rod.p))


@wrong(BOOLEAN, "Point–Box", FALSE, MISSED)
class QuaternionNotNormalised(Planted):
    """The quaternion is used as it is, whatever its length."""

    def axes(self, x: float, y: float, z: float, w: float) -> Axes:
        size = math.hypot(x, y, z, w)
        first, second, third = super().axes(x, y, z, w)
        return times(size, first), times(size, second), times(size, third)


@wrong(BOOLEAN, "Sphere–Box", FALSE, MISSED)
class QuaternionConjugated(Planted):
    """The rotation is the inverse one."""

    def axes(self, x: float, y: float, z: float, w: float) -> Axes:
        return super().axes(x, y, z, -w)


@wrong(BOOLEAN, "Sphere–AABB", FALSE, MISSED)
class ClampedByAnother(Planted):
    """A wrong clamp: the third coordinate is clamped by the second half extent."""

    def clamped(self, own: Vec, half: Vec) -> Vec:
        return super().clamped(own, (half[0], half[1], half[1]))


@wrong(BOOLEAN, "Capsule–AABB", MISSED)
class GjkWithoutTriangles(Planted):
    """A dropped case in GJK: the inside of a triangle is never the nearest part of a simplex."""

    def weights(self, points: list[Vec]) -> list[float] | None:
        return None if len(points) == 3 else super().weights(points)

    def gjk(self, a: Brick, b: Brick) -> tuple[Vec, Vec, bool]:
        return (*super().gjk(a, b)[:2], True)


@wrong(BOOLEAN, "Capsule–Box", MISSED)
class GjkForgetsCorner(Planted):
    """A wrong region in GJK: from three corners on, the second is dropped without a look."""

    def nearest_part(self, corners: list[Corner]) -> Simplex:
        return super().nearest_part(corners[:1] + corners[2:] if len(corners) > 2 else corners)

    def gjk(self, a: Brick, b: Brick) -> tuple[Vec, Vec, bool]:
        return (*super().gjk(a, b)[:2], True)


@wrong(BOOLEAN, "Box–Box", FALSE, MISSED)
class SamePoseAssumed(Planted):
    """Only when parallel: boxes with parallel axes are taken for boxes of the same pose, whatever the turn."""

    def brick_brick_meet(self, a: Brick, b: Brick) -> bool:
        aligned = all(max(abs(dot(u, v)) for v in b.axes) > 1 - 1e-12 for u in a.axes)
        return super().brick_brick_meet(a, b._replace(axes=a.axes) if aligned else b)
