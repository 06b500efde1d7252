"""Point, sphere, capsule and box against a box: closest features apart, separating axes when overlapping.

Everything happens in the frame of one box, where its faces are coordinate planes. Apart, the squared distance
from a segment to a box is minimised exactly; an overlapping pair is first moved apart along the axis of least
overlap, so that its witness points, too, are closest features.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from refimpl.algorithms.nearest import (
    best_normal,
    box_excess,
    nearest_on_segment,
    parameter_towards_box,
    widest,
    without,
)
from refimpl.algorithms.rounds import grown
from refimpl.linear import (
    Array,
    Bools,
    apply,
    apply_inverse,
    cross,
    dot,
    norm,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.results import Separation, where
from refimpl.shapes import AABB, Box, Capsule, Point, Sphere

AXES = np.eye(3)
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@dataclass(frozen=True)
class Frame:
    """A box's own coordinates: world = center + matrix · local."""

    center: Array
    half: Array
    matrix: Array

    @classmethod
    def of(cls, box: Box) -> Frame:
        """Frame of a box."""
        return cls(box.center, box.half_extents, rotation_matrix(box.rotation))

    def local(self, x: Array) -> Array:
        """Local coordinates of a world point."""
        return apply_inverse(self.matrix, x - self.center)

    def world(self, y: Array) -> Array:
        """World coordinates of a local point."""
        return self.center + apply(self.matrix, y)

    def world_separation(self, sep: Separation) -> Separation:
        """Bring a separation from local to world coordinates."""
        return Separation(sep.distance, self.world(sep.on_a), self.world(sep.on_b), apply(self.matrix, sep.normal))


def point_in_slabs(y: Array, lower: Array, upper: Array) -> Separation:
    """Separation of a point and the box lower ≤ y ≤ upper, in its frame.

    Outside, the nearest point is the clamped one; inside, it lies on the nearest face (the first of equally near
    ones). Ericson, Real-Time Collision Detection, 5.1.3.
    """
    below, above = lower - y, y - upper
    depths = np.maximum(below, above)
    face = np.argmax(depths, axis=-1)
    nearest = np.clip(y, lower, upper)
    one_axis = AXES[face]
    outward = np.where(below > above, -one_axis, one_axis)
    inside = np.max(depths, axis=-1)
    direction, gap = unit_or(y - nearest, outward)
    sigma = np.where(inside > 0, gap, inside)
    on_face = np.where(one_axis != 0, np.where(below > above, lower, upper), y)
    return Separation(sigma, y, where(inside > 0, nearest, on_face), -where(inside > 0, direction, outward))


def point_box(x: Point, b: Box) -> Separation:
    """Signed distance of a point from a box; inside, to the nearest face. Closed form."""
    frame = Frame.of(b)
    found = frame.world_separation(point_in_slabs(frame.local(x.position), -frame.half, frame.half))
    return replace(found, on_a=x.position)


def point_aabb(x: Point, b: AABB) -> Separation:
    """Signed distance of a point from an axis-aligned box; inside, to the nearest face. Closed form."""
    return point_in_slabs(x.position, b.lower, b.upper)


def sphere_box(s: Sphere, b: Box) -> Separation:
    """Signed distance of a ball and a box. Closed form. Ericson, Real-Time Collision Detection, 5.2.5."""
    return grown(point_box(Point._trusted(s.center), b), s.radius, np.zeros_like(s.radius))


def sphere_aabb(s: Sphere, b: AABB) -> Separation:
    """Signed distance of a ball and an axis-aligned box. Closed form."""
    return grown(point_aabb(Point._trusted(s.center), b), s.radius, np.zeros_like(s.radius))


