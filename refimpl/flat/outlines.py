"""Outlines of convex polygons, derived exactly: their corners and sides, anticlockwise.

Whether a point is a corner, or a line redundant, is decided exactly (`refimpl.flat.corners`); only the corners of lines
and the directions of the sides are rounded, each to the nearest doubles. Of polygons that are given by their corners in
order, as most are, a whole batch is taken at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Self

import numpy as np

from refimpl.cones import nearest_doubles
from refimpl.derived import repeats
from refimpl.flat.corners import clipped, hull_of_doubles, way_between, whole_lines, wrapped
from refimpl.linear import Array, Bools, largest, norm, power_of_two
from refimpl.proxy import ShapeError, shifted
from refimpl.signs import ROUNDING, TINY

KEPT = 4096


@dataclass(frozen=True, eq=False)
class Outline:
    """Corners and sides of the polygons of a batch.

    Attributes
    ----------
    corners : (..., m, 2)
        Anticlockwise, the lowest first, and of two lowest the left one. Polygons of a batch that have fewer corners
        than others repeat their first one at the end.
    normals : (..., m, 2)
        Outward unit normal of the side from each corner to the next; zero where a corner repeats, and for a point. A
        segment has two sides, there and back.
    """

    corners: Array
    normals: Array

    def mapped(self, change: Callable[[Any, int], Any]) -> Self:
        """Apply one change of batch axes."""
        return type(self)(change(self.corners, 2), change(self.normals, 2))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent."""
        corners = shifted(self.corners, exponent, 2)
        return type(self)(corners, np.broadcast_to(self.normals, corners.shape))


def _of_lines(lines: Array) -> Outline:
    """Outline of one polygon given by lines (m, 3), whose doubles are kept."""
    return _kept(lines.tobytes())


@lru_cache(maxsize=KEPT)
def _kept(content: bytes) -> Outline:
    corners = wrapped(clipped(whole_lines(np.frombuffer(content).reshape(-1, 3))))
    try:
        places = np.array([(x / w, y / w) for x, y, w in corners])
    except OverflowError:
        raise ShapeError("a corner lies beyond the largest float") from None
    normals = np.zeros((len(corners), 2))
    for i in range(len(corners) if len(corners) > 1 else 0):
        x, y = way_between(corners[i], corners[(i + 1) % len(corners)])
        normals[i] = nearest_doubles((y, -x))
    return Outline(places, _units(normals))


def _of_vertices(vertices: Array) -> Outline:
    """Outline of the hull of points (m, 2)."""
    x, y = vertices.T.tolist()
    corners = np.array(hull_of_doubles(list(zip(x, y, strict=True))))
    return Outline(corners, _outward(corners))


def _outward(corners: Array) -> Array:
    """Outward unit normals of the sides from each corner (..., m, 2) to the next."""
    way = np.roll(corners, -1, axis=-2) - corners
    return _units(np.stack([way[..., 1], -way[..., 0]], axis=-1))


def _units(v: Array) -> Array:
    """Vectors of length 1, or 0."""
    sizes = norm(v)
    return np.asarray(v / np.where(sizes > 0, sizes, 1.0)[..., None] + 0.0)


# --------------------------------------------------------------------------------------- in batches


def _in_order(vertices: Array) -> tuple[Outline, Bools]:
    """Outlines of polygons (g, m, 2) as if their vertices were corners in order; and of which that is certain.

    They are where all turns are to one side, by more than rounding, and the sides change between up and down only
    twice: then they go around once.
    """
    after = np.roll(vertices, -1, axis=1)
    side, following = after - vertices, np.roll(after, -1, axis=1) - after
    left, right = side[..., 0] * following[..., 1], side[..., 1] * following[..., 0]
    turn = left - right
    sure = np.abs(turn) > 16 * ROUNDING * (np.abs(left) + np.abs(right)) + TINY
    rises = (side[..., 1] > 0) | ((side[..., 1] == 0) & (side[..., 0] > 0))
    once = np.sum(rises != np.roll(rises, -1, axis=1), axis=1) == 2
    same = np.all(turn > 0, axis=1) | np.all(turn < 0, axis=1)
    clockwise = turn[:, 0] < 0
    ordered = np.where(clockwise[:, None, None], vertices[:, ::-1], vertices)
    lowest = np.min(ordered[..., 1], axis=1, keepdims=True)
    first = np.argmin(np.where(ordered[..., 1] == lowest, ordered[..., 0], np.inf), axis=1)
    index = (first[:, None] + np.arange(ordered.shape[1])) % ordered.shape[1]
    corners = np.take_along_axis(ordered, index[..., None], axis=1)
    return Outline(corners, _outward(corners)), np.all(sure, axis=1) & once & same


