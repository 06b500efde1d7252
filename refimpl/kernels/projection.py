"""The point of a body's surface that is nearest to a given point, from outside and from inside.

On an ellipsoid the normal at the nearest point x leads to the given point y, so xᵢ = yᵢ rᵢ² / (rᵢ² + t) in its own
frame, and t is the greatest root of Σ (rᵢ yᵢ / (rᵢ² + t))² = 1. Eberly, Distance from a Point to an Ellipse, an
Ellipsoid, or a Hyperellipsoid, brackets it. Here the root is sought of

    φ(t) = (Σ (rᵢ yᵢ / (rᵢ² + t))²)^(−1/2) = 1

instead, as trust-region methods do (Moré and Sorensen 1983): φ grows and is concave where all rᵢ² + t > 0, hence its
tangents lie above it, and Newton's steps from the left end of the bracket never pass the root. They cannot diverge.
"""

from __future__ import annotations

import math

from . import kernel
from .bodies import AXES, CENTER, ELLIPSOID, KIND, SIZES, Row, three
from .vectors import Vector, along, dot, length, minus, times, unit_or

Nearest = tuple[float, Vector, Vector]
"""Signed distance of a point from a solid; unit normal, outwards, at the nearest point; the nearest point."""

STEPS = 60


@kernel
def root(weights: Vector, shifts: Vector, start: float) -> float:
    """Root u ≥ start > 0 of Σ (wᵢ / (u + sᵢ))² = 1, with all sᵢ ≥ 0; `start` must not lie above it."""
    u = start
    for _ in range(STEPS):
        x = (weights[0] / (u + shifts[0]), weights[1] / (u + shifts[1]), weights[2] / (u + shifts[2]))
        square = dot(x, x)
        slope = x[0] * x[0] / (u + shifts[0]) + x[1] * x[1] / (u + shifts[1]) + x[2] * x[2] / (u + shifts[2])
        if not square > 1.0 or slope == 0.0:
            break
        further = u + square * (math.sqrt(square) - 1.0) / slope
        if not further > u:
            break
        u = further
    return u


@kernel
def over(x: float, y: float) -> float:
    """Quotient of two numbers that are at least 0; 0 / 0 is 0."""
    if y > 0.0:
        return x / y
    return math.inf if x > 0.0 else 0.0


@kernel
def on_unit_sphere(a: float, b: float, c: float, y: Vector) -> Vector:
    """Give (xᵢ / rᵢ) for the point x of an ellipsoid's surface nearest to y ≥ 0; c is the least of the radii a, b, c.

    In units of c: wᵢ = rᵢ yᵢ / c², sᵢ = (rᵢ² − c²) / c², u = 1 + t / c².
    """
    weights = ((a / c) * (y[0] / c), (b / c) * (y[1] / c), y[2] / c)
    shifts = (((a - c) / c) * ((a + c) / c), ((b - c) / c) * ((b + c) / c), 0.0)
    if weights[2] == 0.0:
        # in the plane of symmetry across the least radius: deep inside, the nearest point lies above or below it
        p, q = over(weights[0], shifts[0]), over(weights[1], shifts[1])
        if p * p + q * q <= 1.0:
            return (p, q, math.sqrt(1.0 - (p * p + q * q)))
    # no term alone exceeds 1 at the root; from here on the sum of their squares stays below 3
    start = max(weights[0] - shifts[0], weights[1] - shifts[1], weights[2], 2.0**-1000)
    u = root(weights, shifts, start)
    return (weights[0] / (u + shifts[0]), weights[1] / (u + shifts[1]), weights[2] / u)


@kernel
def point_ellipsoid(row: Row, point: Vector) -> Nearest:
    """Nearest point of an ellipsoid's surface; of several, the one that the signs of the coordinates prefer.

    Good to rounding for radii of any ratio, at the centre and in the planes of symmetry.
    """
    offset = minus(point, three(row, CENTER))
    least = 2
    for i in range(2):
        if row[SIZES + i] < row[SIZES + least]:
            least = i
    i, j, k = (least + 1) % 3, (least + 2) % 3, least
    u, v, w = three(row, AXES + 3 * i), three(row, AXES + 3 * j), three(row, AXES + 3 * k)
    a, b, c = row[SIZES + i], row[SIZES + j], row[SIZES + k]
    x, y, z = dot(offset, u), dot(offset, v), dot(offset, w)
    p, q, r = on_unit_sphere(a, b, c, (abs(x), abs(y), abs(z)))
    p, q, r = math.copysign(p, x), math.copysign(q, y), math.copysign(r, z)
    nearest = along(along(times(a * p, u), b * q, v), c * r, w)
    way = minus(offset, nearest)
    inside = (x / a) * (x / a) + (y / b) * (y / b) + (z / c) * (z / c) < 1.0
    normal = unit_or(along(along(times(p * (c / a), u), q * (c / b), v), r, w), w)
    straight = unit_or(times(-1.0 if inside else 1.0, way), normal)
    if height(row, offset, straight) >= height(row, offset, normal):
        normal = straight
    sigma = -length(way) if inside else length(way)
    return sigma, normal, along(three(row, CENTER), 1.0, nearest)


@kernel
def height(row: Row, offset: Vector, n: Vector) -> float:
    """How far a point, given from the centre, lies above an ellipsoid's or a cylinder's tangent plane across `n`."""
    x, y, z = dot(three(row, AXES), n), dot(three(row, AXES + 3), n), dot(three(row, AXES + 6), n)
    a, b, c = three(row, SIZES)
    if row[KIND] == ELLIPSOID:
        return dot(offset, n) - length((a * x, b * y, c * z))
    return dot(offset, n) - (length((a * x, a * y, 0.0)) + c * abs(z))


@kernel
def point_cylinder(row: Row, point: Vector) -> Nearest:
    """Nearest point of a cylinder's surface: on a cap, on the side or, from outside, on a rim.

    From the axis, the side is reached along the row's first axis. Ericson, Real-Time Collision Detection, 5.1.
    """
    u, v, w = three(row, AXES), three(row, AXES + 3), three(row, AXES + 6)
    radius, half = row[SIZES], row[SIZES + 2]
    offset = minus(point, three(row, CENTER))
    x, y, z = dot(offset, u), dot(offset, v), dot(offset, w)
    out = length((x, y, 0.0))
    outward = along(times(x / out, u), y / out, v) if out > 0.0 else u
    upward = times(math.copysign(1.0, z), w)
    beyond, above = out - radius, abs(z) - half
    if beyond <= 0.0 and above <= 0.0:
        if beyond >= above:
            return beyond, outward, along(point, -beyond, outward)
        return above, upward, along(point, -above, upward)
    if beyond <= 0.0:
        return above, upward, along(point, -above, upward)
    if above <= 0.0:
        return beyond, outward, along(point, -beyond, outward)
    way = along(times(beyond, outward), above, upward)
    return length((beyond, above, 0.0)), unit_or(way, outward), minus(point, way)


@kernel
def nearest_to_point(row: Row, point: Vector) -> Nearest:
    """Nearest point of the surface of an ellipsoid or a cylinder."""
    if row[KIND] == ELLIPSOID:
        return point_ellipsoid(row, point)
    return point_cylinder(row, point)
