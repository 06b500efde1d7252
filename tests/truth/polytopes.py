"""Signed distance of two convex polytopes in exact arithmetic, whatever their dimension.

The least h(n) = h_A(n) + h_B(−n) over unit n is found at a facet's normal, at the cross product of two edges, at right
angles to an edge and towards a corner, or from corner to corner (`tests.truth.cells`). All are tried in doubles, each
with a bound of what rounding turned it by; those that may be the least are tried exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from tests.truth.bodies import Body
from tests.truth.cells import Search, units
from tests.truth.rationals import Vector, across, cross, dot, minus, perpendicular, primitive, whole

Floats = Any
ROUNDING = 1e-12
"""More than what doubles can err by in h, relative to the scene, for a direction that is itself right."""
ULP = 2.0**-50
"""More than what rounding moves a difference of two points by, relative to the scene."""
CHUNK = 20_000


@dataclass(frozen=True)
class Family:
    """Directions of one kind: as doubles of any length, with the size of what was subtracted in them, and exactly."""

    rough: Floats  # (N, 3)
    size: Floats  # (N,)
    exact: Callable[[int], Vector]


def straight_distance(a: Body, b: Body) -> Fraction:
    """Signed square σ·|σ| of the signed distance of two polytopes without their radii."""
    numbers, unit = whole([*a.points, *b.points])
    of_a, of_b = numbers[: len(a.points)], numbers[len(a.points) :]
    squares = {_square(n, of_a, of_b) for n in _suspects(a, b) if any(n)}
    return -min(squares) / unit**2 if squares else Fraction(0)


def _square(n: Vector, of_a: list[Any], of_b: list[Any]) -> Fraction:
    """The lesser of h(n) and h(−n), times its absolute value."""
    along_a, along_b = [dot(p, n) for p in of_a], [dot(q, n) for q in of_b]
    h = min(max(along_a) - min(along_b), max(along_b) - min(along_a))
    return Fraction(h * abs(h), dot(n, n))


def _suspects(a: Body, b: Body) -> set[Vector]:
    """Exact directions, one of ±n each, among which the least h is."""
    search = Search.of(a, b)
    families = list(_families(a, b, search))
    lows, errors = [], []
    for family in families:
        length = np.linalg.norm(family.rough, axis=-1)
        known = length > 0
        n = np.where(known[:, None], family.rough, [1.0, 0.0, 0.0]) / np.where(known, length, 1.0)[:, None]
        lows.append(_lower_heights(search, n))
        errors.append(np.where(known, ULP * family.size / np.where(known, length, 1.0), np.inf))
    least = min((low.min() for low in lows if low.size), default=0.0) + ROUNDING
    found = set()
    for family, low, error in zip(families, lows, errors, strict=True):
        for i in np.flatnonzero((low - 8.0 * error <= least) | (error > 1e-3)):
            n = primitive(whole([family.exact(int(i))])[0][0])
            found.add(n if n > (0, 0, 0) else (-n[0], -n[1], -n[2]))
    return found  # type: ignore[return-value]


def _lower_heights(search: Search, n: Floats) -> Floats:
    parts = [n[i : i + CHUNK] for i in range(0, len(n), CHUNK)]
    return np.concatenate([np.zeros(0), *(np.minimum(search.height(part), search.height(-part)) for part in parts)])


def _families(a: Body, b: Body, search: Search) -> Iterator[Family]:
    normals = [n for body in (a, b) for n in body.normals]
    yield Family(units(normals), np.zeros(len(normals)), lambda i: normals[i])
    e, f = (units([edge for edge, _ in body.edges]) for body in (a, b))
    pairs = list(product(range(len(e)), range(len(f))))
    crosses = np.cross(e[:, None], f[None]).reshape(-1, 3)
    yield Family(crosses, np.ones(len(pairs)), lambda i: cross(a.edges[pairs[i][0]][0], b.edges[pairs[i][1]][0]))
    corners = list(product(range(len(a.points)), range(len(b.points))))
    steps = (search.points_a[:, None] - search.points_b[None]).reshape(-1, 3)
    yield Family(steps, np.ones(len(corners)), lambda i: minus(a.points[corners[i][0]], b.points[corners[i][1]]))
    base = a.points[0]
    for body, other, points, ways in ((a, b, search.points_b, e), (b, a, search.points_a, f)):
        starts = np.array([[float(x / search.unit) for x in minus(p, base)] for _, p in body.edges]).reshape(-1, 3)
        towards = starts[:, None] - points[None]
        feet = towards - np.sum(towards * ways[:, None], axis=-1, keepdims=True) * ways[:, None]
        yield Family(feet.reshape(-1, 3), np.ones(feet.size // 3), _foot_of(body, other))


def _foot_of(body: Body, other: Body) -> Callable[[int], Vector]:
    """Exact part of corner-to-edge at right angles to the edge; any such direction where corner and edge meet."""

    def exact(i: int) -> Vector:
        (e, p), q = body.edges[i // len(other.points)], other.points[i % len(other.points)]
        foot = across(e, minus(p, q))
        return foot if any(foot) else perpendicular(e)

    return exact
