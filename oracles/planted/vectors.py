"""Vectors of three plain floats."""

from __future__ import annotations

import math

Vec = tuple[float, float, float]
Axes = tuple[Vec, Vec, Vec]

ZERO: Vec = (0.0, 0.0, 0.0)
UNITS: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def add(a: Vec, b: Vec) -> Vec:
    """Sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vec, b: Vec) -> Vec:
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def times(s: float, a: Vec) -> Vec:
    """Multiple."""
    return (s * a[0], s * a[1], s * a[2])


def along(p: Vec, s: float, d: Vec) -> Vec:
    """The point p + s·d."""
    return (p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2])


def dot(a: Vec, b: Vec) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    """Outer product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a: Vec) -> float:
    """Euclidean norm."""
    return math.hypot(a[0], a[1], a[2])


def unit(a: Vec) -> Vec:
    """The direction of a vector; 0 has none and stays 0."""
    size = length(a)
    return (a[0] / size, a[1] / size, a[2] / size) if size > 0 else ZERO


def across(a: Vec, u: Vec) -> Vec:
    """The part of a that is square to the unit vector u."""
    return along(a, -dot(a, u), u)


def square_to(u: Vec) -> Vec:
    """Any direction square to u: through the axis that u is farthest from."""
    axis = min(range(3), key=lambda i: abs(u[i]))
    return unit(across(unit(cross(u, UNITS[axis])), u)) if u != ZERO else UNITS[0]


def largest(*vectors: Vec) -> float:
    """Largest absolute coordinate: the scale on which rounding happens."""
    return max(max(abs(v[0]), abs(v[1]), abs(v[2])) for v in vectors)
