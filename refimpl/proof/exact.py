"""Nearest and deepest features of two proxies, searched in exact rational arithmetic.

Every bounded proxy is the hull of a few points, its core, widened by a ball. Two cores are put on one common
denominator, so that the search runs on integers and every branch is the exact sign of a determinant. So it
ends: each step comes strictly nearer to 0 or adds a vertex, and there are finitely many.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple, Protocol

from refimpl.proof.points import AXES, ZERO, Vector, along, core, cross, dot, minus, opposite, rationals, root
from refimpl.shapes import HalfSpace, Proxy

Pair = tuple[Vector, Vector]
Triangle = tuple[int, int, int]


class Features(NamedTuple):
    """What decides the signed distance of two cores.

    `normal` points from A to B; its length means nothing. Without triangles there is one pair, the nearest
    points, or one common point twice when the cores meet without depth. With triangles, the differences of
    the pairs are the vertices of a closed polytope around 0 whose nearest facet bounds A ⊖ B.
    With `directions` the pairs are directions in which the shapes are unbounded: A ⊖ B is the whole space.
    `carriers` are the vertices whose mean with `weights` the nearest pair is.
    """

    normal: Vector
    pairs: Sequence[Pair]
    triangles: Sequence[Triangle] = ()
    directions: bool = False
    carriers: Sequence[Vertex] = ()
    weights: Sequence[int] = ()


class Vertex(NamedTuple):
    """A point of A ⊖ B, the points of A and B that it is the difference of, and their numbers if they have any."""

    y: Vector
    a: Vector
    b: Vector
    i: int = -1
    j: int = -1


class Supported(Protocol):
    """A convex set that gives its farthest point along any direction, in integers of up to `reach` bits."""

    reach: int

    def support(self, n: Vector) -> Vertex:
        """Farthest point along n."""


class Difference:
    """A ⊖ B of two point sets, scaled by `unit` to integers."""

    def __init__(self, a: Sequence[Vector], b: Sequence[Vector]) -> None:
        self.unit = math.lcm(*(x.denominator for point in (*a, *b) for x in point))
        self.a, self.b = self._whole(a), self._whole(b)
        self.reach = max(abs(x) for point in (*self.a, *self.b) for x in point).bit_length()

    def _whole(self, points: Sequence[Vector]) -> list[Vector]:
        return [(int(x * self.unit), int(y * self.unit), int(z * self.unit)) for x, y, z in points]

    def support(self, n: Vector) -> Vertex:
        """Farthest a − b along n."""
        a = max(self.a, key=lambda p: dot(n, p))
        b = min(self.b, key=lambda p: dot(n, p))
        return Vertex(minus(a, b), a, b)

    def mean(self, points: Sequence[Vector], weights: Sequence[int]) -> Vector:
        """Weighted mean of scaled points, in the shapes' own units."""
        total = ZERO
        for point, weight in zip(points, weights, strict=True):
            total = along(total, weight, point)
        x, y, z = (Fraction(t, self.unit * sum(weights)) for t in total)
        return x, y, z


# ------------------------------------------------------------------------------------------ nearest


def _foot(points: Sequence[Vector]) -> tuple[Sequence[int], Vector]:
    """Foot of 0 on the flat through 1 to 4 points: weights of the points, and a multiple of it.

    The weights are all positive exactly when the points are independent and the foot lies within their hull.
    """
    match points:
        case [a]:
            return (1,), a
        case [a, b]:
            edge = minus(b, a)
            return (dot(b, edge), -dot(a, edge)), cross(edge, cross(a, edge))
        case [a, b, c]:
            n = cross(minus(b, a), minus(c, a))
            side = dot(n, a)
            weights = dot(cross(b, c), n), dot(cross(c, a), n), dot(cross(a, b), n)
            return weights, n if side > 0 else opposite(n) if side < 0 else ZERO
        case [a, b, c, d]:
            ab, cd = cross(a, b), cross(c, d)
            volumes = dot(b, cd), -dot(a, cd), dot(ab, d), -dot(ab, c)
            sign = 1 if sum(volumes) > 0 else -1
            return [sign * volume for volume in volumes], ZERO
    raise AssertionError("a simplex has 1 to 4 points")


