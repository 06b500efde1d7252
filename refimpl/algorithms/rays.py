"""The first time at which a ray meets a solid.

Each function answers a time (inf on a miss, 0 when the ray starts inside) and the outward unit normal there.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.algorithms.boxes import AXES, axes_of
from refimpl.algorithms.halfspaces import unit_plane
from refimpl.algorithms.nearest import nearest_on_segment, without
from refimpl.linear import (
    Array,
    apply,
    apply_inverse,
    dot,
    largest,
    norm,
    power_of_two,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, Cylinder, Ellipsoid, HalfSpace, Ray, Sphere

Entry = tuple[Array, Array]
ROUNDING = 2.0**-48
"""Part of the lengths along a ray by which its distance from a plane may be rounded, and more."""


def _round_span(offset: Array, direction: Array, radius: Array) -> tuple[Array, Array, Array]:
    """Times between which offset + t·direction is within `radius` of 0, and the outward direction at the first.

    An empty span is (inf, −inf). Without a direction it is endless, or empty. The half chord is taken at the
    nearest point of the line, where r² − d² = (r − d)(r + d) does not cancel; so is the outward direction, which
    would be noise if it were taken from a hit point far from the ray's origin. The direction is brought to about 1:
    across an axis, a ray may be so slow that the square of its speed is none.
    """
    exponent = power_of_two(largest(direction))
    direction = np.ldexp(direction, -exponent[..., None])
    square = dot(direction, direction)
    still = square == 0
    square = np.where(still, 1.0, square)
    middle = -dot(offset, direction) / square
    foot = offset + scale(middle, direction)
    nearest = norm(foot)
    chord = (radius - nearest) * (radius + nearest) / square
    half = np.sqrt(np.maximum(chord, 0.0))
    with np.errstate(over="ignore"):  # what comes that late never comes
        enter = np.where(still, -np.inf, np.ldexp(middle - half, -exponent))
        leave = np.where(still, np.inf, np.ldexp(middle + half, -exponent))
    empty = chord < 0
    return np.where(empty, np.inf, enter), np.where(empty, -np.inf, leave), foot - scale(half, direction)


def _first(enter: Array, leave: Array) -> Array:
    """First time t ≥ 0 in a span; inf when there is none."""
    first = np.maximum(enter, 0.0)
    return np.where((enter <= leave) & (leave >= 0), first, np.inf)


def _outward(direction: Array, ray: Ray) -> Array:
    """Unit vector; against the ray where a round without a radius leaves no direction."""
    return unit_or(direction, unit_or(-ray.direction, axes_of(ray.direction)[0])[0])[0]


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
    share with a ball. Of a ball only the outer half counts: where a ray grazes the other, rounding would turn the
    normal by its square root, and the side would stand out beyond the plane. Ericson, Real-Time Collision Detection,
    5.3.7.
    """
    axis, offset = c.q - c.p, ray.origin - c.p
    across = without(ray.direction, axis)
    enter, leave, _ = _round_span(without(offset, axis), across, c.radius)
    rise, height, length = dot(ray.direction, axis), dot(offset, axis), dot(axis, axis)
    near, far = _span(-height, length - height, rise)
    times = [_first(np.maximum(enter, near), np.minimum(leave, far))]
    side = ray.origin + scale(np.where(np.isfinite(times[0]), times[0], 0.0), ray.direction)
    outwards = [unit_or(without(side - nearest_on_segment(side, c.p, c.q), axis), -across)[0]]
    for end, away in ((c.p, -axis), (c.q, axis)):
        enter, leave, outward = _round_span(ray.origin - end, ray.direction, c.radius)
        times.append(_first(enter, leave))
        outwards.append(np.where((dot(outward, away) < 0)[..., None], without(outward, axis), outward))
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
    axes = axes_of(direction)[last]
    outward = np.where(np.take_along_axis(direction, last[:, None], axis=-1) > 0, -axes, axes)
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


def ray_ellipsoid(ray: Ray, e: Ellipsoid) -> Entry:
    """First time of a ray in an ellipsoid: a unit ball in its scaled frame. Closed form.

    In that frame a thin ellipsoid sees its own origin from afar, and the foot of the perpendicular is what is left
    when long vectors cancel; a second projection, of the foot, makes good what the first one lost. The frame's
    components are scaled one by one, so each keeps its own rounding, and none spoils a thinner one.
    """
    matrix = rotation_matrix(e.rotation)
    way = apply_inverse(matrix, ray.direction) / e.radii
    exponent = power_of_two(largest(way))
    way = np.ldexp(way, -exponent[:, None])
    start = apply_inverse(matrix, ray.origin - e.center) / e.radii
    square = dot(way, way)
    first = -dot(start, way) / square
    foot = start + scale(first, way)
    rest = -dot(foot, way) / square
    foot = foot + scale(rest, way)
    nearest = norm(foot)
    with np.errstate(over="ignore"):
        chord = (1.0 - nearest) * (1.0 + nearest) / square
        half = np.sqrt(np.maximum(chord, 0.0))
        middle = first + rest
        t = _first(np.where(chord < 0, np.inf, middle - half), np.where(chord < 0, -np.inf, middle + half))
        t = np.where(norm(start) <= 1.0, 0.0, np.ldexp(t, -exponent))
    normal = (foot - scale(half, way)) / e.radii
    return t, apply(matrix, _outward(normal, ray))


