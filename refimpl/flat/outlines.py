"""Outlines of convex polygons, derived exactly: their corners and sides, anticlockwise.

Whether a point is a corner, or a line redundant, is decided in whole numbers; only the corners and the directions of
the sides that come out are rounded, each to the nearest doubles. Polygons that are given by their corners in order, as
most are, need no exact numbers where an error bound says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import gcd
from typing import Any, Self

import numpy as np

from refimpl.cones import nearest_doubles
from refimpl.derived import repeats
from refimpl.linear import Array, Bools, largest, norm, power_of_two
from refimpl.proxy import ShapeError, shifted
from refimpl.signs import ROUNDING, TINY, on_grid

Place = tuple[int, int, int]
"""A point (x/w, y/w) as (x, y, w), w > 0."""
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


# ------------------------------------------------------------------------------------ in whole numbers


def _turn(a: Place, b: Place, c: Place) -> int:
    """Positive where a, b, c turn anticlockwise."""
    return a[0] * (b[1] * c[2] - c[1] * b[2]) - a[1] * (b[0] * c[2] - c[0] * b[2]) + a[2] * (b[0] * c[1] - c[0] * b[1])


def _before(a: Place, b: Place) -> tuple[int, int]:
    """Way from a to b, times a positive number."""
    return b[0] * a[2] - a[0] * b[2], b[1] * a[2] - a[1] * b[2]


def wrapped(places: list[Place]) -> list[Place]:
    """Corners of the hull of points, anticlockwise, the lowest first (de Berg et al., Computational Geometry, 1.1)."""
    upwards = sorted(set(places), key=lambda p: (Fraction(p[1], p[2]), Fraction(p[0], p[2])))
    corners: list[Place] = []
    for chain in (upwards, upwards[::-1]):
        side: list[Place] = []
        for place in chain:
            while len(side) > 1 and _turn(side[-2], side[-1], place) <= 0:
                side.pop()
            side.append(place)
        corners += side[:-1]
    return corners or upwards


def clipped(lines: list[Place]) -> list[Place]:
    """Points that are corners, or on the sides, of the set n_x x + n_y y + k ≤ 0 for every line (n_x, n_y, k).

    A square that is large enough for all corners is cut by one line after the other (Sutherland and Hodgman 1974).

    Raises
    ------
    ShapeError
        Where the set is empty or unbounded.
    """
    reach = 2 * max(abs(k) for _, _, k in lines) * max(max(abs(x), abs(y)) for x, y, _ in lines) + 1
    places: list[Place] = [(-reach, -reach, 1), (reach, -reach, 1), (reach, reach, 1), (-reach, reach, 1)]
    for n_x, n_y, k in lines:
        heights = [n_x * x + n_y * y + k * w for x, y, w in places]
        kept: list[Place] = []
        for i, (place, height) in enumerate(zip(places, heights, strict=True)):
            before, level = places[i - 1], heights[i - 1]
            if (height < 0 < level) or (level < 0 < height):
                kept.append(_between(before, abs(height), place, abs(level)))
            if height <= 0:
                kept.append(place)
        places = kept
    if not places:
        raise ShapeError("no point lies behind all lines: the set is empty")
    for n_x, n_y, _ in lines:
        for x, y in ((-n_y, n_x), (n_y, -n_x)):
            if all(m_x * x + m_y * y <= 0 for m_x, m_y, _ in lines):
                size = max(abs(x), abs(y))
                raise ShapeError(f"the set is unbounded along {(x / size, y / size)}")
    return places


def _between(a: Place, share: int, b: Place, rest: int) -> Place:
    """The point where a line meets the edge ab, above and below which a and b are by `rest` and `share`."""
    x, y, w = (share * p + rest * q for p, q in zip(a, b, strict=True))
    common = gcd(x, y, w)
    return x // common, y // common, w // common


def _rounded(corners: list[Place], exponent: int) -> Outline:
    """Nearest doubles of corners that count in units of 2^exponent, and unit normals of their sides."""
    try:
        places = np.array([(x / w, y / w) for x, y, w in corners])
    except OverflowError:
        raise ShapeError("a corner lies beyond the largest float") from None
    normals = np.zeros((len(corners), 2))
    for i in range(len(corners) if len(corners) > 1 else 0):
        x, y = _before(corners[i], corners[(i + 1) % len(corners)])
        normals[i] = nearest_doubles((y, -x))
    sizes = norm(normals)
    with np.errstate(over="ignore"):
        return Outline(np.ldexp(places, exponent), normals / np.where(sizes > 0, sizes, 1.0)[:, None] + 0.0)


@lru_cache(maxsize=KEPT)
def _exact(content: bytes, width: int) -> Outline:
    """Outline of one polygon, which is named by the bytes of its numbers."""
    numbers = np.frombuffer(content).reshape(-1, width)
    if width == 2:
        grid, exponent = on_grid(numbers)
        return _rounded(wrapped([(x, y, 1) for x, y in grid.tolist()]), exponent)
    lines = [tuple(on_grid(line)[0].tolist()) for line in numbers]
    return _rounded(wrapped(clipped(lines)), 0)


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
    way = np.roll(corners, -1, axis=1) - corners
    outward = np.stack([way[..., 1], -way[..., 0]], axis=-1)
    sizes = norm(outward)
    return Outline(corners, outward / np.where(sizes > 0, sizes, 1.0)[..., None] + 0.0), np.all(
        sure, axis=1
    ) & once & same


def _of_batch(numbers: Array, batch: tuple[int, ...]) -> Outline:
    """Outlines of polygons (g, m, w), where an order is certain from doubles, else from whole numbers."""
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
        return _exact(numbers.tobytes(), numbers.shape[-1])
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
