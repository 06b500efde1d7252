"""The pieces on which the support function of a Minkowski difference is smooth, and all directions fixed by them.

σ(A, B) = −min over unit n of h(n) = h_A(n) + h_B(−n), for disjoint and for overlapping bodies alike. The normal fan of
the two hulls cuts the sphere of directions into open cells: facets fix n, edges leave an arc n ⊥ e, pairs of corners
leave a piece of the sphere. The least h lies in one of the cells and is critical there. So it is among the
critical directions of all cells, and no other direction can do harm, for h(n) is a bound whatever n is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from tests.truth.bodies import Body
from tests.truth.rationals import Vector, cross, in_floats, minus, opposite

Floats = Any


@dataclass(frozen=True)
class Cell:
    """h(n) = w·n + √(n·M_A n) + √(n·M_B n) on n ⊥ arc; everywhere when arc is None."""

    w: Vector
    arc: Vector | None = None


def cells(a: Body, b: Body) -> list[Cell]:
    """Every pair of corners, and every edge with every corner of the other."""
    found = [Cell(minus(p, q)) for p, q in product(a.points, b.points)]
    found += [Cell(minus(p, q), e) for (e, p), q in product(a.edges, b.points)]
    found += [Cell(minus(p, q), e) for p, (e, q) in product(a.points, b.edges)]
    return list(dict.fromkeys(found))


def fixed_directions(a: Body, b: Body) -> Iterator[Vector]:
    """Normals of facets of A, of B and of the facets that two edges span, and the kinks of disks; one of ±n each."""
    yield from (*a.normals, *b.normals, *a.tips, *b.tips)
    for (e, _), (f, _) in product(a.edges, b.edges):
        yield cross(e, f)


@dataclass(frozen=True)
class Search:
    """A pair in doubles, relative to a corner of A and to a length that makes the largest number about 1."""

    unit: Fraction
    points_a: Floats
    points_b: Floats
    axes_a: Floats  # (3, k): M = axes axesᵀ
    axes_b: Floats

    @classmethod
    def of(cls, a: Body, b: Body) -> Search:
        base = a.points[0]
        near, far = ([minus(p, base) for p in body.points] for body in (a, b))
        sizes = [abs(x) for p in (*near, *far) for x in p]
        sizes += [abs(Fraction(x)) for body in (a, b) for g in body.axes for x in g]
        largest = max(sizes) or Fraction(1)
        unit = Fraction(2) ** (largest.numerator.bit_length() - largest.denominator.bit_length() + 1)
        axes = [
            np.array([in_floats(g, unit) for g in (tuple(map(Fraction, g)) for g in body.axes)]).reshape(-1, 3).T
            for body in (a, b)
        ]
        return cls(
            unit, np.array([in_floats(p, unit) for p in near]), np.array([in_floats(p, unit) for p in far]), *axes
        )

    def bulges(self, n: Floats) -> tuple[Floats, Floats]:
        """√(n·M n) of A and of B."""
        return np.linalg.norm(n @ self.axes_a, axis=-1), np.linalg.norm(n @ self.axes_b, axis=-1)

    def height(self, n: Floats) -> Floats:
        """h(n) for unit vectors (..., 3)."""
        s, t = self.bulges(n)
        return np.max(n @ self.points_a.T, axis=-1) - np.min(n @ self.points_b.T, axis=-1) + s + t


def units(directions: list[Any]) -> Floats:
    """Exact directions as unit vectors in doubles, shape (len, 3)."""
    rows = []
    for n in directions:
        largest = max(abs(Fraction(x)) for x in n)
        rows.append(in_floats(n, largest))
    found = np.array(rows).reshape(-1, 3)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def both_signs(directions: list[Any]) -> list[Any]:
    return [*directions, *map(opposite, directions)]