@dataclass(frozen=True)
class SegmentAndBox:
    """The segment start + [0, 1]·step and the box |y_i| ≤ half_i, in the box's frame."""

    start: Array
    step: Array
    half: Array

    def gap_along(self, n: Array) -> Array:
        """Gap between the two along the unit vector `n`, from the segment to the box."""
        ends = dot(self.start, n), dot(self.start + self.step, n)
        return -dot(np.abs(n), self.half) - np.maximum(*ends)

    def widest_axis(self) -> tuple[Array, Array]:
        """Separating axis with the widest gap: the faces' normals, and the edges crossed with the segment."""
        middle = self.start + self.step / 2
        crosses = [unit_or(cross(axis, self.step), AXES[0])[0] for axis in AXES]
        axes = [np.broadcast_to(axis, self.start.shape) for axis in AXES] + crosses
        axes = [where(dot(n, middle) > 0, -n, n) for n in axes]
        return widest(axes, self.gap_along)

    def closest(self, shift: Array) -> tuple[Array, Array, list[Array]]:
        """Closest points of the moved segment and the box, and directions across the segment between them."""
        start = self.start + shift
        t = parameter_towards_box(start, self.step, self.half)
        y = start + scale(t, self.step)
        excess = box_excess(y, self.half)
        return y, y - excess, [-v for v in across_edge(excess, self.step, t)]


def across_edge(excess: Array, step: Array, t: Array) -> list[Array]:
    """The vector from a box to the point at `t` of an edge, cleaned of rounding in two ways.

    Against an edge or a face of the box, it is perpendicular to the edge within the slabs that it lies outside of;
    against a corner of the box, in all three coordinates.
    """
    slanted = np.where(excess != 0, step, 0.0)
    return [where((t > 0) & (t < 1), without(excess, slanted), excess), without(excess, step)]


def segment_in_frame(pair: SegmentAndBox) -> Separation:
    """Separation of a segment and a box."""
    axis, gap = pair.widest_axis()
    push = scale(np.minimum(gap, 0.0), axis)
    y, on_box, across = pair.closest(push)
    directions = [axis, *(unit_or(v, axis)[0] for v in (*across, on_box - y))]
    normal = best_normal(directions, pair.gap_along, on_box - y)
    apart = gap > 0
    normal, length = where(apart, normal, axis), norm(on_box - y)
    start = pair.start + push
    for _ in range(2):
        y = nearest_on_segment(on_box - scale(length, normal), start, start + pair.step)
        on_box = np.clip(y + scale(length, normal), -pair.half, pair.half)
    return Separation(np.where(apart, length, gap), y - push, on_box, normal)


def capsule_box(c: Capsule, b: Box) -> Separation:
    """Signed distance of a capsule and a box; the depth is minimal also with the axis deep inside.

    Finite: closest features of segment and box, or the six separating axes. Gottschalk, Lin and Manocha,
    OBBTree, 1996.
    """
    frame = Frame.of(b)
    start = frame.local(c.p)
    core = segment_in_frame(SegmentAndBox(start, apply_inverse(frame.matrix, c.q - c.p), frame.half))
    return grown(frame.world_separation(core), c.radius, np.zeros_like(c.radius))


def capsule_aabb(c: Capsule, b: AABB) -> Separation:
    """Signed distance of a capsule and an axis-aligned box; finite, as for any box."""
    return capsule_box(c, b.to_box())


