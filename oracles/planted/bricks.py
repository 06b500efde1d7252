"""Boxes against boxes and rods: the 15 separating axes, the nearest features, and GJK."""

from __future__ import annotations

from itertools import product

from oracles.planted.balls import PARALLEL, TIE, Balls
from oracles.planted.gjk import Gjk
from oracles.planted.shapes import Brick, Gap, Rod, core_of
from oracles.planted.vectors import UNITS, Vec, across, add, along, cross, dot, length, sub, times, unit

Way = tuple[Vec, Vec]


class Bricks(Gjk, Balls):
    """Pairs of polytopes."""

    def upright_upright(self, a: Brick, b: Brick) -> Gap:
        """Two axis-aligned boxes: the gaps along the axes, or the least overlap."""
        middle = sub(b.center, a.center)
        gaps = [abs(m) - (ha + hb) for m, ha, hb in zip(middle, a.half, b.half, strict=True)]
        apart = self.apart_along(gaps)
        if length(apart) > TIE * max(a.size, b.size):
            signs = [1.0 if m >= 0 else -1.0 for m in middle]
            way = (apart[0] * signs[0], apart[1] * signs[1], apart[2] * signs[2])
            distance, normal = length(way), unit(way)
        else:
            axis = self.least_overlap(gaps)
            distance, normal = gaps[axis], times(1.0 if middle[axis] >= 0 else -1.0, UNITS[axis])
        on_a = self.common_point(a, b, times(distance, normal))
        return Gap(distance, on_a, along(on_a, distance, normal), normal)

    def apart_along(self, gaps: list[float]) -> Vec:
        """The gaps of the axes that separate; 0 of those that do not."""
        return (max(gaps[0], 0.0), max(gaps[1], 0.0), max(gaps[2], 0.0))

    def least_overlap(self, gaps: list[float]) -> int:
        """Axis along which the overlap is least."""
        return max(range(3), key=gaps.__getitem__)

    def common_point(self, a: Brick, b: Brick, way: Vec) -> Vec:
        """Middle of what A has in common with B moved back by the way between them."""
        low = [max(x - h, y - g - w) for x, h, y, g, w in zip(a.center, a.half, b.center, b.half, way, strict=True)]
        high = [min(x + h, y + g - w) for x, h, y, g, w in zip(a.center, a.half, b.center, b.half, way, strict=True)]
        return (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))

    def brick_brick(self, a: Brick, b: Brick) -> Gap:
        """Nearest features where an axis separates, else the axis of the least overlap."""
        separation, normal = self.widest_axis(a, b)
        if separation > 0:
            x, y = self.nearest_features(a, b)
            way = sub(y, x)
            if length(way) > TIE * max(a.size, b.size):
                return Gap(length(way), x, y, unit(way))
        return self.overlapping(a, b, separation, normal)

    def overlapping(self, a: Brick, b: Brick, separation: float, normal: Vec) -> Gap:
        """Witnesses of an overlap: B is moved out, and what then touches is moved back."""
        way = times(separation, normal)
        x, y = self.nearest_features(a, b._replace(center=sub(b.center, way)))
        return Gap(separation, x, add(y, way), normal)

    def rod_brick(self, a: Rod, b: Brick) -> Gap:
        """GJK between the segment and the box; where that does not end, as two boxes of which one has no width."""
        core, size = core_of(a), max(a.size, b.size)
        x, y, settled = self.gjk(core, b)
        if settled:
            x = self.foot(y, a.p, a.q)
            y = self.on_brick(b, x)  # square to what it is on, whatever rounding GJK's weights have gone through
            if length(sub(y, x)) > TIE * size:
                return self.rounded(x, a.radius, y, 0.0, UNITS[0], size)
        inner = self.brick_brick(core, b)
        return Gap(inner.distance - a.radius, along(inner.on_a, a.radius, inner.normal), inner.on_b, inner.normal)

    def upright_brick_meet(self, a: Brick, b: Brick) -> bool:
        """Whether two boxes have a point in common: GJK finds most that have not, the axes decide on the others."""
        x, y, settled = self.gjk(a, b)
        if settled and length(sub(y, x)) > TIE * max(a.size, b.size):
            return False
        return self.brick_brick_meet(a, b)

    def brick_brick_meet(self, a: Brick, b: Brick) -> bool:
        """Whether no axis separates two boxes."""
        return self.widest_axis(a, b)[0] <= 0

    # -- separating axes -------------------------------------------------------------------------------------

    def axes_to_try(self, a: Brick, b: Brick) -> list[Vec]:
        """Three face normals of each, and nine directions square to an edge of both."""
        return [*self.face_axes(a), *self.face_axes(b), *self.edge_axes(a, b)]

    def face_axes(self, brick: Brick) -> list[Vec]:
        """Normals of the faces."""
        return list(brick.axes)

    def edge_axes(self, a: Brick, b: Brick) -> list[Vec]:
        """Directions square to an edge of both; parallel edges have none of their own."""
        pairs = ((u, v, cross(u, v)) for u, v in product(a.axes, b.axes))
        return [unit(across(unit(n), u)) for u, v, n in pairs if length(n) > PARALLEL]

    def widest_axis(self, a: Brick, b: Brick) -> tuple[float, Vec]:
        """The axis along which the boxes are farthest apart, or overlap least: by how much, and from A to B."""
        middle = sub(b.center, a.center)
        best, normal = -float("inf"), UNITS[0]
        for axis in self.axes_to_try(a, b):
            along_axis = dot(middle, axis)
            gap = abs(along_axis) - (a.reach(axis) + b.reach(axis))
            if gap > best:
                best, normal = gap, axis if along_axis >= 0 else times(-1.0, axis)
        return best, normal

    # -- nearest features ------------------------------------------------------------------------------------

    def nearest_features(self, a: Brick, b: Brick) -> Way:
        """The least way from a corner to the other box, or between two edges."""
        ways = [*self.corners_of_a(a, b), *self.corners_of_b(a, b), *self.edges_on_edges(a, b)]
        return min(ways, key=lambda way: length(sub(way[1], way[0])))

    def corners_of_a(self, a: Brick, b: Brick) -> list[Way]:
        """From the corners of A to B."""
        return [(corner, self.on_brick(b, corner)) for corner in a.corners()]

    def corners_of_b(self, a: Brick, b: Brick) -> list[Way]:
        """From A to the corners of B."""
        return [(self.on_brick(a, corner), corner) for corner in b.corners()]

    def on_brick(self, brick: Brick, point: Vec) -> Vec:
        """Nearest point of a box."""
        return brick.out(self.clamped(brick.into(point), brick.half))

    def edges_on_edges(self, a: Brick, b: Brick) -> list[Way]:
        """Between the inner points of two edges."""
        found: list[Way] = []
        for (p, d), (q, e) in product(self.edges(a), self.edges(b)):
            found += self.crossing(p, d, q, e)
        return found

    def edges(self, brick: Brick) -> list[Way]:
        """All twelve edges, each as its start and the way along it; those without length are left out."""
        found: list[Way] = []
        for i, h in enumerate(brick.half):
            if h > 0:
                way = times(2 * h, brick.axes[i])
                j, k = (i + 1) % 3, (i + 2) % 3
                for s, t in product((-1.0, 1.0), repeat=2):
                    start = along(brick.center, s * brick.half[j], brick.axes[j])
                    start = along(start, t * brick.half[k], brick.axes[k])
                    found.append((along(start, -h, brick.axes[i]), way))
        return found
