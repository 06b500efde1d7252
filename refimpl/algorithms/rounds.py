"""Point, sphere and capsule against each other: a point or a segment, grown by a radius.

σ(A ⊕ r, B ⊕ s) = σ(A, B) − (r + s) on both branches, so the inner point or segment decides, and concentric or
crossing proxies need no search: only a choice among equally good normals.
"""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.nearest import best_normal, nearest_on_segment, without
from refimpl.compiling import module_for, numbers
from refimpl.linear import Array, Bools, dot, norm, perpendicular, scale, unit_or
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
    normal, gap = unit_or(y - x, X_AXIS[: x.shape[-1]])
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


def segment_segment(c: Capsule, d: Capsule) -> Separation:
    """Gap between the axes of two capsules: the scalar kernel `refimpl.kernels.segments`."""
    module = module_for("segments", len(c))
    answers = numbers(np.zeros((len(c), 10)), module)
    module.segment_separations(numbers(c.pack(), module), numbers(d.pack(), module), answers)
    found = np.array(answers).reshape(len(c), 10)
    return Separation(found[:, 0], found[:, 4:7], found[:, 7:10], found[:, 1:4])


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
    return grown(segment_segment(c, d), c.radius, d.radius)


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