@dataclass(frozen=True)
class BoxPair:
    """Two boxes in the frame of the first: the second has this offset and these axes (columns of `turn`)."""

    half_a: Array
    half_b: Array
    offset: Array
    turn: Array

    @classmethod
    def of(cls, a: Frame, b: Frame) -> BoxPair:
        """Relative pose of two frames."""
        columns = [apply_inverse(a.matrix, b.matrix[..., :, j]) for j in range(3)]
        return cls(a.half, b.half, a.local(b.center), np.stack(columns, axis=-1))

    @cached_property
    def axes(self) -> Array:
        """The 15 unit axes that can separate two boxes, (n, 15, 3): faces of both, edges crossed.

        A cross product with a coordinate axis only copies two coordinates, so it is exactly perpendicular to
        both edges, however nearly parallel they are.
        """
        faces_a = np.broadcast_to(AXES, (len(self.offset), 3, 3))
        faces_b = np.swapaxes(self.turn, -1, -2)
        edges = cross(faces_a[:, :, None, :], faces_b[:, None, :, :]).reshape(-1, 9, 3)
        return unit_or(np.concatenate([faces_a, faces_b, edges], axis=1), AXES[0])[0]

    def gap_along(self, n: Array) -> Array:
        """Gap between the boxes along unit vectors `n`, from the first to the second."""
        extra = (1,) * (n.ndim - 2)
        offset, half_a, half_b = (v.reshape(-1, *extra, 3) for v in (self.offset, self.half_a, self.half_b))
        turn = self.turn.reshape(-1, *extra, 3, 3)
        return dot(offset, n) - dot(half_a, np.abs(n)) - dot(half_b, np.abs(apply_inverse(turn, n)))

    def widest_axis(self) -> tuple[Array, Array]:
        """Separating axis with the widest gap, pointing from the first box to the second, and that gap."""
        towards = where(dot(self.axes, self.offset[:, None, :]) < 0, -self.axes, self.axes)
        gaps = self.gap_along(towards)
        best = np.argmax(gaps, axis=-1)[:, None]
        axis = np.take_along_axis(towards, best[..., None], axis=1)[:, 0]
        return axis, np.take_along_axis(gaps, best, axis=1)[:, 0]

    def edges_of_b(self) -> tuple[Array, Array]:
        """The 12 edges of the second box as starts and steps, (n, 12, 3), without its offset."""
        sides = self.turn * self.half_b[:, None, :]
        starts, steps = [], []
        for j in range(3):
            for u in (-1.0, 1.0):
                for v in (-1.0, 1.0):
                    starts.append(u * sides[:, :, j - 1] + v * sides[:, :, j - 2] - sides[:, :, j])
                    steps.append(2 * sides[:, :, j])
        return np.stack(starts, axis=1), np.stack(steps, axis=1)

    def closest(self, shift: Array) -> tuple[Array, Array, list[Array]]:
        """Closest points when the second box is moved by `shift`, and directions across its edge between them.

        Two disjoint boxes are nearest at a point of an edge of the second (its corners included), or at a
        corner of the first above a face of the second.
        """
        offset = (self.offset + shift)[:, None, :]
        both = zip(self._from_edges(offset), self._from_corners(offset), strict=True)
        on_a, on_b, *across = (np.concatenate(found, axis=1) for found in both)
        gaps = on_b - on_a
        best = np.argmin(dot(gaps, gaps), axis=-1)[:, None, None]
        x, y, *chosen = (np.take_along_axis(v, best, axis=1)[:, 0] for v in (on_a, on_b, *across))
        return x, y, chosen

    def nearest_on_b(self, x: Array, shift: Array) -> Array:
        """Point of the second box, moved by `shift`, nearest to `x`."""
        offset = self.offset + shift
        return offset + apply(self.turn, np.clip(apply_inverse(self.turn, x - offset), -self.half_b, self.half_b))

    def _from_edges(self, offset: Array) -> tuple[Array, ...]:
        start, step = self.edges_of_b()
        start = offset + start
        half = np.broadcast_to(self.half_a[:, None, :], start.shape)
        t = parameter_towards_box(start, step, half)
        y = start + scale(t, step)
        excess = box_excess(y, half)
        return y - excess, y, *across_edge(excess, step, t)

    def _from_corners(self, offset: Array) -> tuple[Array, ...]:
        corners = CORNERS * self.half_a[:, None, :]
        turn = self.turn[:, None, :, :]
        inner = apply_inverse(turn, corners - offset)
        excess = box_excess(inner, self.half_b[:, None, :])
        between = -apply(turn, excess)
        return corners, offset + apply(turn, inner - excess), between, between


