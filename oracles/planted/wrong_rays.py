"""Wrong rays."""

from __future__ import annotations

import math

from oracles.claims import BRIEF, LENGTHY, RAY_FALSE, RAY_LATE, RAY_MISSED, RAY_OFF, RAY_POINT, TILTED
from oracles.engine import COLUMNS, AnswerRow, Row
from oracles.planted.mutant import Planted, wrong
from oracles.planted.rays import Hit, Line, Slab
from oracles.planted.shapes import Ball, Brick, Plane, Rod
from oracles.planted.vectors import Vec, along, dot, length, sub, times, unit
from oracles.scene import RAYCAST


@wrong(RAYCAST, "Ray–Sphere", RAY_LATE, RAY_OFF)
class TimeIsLength(Planted):
    """The direction is brought to length 1, and the time told in that unit."""

    def speed_of(self, direction: Vec) -> float:
        return 1.0


@wrong(RAYCAST, "Ray–Sphere", RAY_LATE)
class LeavesNotEnters(Planted):
    """The wrong root of the quadratic: where the ray leaves."""

    def half_chord(self, radius: float, off: float) -> float:
        return -super().half_chord(radius, off)


@wrong(RAYCAST, "Ray–Sphere", RAY_LATE)
class InsideHitsFarSide(Planted):
    """A ray that starts inside hits where it leaves."""

    def ray_ball(self, ray: Line, ball: Ball) -> Hit | None:
        hit = super().ray_ball(ray, ball)
        if hit is None or hit.normal is not None:
            return hit
        offset = sub(ray.origin, ball.center)
        middle = self.nearest_on_line(offset, ray.direction)
        way = middle + self.half_chord(ball.radius, min(length(along(offset, middle, ray.direction)), ball.radius))
        return Hit(way, unit(sub(along(ray.origin, way, ray.direction), ball.center)))


@wrong(RAYCAST, "Ray–AABB", RAY_MISSED)
class InsideMisses(Planted):
    """A ray that starts inside is said to hit nothing."""

    def inside(self) -> Hit | None:
        return None


@wrong(RAYCAST, "Ray–Sphere", RAY_FALSE, RAY_OFF)
class HitsBehind(Planted):
    """A dropped case: balls behind the start are hit, too."""

    def way_to_ball(self, ray: Line, ball: Ball) -> float | None:
        way = super().way_to_ball(ray, ball)
        return way if way is not None else super().way_to_ball(ray._replace(direction=times(-1.0, ray.direction)), ball)


@wrong(RAYCAST, "Ray–HalfSpace", RAY_FALSE, RAY_OFF)
class PlaneBehind(Planted):
    """A dropped case: rays that go away from the plane hit it, too.

    One that starts above it by no more than the tolerance may hit it; but not where it says, at twice that height.
    """

    def ray_plane(self, ray: Line, plane: Plane) -> Hit | None:
        height, slope = plane.height(ray.origin), dot(plane.normal, ray.direction)
        return Hit(abs(height / slope), plane.normal) if height > 0 and slope != 0 else super().ray_plane(ray, plane)


@wrong(RAYCAST, "Ray–HalfSpace", TILTED)
class NormalIntoPlane(Planted):
    """The normal points into the half-space."""

    def ray_plane(self, ray: Line, plane: Plane) -> Hit | None:
        hit = super().ray_plane(ray, plane)
        return hit if hit is None or hit.normal is None else Hit(hit.way, times(-1.0, hit.normal))


@wrong(RAYCAST, "Ray–AABB", RAY_FALSE)
class AlongSlabIgnored(Planted):
    """A dropped case: a ray along a slab is never beside it."""

    def beside(self, start: float, half: float) -> bool:
        return False


@wrong(RAYCAST, "Ray–Box", TILTED)
class NormalOfExit(Planted):
    """The normal is the opposite one, of the face through which the ray would leave."""

    def ray_brick(self, ray: Line, brick: Brick) -> Hit | None:
        hit = super().ray_brick(ray, brick)
        return hit if hit is None or hit.normal is None else Hit(hit.way, times(-1.0, hit.normal))


