"""Point, sphere and capsule against each other: a point or a segment, grown by a radius.

σ(A ⊕ r, B ⊕ s) = σ(A, B) − (r + s) on both branches, so the inner point or segment decides, and concentric or
crossing proxies need no search: only a choice among equally good normals.
"""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.nearest import best_normal, nearest_on_segment, point_on_segment, without
from refimpl.linear import Array, Bools, cross, dot, norm, perpendicular, scale, unit_or
from refimpl.results import Separation
from refimpl.shapes import Capsule, Point, Sphere

X_AXIS = np.array([1.0, 0.0, 0.0])


def grown(core: Separation, radius_a: Array, radius_b: Array) -> Separation:
    """Separation of A ⊕ radius_a and B ⊕ radius_b from that of A and B."""
    return Separation(
        distance=core.distance - (radius_a + radius_b),
        on_a=core.on_a + scale(radius_a, core.normal),
        on_b=core.on_b - scale(radius_b, core.normal),
        normal=core.normal,
    )


def point_point(x: Array, y: Array) -> Separation:
    """Gap between two points; the normal of coinciding ones is the x axis."""
    normal, gap = unit_or(y - x, X_AXIS)
    return Separation(gap, x, y, normal)


def point_segment(x: Array, p: Array, q: Array) -> Separation:
    """Gap between a point and a segment.

    Unique, but for a point of the segment itself; the normal is then perpendicular to the segment.
    """
    nearest = nearest_on_segment(x, p, q)
    step, offset = q - p, nearest - x
    sideways = perpendicular(step)
    directions = [unit_or(offset, sideways)[0], unit_or(without(offset, step), sideways)[0], sideways]

    def gap_along(n: Array) -> Array:
        return np.minimum(dot(p - x, n), dot(q - x, n))

    return Separation(norm(offset), x, nearest, best_normal(directions, gap_along, offset))


def segment_segment(p: Array, q: Array, r: Array, s: Array) -> Separation:
    """Gap between the segments pq and rs.

    Of five candidates, one of which is the answer, the nearest counts: the feet of the common perpendicular, and
    each of the four ends with its nearest point on the other segment. The perpendicular is found in the plane
    across pq: there the nearly parallel case loses nothing that matters, because an error along the
    common direction does not change the gap. Ericson, Real-Time Collision Detection, 5.1.9.
    """
    a, b = q - p, s - r
    across, offset = without(b, a), without(r - p, a)
    square = dot(across, across)
    t = np.clip(-dot(offset, across) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    foot = point_on_segment(t, r, s)
    on_b = [foot, r, s, nearest_on_segment(p, r, s), nearest_on_segment(q, r, s)]
    on_a = [nearest_on_segment(y, p, q) for y in on_b[:3]] + [p, q]
    gaps = np.stack([norm(y - x) for x, y in zip(on_a, on_b, strict=True)], axis=-1)
    best = np.argmin(gaps, axis=-1)[..., None]
    x = np.take_along_axis(np.stack(on_a, axis=-2), best[..., None], axis=-2)[..., 0, :]
    y = np.take_along_axis(np.stack(on_b, axis=-2), best[..., None], axis=-2)[..., 0, :]
    gap = np.take_along_axis(gaps, best, axis=-1)[..., 0]
    normal = _normal_of_segments(p, a, r, b, y - x)
    for _ in range(2):  # nearly parallel: of many pairs with equal gaps, one that lies along the normal
        x = nearest_on_segment(y - scale(gap, normal), p, q)
        y = nearest_on_segment(x + scale(gap, normal), r, s)
    return Separation(gap, x, y, normal)


def _normal_of_segments(p: Array, a: Array, r: Array, b: Array, offset: Array) -> Array:
    """Return the normal from segment p + [0, 1] a to segment r + [0, 1] b, whose closest points are `offset` apart."""
    sideways = perpendicular(np.where((dot(a, a) >= dot(b, b))[..., None], a, b))
    common = unit_or(without(cross(a, b), a), sideways)[0]
    direct = unit_or(offset, sideways)[0]
    directions = [direct, unit_or(without(offset, a), direct)[0], unit_or(without(offset, b), direct)[0]]
    directions += [common, -common, sideways, -sideways]

    def gap_along(n: Array) -> Array:
        return dot(r - p, n) + np.minimum(dot(b, n), 0.0) - np.maximum(dot(a, n), 0.0)

    return best_normal(directions, gap_along, offset)


def point_sphere(x: Point, s: Sphere) -> Separation:
    """Signed distance of a point from a ball; the normal at the centre is the x axis. Closed form."""
    return grown(point_point(x.position, s.center), np.zeros_like(s.radius), s.radius)


def point_capsule(x: Point, c: Capsule) -> Separation:
    """Signed distance of a point from a capsule; on the axis the normal is perpendicular to it. Closed form."""
    return grown(point_segment(x.position, c.p, c.q), np.zeros_like(c.radius), c.radius)


def sphere_sphere(s: Sphere, z: Sphere) -> Separation:
    """Signed distance of two balls; the normal of concentric ones is the x axis. Closed form."""
    return grown(point_point(s.center, z.center), s.radius, z.radius)


def sphere_capsule(s: Sphere, c: Capsule) -> Separation:
    """Signed distance of a ball and a capsule. Closed form.

    Unique unless the centre lies on the capsule's axis; the normal is then perpendicular to it.
    Ericson, Real-Time Collision Detection, 4.5.1.
    """
    return grown(point_segment(s.center, c.p, c.q), s.radius, c.radius)


def capsule_capsule(c: Capsule, d: Capsule) -> Separation:
    """Signed distance of two capsules. Closed form.

    Where the axes cross, the normal is perpendicular to both. Ericson, Real-Time Collision Detection, 4.5.1.
    """
    return grown(segment_segment(c.p, c.q, d.p, d.q), c.radius, d.radius)


def point_meets_sphere(x: Point, s: Sphere) -> Bools:
    """Compare squares: no root is needed to know on which side of the surface a point lies."""
    offset = s.center - x.position
    return np.asarray(dot(offset, offset) <= s.radius * s.radius)


def sphere_meets_sphere(s: Sphere, z: Sphere) -> Bools:
    """Compare the squared distance of the centres with the squared sum of the radii."""
    offset, reach = z.center - s.center, s.radius + z.radius
    return np.asarray(dot(offset, offset) <= reach * reach)


def sphere_meets_capsule(s: Sphere, c: Capsule) -> Bools:
    """Compare squares at the nearest point of the axis."""
    offset, reach = nearest_on_segment(s.center, c.p, c.q) - s.center, s.radius + c.radius
    return np.asarray(dot(offset, offset) <= reach * reach)


def point_meets_capsule(x: Point, c: Capsule) -> Bools:
    """Compare squares at the nearest point of the axis."""
    offset = nearest_on_segment(x.position, c.p, c.q) - x.position
    return np.asarray(dot(offset, offset) <= c.radius * c.radius)
