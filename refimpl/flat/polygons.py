"""Signed distance of flat proxies with sides: the origin against their Minkowski difference."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.algorithms.boxes import AXES
from refimpl.algorithms.nearest import best_normal, parameter_on_segment, point_on_segment
from refimpl.algorithms.rounds import grown
from refimpl.flat.difference import Difference, difference, outline_of, radius_of, sides_of
from refimpl.flat.outlines import Outline
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.shapes import Disc, FlatPoint, Rectangle, Segment
from refimpl.linear import Array, dot, largest, norm, scale, unit_or
from refimpl.results import Separation
from refimpl.signs import Indices

SLACK = 2.0**-46
"""Part of the scene by which rounding may move a corner or a side, and more."""


def _at(rows: Any, index: Indices) -> Any:
    """Item of each row (n, m, ...) at its index (n)."""
    return rows[np.arange(len(rows)), index]


def separate(a: Outline, b: Outline) -> Separation:
    """Signed distance of the polygons, segments or points that two outlines with one batch axis mean. Finite.

    The origin is inside A ⊖ B where it lies behind all sides; minus the depth is the height above the highest one. Else
    the nearest point of the sides decides. The way out of the depth ends on its side, not aside of it.

    A sliver or a segment seems to have the origin behind all sides where rounding hides that it lies beyond an end;
    then no side is as near as the depth would be. Ericson, Real-Time Collision Detection, 5.4.2 and 9.3; Gottschalk
    1996 (separating axes).
    """
    found = difference(a, b)
    corners, normals = found.outline.corners, found.outline.normals
    heights = np.where(np.any(normals != 0, axis=-1), -dot(normals, corners), -np.inf)
    after = np.roll(corners, -1, axis=1)
    share = parameter_on_segment(np.zeros(2), corners, after - corners)
    feet = point_on_segment(share, corners, after)
    lengths = norm(feet)
    top, near = np.max(heights, axis=1), np.min(lengths, axis=1)
    slack = SLACK * np.maximum(*(np.max(largest(outline.corners), axis=1) for outline in (a, b)))
    inside = np.isfinite(top) & (top <= 0) & (near <= slack - top)
    aside = norm(feet + scale(np.where(np.isfinite(heights), heights, 0.0), normals))
    ways_out = np.argmax(np.where(lengths <= (near + slack)[:, None], heights - aside, -np.inf), axis=1)
    side = np.where(inside, ways_out, np.argmin(lengths, axis=1))
    share, height, straight = _at(share, side), _at(heights, side), _at(normals, side)
    on_a, on_b = _witnesses(found, a, b, side, share)
    flat = inside | ((share > 0) & (share < 1) & (height > 0))
    normal = _normal(found, side, share, on_b - on_a)
    return Separation(np.where(flat, height, near), on_a, on_b, np.where(inside[:, None], straight, normal))


def _witnesses(found: Difference, a: Outline, b: Outline, side: Indices, share: Array) -> tuple[Array, Array]:
    """Points of A and B whose difference is a point of a side: on one of them a corner, on the other on its side."""
    of_a = _at(found.of_a, side)[:, None]
    ends = []
    for outline, index, moving in ((a, found.i, of_a), (b, found.j, ~of_a)):
        here = _at(index, side)
        start, end = _at(outline.corners, here), _at(outline.corners, (here + 1) % np.maximum(sides_of(outline), 1))
        ends.append(np.where(moving, point_on_segment(share, start, end), start))
    return ends[0], ends[1]


def _normal(found: Difference, side: Indices, share: Array, offset: Array) -> Array:
    """Direction from A to B across a gap: of the offset, or the normal of a side that meets there.

    The offset's own direction means nothing where it is little more than rounding.
    """
    corners, normals = found.outline.corners, found.outline.normals
    count = np.maximum(sides_of(found.outline), 1)
    straight = _at(normals, side)
    other = _at(normals, (side + np.where(share > 0.5, 1, count - 1)) % count)
    straight = np.where(np.any(straight != 0, axis=-1)[:, None], straight, AXES[0, :2])

    def gap_along(n: Array) -> Array:
        return np.asarray(np.min(-dot(corners, n[:, None, :]), axis=1))

    return best_normal([straight, unit_or(offset, straight)[0], other], gap_along, offset)


def common_points(x: Any, y: Any) -> Array:
    """One point (n, 2) of both of two flat proxies that overlap, or nearly so; with one batch axis.

    Across a gap of the cores it divides the gap as the radii do. Cores that overlap have one on the line through the
    origin along their normal, which leaves A ⊖ B at two sides: between the points of A that the witnesses of both are.
    """
    a, b = outline_of(x), outline_of(y)
    core = separate(a, b)
    reach = radius_of(x) + radius_of(y)
    part = radius_of(x) / np.where(reach > 0, reach, 1.0)
    found = difference(a, b)
    corners = found.outline.corners
    speed = -dot(found.outline.normals, core.normal[:, None, :])
    leaves = speed > 0
    with np.errstate(over="ignore", invalid="ignore"):
        room = np.where(leaves, dot(found.outline.normals, corners) / np.where(leaves, speed, 1.0), np.inf)
    side, depth = np.argmin(room, axis=1), -core.distance
    far = np.where(np.isfinite(np.min(room, axis=1)), np.maximum(np.min(room, axis=1), 0.0), 0.0)
    opposite = scale(-far, core.normal)
    start, end = _at(corners, side), _at(np.roll(corners, -1, axis=1), side)
    other, _ = _witnesses(found, a, b, side, parameter_on_segment(opposite, start, end - start))
    whole = np.where(depth > 0, depth + far, 1.0)
    weight = np.where(depth > 0, np.maximum(depth, 0.0) / whole, part)
    toward = np.where((depth > 0)[:, None], other, core.on_b)
    return np.asarray(core.on_a + scale(weight, toward - core.on_a))


def polygons(x: Any, y: Any) -> Separation:
    """Signed distance of two flat proxies: that of their cores, less the radii."""
    return grown(separate(outline_of(x), outline_of(y)), radius_of(x), radius_of(y))


def point_convexpolygon(x: FlatPoint, b: ConvexPolygon) -> Separation:
    """Signed distance of a point from a convex polygon; inside, to the nearest side. Finite."""
    return polygons(x, b)


def disc_convexpolygon(s: Disc, b: ConvexPolygon) -> Separation:
    """Signed distance of a disc and a convex polygon: that of the centre, less the radius. Finite."""
    return polygons(s, b)


def segment_segment(s: Segment, t: Segment) -> Separation:
    """Signed distance of two segments; those that cross are as deep as the shortest way in the plane. Finite."""
    return polygons(s, t)


def segment_rectangle(s: Segment, b: Rectangle) -> Separation:
    """Signed distance of a segment and a rectangle. Finite."""
    return polygons(s, b)


def segment_convexpolygon(s: Segment, b: ConvexPolygon) -> Separation:
    """Signed distance of a segment and a convex polygon. Finite."""
    return polygons(s, b)


def rectangle_convexpolygon(a: Rectangle, b: ConvexPolygon) -> Separation:
    """Signed distance of a rectangle and a convex polygon. Finite."""
    return polygons(a, b)


def convexpolygon_convexpolygon(a: ConvexPolygon, b: ConvexPolygon) -> Separation:
    """Signed distance of two convex polygons. Finite."""
    return polygons(a, b)
