"""Anything against a half-space: its lowest point along the normal decides."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from refimpl.linear import Array, Bools, apply_inverse, dot, largest, norm, power_of_two, rotation_matrix, scale
from refimpl.linear import apply as rotate
from refimpl.results import Separation, where
from refimpl.shapes import AABB, Box, Capsule, HalfSpace, Point, Sphere


def unit_plane(h: HalfSpace) -> tuple[Array, Array]:
    """Unit normal and signed distance −offset of the plane: {x : n·x + offset ≤ 0}."""
    exponent = power_of_two(largest(h.normal))
    normal = np.ldexp(h.normal, -exponent[..., None])
    length = norm(normal)
    return scale(1.0 / length, normal), np.ldexp(h.k, -exponent) / length


def lowest_against_plane(h: HalfSpace, lowest: Array, radius: Array) -> Separation:
    """Separation of a set from a half-space; the set's core is lowest at `lowest`, and grown by `radius`."""
    n, offset = unit_plane(h)
    sigma = (dot(n, lowest) + offset) - radius
    on_a = lowest - scale(radius, n)
    return Separation(sigma, on_a, on_a - scale(sigma, n), -n)


def point_halfspace(x: Point, h: HalfSpace) -> Separation:
    """Signed distance of a point from a half-space. Closed form. Ericson, Real-Time Collision Detection, 5.1.1."""
    return lowest_against_plane(h, x.position, np.zeros(len(x)))


def sphere_halfspace(s: Sphere, h: HalfSpace) -> Separation:
    """Signed distance of a ball and a half-space. Closed form. Ericson, Real-Time Collision Detection, 5.2.2."""
    return lowest_against_plane(h, s.center, s.radius)


def capsule_halfspace(c: Capsule, h: HalfSpace) -> Separation:
    """Signed distance of a capsule and a half-space: its lower end decides. Closed form.

    Not unique when the axis is parallel to the plane: `p` is the witness then.
    """
    n, _ = unit_plane(h)
    return lowest_against_plane(h, where(dot(n, c.q - c.p) < 0, c.q, c.p), c.radius)


def halfspace_aabb(h: HalfSpace, b: AABB) -> Separation:
    """Signed distance of a half-space and an axis-aligned box: its lowest corner decides. Closed form."""
    corner = np.where(h.normal > 0, b.lower, b.upper)
    return lowest_against_plane(h, corner, np.zeros(len(h))).flipped()


def halfspace_box(h: HalfSpace, b: Box) -> Separation:
    """Signed distance of a half-space and a box: its lowest corner decides. Closed form.

    Not unique when a face or an edge is parallel to the plane. Ericson, Real-Time Collision Detection, 5.2.3.
    """
    n, _ = unit_plane(h)
    matrix = rotation_matrix(b.rotation)
    corner = np.where(apply_inverse(matrix, n) > 0, -b.half_extents, b.half_extents)
    return lowest_against_plane(h, b.center + rotate(matrix, corner), np.zeros(len(h))).flipped()


def halfspace_halfspace(h: HalfSpace, g: HalfSpace) -> Separation:
    """Signed distance of two half-spaces: finite only when they face each other exactly. Closed form.

    Otherwise they overlap without end: distance −inf, no normal and no witness points (NaN). Whether the normals
    are opposite is decided in exact arithmetic, for no rounding may turn an infinite depth into a finite one.
    """
    n, offset = unit_plane(h)
    m, other = unit_plane(g)
    facing = dot(n, m) < -0.5
    suspects = np.flatnonzero(facing & (norm(n + m) < 1e-9))
    facing[:] = False
    facing[suspects] = _exactly_opposite(h.normal[suspects], g.normal[suspects])
    gap = np.where(facing, offset + other, -np.inf)
    on_a = np.where(facing[:, None], scale(-offset, n), np.nan)
    on_b = np.where(facing[:, None], on_a + scale(np.where(facing, gap, 0.0), n), np.nan)
    return Separation(gap, on_a, on_b, np.where(facing[:, None], n, np.nan))


def _exactly_opposite(n: Array, m: Array) -> Bools:
    """Which rows are opposite: those that differ by the sign and a power of two are, others are asked in fractions."""
    (digits, exponents), (others, theirs) = np.frexp(n), np.frexp(m)
    first = np.argmax(digits != 0, axis=-1)[:, None]
    steps = exponents - theirs
    alike = (steps == np.take_along_axis(steps, first, axis=-1)) | (digits == 0)
    opposite = np.all((digits == -others) & alike, axis=-1)
    rest = np.flatnonzero(~opposite)
    opposite[rest] = [_opposite_fractions(n[i], m[i]) for i in rest]
    return np.asarray(opposite)


def _opposite_fractions(n: Array, m: Array) -> bool:
    a, b = [Fraction(x) for x in n.tolist()], [Fraction(x) for x in m.tolist()]
    parallel = all(a[i] * b[j] == a[j] * b[i] for i, j in ((0, 1), (1, 2), (0, 2)))
    return parallel and sum(x * y for x, y in zip(a, b, strict=True)) < 0
