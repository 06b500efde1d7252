"""Rays: by plane, by quadratic, by slabs. Times are made lengths first: the direction is brought to length 1."""

from __future__ import annotations

import math
from typing import NamedTuple

from oracles.engine import Row
from oracles.planted.balls import Balls
from oracles.planted.shapes import Ball, Brick, Plane, Rod
from oracles.planted.vectors import Vec, across, along, dot, length, sub, times, unit

UPRIGHT = 1e-12
"""Sine of the angle to a rod's axis below which a ray never reaches the rod's side."""


class Line(NamedTuple):
    """A ray: start, direction of length 1, and how long the given direction was."""

    origin: Vec
    direction: Vec
    speed: float


class Hit(NamedTuple):
    """Length of the way, and the outward normal; none of a ray that starts inside."""

    way: float
    normal: Vec | None


Slab = tuple[float, float, float, Vec]
"""Where the ray starts, its slope, half the width, and the slab's direction."""


class Rays(Balls):
    """First hit of a ray, or None."""

    def line(self, row: Row) -> Line:
        """Read a ray."""
        direction = (row[3], row[4], row[5])
        return Line((row[0], row[1], row[2]), unit(direction), self.speed_of(direction))

    def speed_of(self, direction: Vec) -> float:
        """Length of the direction, in which times are counted."""
        return length(direction)

    def ray_plane(self, ray: Line, plane: Plane) -> Hit | None:
        """Height by slope."""
        height, slope = plane.height(ray.origin), dot(plane.normal, ray.direction)
        if height <= 0:
            return self.inside()
        return Hit(height / -slope, plane.normal) if slope < 0 else None

    def inside(self) -> Hit | None:
        """Where the ray starts in the shape."""
        return Hit(0.0, None)

    def ray_ball(self, ray: Line, ball: Ball) -> Hit | None:
        """Half a chord before the point of the line that is nearest to the centre."""
        if length(sub(ray.origin, ball.center)) <= ball.radius:
            return self.inside()
        way = self.way_to_ball(ray, ball)
        return None if way is None else Hit(way, unit(sub(along(ray.origin, way, ray.direction), ball.center)))

    def way_to_ball(self, ray: Line, ball: Ball) -> float | None:
        """Way to a ball that the ray does not start in."""
        offset = sub(ray.origin, ball.center)
        middle = self.nearest_on_line(offset, ray.direction)
        off = length(along(offset, middle, ray.direction))
        if off > ball.radius or middle < 0:
            return None
        return middle - self.half_chord(ball.radius, off)

    def nearest_on_line(self, offset: Vec, direction: Vec) -> float:
        """Way along a line of that offset to the point nearest to 0."""
        return -dot(offset, direction)

    def half_chord(self, radius: float, off: float) -> float:
        """Half the chord of a circle at some distance from its centre."""
        return math.sqrt((radius - off) * (radius + off))

    def ray_rod(self, ray: Line, rod: Rod) -> Hit | None:
        """The side, then both caps: the first of them."""
        foot = self.foot(ray.origin, rod.p, rod.q)
        if length(sub(ray.origin, foot)) <= rod.radius:
            return self.inside()
        hits = [*self.side_of_rod(ray, rod), *self.caps_of_rod(ray, rod)]
        return min(hits, key=lambda hit: hit.way, default=None)

    def side_of_rod(self, ray: Line, rod: Rod) -> list[Hit]:
        """The cylinder between the ends."""
        axis = rod.axis
        offset, drift = across(sub(ray.origin, rod.p), axis), across(ray.direction, axis)
        slope = length(drift)
        if slope <= UPRIGHT:
            return []
        middle = self.nearest_on_line(offset, times(1 / slope, drift))
        off = length(along(offset, middle / slope, drift))
        if off > rod.radius or middle < 0:
            return []
        way = (middle - self.half_chord(rod.radius, off)) / slope
        if 0 <= dot(sub(ray.origin, rod.p), axis) <= length(sub(rod.q, rod.p)):
            way = max(way, 0.0)  # beside the rod, it is ahead, but for rounding
        point = along(ray.origin, way, ray.direction)
        height = dot(sub(point, rod.p), axis)
        if way < 0 or not 0 <= height <= length(sub(rod.q, rod.p)):
            return []
        return [Hit(way, unit(across(unit(along(offset, way, drift)), axis)))]

    def caps_of_rod(self, ray: Line, rod: Rod) -> list[Hit]:
        """The balls around the ends; only their outer half counts for the normal."""
        found = []
        for end, outward in ((rod.p, times(-1.0, rod.axis)), (rod.q, rod.axis)):
            way = self.way_to_ball(ray, Ball(end, rod.radius))
            if way is not None:
                normal = unit(sub(along(ray.origin, way, ray.direction), end))
                found.append(Hit(way, normal if dot(normal, outward) >= 0 else unit(across(normal, outward))))
        return found

    def ray_brick(self, ray: Line, brick: Brick) -> Hit | None:
        """Three slabs."""
        starts = brick.into(ray.origin)
        slopes = [dot(ray.direction, axis) for axis in brick.axes]
        return self.ray_slabs(list(zip(starts, slopes, brick.half, brick.axes, strict=True)))

    def ray_slabs(self, slabs: list[Slab]) -> Hit | None:
        """The last entry, if it comes before the first exit."""
        enter, leave, normal = -math.inf, math.inf, None
        for start, slope, half, axis in slabs:
            if slope == 0:
                if self.beside(start, half):
                    return None
                continue
            first, last = self.span(start, slope, half)
            if first > enter:
                enter, normal = first, times(-1.0 if slope > 0 else 1.0, axis)
            leave = min(leave, last)
        return self.between(enter, leave, normal)

    def beside(self, start: float, half: float) -> bool:
        """Whether a ray along a slab is outside of it."""
        return abs(start) > half

    def span(self, start: float, slope: float, half: float) -> tuple[float, float]:
        """Ways at which a ray enters and leaves a slab."""
        ways = (-half - start) / slope, (half - start) / slope
        return min(ways), max(ways)

    def between(self, enter: float, leave: float, normal: Vec | None) -> Hit | None:
        """What the last entry and the first exit mean."""
        if enter > leave or leave < 0:
            return None
        return Hit(enter, normal) if enter > 0 else self.inside()

    def ray_slab_polytope(self, ray: Line, row: Row) -> Hit | None:
        """The slabs of a k-DOP: directions, lower and upper bounds, behind their number."""
        count = int(row[0])
        slabs: list[Slab] = []
        for i in range(count):
            x, y, z = row[1 + 3 * i : 4 + 3 * i]
            size = length((x, y, z))
            low, high = row[1 + 3 * count + i] / size, row[1 + 4 * count + i] / size
            axis = unit((x, y, z))
            start = dot(ray.origin, axis) - 0.5 * (low + high)
            slabs.append((start, dot(ray.direction, axis), 0.5 * (high - low), axis))
        return self.ray_slabs(slabs)