def ray_cylinder(ray: Ray, c: Cylinder) -> Entry:
    """First time of a ray in a cylinder: within the radius of the axis, and between the ends. Closed form.

    The last of the two to be entered is the surface that is hit. Ericson, Real-Time Collision Detection, 5.3.7.
    """
    axis, offset = unit_or(c.q - c.p, AXES[2])[0], ray.origin - c.p
    length = norm(c.q - c.p)
    radial, across = without(offset, axis), without(ray.direction, axis)
    enter, leave, outward = _round_span(radial, across, c.radius)
    height, rise = dot(offset, axis), dot(ray.direction, axis)
    near, far = _span(-height, length - height, rise)
    within = (norm(radial) <= c.radius) & (height >= 0) & (height <= length)
    t = np.where(within, 0.0, _first(np.maximum(enter, near), np.minimum(leave, far)))
    side = unit_or(outward, unit_or(-across, AXES[0])[0])[0]
    end = scale(np.where(rise > 0, -1.0, 1.0), axis)
    return t, np.where((near > enter)[:, None], end, side)


def ray_kdop(ray: Ray, d: KDOP) -> Entry:
    """First time of a ray in a k-DOP: its slabs. Closed form. Kay and Kajiya 1986."""
    size = power_of_two(largest(d.directions))
    ways = np.ldexp(d.directions, -size[..., None])
    start = dot(ways, ray.origin[:, None, :])
    speed = dot(ways, ray.direction[:, None, :])
    lower, upper = np.ldexp(d.lower, -size) - start, np.ldexp(d.upper, -size) - start
    near, far = _span(lower, upper, speed)
    last = np.argmax(near, axis=-1)[:, None]
    faster = np.take_along_axis(speed, last, axis=-1) > 0
    face = np.take_along_axis(ways, last[..., None], axis=1)[:, 0]
    within = np.all((lower <= 0) & (upper >= 0), axis=-1)
    t = np.where(within, 0.0, _first(np.max(near, axis=-1), np.min(far, axis=-1)))
    return t, unit_or(np.where(faster, -face, face), AXES[0])[0]


def _comes_through(ray: Ray, c: ConvexPolyhedron) -> bool:
    """Whether a ray meets a convex polyhedron given by planes, in rational numbers."""
    from refimpl.proof import reading, vectors  # noqa: PLC0415  only what is flat or grazed needs it

    line: Any = reading.read(ray)
    solid: Any = reading.read(c)
    enter, leave = Fraction(0), math.inf
    for normal, k in solid.planes:
        height, speed = vectors.dot(normal, line.origin) + k, vectors.dot(normal, line.direction)
        if speed == 0 and height > 0:
            return False
        if speed < 0:
            enter = max(enter, -height / speed)
        if speed > 0:
            leave = min(leave, -height / speed)
    return bool(enter <= leave)


def ray_convexpolyhedron(ray: Ray, c: ConvexPolyhedron) -> Entry:
    """First time of a ray in a convex polyhedron: clipped by one plane after the other. Closed form.

    The planes are those given, or the faces of the hull of the vertices given. Where given ones leave the ray less room
    than rounding, rational numbers decide whether it comes through. Cyrus and Beck 1978; Ericson, Real-Time Collision
    Detection, 5.3.8.
    """
    planes = c.numbers if c.given == "planes" else c.hull.planes
    size = power_of_two(largest(planes[..., :3]))
    normals = np.ldexp(planes[..., :3], -size[..., None])
    matrix = rotation_matrix(c.rotation)
    start, way = apply_inverse(matrix, ray.origin - c.position), apply_inverse(matrix, ray.direction)
    height = dot(normals, start[:, None, :]) + np.ldexp(planes[..., 3], -size)
    speed = dot(normals, way[:, None, :])
    moving = speed != 0
    with np.errstate(over="ignore"):
        times = -height / np.where(moving, speed, 1.0)
    still = np.where(height <= 0, -np.inf, np.inf)  # along a plane: always below it, or never
    near = np.where(speed < 0, times, np.where(moving, -np.inf, still))
    far = np.where(speed > 0, times, np.inf)
    last = np.argmax(near, axis=-1)[:, None, None]
    outward = unit_or(np.take_along_axis(normals, last, axis=1)[:, 0], AXES[0])[0]
    enter, leave = np.max(near, axis=-1), np.min(far, axis=-1)
    if c.given == "planes":
        blur = ROUNDING * (norm(start)[:, None] + np.abs(height)) / np.where(moving, np.abs(speed), np.inf)
        decides = (near == enter[:, None]) | (far == leave[:, None])
        with np.errstate(invalid="ignore"):  # without an end there is no room to measure
            doubtful = np.abs(leave - enter) <= np.max(np.where(decides, blur, 0.0), axis=-1)
        for i in np.flatnonzero(doubtful):
            leave[i] = max(enter[i], leave[i]) if _comes_through(ray[i], c[i]) else -np.inf
    t = np.where(np.all(height <= 0, axis=-1), 0.0, _first(enter, leave))
    return t, apply(matrix, outward)