@wrong(RAYCAST, "Ray–Box", TILTED)
class RayNormalNotTurned(Planted):
    """A wrong frame: the normal is told in the box's axes."""

    def ray_brick(self, ray: Line, brick: Brick) -> Hit | None:
        hit = super().ray_brick(ray, brick)
        if hit is None or hit.normal is None:
            return hit
        x, y, z = brick.axes
        return Hit(hit.way, (dot(hit.normal, x), dot(hit.normal, y), dot(hit.normal, z)))


@wrong(RAYCAST, "Ray–Box", RAY_POINT)
class PointByTime(Planted):
    """The hit point is taken at the length of the way in units of the direction."""

    def told(self, ray: Line, hit: Hit | None) -> AnswerRow:
        row = list(super().told(ray, hit))
        if hit is not None:
            row[COLUMNS["point"]] = along(ray.origin, hit.way * ray.speed, ray.direction)
        return row


@wrong(RAYCAST, "Ray–Capsule", RAY_MISSED)
class RayCapsMissing(Planted):
    """A dropped case: only the side of the rod is hit, never its caps."""

    def caps_of_rod(self, ray: Line, rod: Rod) -> list[Hit]:
        return []


@wrong(RAYCAST, "Ray–Capsule", RAY_OFF, RAY_FALSE)
class EndlessSide(Planted):
    """A wrong clamp: the rod's side goes on to a length beyond each end."""

    def side_of_rod(self, ray: Line, rod: Rod) -> list[Hit]:
        way = sub(rod.q, rod.p)
        return super().side_of_rod(ray, rod._replace(p=sub(rod.p, way), q=along(rod.q, 1.0, way)))


@wrong(RAYCAST, "Ray–Capsule", RAY_MISSED)
class AlongAxisMissed(Planted):
    """Only when parallel: a ray along the axis is said to miss."""

    def caps_of_rod(self, ray: Line, rod: Rod) -> list[Hit]:
        return [] if abs(dot(ray.direction, rod.axis)) > 1 - 1e-9 else super().caps_of_rod(ray, rod)


@wrong(RAYCAST, "Ray–Capsule", RAY_MISSED, RAY_OFF)
class GrazingMissed(Planted):
    """An absolute epsilon where a relative one is needed: chords whose squares are under 1e-4 are no hits."""

    def half_chord(self, radius: float, off: float) -> float:
        half = super().half_chord(radius, off)
        return half if half * half > 1e-4 else -math.inf

    def ray_rod(self, ray: Line, rod: Rod) -> Hit | None:
        hit = super().ray_rod(ray, rod)
        return hit if hit is None or hit.way < math.inf else None


@wrong(RAYCAST, "Ray–AABB", RAY_MISSED)
class EndsAtOne(Planted):
    """The ray is taken for a segment that ends at time 1."""

    def told(self, ray: Line, hit: Hit | None) -> AnswerRow:
        return super().told(ray, hit if hit is None or hit.way <= ray.speed else None)


@wrong(RAYCAST, "Ray–KDOP", RAY_OFF, RAY_FALSE)
class LastSlabMissing(Planted):
    """A dropped case: the last slab is not tried."""

    def ray_slabs(self, slabs: list[Slab]) -> Hit | None:
        return super().ray_slabs(slabs[:-1])


@wrong(RAYCAST, "Ray–KDOP", LENGTHY, BRIEF)
class DirectionAsNormal(Planted):
    """The normal is the slab's direction as it is, whatever its length."""

    def ray_slab_polytope(self, ray: Line, row: Row) -> Hit | None:
        hit = super().ray_slab_polytope(ray, row)
        if hit is None or hit.normal is None:
            return hit
        given = [(row[1 + 3 * i], row[2 + 3 * i], row[3 + 3 * i]) for i in range(int(row[0]))]
        nearest = max(given, key=lambda d: abs(dot(unit(d), hit.normal or d)))
        return Hit(hit.way, times(length(nearest), hit.normal))
