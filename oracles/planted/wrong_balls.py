"""Wrong signed distances of points, balls and rods."""

from __future__ import annotations

import math
import struct

from oracles.claims import APART, LONG, OFF_SHAPE, OVERSHOT, SHORT, STUCK
from oracles.engine import AnswerRow
from oracles.planted.mutant import Planted, wrong
from oracles.planted.shapes import Ball, Brick, Gap, Plane, Rod
from oracles.planted.vectors import Vec, along, dot, length, sub, times
from oracles.scene import DISTANCE


def single(value: float) -> float:
    """Round a number to single precision."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


@wrong(DISTANCE, "Sphere–Sphere", LONG)
class RadiusSubtracted(Planted):
    """A sign: the second radius is added to the gap instead of taken off."""

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        gap = super().ball_ball(a, b)
        return gap._replace(distance=gap.distance + 2 * b.radius)


@wrong(DISTANCE, "Sphere–Sphere", OFF_SHAPE)
class WitnessesSwapped(Planted):
    """A and B are swapped in the witness points."""

    def distance(self, gap: Gap) -> AnswerRow:
        return super().distance(gap._replace(on_a=gap.on_b, on_b=gap.on_a))


@wrong(DISTANCE, "Point–Sphere", LONG)
class UnsignedInside(Planted):
    """The distance of a point inside is given as positive."""

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        gap = super().ball_ball(a, b)
        return gap._replace(distance=abs(gap.distance))


@wrong(DISTANCE, "Sphere–Capsule", SHORT, OFF_SHAPE)
class CapsMissing(Planted):
    """The segment is never clamped: the rod goes on beyond its ends.

    Just beyond an end the distance is too small by the square only of what the witness is off the rod by.
    """

    def on_segment(self, p: Vec, q: Vec, way: Vec, share: float) -> Vec:
        return along(p, share, way)


@wrong(DISTANCE, "Point–Capsule", SHORT)
class OneCapMissing(Planted):
    """A dropped case: the segment is clamped at its second end only."""

    def on_segment(self, p: Vec, q: Vec, way: Vec, share: float) -> Vec:
        return q if share >= 1 else along(p, share, way)


# A wrong place on the axis tilts the normal as well. Where that place is nearer than the surface, the tilt shows before
# the distance does: that grows by d·θ²/2 for an axis at a distance d, but what has been moved by a depth of about r
# along a normal that is tilted by θ overlaps still, by r·θ²/2. So what is deep inside may be STUCK at a right distance.


@wrong(DISTANCE, "Point–Capsule", LONG, STUCK)
class ClampedAtHalf(Planted):
    """A wrong clamp: the share along the segment ends at a half instead of at 1."""

    def on_segment(self, p: Vec, q: Vec, way: Vec, share: float) -> Vec:
        return along(p, min(max(share, 0.0), 0.5), way)


@wrong(DISTANCE, "Capsule–Capsule", LONG, STUCK)
class CrossingDropped(Planted):
    """A dropped case: only the ends of the segments are tried, and never their inner points."""

    def crossing(self, p: Vec, d: Vec, q: Vec, e: Vec) -> list[tuple[Vec, Vec]]:
        return []


@wrong(DISTANCE, "Capsule–Capsule", LONG, STUCK)
class ClampedApart(Planted):
    """Both lines' nearest points are clamped, each for itself: after the first clamp the second is another."""

    def nearest_of_segments(self, a: Rod, b: Rod) -> tuple[Vec, Vec]:
        d, e, way = sub(a.q, a.p), sub(b.q, b.p), sub(b.p, a.p)
        det = dot(d, d) * dot(e, e) - dot(d, e) ** 2
        if det <= 1e-12 * dot(d, d) * dot(e, e):
            return super().nearest_of_segments(a, b)
        s = (dot(d, way) * dot(e, e) - dot(d, e) * dot(e, way)) / det
        t = (dot(d, way) * dot(d, e) - dot(d, d) * dot(e, way)) / det
        return along(a.p, min(max(s, 0.0), 1.0), d), along(b.p, min(max(t, 0.0), 1.0), e)


@wrong(DISTANCE, "Capsule–Capsule", LONG)
class ParallelFirstEnds(Planted):
    """Only when parallel: the first ends are taken for the nearest points."""

    def nearest_of_segments(self, a: Rod, b: Rod) -> tuple[Vec, Vec]:
        parallel = abs(dot(a.axis, b.axis)) >= 1 - 1e-15
        return (a.p, b.p) if parallel else super().nearest_of_segments(a, b)


