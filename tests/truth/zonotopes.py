"""Signed distances of points, spheres, capsules and boxes, exact but for one square root.

Every core (point, segment, box) is center + Σ tᵢ·gᵢ with |tᵢ| ≤ 1. The Minkowski difference of two cores therefore is
such a set again, a zonotope of at most six generators, and the signed distance is that of the origin from it. Each tᵢ
is put at −1, free or +1 in turn, which tries every vertex, edge and facet of the difference; the one that fulfils the
exact optimality conditions is nearest, whatever the degeneracy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations, product

from refimpl.shapes import AABB, Box, Capsule, Point, Proxy, Sphere
from tests.truth.bodies import frame
from tests.truth.rationals import Vector, cross, dot, minus, number, plus, scaled, sum_product, vector


@dataclass(frozen=True)
class Core:
    """The set {center + Σ tᵢ·gᵢ, |tᵢ| ≤ 1} ⊕ ball of `radius`, in rationals; no generator is zero."""

    center: Vector
    generators: tuple[Vector, ...] = ()
    radius: Fraction = Fraction(0)


def core_of(shape: Proxy) -> Core:
    """Core and radius of a single proxy: exactly the set that its stored doubles mean."""
    match shape:
        case Point():
            return Core(vector(shape.position))
        case Sphere():
            return Core(vector(shape.center), (), number(shape.radius))
        case Capsule():
            p, q = vector(shape.p), vector(shape.q)
            half = scaled(Fraction(1, 2), minus(q, p))
            return Core(plus(p, half), (half,) if any(half) else (), number(shape.radius))
        case AABB() | Box():
            center, half_axes = frame(shape)
            return Core(center, tuple(scaled(h, axis) for axis, h in half_axes if h))
    raise TypeError(f"no core for {type(shape).__name__}")


def core_to_core(a: Core, b: Core) -> Fraction:
    c, g, unit = difference(a, b)
    depth_square = _depth_square(c, g)
    square = -depth_square if depth_square else Nearest.of(c, g).square
    return square / unit**2


def difference(a: Core, b: Core) -> tuple[Vector, list[Vector], int]:
    """Zonotope (center, generators) of the Minkowski difference A ⊖ B, in integers that count 1/unit."""
    vectors = [minus(a.center, b.center), *a.generators, *b.generators]
    unit = math.lcm(*(x.denominator for v in vectors for x in v))
    c, *g = ((int(v[0] * unit), int(v[1] * unit), int(v[2] * unit)) for v in vectors)
    return c, g, unit


def _depth_square(c: Vector, generators: list[Vector]) -> Fraction:
    """Squared depth of the origin in the zonotope; 0 if it is not in the interior.

    Two generators span each facet, so their vector products are all the directions of shortest escape.
    """
    squares = []
    for p, q in combinations(generators, 2):
        n = cross(p, q)
        if any(n):
            depth = sum(abs(dot(n, g)) for g in generators) - abs(dot(n, c))
            if depth <= 0:
                return Fraction(0)
            squares.append(Fraction(depth * depth, dot(n, n)))
    return min(squares, default=Fraction(0))


@cache
def _features(generators: int) -> list[tuple[list[int], list[int], tuple[int, ...]]]:
    """All ways to fix each tᵢ at an end or leave it free, two at most: (free, fixed, end or 0 of each)."""
    ends = [s for s in product((-1, 0, 1), repeat=generators) if s.count(0) <= 2]
    return [([i for i, e in enumerate(s) if not e], [i for i, e in enumerate(s) if e], s) for s in ends]


@dataclass(frozen=True)
class Nearest:
    """The point c + Σ tᵢ·gᵢ of a zonotope nearest to the origin, and its squared distance."""

    t: list[Fraction]
    square: Fraction

    @classmethod
    def of(cls, c: Vector, generators: list[Vector]) -> Nearest:
        """Find it, for a zonotope that does not hold the origin in its interior.

        On each feature, x is the foot of the perpendicular from the origin to its span. It is the nearest
        point if and only if all |tᵢ| ≤ 1 and moving a fixed tᵢ inwards brings nothing nearer: sᵢ (gᵢ·x) ≤ 0.
        Some feature always does both: of all t that give the nearest point, take a basic solution.
        """
        G = [[dot(p, q) for q in generators] for p in generators]
        v = [dot(g, c) for g in generators]
        for free, fixed, s in _features(len(generators)):
            det, t = _foot(G, [v[i] + sum(s[j] * G[i][j] for j in fixed) for i in free], free)
            if det == 0 or any(abs(t_i) > det for t_i in t):
                continue
            t_all = [det * e for e in s]
            for i, t_i in zip(free, t, strict=True):
                t_all[i] = t_i
            if all(s[i] * (det * v[i] + sum_product(t_all, G[i])) <= 0 for i in fixed):
                x = [det * c[k] + sum_product(t_all, [g[k] for g in generators]) for k in range(3)]
                return cls([Fraction(t_i, det) for t_i in t_all], Fraction(sum_product(x, x), det * det))
        raise AssertionError("the origin is in the interior")


def _foot(G: list[list[int]], u: list[int], free: list[int]) -> tuple[int, list[int]]:
    """Solve G t = −u for the free generators by Cramer's rule: (determinant, determinant·t)."""
    if not free:
        return 1, []
    if len(free) == 1:
        return G[free[0]][free[0]], [-u[0]]
    i, j = free
    det = G[i][i] * G[j][j] - G[i][j] * G[i][j]
    return det, [G[i][j] * u[1] - G[j][j] * u[0], G[i][j] * u[0] - G[i][i] * u[1]]
