"""Nearest points: on a segment, on a box, and along a segment towards a box."""

from __future__ import annotations

from collections.abc import Callable, Iterator

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


def widest(directions: list[Array], gap_along: GapAlong) -> tuple[Array, Array]:
    """The unit direction, with its sign, along which the gap is largest, and that gap.

    The signed distance of convex sets is the largest gap over all directions (van den Bergen, Collision
    Detection in Interactive 3D Environments, 2.3). So of several candidates for the normal, each marred by
    rounding in its own way, the one with the largest gap is nearest to the truth.
    """
    best, gap = directions[0], gap_along(directions[0])
    for direction in directions[1:]:
        other = gap_along(direction)
        better = other > gap
        best = np.where(better[..., None], direction, best)
        gap = np.where(better, other, gap)
    return best, gap


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


def parameter_towards_box(start: Array, step: Array, half: Array) -> Array:
    """Parameter t in [0, 1] at which start + t·step is nearest to the box |y_i| ≤ half_i.

    The squared distance is convex and quadratic between the times at which the line enters and leaves the three
    slabs. Seven intervals start at 0 and at those six times; each one's minimum is the mean of the times of the
    slabs outside of which it lies, weighted by step_i². Taking the best of the seven by the distance itself
    needs no sorting, and no rounding can mislead it by more than it costs in distance; a last step puts the
    foot exactly where the chosen slabs say.
    """
    # Coordinates one by one, and the seven intervals in front: so numpy's inner loops run over the whole batch.
    enters, leaves, sides = [], [], []
    for x, d, h in _coordinates(start, step, half):
        side = np.where(d > 0, h, -h)
        speed = np.where(d != 0, d, 1.0)
        with np.errstate(over="ignore"):
            enters.append(np.where(d != 0, (-side - x) / speed, -np.inf))
            leaves.append(np.where(d != 0, (side - x) / speed, np.inf))
        sides.append(side)
    begins = np.clip(np.stack([np.zeros_like(enters[0]), *enters, *leaves]), 0.0, 1.0)
    slope, way = np.zeros_like(begins), np.zeros_like(begins)
    for (x, d, _), enter, leave, side in zip(_coordinates(start, step, half), enters, leaves, sides, strict=True):
        after = begins >= leave
        slope += np.where(after | (begins < enter), d * d, 0.0)
        way += np.where(after, d * (side - x), np.where(begins < enter, d * (-side - x), 0.0))
    with np.errstate(over="ignore"):
        t = np.where(slope > 0, way / np.where(slope > 0, slope, 1.0), begins)
    t = np.clip(t, 0.0, 1.0)
    square = np.zeros_like(t)
    for x, d, h in _coordinates(start, step, half):
        beyond = np.maximum(np.abs(x + t * d) - h, 0.0)
        square += beyond * beyond
    best, least = t[0], square[0]
    for other, its_square in zip(t[1:], square[1:], strict=True):
        nearer = its_square < least
        best, least = np.where(nearer, other, best), np.where(nearer, its_square, least)
    return _settled(best, start, step, half)


def _coordinates(*vectors: Array) -> Iterator[tuple[Array, ...]]:
    """The x, the y and the z coordinates of all the vectors, each in memory of its own."""
    for i in range(3):
        yield tuple(np.ascontiguousarray(v[..., i]) for v in vectors)


def _settled(t: Array, start: Array, step: Array, half: Array) -> Array:
    """Newton's step within the slabs that count at `t`; kept where the same slabs count afterwards."""
    excess = box_excess(start + scale(t, step), half)
    active = np.where(excess != 0, step, 0.0)
    slope = dot(active, active)
    better = np.clip(t - dot(excess, active) / np.where(slope > 0, slope, 1.0), 0.0, 1.0)
    after = box_excess(start + scale(better, step), half)
    same = np.all(np.sign(after) == np.sign(excess), axis=-1)
    return np.where(same, better, t)


def box_excess(y: Array, half: Array) -> Array:
    """Vector from the nearest point of the box |y_i| ≤ half_i to `y`; zero in every slab that holds `y`."""
    return y - np.clip(y, -half, half)