@wrong(DISTANCE, "Capsule–Capsule", LONG, STUCK)
class AbsoluteParallel(Planted):
    """An absolute epsilon where a relative one is needed: segments shorter than a millimetre count as parallel."""

    def crossing(self, p: Vec, d: Vec, q: Vec, e: Vec) -> list[tuple[Vec, Vec]]:
        return [] if dot(d, d) * dot(e, e) < 1e-12 else super().crossing(p, d, q, e)


@wrong(DISTANCE, "Sphere–Box", LONG, SHORT)
class SinglePrecision(Planted):
    """The distance is kept in single precision."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(distance=single(gap.distance))


@wrong(DISTANCE, "Sphere–AABB", LONG, SHORT)
class SmallIsTouching(Planted):
    """Wrong only for sizes under 1e-4: distances below that are taken for 0."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(distance=0.0) if max(a.size, b.size) < 1e-4 else gap


@wrong(DISTANCE, "Point–Box", SHORT)
class CoarseFarAway(Planted):
    """Wrong only above 1e5: a distance at such coordinates is cut off to a multiple of 1/64."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(distance=math.floor(64 * gap.distance) / 64) if max(a.size, b.size) > 1e5 else gap


@wrong(DISTANCE, "Point–HalfSpace", LONG, SHORT)
class NormalNotNormalised(Planted):
    """The half-space's normal is used as it is, whatever its length."""

    def plane(self, normal: Vec, k: float) -> Plane:
        right = super().plane(normal, k)
        return right._replace(offset=k) if abs(length(normal) - 1) > 1e-12 else right


@wrong(DISTANCE, "Sphere–HalfSpace", LONG, SHORT)
class OffsetNegated(Planted):
    """A sign: the plane lies at +k instead of −k."""

    def plane(self, normal: Vec, k: float) -> Plane:
        return super().plane(normal, -k)


@wrong(DISTANCE, "Capsule–HalfSpace", LONG)
class FirstEndOnly(Planted):
    """A dropped case: only the first end of the rod is held against the plane."""

    def lower_end(self, rod: Rod, plane: Plane) -> Vec:
        return rod.p


@wrong(DISTANCE, "Capsule–HalfSpace", OVERSHOT, STUCK)
class NormalFlipped(Planted):
    """The normal points from B to A."""

    def above(self, low: Vec, radius: float, plane: Plane) -> Gap:
        gap = super().above(low, radius, plane)
        return gap._replace(normal=times(-1.0, gap.normal))


@wrong(DISTANCE, "Point–AABB", SHORT)
class FarthestFace(Planted):
    """The wrong face is chosen inside: the one that is farthest."""

    def nearest_face(self, over: list[float]) -> int:
        return min(range(3), key=over.__getitem__)


@wrong(DISTANCE, "Sphere–Box", LONG)
class InsideDropped(Planted):
    """A dropped case: a centre inside of the box counts as one on its surface."""

    def out_of_face(self, own: Vec, half: Vec) -> tuple[float, Vec, Vec]:
        _, normal, near = super().out_of_face(own, half)
        return 0.0, normal, near


@wrong(DISTANCE, "Point–Box", OFF_SHAPE)
class WitnessInOwnFrame(Planted):
    """A wrong frame: the witness that is the point is told from the box's centre, not from the origin."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        return gap._replace(on_a=sub(gap.on_a, b.center))


@wrong(DISTANCE, "Sphere–Box", STUCK, OVERSHOT)
class NormalInOwnFrame(Planted):
    """A wrong frame: the normal is not turned from the box's axes to the world's."""

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        gap = super().ball_brick(a, b)
        n = gap.normal
        return gap._replace(normal=(dot(n, b.axes[0]), dot(n, b.axes[1]), dot(n, b.axes[2])))


@wrong(DISTANCE, "Point–Sphere", APART)
class WitnessOnFarSide(Planted):
    """A sign: the witness on the ball lies on its far side."""

    def rounded(self, x: Vec, ra: float, y: Vec, rb: float, spare: Vec, size: float) -> Gap:
        gap = super().rounded(x, ra, y, rb, spare, size)
        return gap._replace(on_b=along(gap.on_b, 2 * rb, gap.normal))
