"""Vectors as three floats."""

from __future__ import annotations

import math

from . import kernel

Vector = tuple[float, float, float]

TINY, HUGE = 2.0**-900, 2.0**900
"""Between these, a sum of squares has lost nothing, and the square root is enough."""


@kernel
def dot(u: Vector, v: Vector) -> float:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@kernel
def cross(u: Vector, v: Vector) -> Vector:
    """Vector product."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


@kernel
def plus(u: Vector, v: Vector) -> Vector:
    """Sum."""
    return (u[0] + v[0], u[1] + v[1], u[2] + v[2])


@kernel
def minus(u: Vector, v: Vector) -> Vector:
    """Difference u − v."""
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


@kernel
def opposite(v: Vector) -> Vector:
    """Give −v."""
    return (-v[0], -v[1], -v[2])


@kernel
def times(factor: float, v: Vector) -> Vector:
    """Multiple of a vector."""
    return (factor * v[0], factor * v[1], factor * v[2])


@kernel
def along(start: Vector, factor: float, way: Vector) -> Vector:
    """Point start + factor·way."""
    return (start[0] + factor * way[0], start[1] + factor * way[1], start[2] + factor * way[2])


@kernel
def length(v: Vector) -> float:
    """Euclidean length; neither overflows nor underflows."""
    square = dot(v, v)
    if TINY < square < HUGE:
        return math.sqrt(square)
    size = max(abs(v[0]), abs(v[1]), abs(v[2]))
    if size == 0.0:
        return 0.0
    u = (v[0] / size, v[1] / size, v[2] / size)
    return size * math.sqrt(dot(u, u))


@kernel
def unit_or(v: Vector, fallback: Vector) -> Vector:
    """Direction of a vector; `fallback` for zero."""
    square = dot(v, v)
    if TINY < square < HUGE:
        return times(1.0 / math.sqrt(square), v)
    size = max(abs(v[0]), abs(v[1]), abs(v[2]))
    if size == 0.0:
        return fallback
    u = (v[0] / size, v[1] / size, v[2] / size)
    return times(1.0 / math.sqrt(dot(u, u)), u)


@kernel
def perpendicular(v: Vector) -> Vector:
    """Some unit vector at right angles to `v`; any unit vector for zero (Hughes and Möller 1999)."""
    x, y, z = abs(v[0]), abs(v[1]), abs(v[2])
    if x <= y and x <= z:
        return unit_or((0.0, -v[2], v[1]), (0.0, 1.0, 0.0))
    if y <= z:
        return unit_or((v[2], 0.0, -v[0]), (0.0, 0.0, 1.0))
    return unit_or((-v[1], v[0], 0.0), (1.0, 0.0, 0.0))


@kernel
def without(v: Vector, direction: Vector) -> Vector:
    """Part of `v` at right angles to `direction`; `v` itself where that is zero."""
    square = dot(direction, direction)
    if square == 0.0:
        return v
    return along(v, -dot(v, direction) / square, direction)
