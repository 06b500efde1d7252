"""The depth of unions of polytopes in exact arithmetic: the shortest translation out of all Minkowski differences.

A translation t of B frees it of A if and only if t lies in the interior of no A_i ⊖ B_j, the differences of their
convex parts. The nearest such t to 0 is a corner of their arrangement, or the foot of 0 on one of its edges or facets:
the foot on a plane, on the line of two planes, or the point of three. All are tried in doubles, and what may be free
and no longer than the best is decided in integers. It needs no search, no start, and nothing of what it measures.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
from mpmath import mp, mpf  # type: ignore[import-untyped]

from tests.truth.bodies import Body
from tests.truth.rationals import DIGITS, Vector, cross, dot, minus, opposite, plus, primitive, real, scaled, whole

Floats = Any
MARGIN = 1e-9
"""More than what doubles err by, relative to the scene, at the meeting of planes that are not nearly parallel."""
STEEP = 1e-5
"""Determinants below belong to planes that nearly are: then only integers count."""
CHUNK = 200_000

Place = tuple[Vector, int]
"""A point as integers over a positive integer."""


@dataclass(frozen=True)
class Arrangement:
    """Minkowski differences of all pairs of parts.

    Attributes
    ----------
    planes
        Facets (n, h) of all of them, n·x ≤ h in integers that count 1/unit.
    of
        For each difference the numbers of its planes.
    rough, level
        The planes in doubles, with unit normals, relative to `size`.
    """

    planes: list[tuple[Vector, int]]
    of: list[list[int]]
    unit: int
    rough: Floats
    level: Floats
    size: float

    @classmethod
    def between(cls, a: Sequence[Body], b: Sequence[Body]) -> Arrangement:
        numbers, unit = whole([p for body in (*a, *b) for p in body.points])
        corners, at = [], 0
        for body in (*a, *b):
            corners.append(numbers[at : at + len(body.points)])
            at += len(body.points)
        planes: dict[tuple[Vector, int], int] = {}
        of = []
        for i, one in enumerate(a):
            for j, other in enumerate(b):
                found = list(_facets(one, other, corners[i], corners[len(a) + j]))
                of.append([planes.setdefault(plane, len(planes)) for plane in found])
        normals = np.array([[float(Fraction(x, max(map(abs, n)))) for x in n] for n, _ in planes])
        lengths = np.linalg.norm(normals, axis=1)
        heights = [Fraction(h, max(map(abs, n)) * unit) for n, h in planes]
        size = float(max(map(abs, heights))) or 1.0
        level = np.array([float(h / Fraction(size)) for h in heights]) / lengths
        return cls(list(planes), of, unit, normals / lengths[:, None], level, size)

    def is_free(self, place: Place) -> bool:
        """Whether a point is in the interior of no difference, exactly."""
        x, w = place
        below = {}
        for numbers in self.of:
            for number in numbers:
                n, h = self.planes[number]
                below[number] = below.get(number, dot(n, x) < h * w)
                if not below[number]:
                    break
            else:
                return False
        return True

    def may_be_free(self, t: Floats) -> Floats:
        """Whether points (n, 3) may be free, as far as doubles tell."""
        room = self.level - t @ self.rough.T
        inside = np.zeros(len(t), dtype=bool)
        for numbers in self.of:
            inside |= room[:, numbers].min(axis=1) > MARGIN * (1.0 + np.abs(t).max(axis=1))
        return ~inside

    def meeting(self, numbers: Sequence[int]) -> Place | None:
        """The point nearest to 0 of one, two or three planes; None where they are parallel."""
        (n, h), *others = (self.planes[i] for i in numbers)
        if not others:
            return scaled(h, n), dot(n, n)
        if len(others) == 1:
            way = cross(n, others[0][0])
            others.append((way, 0))
        (m, k), (o, l) = others
        sides = cross(m, o), cross(o, n), cross(n, m)
        det = dot(n, sides[0])
        if det == 0:
            return None
        x = plus(plus(scaled(h, sides[0]), scaled(k, sides[1])), scaled(l, sides[2]))
        return (x, det) if det > 0 else (opposite(x), -det)


def _facets(a: Body, b: Body, of_a: list[Any], of_b: list[Any]) -> Iterator[tuple[Vector, int]]:
    """Planes (n, h) around A ⊖ B: at the normals of both, and across an edge of each."""
    ways = [*a.normals, *(opposite(n) for n in b.normals)]
    ways += [cross(e, f) for e, _ in a.edges for f, _ in b.edges]
    seen = set()
    for way in ways:
        if not any(way):
            continue
        n: Any = primitive(whole([way])[0][0])
        for normal in (n, opposite(n)):
            if normal in seen:
                continue
            seen.add(normal)
            along_a, along_b = [dot(normal, p) for p in of_a], [dot(normal, q) for q in of_b]
            high, low = max(along_a), min(along_b)
            flat_a = [p for p, x in zip(of_a, along_a, strict=True) if x == high]
            flat_b = [q for q, x in zip(of_b, along_b, strict=True) if x == low]
            spans = [minus(p, flat_a[0]) for p in flat_a[1:]] + [minus(q, flat_b[0]) for q in flat_b[1:]]
            if any(any(cross(u, v)) for u, v in combinations(spans, 2)):
                yield normal, high - low


def shortest_way_out(a: Sequence[Body], b: Sequence[Body]) -> tuple[mpf, Vector]:
    """Length of the shortest translation of the union of `b` after which no interiors meet, and that translation.

    Parameters
    ----------
    a, b
        Convex parts: polytopes with an inside, without radius; they may overlap or touch each other.

    Returns
    -------
    mpf, (3,) of Fraction
        The length to 60 digits; 0 where they do not overlap.
    """
    there = Arrangement.between(a, b)
    origin: Place = ((0, 0, 0), 1)
    best, where = (Fraction(0), origin) if there.is_free(origin) else (None, origin)
    for count in (1, 2, 3) if best is None or best > 0 else ():
        limit = np.inf if best is None else float(mp.sqrt(real(best / there.unit**2))) / there.size * (1 + MARGIN)
        for numbers in _suspects(there, count, limit):
            place = there.meeting(numbers)
            if place is None:
                continue
            x, w = place
            square = Fraction(dot(x, x), w * w)
            if (best is None or square < best) and there.is_free(place):
                best, where = square, place
    assert best is not None, "no way out"
    x, w = where
    with mp.workdps(DIGITS):
        length = mp.sqrt(real(best / there.unit**2))
    return length, tuple(Fraction(c, w * there.unit) for c in x)  # type: ignore[return-value]


def _suspects(there: Arrangement, count: int, limit: float) -> list[tuple[int, ...]]:
    """Planes whose meeting may be free and nearer to 0 than `limit`, the nearest first."""
    total = len(there.planes)
    near = [i for i in range(total) if abs(there.level[i]) <= limit]
    sets = np.array(list(combinations(near, count)), dtype=np.int64).reshape(-1, count)
    found: list[tuple[float, tuple[int, ...]]] = []
    for start in range(0, len(sets), CHUNK):
        some = sets[start : start + CHUNK]
        t, det = _meetings(there.rough[some], there.level[some])
        doubtful = np.abs(det) < STEEP
        length = np.where(doubtful, 0.0, np.linalg.norm(t, axis=1))
        keep = np.flatnonzero(length <= limit)
        keep = keep[doubtful[keep] | there.may_be_free(np.where(doubtful[keep, None], 0.0, t[keep]))]
        found += [(float(length[i]), tuple(some[i].tolist())) for i in keep if det[i] or count == 1]
    return [numbers for _, numbers in sorted(found)]


def _meetings(n: Floats, level: Floats) -> tuple[Floats, Floats]:
    """Points of planes (s, count, 3) that are nearest to 0, and determinants that say how surely they meet."""
    if n.shape[1] == 1:
        return n[:, 0] * level, np.ones(len(n))
    if n.shape[1] == 2:
        way = np.cross(n[:, 0], n[:, 1])
        n = np.concatenate([n, way[:, None]], axis=1)
        level = np.concatenate([level, np.zeros((len(n), 1))], axis=1)
    sides = np.cross(n[:, [1, 2, 0]], n[:, [2, 0, 1]])
    det = np.sum(n[:, 0] * sides[:, 0], axis=1)
    safe = np.where(det == 0, 1.0, det)
    return np.sum(level[:, :, None] * sides, axis=1) / safe[:, None], det
