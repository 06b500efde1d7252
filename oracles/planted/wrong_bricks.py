"""Wrong signed distances of boxes."""

from __future__ import annotations

from oracles.claims import LONG, SHORT, STUCK
from oracles.planted.balls import PARALLEL
from oracles.planted.bricks import Way
from oracles.planted.mutant import Planted, wrong
from oracles.planted.shapes import Brick, Gap, Plane
from oracles.planted.textbook import Textbook
from oracles.planted.vectors import Vec, cross, dot, length, sub, times, unit
from oracles.scene import DISTANCE


@wrong(DISTANCE, "AABB–AABB", LONG)
class GapsAdded(Planted):
    """The gaps along the axes are added up instead of their squares."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        gap = super().upright_upright(a, b)
        return gap._replace(distance=sum(map(abs, times(gap.distance, gap.normal)))) if gap.distance > 0 else gap


@wrong(DISTANCE, "AABB–AABB", SHORT)
class LargestGapOnly(Planted):
    """A wrong region: of boxes apart along several axes, the distance is that along one."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        gap = super().upright_upright(a, b)
        return gap._replace(distance=max(map(abs, times(gap.distance, gap.normal)))) if gap.distance > 0 else gap


@wrong(DISTANCE, "AABB–AABB", SHORT)
class MostOverlap(Planted):
    """The wrong face: the depth is that of the axis with the largest overlap."""

    def least_overlap(self, gaps: list[float]) -> int:
        return min(range(3), key=gaps.__getitem__)


@wrong(DISTANCE, "Box–Box", SHORT)
class OneAxisMissing(Planted):
    """One of the fifteen axes is missing: that of A's first and B's second edge."""

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        missing = cross(a.axes[0], b.axes[1])
        return [n for n in super().edge_axes(a, b) if length(cross(n, missing)) > 1e-9 * length(missing)]


@wrong(DISTANCE, "Box–Box", SHORT)
class EdgeAxesMissing(Planted):
    """A dropped case: only face normals are tried as separating axes."""

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        return []


@wrong(DISTANCE, "AABB–Box", SHORT)
class FaceAxisMissing(Planted):
    """One of the fifteen axes is missing: the third face normal of A."""

    def axes_to_try(self, a: Brick, b: Brick) -> list[Vec]:
        return super().axes_to_try(a, b)[:2] + super().axes_to_try(a, b)[3:]


@wrong(DISTANCE, "Box–Box", LONG, STUCK)
class AxisNotNormalised(Planted):
    """Overlaps are measured along cross products of edges that were not brought to length 1.

    Along a product of length s < 1 the depth d that is told is s times the overlap along it, and the least overlap is
    no larger: a move by d leaves d/s − d, at least as much as the depth is off. So where the tolerance, which grows
    with the coordinates, lies between the two, the depth is within it and the move is not: that is STUCK, and rightly.
    """

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        return [n for u in a.axes for v in b.axes if length(n := cross(u, v)) > PARALLEL]

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        return super().overlapping(a, b, separation, unit(normal))


@wrong(DISTANCE, "Box–Box", LONG)
class EdgesDropped(Planted):
    """A wrong region: nearest points on two edges are never tried, only corners."""

    def edges_on_edges(self, a: Brick, b: Brick) -> list[Way]:
        return []

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        return Textbook().overlapping(a, b, separation, normal)


@wrong(DISTANCE, "AABB–Box", LONG)
class CornersDropped(Planted):
    """A wrong region: the corners of A are never held against B."""

    def corners_of_a(self, a: Brick, b: Brick) -> list[Way]:
        return []

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        return Textbook().overlapping(a, b, separation, normal)


@wrong(DISTANCE, "Box–Box", SHORT)
class DepthFromCenters(Planted):
    """Overlaps are told as if the centres coincided."""

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        gap = super().overlapping(a, b, separation, normal)
        return gap._replace(distance=separation - abs(dot(sub(b.center, a.center), normal)))


@wrong(DISTANCE, "Capsule–Box", LONG, STUCK)
class GjkLeavesEarly(Planted):
    """An early exit in GJK: after two steps the search is over.

    Of a box that is small and deep inside of a rod the distance is right to rounding, and the normal is not: see
    `wrong_balls.ClampedAtHalf`.
    """

    def most_steps(self) -> int:
        return 2

    def gjk(self, a: Brick, b: Brick) -> tuple[Vec, Vec, bool]:
        return (*super().gjk(a, b)[:2], True)


@wrong(DISTANCE, "Capsule–AABB", LONG)
class GjkLoose(Planted):
    """An early exit in GJK: a gap of a hundredth between its bounds is good enough."""

    def has_converged(self, nearest: Vec, new: Vec, size: float) -> bool:
        return dot(nearest, sub(nearest, new)) <= 0.01 * dot(nearest, nearest)


@wrong(DISTANCE, "Capsule–Box", LONG)
class GjkAbsolute(Planted):
    """An absolute epsilon where a relative one is needed: GJK ends when squares differ by less than 1e-6."""

    def has_converged(self, nearest: Vec, new: Vec, size: float) -> bool:
        return dot(nearest, sub(nearest, new)) <= 1e-6


@wrong(DISTANCE, "HalfSpace–Box", LONG)
class CornerByWorldAxes(Planted):
    """A wrong frame: the lowest corner is chosen by the signs of the normal in the world, not in the box."""

    def lowest_corner(self, plane: Plane, brick: Brick) -> Vec:
        x, y, z = (-h if n > 0 else h for h, n in zip(brick.half, plane.normal, strict=True))
        return brick.out((x, y, z))


@wrong(DISTANCE, "HalfSpace–AABB", LONG)
class FourCorners(Planted):
    """A dropped case: only the corners of the lower face are tried."""

    def lowest_corner(self, plane: Plane, brick: Brick) -> Vec:
        x, y, _ = (-h if n > 0 else h for h, n in zip(brick.half, plane.normal, strict=True))
        return brick.out((x, y, -brick.half[2]))
