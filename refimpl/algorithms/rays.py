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


def _round_span(offset: Array, direction: Array, radius: Array) -> tuple[Array, Array, Array]:
    """Times between which offset + t·direction is within `radius` of 0, and the outward direction at the first.

    An empty span is (inf, −inf). Without a direction it is endless, or empty. The half chord is taken at the
    nearest point of the line, where r² − d² = (r − d)(r + d) does not cancel; so is the outward direction, which
    would be noise if it were taken from a hit point far from the ray's origin.
    """
    square = dot(direction, direction)
    still = square == 0
    square = np.where(still, 1.0, square)
    middle = -dot(offset, direction) / square
    foot = offset + scale(middle, direction)
    nearest = norm(foot)
    chord = (radius - nearest) * (radius + nearest) / square
    half = np.sqrt(np.maximum(chord, 0.0))
    enter = np.where(still, -np.inf, middle - half)
    leave = np.where(still, np.inf, middle + half)
    empty = chord < 0
    return np.where(empty, np.inf, enter), np.where(empty, -np.inf, leave), foot - scale(half, direction)


def _first(enter: Array, leave: Array) -> Array:
    """First time t ≥ 0 in a span; inf when there is none."""
    first = np.maximum(enter, 0.0)
    return np.where((enter <= leave) & (leave >= 0), first, np.inf)


def _outward(direction: Array, ray: Ray) -> Array:
    """Unit vector; against the ray where a round without a radius leaves no direction."""
    return unit_or(direction, unit_or(-ray.direction, AXES[0])[0])[0]


def ray_sphere(ray: Ray, s: Sphere) -> Entry:
    """First time of a ray in a ball. Closed form. Ericson, Real-Time Collision Detection, 5.3.2."""
    offset = ray.origin - s.center
    enter, leave, outward = _round_span(offset, ray.direction, s.radius)
    t = np.where(norm(offset) <= s.radius, 0.0, _first(enter, leave))
    return t, _outward(outward, ray)


def ray_capsule(ray: Ray, c: Capsule) -> Entry:
    """First time of a ray in a capsule: its side between the ends, or the ball at either end. Closed form.

    The side is hit while the line is both within the radius of the axis and between the ends. Near the seams
    rounding moves the first span's ends by much for a ray nearly along the axis, but not the part that both
    share with a ball. Ericson, Real-Time Collision Detection, 5.3.7.
    """
    axis, offset = c.q - c.p, ray.origin - c.p
    across = without(ray.direction, axis)
    enter, leave, _ = _round_span(without(offset, axis), across, c.radius)
    rise, height, length = dot(ray.direction, axis), dot(offset, axis), dot(axis, axis)
    near, far = _span(-height, length - height, rise)
    times = [_first(np.maximum(enter, near), np.minimum(leave, far))]
    side = ray.origin + scale(np.where(np.isfinite(times[0]), times[0], 0.0), ray.direction)
    outwards = [unit_or(without(side - nearest_on_segment(side, c.p, c.q), axis), -across)[0]]
    for end in (c.p, c.q):
        enter, leave, outward = _round_span(ray.origin - end, ray.direction, c.radius)
        times.append(_first(enter, leave))
        outwards.append(outward)
    first = np.argmin(np.stack(times), axis=0)
    t = np.min(np.stack(times), axis=0)
    t = np.where(norm(ray.origin - nearest_on_segment(ray.origin, c.p, c.q)) <= c.radius, 0.0, t)
    chosen = np.take_along_axis(np.stack(outwards), first[None, :, None], axis=0)[0]
    return t, _outward(chosen, ray)


def _span(lower: Array, upper: Array, speed: Array) -> tuple[Array, Array]:
    """Times between which t·speed lies in lower ≤ x ≤ upper; (inf, −inf) when it never does."""
    moving = speed != 0
    divisor = np.where(moving, speed, 1.0)
    within = (lower <= 0) & (upper >= 0)
    with np.errstate(over="ignore"):
        near = np.where(moving, np.where(divisor > 0, lower, upper) / divisor, np.where(within, -np.inf, np.inf))
        far = np.where(moving, np.where(divisor > 0, upper, lower) / divisor, np.where(within, np.inf, -np.inf))
    return near, far


def _slabs(lower: Array, upper: Array, direction: Array) -> Entry:
    """First time of a ray from the origin in lower ≤ x ≤ upper, and the face it enters by.

    Ericson, Real-Time Collision Detection, 5.3.3; Kay and Kajiya 1986. A ray within a face's plane touches it.
    """
    near, far = _span(lower, upper, direction)
    within = (lower <= 0) & (upper >= 0)
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