def _of_batch(numbers: Array, batch: tuple[int, ...]) -> Outline:
    """Outlines of polygons (g, m, w), where an order is certain from doubles, else one by one."""
    count, rows, width = numbers.shape
    done = np.zeros(count, dtype=bool)
    corners = normals = np.zeros((count, 1, 2))
    if width == 2 and rows > 2:
        found, done = _in_order(numbers)
        corners, normals = found.corners, found.normals
    if not done.all():
        others = {int(i): _exact_at(numbers[i], np.unravel_index(i, batch)) for i in np.flatnonzero(~done)}
        longest = max(*(len(o.corners) for o in others.values()), corners.shape[1] if done.any() else 1)
        corners, normals = _longer(corners, longest, repeat=True), _longer(normals, longest, repeat=False)
        for i, outline in others.items():
            corners[i] = _longer(outline.corners[None], longest, repeat=True)[0]
            normals[i] = _longer(outline.normals[None], longest, repeat=False)[0]
    return Outline(corners.reshape((*batch, *corners.shape[1:])), normals.reshape((*batch, *normals.shape[1:])))


def _exact_at(numbers: Array, where: Any) -> Outline:
    try:
        return _of_lines(numbers) if numbers.shape[-1] == 3 else _of_vertices(numbers)
    except ShapeError as error:
        at = f", at index {tuple(int(i) for i in where)}" if len(where) else ""
        raise ShapeError(f"{error}{at}") from None


def _longer(rows: Array, count: int, *, repeat: bool) -> Array:
    """Lists (g, m, 2) of `count` items: the first one again, or zeros, at the end; or without such."""
    made = np.zeros((len(rows), count, 2))
    if repeat:
        made[:] = rows[:, :1]
    kept = min(count, rows.shape[1])
    made[:, :kept] = rows[:, :kept]
    return made


def outline_of_vertices(vertices: Array) -> Outline:
    """Outlines of the hulls of points (..., m, 2), of which any may be equal or collinear."""
    if repeats(vertices, 2):
        return _repeated(outline_of_vertices(vertices[(0,) * (vertices.ndim - 2)]), vertices.shape[:-2])
    batch = vertices.shape[:-2]
    size = power_of_two(np.max(np.abs(vertices), axis=(-2, -1), initial=0.0))
    level = shifted(vertices, -size, 2).reshape((-1, *vertices.shape[-2:]))
    return _of_batch(level, batch).times_power(size)


def outline_of_lines(lines: Array) -> Outline:
    """Outlines of the sets behind all lines (..., m, 3), n·x + k ≤ 0, with normals of any non-zero length.

    Raises
    ------
    ShapeError
        Where a set is empty or unbounded: which of the two, and where in the batch.
    """
    if repeats(lines, 2):
        return _repeated(outline_of_lines(lines[(0,) * (lines.ndim - 2)]), lines.shape[:-2])
    own = power_of_two(largest(lines[..., :2]))
    with np.errstate(over="ignore"):
        offsets = np.ldexp(lines[..., 2], -own)
    if not np.all(np.isfinite(offsets)):
        raise ShapeError("a line lies beyond the largest float")
    size = power_of_two(np.max(np.abs(offsets), axis=-1, initial=0.0))
    level = np.concatenate([shifted(lines[..., :2], -own, 1), shifted(offsets, -size, 1)[..., None]], axis=-1)
    found = _of_batch(level.reshape((-1, *lines.shape[-2:])), lines.shape[:-2])
    with np.errstate(over="ignore"):
        found = found.times_power(size)
    if not np.all(np.isfinite(found.corners)):
        raise ShapeError("a corner lies beyond the largest float")
    return found


def _repeated(found: Outline, batch: tuple[int, ...]) -> Outline:
    return found.mapped(lambda a, ends: np.broadcast_to(a, (*batch, *a.shape[a.ndim - ends :])))
