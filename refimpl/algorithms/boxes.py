"""Point, sphere, capsule and box against a box: closest features apart, separating axes when overlapping.

A point is met in the box's frame, where its faces are coordinate planes. A segment or a box is searched for by a
scalar kernel, `refimpl.kernels.boxes`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from refimpl.algorithms.nearest import box_excess
from refimpl.algorithms.rounds import grown
from refimpl.compiling import module_for, numbers
from refimpl.kernels.boxes import ALIGNED, FRAME, NUMBERS, PLACED, SEGMENT, TURNED
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.kernels.polytopes_pair import FEATURES
from refimpl.linear import Array, Bools, apply, apply_inverse, cross, dot, rotation_matrix, unit_or
from refimpl.results import Separation, where
from refimpl.shapes import AABB, Box, Capsule, Point, Sphere

AXES = np.eye(3)


def axes_of(v: Array) -> Array:
    """Unit vectors of the coordinate axes, as many as the vectors (..., d) have coordinates."""
    return AXES[: v.shape[-1], : v.shape[-1]]


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
    one_axis = axes_of(y)[face]
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


def _searched(a: Capsule | AABB | Box, b: AABB | Box) -> Separation:
    """Separation of a capsule's axis or a box from a box, by the scalar kernel."""
    module = module_for("boxes", len(a))
    kinds = {Capsule: SEGMENT, AABB: ALIGNED, Box: TURNED}
    room = (np.zeros(n) for n in (NUMBERS, FRAME, FRAME, PLACED, PLACED, ROOM, FEATURES))
    answers = numbers(np.zeros((len(a), 10)), module)
    rows_a, rows_b = numbers(a.pack(), module), numbers(b.pack(), module)
    module.box_separations(kinds[type(a)], rows_a, kinds[type(b)], rows_b, *(numbers(r, module) for r in room), answers)
    found = np.array(answers).reshape(len(a), 10)
    return Separation(found[:, 0], found[:, 4:7], found[:, 7:10], found[:, 1:4])


def capsule_box(c: Capsule, b: Box) -> Separation:
    """Signed distance of a capsule and a box; the depth is minimal also with the axis deep inside.

    Finite: closest features of segment and box, or the six separating axes. Gottschalk, Lin and Manocha,
    OBBTree, 1996.
    """
    return grown(_searched(c, b), c.radius, np.zeros_like(c.radius))


def capsule_aabb(c: Capsule, b: AABB) -> Separation:
    """Signed distance of a capsule and an axis-aligned box; finite, as for any box."""
    return grown(_searched(c, b), c.radius, np.zeros_like(c.radius))


def box_box(a: Box, b: Box) -> Separation:
    """Signed distance of two boxes.

    Finite: closest features when apart, the 15 separating axes when overlapping. Gottschalk, Lin and Manocha,
    OBBTree, 1996; Gregorius, The Separating Axis Test between Convex Polyhedra, 2013.
    """
    return _searched(a, b)


def aabb_box(a: AABB, b: Box) -> Separation:
    """Signed distance of an axis-aligned and any other box; finite, as for two boxes."""
    return _searched(a, b)


def aabb_aabb(a: AABB, b: AABB) -> Separation:
    """Signed distance of two axis-aligned boxes: intervals, coordinate by coordinate. Closed form.

    Apart, the gap vector has the gap of each coordinate; overlapping, one coordinate has to come free, upwards or
    downwards, and the cheapest counts. Witness points lie in the middle of what faces each other.
    """
    above, below = b.lower - a.upper, a.lower - b.upper
    sign = np.where(above >= below, 1.0, -1.0)
    gaps = np.maximum(above, below)
    cheapest = np.argmax(gaps, axis=-1)
    one_axis = axes_of(gaps)[cheapest]
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
    """No axis of the 15 separates; no closest features are needed.

    The faces of both, and their edges crossed, in the frame of the first. A cross product with a coordinate axis only
    copies two coordinates, so it is exactly perpendicular to both edges, however nearly parallel they are.
    """
    frame, other = Frame.of(a), Frame.of(b)
    offset = frame.local(other.center)[:, None, :]
    turn = np.stack([apply_inverse(frame.matrix, other.matrix[..., :, j]) for j in range(3)], axis=-1)
    faces_a = np.broadcast_to(AXES, (len(a), 3, 3))
    faces_b = np.swapaxes(turn, -1, -2)
    edges = cross(faces_a[:, :, None, :], faces_b[:, None, :, :]).reshape(-1, 9, 3)
    axes = unit_or(np.concatenate([faces_a, faces_b, edges], axis=1), AXES[0])[0]
    widths = dot(frame.half[:, None, :], np.abs(axes))
    widths += dot(other.half[:, None, :], np.abs(apply_inverse(turn[:, None, :, :], axes)))
    return np.asarray(np.all(np.abs(dot(axes, offset)) - widths <= 0, axis=-1))


def aabb_meets_box(a: AABB, b: Box) -> Bools:
    """No axis of the 15 separates."""
    return box_meets_box(a.to_box(), b)
