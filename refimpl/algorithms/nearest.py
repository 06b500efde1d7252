"""Nearest points on a segment and on a box, and the normal between nearest points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from refimpl.linear import Array, dot, norm, scale

GapAlong = Callable[[Array], Array]


def parameter_on_segment(x: Array, p: Array, step: Array) -> Array:
    """Parameter t in [0, 1] of the point p + t·step nearest to `x`; 0 for a segment of zero length.

    Ericson, Real-Time Collision Detection, 5.1.2.
    """
    square = dot(step, step)
    t = dot(x - p, step) / np.where(square > 0, square, 1.0)
    return np.clip(t, 0.0, 1.0)


def nearest_on_segment(x: Array, p: Array, q: Array) -> Array:
    """Point of the segment pq nearest to `x`; reaches both ends exactly."""
    t = parameter_on_segment(x, p, q - p)
    return point_on_segment(t, p, q)


def point_on_segment(t: Array, p: Array, q: Array) -> Array:
    """Point p + t (q − p), counted from the nearer end, so that t = 1 gives q exactly."""
    step = q - p
    return np.where((t < 0.5)[..., None], p + scale(t, step), q - scale(1.0 - t, step))


def without(v: Array, direction: Array) -> Array:
    """Part of `v` at right angles to `direction`; `v` itself where the direction is zero."""
    square = dot(direction, direction)
    return v - scale(dot(v, direction) / np.where(square > 0, square, 1.0), direction)


def best_normal(directions: list[Array], gap_along: GapAlong, offset: Array) -> Array:
    """The unit direction that serves best as the normal of closest points `offset` apart.

    It should point along the offset, and the gap along it should be as long as the offset is. When the offset is
    little more than rounding, its own direction fails the second wish by far; then another candidate wins.
    """
    length = norm(offset)

    def error(n: Array) -> Array:
        return (length - gap_along(n)) + norm(offset - scale(length, n))

    best, least = directions[0], error(directions[0])
    for direction in directions[1:]:
        other = error(direction)
        better = other < least
        best = np.where(better[..., None], direction, best)
        least = np.where(better, other, least)
    return best


def box_excess(y: Array, half: Array) -> Array:
    """Vector from the nearest point of the box |y_i| ≤ half_i to `y`; zero in every slab that holds `y`."""
    return y - np.clip(y, -half, half)