def box_box(a: Box, b: Box) -> Separation:
    """Signed distance of two boxes.

    Finite: closest features when apart, the 15 separating axes when overlapping. Gottschalk, Lin and Manocha,
    OBBTree, 1996; Gregorius, The Separating Axis Test between Convex Polyhedra, 2013.
    """
    frame = Frame.of(a)
    pair = BoxPair.of(frame, Frame.of(b))
    axis, gap = pair.widest_axis()
    push = scale(np.maximum(-gap, 0.0), axis)
    on_a, on_b, across = pair.closest(push)
    offset = on_b - on_a
    across += [without(offset, pair.turn[:, :, j]) for j in range(3)] + [offset * (1.0 - e) for e in AXES]
    directions = [axis, *(unit_or(v, axis)[0] for v in (*across, offset))]
    apart = gap > 0
    normal, length = where(apart, best_normal(directions, pair.gap_along, offset), axis), norm(offset)
    for _ in range(2):
        on_a = np.clip(on_b - scale(length, normal), -pair.half_a, pair.half_a)
        on_b = pair.nearest_on_b(on_a + scale(length, normal), push)
    return frame.world_separation(Separation(np.where(apart, length, gap), on_a, on_b - push, normal))


def aabb_box(a: AABB, b: Box) -> Separation:
    """Signed distance of an axis-aligned and any other box; finite, as for two boxes."""
    return box_box(a.to_box(), b)


def aabb_aabb(a: AABB, b: AABB) -> Separation:
    """Signed distance of two axis-aligned boxes: intervals, coordinate by coordinate. Closed form.

    Apart, the gap vector has the gap of each coordinate; overlapping, one coordinate has to come free, upwards or
    downwards, and the cheapest counts. Witness points lie in the middle of what faces each other.
    """
    above, below = b.lower - a.upper, a.lower - b.upper
    sign = np.where(above >= below, 1.0, -1.0)
    gaps = np.maximum(above, below)
    cheapest = np.argmax(gaps, axis=-1)
    one_axis = AXES[cheapest]
    apart = np.max(gaps, axis=-1) > 0
    between = np.where(apart[:, None], np.maximum(gaps, 0.0), gaps * one_axis) * sign
    direction, gap = unit_or(np.maximum(gaps, 0.0) * sign, sign * one_axis)
    facing = between != 0
    middle = (np.maximum(a.lower, b.lower) + np.minimum(a.upper, b.upper)) / 2
    on_a = np.where(facing | (one_axis != 0), np.where(sign > 0, a.upper, a.lower), middle)
    on_b = np.where(facing | (one_axis != 0), np.where(sign > 0, b.lower, b.upper), middle)
    sigma = np.where(apart, gap, np.max(gaps, axis=-1))
    return Separation(sigma, on_a, on_b, direction)


def aabb_meets_aabb(a: AABB, b: AABB) -> Bools:
    """Compare intervals: exact, no arithmetic at all."""
    return np.asarray(np.all((a.lower <= b.upper) & (b.lower <= a.upper), axis=-1))


def point_meets_aabb(x: Point, b: AABB) -> Bools:
    """Compare coordinates: exact, no arithmetic at all."""
    return np.asarray(np.all((b.lower <= x.position) & (x.position <= b.upper), axis=-1))


def point_meets_box(x: Point, b: Box) -> Bools:
    """Compare coordinates in the box's frame."""
    frame = Frame.of(b)
    return np.asarray(np.all(np.abs(frame.local(x.position)) <= frame.half, axis=-1))


def sphere_meets_box(s: Sphere, b: Box) -> Bools:
    """Compare squares at the box's nearest point. Ericson, Real-Time Collision Detection, 5.2.5."""
    frame = Frame.of(b)
    excess = box_excess(frame.local(s.center), frame.half)
    return np.asarray(dot(excess, excess) <= s.radius * s.radius)


def sphere_meets_aabb(s: Sphere, b: AABB) -> Bools:
    """Compare squares at the box's nearest point (Arvo 1990)."""
    excess = s.center - np.clip(s.center, b.lower, b.upper)
    return np.asarray(dot(excess, excess) <= s.radius * s.radius)


def box_meets_box(a: Box, b: Box) -> Bools:
    """No axis of the 15 separates; no closest features are needed."""
    return np.asarray(BoxPair.of(Frame.of(a), Frame.of(b)).widest_axis()[1] <= 0)


def aabb_meets_box(a: AABB, b: Box) -> Bools:
    """No axis of the 15 separates."""
    return box_meets_box(a.to_box(), b)
