"""The first time at which a ray meets a solid.

Each function answers a time (inf on a miss, 0 when the ray starts inside) and the outward unit normal there.
"""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.boxes import AXES
from refimpl.algorithms.halfspaces import unit_plane
from refimpl.algorithms.nearest import nearest_on_segment, without
from refimpl.linear import Array, apply, apply_inverse, dot, norm, rotation_matrix, scale, unit_or
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Ray, Sphere

Entry = tuple[Array, Array]


def _round_entry(offset: Array, direction: Array, radius: Array) -> Array:
    """Time at which offset + t·direction comes within `radius` of 0, if it ever does; inf without direction.

    The half chord is taken at the nearest point of the line, where r² − d² = (r − d)(r + d) does not cancel.
    """
    square = dot(direction, direction)
    still = square == 0
    square = np.where(still, 1.0, square)
    middle = -dot(offset, direction) / square
    nearest = norm(offset + scale(middle, direction))
    chord = (radius - nearest) * (radius + nearest) / square
    time = np.where(chord >= 0, middle - np.sqrt(np.maximum(chord, 0.0)), np.inf)
    leaves = middle + np.sqrt(np.maximum(chord, 0.0))
    return np.where(~still & (leaves >= 0), time, np.inf)


def ray_sphere(ray: Ray, s: Sphere) -> Entry:
    """First time of a ray in a ball. Closed form. Ericson, Real-Time Collision Detection, 5.3.2."""
    offset = ray.origin - s.center
    t = np.maximum(_round_entry(offset, ray.direction, s.radius), 0.0)
    t = np.where(norm(offset) <= s.radius, 0.0, t)
    outward = unit_or(offset + scale(np.where(np.isfinite(t), t, 0.0), ray.direction), AXES[0])[0]
    return t, outward


def ray_capsule(ray: Ray, c: Capsule) -> Entry:
    """First time of a ray in a capsule: its side between the ends, or the ball at either end. Closed form.

    Ericson, Real-Time Collision Detection, 5.3.7.
    """
    axis, offset = c.q - c.p, ray.origin - c.p
    length = dot(axis, axis)
    side = _round_entry(without(offset, axis), without(ray.direction, axis), c.radius)
    first = np.maximum(side, 0.0)  # a line that entered the side before t = 0 is inside it now, or not in the solid
    with np.errstate(invalid="ignore"):
        along = dot(offset + scale(first, ray.direction), axis)
    times = [np.where((along >= 0) & (along <= length), first, np.inf)]
    times += [_round_entry(ray.origin - end, ray.direction, c.radius) for end in (c.p, c.q)]
    t = np.maximum(np.minimum(np.minimum(times[0], times[1]), times[2]), 0.0)
    t = np.where(norm(ray.origin - nearest_on_segment(ray.origin, c.p, c.q)) <= c.radius, 0.0, t)
    point = ray.origin + scale(np.where(np.isfinite(t), t, 0.0), ray.direction)
    return t, unit_or(point - nearest_on_segment(point, c.p, c.q), AXES[0])[0]


def _slabs(lower: Array, upper: Array, direction: Array) -> Entry:
    """First time of a ray from the origin in lower ≤ x ≤ upper, and the face it enters by.

    Ericson, Real-Time Collision Detection, 5.3.3; Kay and Kajiya 1986. A ray within a face's plane touches it.
    """
    moving = direction != 0
    speed = np.where(moving, direction, 1.0)
    within = (lower <= 0) & (upper >= 0)
    with np.errstate(over="ignore"):
        near = np.where(moving, np.where(speed > 0, lower, upper) / speed, np.where(within, -np.inf, np.inf))
        far = np.where(moving, np.where(speed > 0, upper, lower) / speed, np.where(within, np.inf, -np.inf))
    last = np.argmax(near, axis=-1)
    enter = np.max(near, axis=-1)
    hit = (enter <= np.min(far, axis=-1)) & (np.min(far, axis=-1) >= 0)
    t = np.where(hit, np.maximum(enter, 0.0), np.inf)
    outward = np.where(np.take_along_axis(direction, last[:, None], axis=-1) > 0, -AXES[last], AXES[last])
    return np.where(np.all(within, axis=-1), 0.0, t), outward


def ray_aabb(ray: Ray, b: AABB) -> Entry:
    """First time of a ray in an axis-aligned box: the three slabs. Closed form."""
    return _slabs(b.lower - ray.origin, b.upper - ray.origin, ray.direction)


def ray_box(ray: Ray, b: Box) -> Entry:
    """First time of a ray in a box: the three slabs of its frame. Closed form."""
    matrix = rotation_matrix(b.rotation)
    origin = apply_inverse(matrix, ray.origin - b.center)
    t, outward = _slabs(-b.half_extents - origin, b.half_extents - origin, apply_inverse(matrix, ray.direction))
    return t, apply(matrix, outward)


def ray_halfspace(ray: Ray, h: HalfSpace) -> Entry:
    """First time of a ray in a half-space. Closed form. Ericson, Real-Time Collision Detection, 5.3.1."""
    n, offset = unit_plane(h)
    height, speed = dot(n, ray.origin) + offset, dot(n, ray.direction)
    with np.errstate(over="ignore"):
        t = np.where(speed < 0, height / np.where(speed < 0, -speed, 1.0), np.inf)
    return np.where(height <= 0, 0.0, t), n
