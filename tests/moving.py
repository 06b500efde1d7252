"""Families of queries about moving triangles, degenerate ones above all."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

Query = tuple[list[list[Any]], list[list[Any]]]
Draw = Callable[[np.random.Generator], Query]


def _points(rng: np.random.Generator, size: int) -> list[list[Any]]:
    return rng.integers(-size, size + 1, (4, 3)).tolist()  # type: ignore[no-any-return]


def small(rng: np.random.Generator) -> Query:
    """Tiny integers: points that meet, edges without length, roots at 0, 1/2 and 1 are common."""
    return _points(rng, 1), _points(rng, 1)


def whole(rng: np.random.Generator) -> Query:
    """Small integers."""
    return _points(rng, 3), _points(rng, 3)


def generic(rng: np.random.Generator) -> Query:
    """Doubles."""
    return rng.uniform(-1, 1, (4, 3)).tolist(), rng.uniform(-1, 1, (4, 3)).tolist()


def planar(rng: np.random.Generator) -> Query:
    """All the time in one plane, which is not across an axis."""
    start, end = _points(rng, 3), _points(rng, 3)
    return [[x, y, x + y] for x, y, _ in start], [[x, y, x + y] for x, y, _ in end]


def carried(rng: np.random.Generator) -> Query:
    """All the time in one plane that moves and turns: its points' coordinates in it stay."""
    places = rng.integers(-2, 3, (4, 2))
    start, end = (places @ rng.integers(-2, 3, (2, 3)) + rng.integers(-2, 3, 3) for _ in range(2))
    return start.tolist(), end.tolist()


def in_line(rng: np.random.Generator) -> Query:
    """All the time on one line."""
    way = rng.integers(-1, 2, 3)
    return np.outer(rng.integers(-3, 4, 4), way).tolist(), np.outer(rng.integers(-3, 4, 4), way).tolist()


def collapsed(rng: np.random.Generator) -> Query:
    """One of the points is another: an edge, or a side of a face, without length, at the start or for ever."""
    start, end = _points(rng, 2), _points(rng, 2)
    i, j = rng.permutation(4)[:2]
    start[i] = start[j]
    if rng.integers(2):
        end[i] = end[j]
    return start, end


def at_rest(rng: np.random.Generator) -> Query:
    """Nothing moves, or all points move together."""
    start, way = _points(rng, 1), rng.integers(-1, 2, 3) * rng.integers(2)
    return start, (np.array(start) + way).tolist()


def thirds(rng: np.random.Generator) -> Query:
    """Rationals, which are no doubles."""
    start, end = _points(rng, 4), _points(rng, 4)
    return [[[Fraction(x, 3) for x in p] for p in q] for q in (start, end)]  # type: ignore[return-value]


def meeting(rng: np.random.Generator) -> Query:
    """The four points come to random places on one line, edge or corner at t = 1/2, and go on."""
    middle = _points(rng, 1)
    i, j, k = rng.permutation(4)[:3]
    middle[i] = [(x + y) // 2 * 1 for x, y in zip(middle[j], middle[k], strict=True)]
    ways = _points(rng, 2)
    start = [[x - w for x, w in zip(p, q, strict=True)] for p, q in zip(middle, ways, strict=True)]
    return start, [[x + w for x, w in zip(p, q, strict=True)] for p, q in zip(middle, ways, strict=True)]


def nudged(rng: np.random.Generator) -> Query:
    """Integers of which one is moved by about one unit in the last place."""
    draw = (small, whole, planar, carried, meeting)[rng.integers(5)]
    start, end = draw(rng)
    i, axis = rng.integers(4), rng.integers(3)
    start[i][axis] += float(rng.choice([-1.0, 1.0])) * math.ulp(max(abs(start[i][axis]), 0.5))
    return start, end


FAMILIES: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (small, whole, generic, planar, carried, in_line, collapsed, at_rest, thirds, meeting, nudged)
}