def smallest(simplex: Sequence[Vertex]) -> tuple[list[Vertex], Sequence[int], Vector]:
    """Which vertices carry the point of a simplex nearest to 0, their weights, and that point's direction."""
    for size in range(1, len(simplex) + 1):
        for chosen in combinations(simplex, size):
            weights, direction = _foot([vertex.y for vertex in chosen])
            if min(weights) > 0:
                level = dot(direction, chosen[0].y)
                if all(dot(direction, vertex.y) >= level for vertex in simplex):
                    return list(chosen), weights, direction
    raise AssertionError("some vertices of a simplex carry its nearest point")


def nearest(difference: Difference) -> Features:
    """Nearest points of two cores and the direction between them, which is zero when they meet.

    The search of Gilbert, Johnson and Keerthi (1988), ended by the exact comparison that no support point is
    nearer to 0 than the plane through the nearest point found.
    """
    simplex = [difference.support((1, 0, 0))]
    while True:
        simplex, weights, direction = smallest(simplex)
        new = difference.support(opposite(direction))
        if dot(direction, new.y) >= dot(direction, simplex[0].y):
            on_a = difference.mean([vertex.a for vertex in simplex], weights)
            on_b = difference.mean([vertex.b for vertex in simplex], weights)
            return Features(opposite(direction), [(on_a, on_b)], carriers=simplex, weights=weights)
        simplex.append(new)


# ------------------------------------------------------------------------------------------ deepest


class _Facet(NamedTuple):
    corners: Triangle
    normal: Vector
    offset: int


def independent(difference: Supported) -> tuple[list[Vertex], Vector]:
    """Four independent support points; or fewer, and a normal of a plane that then holds all of A ⊖ B."""
    found = [difference.support((1, 0, 0))]
    ways: list[Vector] = AXES
    while len(found) < 4:
        if len(found) == 2:
            edge = minus(found[1].y, found[0].y)
            side = cross(edge, min(AXES, key=lambda axis: abs(dot(axis, edge))))
            ways = [side, cross(edge, side)]
        elif len(found) == 3:
            ways = [cross(edge, minus(found[2].y, found[0].y))]
        tried = [(n, difference.support(n)) for way in ways for n in (way, opposite(way))]
        new = [vertex for n, vertex in tried if dot(n, vertex.y) > dot(n, found[0].y)]
        if not new:
            return found, ways[0]
        found.append(new[0])
    return found, ZERO


class Polytope:
    """A convex polytope within A ⊖ B that grows by support points; its facets wait in order of distance."""

    def __init__(self, difference: Supported, tetrahedron: list[Vertex]) -> None:
        self.vertices = list(tetrahedron)
        self.facets: dict[Triangle, _Facet] = {}
        self.queue: list[tuple[int, Triangle]] = []
        self.shift = 2 * difference.reach + 140  # leaves at least 64 bits of the smallest possible distance
        base, *rest = (vertex.y for vertex in tetrahedron)
        left, right, top = (minus(y, base) for y in rest)
        upwards = dot(cross(left, right), top) > 0
        for i, j, k in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]:
            self._add((i, j, k) if upwards else (i, k, j))

    def _add(self, corners: Triangle) -> None:
        a, b, c = (self.vertices[i].y for i in corners)
        normal = cross(minus(b, a), minus(c, a))
        facet = _Facet(corners, normal, dot(normal, a))
        distance = (facet.offset << self.shift) // math.isqrt(dot(normal, normal) << 128)
        self.facets[corners] = facet
        heapq.heappush(self.queue, (distance, corners))

    def nearest_facet(self) -> _Facet:
        """Find the facet whose plane is nearest to 0; planes that 0 lies outside of come first."""
        while self.queue[0][1] not in self.facets:
            heapq.heappop(self.queue)
        return self.facets[self.queue[0][1]]

    def grow(self, new: Vertex) -> None:
        """Replace the facets that see `new` strictly by those that join their rim to it.

        A facet whose plane holds `new` stays. So the rim is never on a line with `new`: that line would lie
        in the plane of a facet that sees it strictly.
        """
        self.vertices.append(new)
        seen = [facet for facet in self.facets.values() if dot(facet.normal, new.y) > facet.offset]
        edges = {edge for i, j, k in (facet.corners for facet in seen) for edge in ((i, j), (j, k), (k, i))}
        for facet in seen:
            del self.facets[facet.corners]
        for i, j in sorted(edges):
            if (j, i) not in edges:
                self._add((i, j, len(self.vertices) - 1))


