"""Directions and points that decide the signed distance of any two convex cores, found by support points alone.

Support points are floats, put on a grid of integers that is finer than their rounding. On integers the search itself
makes no rounding errors: its simplex and its polytope are what they seem, and it ends when the bounds from both sides
are as near to each other as the support points allow. Nothing here has to be believed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from refimpl.proof.bodies import Body, Corners, Mix
from refimpl.proof.exact import Polytope, Triangle, Vertex, independent, smallest
from refimpl.proof.points import Vector, along, dot, minus, opposite

GRID = 62  # bits of the largest coordinate on the grid
NARROW = 50  # the search for the nearest points ends at an interval of 2^-50 of the scene
DEEP = 38  # the search for the depth at 2^-38, about 4e-12; that of two polytopes goes on to the facet that it ends at
STEPS = 60
VERTICES, MANY = 120, 1000  # of a polytope; where the fewer do not do, large circles of directions compete


class Meeting(NamedTuple):
    """Candidates for proofs: directions, points of A and B with their weights, and a polytope of such pairs."""

    normals: list[Vector]
    pairs: list[tuple[tuple[Vector, Mix], tuple[Vector, Mix]]]
    triangles: Sequence[Triangle] = ()
    closed: bool = True


class Grid:
    """A ⊖ B of two bodies, on integers."""

    def __init__(self, a: Body, b: Body) -> None:
        self.bodies = a, b
        self.is_flat = isinstance(a, Corners) and isinstance(b, Corners)
        self.shift = GRID - math.frexp(max(a.extent, b.extent, 5e-300))[1]
        self.reach = GRID + 1

    def support(self, n: Vector) -> Vertex:
        """Farthest a − b along n, nearly."""
        bits = max(abs(c) for c in n).bit_length()
        way = (math.ldexp(n[0], 0), n[1], n[2]) if bits < 900 else tuple(c >> (bits - 900) for c in n)
        size = max(abs(float(c)) for c in way) or 1.0
        unit = (float(way[0]) / size, float(way[1]) / size, float(way[2]) / size)
        (a, i), (b, j) = self.bodies[0].support(unit), self.bodies[1].support(opposite(unit))
        on_a, on_b = self._whole(a), self._whole(b)
        return Vertex(minus(on_a, on_b), on_a, on_b, i, j)

    def _whole(self, point: Vector) -> Vector:
        x, y, z = (round(math.ldexp(c, self.shift)) for c in point)
        return x, y, z

    def pair(self, vertices: Sequence[Vertex], weights: Sequence[int]) -> tuple[tuple[Vector, Mix], tuple[Vector, Mix]]:
        """Means of the points of A and of B in some vertices, and of which corners they are made."""
        total = sum(weights)
        unit = Fraction(2) ** -self.shift / total
        ends = []
        for points, numbers in (
            ([v.a for v in vertices], [v.i for v in vertices]),
            ([v.b for v in vertices], [v.j for v in vertices]),
        ):
            mean: Vector = (Fraction(0),) * 3
            for point, weight in zip(points, weights, strict=True):
                mean = along(mean, weight * unit, point)
            mix: dict[int, int] = {}
            for number, weight in zip(numbers, weights, strict=True):
                mix[number] = mix.get(number, 0) + weight
            ends.append((mean, [] if -1 in mix else list(mix.items())))
        return ends[0], ends[1]


def _rate(n: Vector, new: Vector) -> float:
    """n·new/‖n‖, the bound on −σ from a support point, on the grid."""
    bits = max(abs(c) for c in n).bit_length()
    n = n if bits < 400 else (n[0] >> (bits - 400), n[1] >> (bits - 400), n[2] >> (bits - 400))
    return dot(n, new) / math.sqrt(dot(n, n)) if any(n) else math.inf


def _is_short(lead: int, n: Vector, bits: int) -> bool:
    """Whether lead/‖n‖, on the grid, is no more than 2^-bits of the scene."""
    return lead <= 0 or (lead << bits) ** 2 <= dot(n, n) << 2 * GRID


def nearest(grid: Grid) -> Meeting:
    """Search for the nearest points (Gilbert, Johnson and Keerthi 1988)."""
    candidates = [grid.support((1, 0, 0))]
    best, normal = math.inf, (1, 0, 0)
    for _ in range(STEPS):
        simplex, weights, direction = smallest(candidates)
        if not any(direction):
            return Meeting([], [grid.pair(simplex, weights)])
        way = opposite(direction)
        new = grid.support(way)
        rate = _rate(way, new.y)
        if rate < best:
            best, normal = rate, way
        lead = dot(direction, minus(simplex[0].y, new.y))
        if new.y in [v.y for v in simplex] or _is_short(lead, direction, NARROW):
            break
        candidates = [*simplex, new]
    return Meeting([normal], [grid.pair(simplex, weights)])


def deepest(grid: Grid, vertices: int = VERTICES) -> Meeting:
    """Search for the nearest boundary around 0 (van den Bergen 2001)."""
    found, normal = independent(grid)
    if len(found) < 4:
        return Meeting([normal, opposite(normal)], [])
    polytope = Polytope(grid, found)
    best, way, closed = math.inf, found[0].y, False
    while len(polytope.vertices) < vertices:
        facet = polytope.nearest_facet()
        new = grid.support(facet.normal)
        rate = _rate(facet.normal, new.y)
        if rate < best:
            best, way = rate, facet.normal
        lead = dot(facet.normal, new.y) - facet.offset
        closed = _is_short(lead, facet.normal, DEEP)
        if _is_short(lead, facet.normal, NARROW if grid.is_flat else DEEP):
            break
        polytope.grow(new)
    used = {i: n for n, i in enumerate(sorted({i for corners in polytope.facets for i in corners}))}
    pairs = [grid.pair([polytope.vertices[i]], [1]) for i in used]
    triangles = [(used[i], used[j], used[k]) for i, j, k in polytope.facets]
    return Meeting([way], pairs, triangles if polytope.nearest_facet().offset > 0 else (), closed)
