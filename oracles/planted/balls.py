"""Pairs that come down to two nearest points, with radii around them: balls, rods, and both against planes."""

from __future__ import annotations

from oracles.planted.shapes import Ball, Brick, Gap, Plane, Rod
from oracles.planted.vectors import UNITS, ZERO, Vec, across, along, cross, dot, length, square_to, sub, times, unit

TIE = 1e-10
"""Points nearer than this, relative to the scene's size, have no direction between them; the engine promises 1e-9."""
PARALLEL = 1e-11
"""Sine of the angle below which two directions are one."""


class Balls:
    """Closed forms."""

    def ball_ball(self, a: Ball, b: Ball) -> Gap:
        """Centre to centre."""
        return self.rounded(a.center, a.radius, b.center, b.radius, UNITS[0], max(a.size, b.size))

    def ball_rod(self, a: Ball, b: Rod) -> Gap:
        """Centre to the nearest point of the segment."""
        foot = self.foot(a.center, b.p, b.q)
        return self.rounded(a.center, a.radius, foot, b.radius, square_to(b.axis), max(a.size, b.size))

    def rod_rod(self, a: Rod, b: Rod) -> Gap:
        """Segment to segment."""
        x, y = self.nearest_of_segments(a, b)
        return self.rounded(x, a.radius, y, b.radius, self.square_to_both(a.axis, b.axis), max(a.size, b.size))

    def ball_plane(self, a: Ball, b: Plane) -> Gap:
        """Height of the centre."""
        return self.above(a.center, a.radius, b)

    def rod_plane(self, a: Rod, b: Plane) -> Gap:
        """Height of the lower end."""
        return self.above(self.lower_end(a, b), a.radius, b)

    def plane_brick(self, a: Plane, b: Brick) -> Gap:
        """Height of the lowest corner."""
        low = self.lowest_corner(a, b)
        height = a.height(low)
        return Gap(height, along(low, -height, a.normal), low, a.normal)

    def ball_brick(self, a: Ball, b: Brick) -> Gap:
        """Clamp the centre into the box; where it is inside, to the nearest face."""
        own = b.into(a.center)
        near = self.clamped(own, b.half)
        way = sub(near, own)
        gap = length(way)
        if gap > TIE * max(a.size, b.size):
            normal = times(1 / gap, way)
        else:
            gap, normal, near = self.out_of_face(own, b.half)
        normal = b.turn(normal)
        return Gap(gap - a.radius, along(a.center, a.radius, normal), b.out(near), normal)

    # -- steps -----------------------------------------------------------------------------------------------

    def rounded(self, x: Vec, ra: float, y: Vec, rb: float, spare: Vec, size: float) -> Gap:
        """Two points with balls around them; `spare` is the normal where the points coincide."""
        way = sub(y, x)
        gap = length(way)
        normal = times(1 / gap, way) if gap > TIE * size else spare
        return Gap(gap - (ra + rb), along(x, ra, normal), along(y, -rb, normal), normal)

    def above(self, low: Vec, radius: float, plane: Plane) -> Gap:
        """A ball over a plane; the normal points down, from A to B."""
        height = plane.height(low)
        down = times(-1.0, plane.normal)
        return Gap(height - radius, along(low, radius, down), along(low, height, down), down)

    def foot(self, point: Vec, p: Vec, q: Vec) -> Vec:
        """Nearest point of the segment pq."""
        way = sub(q, p)
        square = dot(way, way)
        share = dot(sub(point, p), way) / square if square > 0 else 0.0
        return self.on_segment(p, q, way, share)

    def on_segment(self, p: Vec, q: Vec, way: Vec, share: float) -> Vec:
        """Point of a segment at a share of its length, or the end beyond which that lies."""
        if share <= 0:
            return p
        return q if share >= 1 else along(p, share, way)

    def nearest_of_segments(self, a: Rod, b: Rod) -> tuple[Vec, Vec]:
        """The least of the four ways from an end to the other segment, and of the way square to both."""
        ways = [(end, self.foot(end, b.p, b.q)) for end in (a.p, a.q)]
        ways += [(self.foot(end, a.p, a.q), end) for end in (b.p, b.q)]
        for _, y in self.crossing(a.p, sub(a.q, a.p), b.p, sub(b.q, b.p)):
            x = self.foot(y, a.p, a.q)  # of lines that hardly cross, rounding puts the two points apart along them
            ways.append((x, self.foot(x, b.p, b.q)))
        return min(ways, key=lambda way: length(sub(way[1], way[0])))

    def crossing(self, p: Vec, d: Vec, q: Vec, e: Vec) -> list[tuple[Vec, Vec]]:
        """Points p + s·d and q + t·e where the lines are nearest, if both lie between the ends."""
        normal = cross(d, e)
        square = dot(normal, normal)
        if not square > 0:
            return []
        way = sub(q, p)
        s, t = dot(cross(way, e), normal) / square, dot(cross(way, d), normal) / square
        return [(along(p, s, d), along(q, t, e))] if 0 < s < 1 and 0 < t < 1 else []

    def square_to_both(self, u: Vec, v: Vec) -> Vec:
        """A direction square to two others."""
        both = cross(u, v)
        if length(both) > PARALLEL:
            return unit(across(unit(both), u))
        return square_to(u if u != ZERO else v)

    def lower_end(self, rod: Rod, plane: Plane) -> Vec:
        """The end of the segment that is nearer to the plane, or deeper."""
        return min((rod.p, rod.q), key=plane.height)

    def lowest_corner(self, plane: Plane, brick: Brick) -> Vec:
        """The corner that is nearest to the plane, or deepest."""
        return brick.support(times(-1.0, plane.normal))

    def clamped(self, own: Vec, half: Vec) -> Vec:
        """Nearest point of a box, in its own frame."""
        x, y, z = (min(max(c, -h), h) for c, h in zip(own, half, strict=True))
        return (x, y, z)

    def out_of_face(self, own: Vec, half: Vec) -> tuple[float, Vec, Vec]:
        """Signed distance, normal into the box and point of the face that an inner point is nearest to."""
        over = [abs(c) - h for c, h in zip(own, half, strict=True)]
        axis = self.nearest_face(over)
        sign = 1.0 if own[axis] >= 0 else -1.0
        near = [half[i] * sign if i == axis else c for i, c in enumerate(self.clamped(own, half))]
        return over[axis], times(-sign, UNITS[axis]), (near[0], near[1], near[2])

    def nearest_face(self, over: list[float]) -> int:
        """Axis of the face out of which it is nearest."""
        return max(range(3), key=over.__getitem__)
