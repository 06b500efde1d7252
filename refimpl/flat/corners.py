"""Corners of convex polygons, decided exactly: of the hull of points, and of the set behind lines.

Coordinates are doubles, or whole numbers: a point (x/w, y/w) as (x, y, w). The sign of a turn is taken from doubles
where their error bound allows it, else from rational numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import gcd
from typing import TypeVar

from refimpl.linear import Array
from refimpl.proxy import ShapeError
from refimpl.signs import ROUNDING, TINY, on_grid

Place = tuple[int, int, int]
"""A point (x/w, y/w) as (x, y, w), w > 0."""
Plain = tuple[float, float]
P = TypeVar("P")


def _wound(upwards: list[P], turn: Callable[[P, P, P], float]) -> list[P]:
    """Corners of the hull of points that are sorted upwards, anticlockwise, the lowest first.

    Andrew's monotone chain; de Berg et al., Computational Geometry, 1.1.
    """
    corners: list[P] = []
    for chain in (upwards, upwards[::-1]):
        side: list[P] = []
        for place in chain:
            while len(side) > 1 and turn(side[-2], side[-1], place) <= 0:
                side.pop()
            side.append(place)
        corners += side[:-1]
    return corners or upwards


def hull_of_doubles(points: list[Plain]) -> list[Plain]:
    """Corners of the hull of points, anticlockwise, the lowest first, of two lowest the left one."""
    return _wound(sorted(set(points), key=lambda p: (p[1], p[0])), _turn_of_doubles)


def _turn_of_doubles(a: Plain, b: Plain, c: Plain) -> float:
    """Positive where a, b, c turn anticlockwise, by exact sign; of numbers up to about 1."""
    left, right = (b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])
    if abs(left - right) > 8 * ROUNDING * (abs(left) + abs(right)) + TINY:
        return left - right
    u, v, w = ([Fraction(x) for x in p] for p in (a, b, c))
    exactly = (v[0] - u[0]) * (w[1] - u[1]) - (v[1] - u[1]) * (w[0] - u[0])
    return (exactly > 0) - (exactly < 0)


def wrapped(places: list[Place]) -> list[Place]:
    """Corners of the hull of points, anticlockwise, the lowest first, of two lowest the left one."""
    return _wound(sorted(set(places), key=lambda p: (Fraction(p[1], p[2]), Fraction(p[0], p[2]))), _turn)


def _turn(a: Place, b: Place, c: Place) -> int:
    """Positive where a, b, c turn anticlockwise."""
    return a[0] * (b[1] * c[2] - c[1] * b[2]) - a[1] * (b[0] * c[2] - c[0] * b[2]) + a[2] * (b[0] * c[1] - c[0] * b[1])


def way_between(a: Place, b: Place) -> tuple[int, int]:
    """Way from a to b, times a positive number."""
    return b[0] * a[2] - a[0] * b[2], b[1] * a[2] - a[1] * b[2]


def whole_lines(lines: Array) -> list[Place]:
    """Lines (m, 3) in whole numbers: each a multiple of what it was."""
    found = []
    for line in lines:
        x, y, k = on_grid(line)[0].tolist()
        found.append((x, y, k))
    return found


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