def deepest(difference: Difference, common: Features) -> Features:
    """Nearest boundary of A ⊖ B, for cores that meet in the point of `common`.

    The expanding polytope of van den Bergen (2001), with signed distances, so that it may start anywhere.
    """
    found, normal = independent(difference)
    if len(found) < 4:
        return common._replace(normal=normal)
    polytope = Polytope(difference, found)
    while True:
        facet = polytope.nearest_facet()
        new = difference.support(facet.normal)
        if dot(facet.normal, new.y) <= facet.offset:
            break
        polytope.grow(new)
    if facet.offset == 0:
        return common._replace(normal=facet.normal)
    used = {i: n for n, i in enumerate(sorted({i for corners in polytope.facets for i in corners}))}
    pairs = [(difference.mean([v.a], [1]), difference.mean([v.b], [1])) for v in (polytope.vertices[i] for i in used)]
    return Features(facet.normal, pairs, [(used[i], used[j], used[k]) for i, j, k in polytope.facets])


# -------------------------------------------------------------------------------------- half-spaces


def pyramid(half: HalfSpace, point: Vector) -> Features:
    """Nearest points, or the polytope, of a half-space and a core of which `point` is the lowest."""
    n, k = rationals(half.normal), Fraction(half.k.tolist())
    height = (dot(n, point) + k) / dot(n, n)
    foot, normal = along(point, -height, n), tuple(half.normal.tolist())
    if height >= 0:
        return Features(normal, [(foot, point)])
    side = cross(n, min(AXES, key=lambda axis: abs(dot(axis, n))))
    sides = []
    for way in (side, cross(n, side)):  # at right angles, and a little more than twice the depth long
        _, stretch = root(4 * height * height * dot(n, n) / dot(way, way), 8)
        sides.append(along(ZERO, stretch, way))
    base = [along(along(foot, u, sides[0]), v, sides[1]) for u, v in [(1, 1), (-1, 1), (-1, -1), (1, -1)]]
    apex = along(foot, 3 * height, n)  # twice the depth below 0, so that the slopes are farther than the base
    slopes = [((i + 1) % 4, i, 4) for i in range(4)]
    return Features(normal, [(corner, point) for corner in (*base, apex)], [(0, 1, 2), (0, 2, 3), *slopes])


def _whole_space(n: Vector, m: Vector) -> Features:
    """Directions out of which differences of two half-spaces that are not opposite reach everywhere."""
    bend = opposite(n) if dot(n, m) >= 0 else along(along(ZERO, -1, n), Fraction(dot(n, m), dot(m, m)), m)
    pairs = []
    for way in [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]:
        if dot(n, way) <= 0:
            pairs.append((way, ZERO))
        elif dot(m, way) >= 0:
            pairs.append((ZERO, opposite(way)))
        else:  # both recede along `bend`, which leads into the first: as far as the first needs it
            detour = along(ZERO, -dot(n, way) / dot(n, bend), bend)
            pairs.append((along(way, 1, detour), detour))
    return Features(ZERO, pairs, [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], directions=True)


def features(a: Proxy, b: Proxy) -> Features:
    """Nearest or deepest features of two proxies' cores; only `a` alone, or both, may be a `HalfSpace`."""
    if isinstance(a, HalfSpace) and isinstance(b, HalfSpace):
        n, m = rationals(a.normal), rationals(b.normal)
        if any(cross(n, m)) or dot(n, m) > 0:
            return _whole_space(n, m)
        return pyramid(a, along(ZERO, -Fraction(b.k.tolist()) / dot(m, m), m))
    if isinstance(a, HalfSpace):
        return pyramid(a, min(core(b)[0], key=lambda point: dot(rationals(a.normal), point)))
    difference = Difference(core(a)[0], core(b)[0])
    found = nearest(difference)
    return found if any(found.normal) else deepest(difference, found)
