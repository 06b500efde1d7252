"""Corners, edges and facets of convex polytopes in exact arithmetic, by the double description method.

Fukuda and Prodon, Double Description Method Revisited (1996). A polytope is a cone of homogeneous points
(x, y, z, w), and planes cut it one by one. Two corners share an edge if and only if no third one lies on all the
planes that both lie on. The hull of points is the same problem for the polar body.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

from tests.truth.rationals import Vector, cross, dot, minus, opposite, plus, primitive, scaled, whole

Homogeneous = tuple[int, ...]
Plane = tuple[Any, Any, Any, Any]  # (n, k): n·x + k ≤ 0


@dataclass(frozen=True)
class Hull:
    """A convex polytope of any dimension: exact corners, pairs of them that share an edge, and planes (n, k)."""

    corners: tuple[Vector, ...]
    edges: tuple[tuple[int, int], ...]
    planes: tuple[Plane, ...]


def hull_of_planes(planes: Iterable[Plane]) -> Hull:
    """Intersect half-spaces n·x + k ≤ 0; the set must be bounded and not empty, and may be flat."""
    rows = [primitive(whole([plane])[0][0]) for plane in dict.fromkeys(map(tuple, planes))]
    rays = _cut_cone([row for row in rows if any(row[:3])])
    assert rays, "empty"
    assert all(ray[3] > 0 for ray in rays), "unbounded"
    corners = tuple((Fraction(x, w), Fraction(y, w), Fraction(z, w)) for x, y, z, w in rays)
    return Hull(corners, tuple(_adjacent(list(rays.values()))), tuple((*row[:3], row[3]) for row in rows))


def hull_of_points(points: Iterable[Vector]) -> Hull:
    """Convex hull of points, of which some may be equal, or all on one plane or line."""
    distinct = list(dict.fromkeys(points))
    base = distinct[0]
    spans = [minus(p, base) for p in distinct]
    line = next((v for v in spans if any(v)), None)
    if line is None:
        return Hull((base,), (), ())
    normal = next((n for v in spans if any(n := cross(line, v))), None)
    if normal is None:
        along = sorted(distinct, key=lambda p: dot(line, p))
        return Hull((along[0], along[-1]), ((0, 1),), ())
    if any(dot(normal, v) for v in spans):
        return _solid_hull(distinct)
    return _flat_hull(distinct, normal)


def _solid_hull(points: list[Vector]) -> Hull:
    """Hull of points that are not all on one plane: the corners of the polar body are its facets."""
    total = points[0]
    for p in points[1:]:
        total = plus(total, p)
    center = scaled(Fraction(1, len(points)), total)
    polar = _cut_cone([primitive(whole([(*minus(p, center), -1)])[0][0]) for p in points])
    touching = [sum(1 << f for f, mask in enumerate(polar.values()) if mask >> i & 1) for i in range(len(points))]
    extreme = [
        i
        for i, mine in enumerate(touching)
        if mine and not any(mine & t == mine for j, t in enumerate(touching) if j != i)
    ]
    corners = tuple(points[i] for i in extreme)
    planes = tuple((*y[:3], -dot(y[:3], center) - y[3]) for y in polar)
    return Hull(corners, tuple(_adjacent([touching[i] for i in extreme])), planes)


def _flat_hull(points: list[Vector], normal: Vector) -> Hull:
    """Hull of points on one plane: what is left of a double pyramid without its two tips."""
    total = points[0]
    for p in points[1:]:
        total = plus(total, p)
    center = scaled(Fraction(1, len(points)), total)
    tips = (plus(center, normal), minus(center, normal))
    solid = _solid_hull([*points, *tips])
    kept = [i for i, p in enumerate(solid.corners) if p not in tips]
    edges = tuple((kept.index(i), kept.index(j)) for i, j in solid.edges if i in kept and j in kept)
    corners = tuple(solid.corners[i] for i in kept)
    sides = []
    for i, j in edges:  # planes through the edges, at right angles to the polygon
        outward = cross(minus(corners[j], corners[i]), normal)
        outward = outward if dot(outward, minus(corners[i], center)) > 0 else opposite(outward)
        sides.append((*outward, -dot(outward, corners[i])))
    level = dot(normal, center)
    return Hull(corners, edges, ((*normal, -level), (*opposite(normal), level), *sides))


def _cut_cone(rows: Sequence[Homogeneous]) -> dict[Homogeneous, int]:
    """Extreme rays of {x : row·x ≤ 0 for all rows, w ≥ 0}, each with the bits of the rows that it lies on."""
    first = _independent(rows)
    a, b, c = (rows[i] for i in first)
    outer = 1 << len(rows)  # the bit of w ≥ 0
    tip = _meeting(a, b, c)
    rays = {tip: sum(1 << i for i in first)}
    for one, j, k in ((a, 1, 2), (b, 2, 0), (c, 0, 1)):
        way = cross(rows[first[j]][:3], rows[first[k]][:3])  # type: ignore[arg-type]
        way = opposite(way) if dot(one[:3], way) > 0 else way  # type: ignore[arg-type]
        rays[primitive((*way, 0))] = outer | 1 << first[j] | 1 << first[k]
    for index, row in enumerate(rows):
        if index not in first:
            rays = _cut(rays, row, 1 << index)
    return rays


def _cut(rays: dict[Homogeneous, int], row: Homogeneous, bit: int) -> dict[Homogeneous, int]:
    """Rays of the cone that is left below one more plane."""
    heights = {ray: sum(x * y for x, y in zip(row, ray, strict=True)) for ray in rays}
    kept = {ray: mask | bit if heights[ray] == 0 else mask for ray, mask in rays.items() if heights[ray] <= 0}
    above = [ray for ray in rays if heights[ray] > 0]
    masks = list(rays.values())
    for low in [ray for ray in rays if heights[ray] < 0]:
        for high in above:
            common = rays[low] & rays[high]
            if common.bit_count() >= 2 and sum(mask & common == common for mask in masks) == 2:
                new = primitive([heights[high] * x - heights[low] * y for x, y in zip(low, high, strict=True)])
                kept[new] = kept.get(new, 0) | common | bit
    return kept


def _adjacent(masks: list[int]) -> list[tuple[int, int]]:
    """Pairs that no third one shares everything with."""
    pairs = []
    for i, j in combinations(range(len(masks)), 2):
        common = masks[i] & masks[j]
        if common.bit_count() >= 2 and sum(mask & common == common for mask in masks) == 2:
            pairs.append((i, j))
    return pairs


def _independent(rows: Sequence[Homogeneous]) -> tuple[int, int, int]:
    """Three planes that meet in a point."""
    normals: list[Any] = [row[:3] for row in rows]
    for i, n in enumerate(normals[1:], 1):
        axis = cross(normals[0], n)
        if any(axis):
            for j, m in enumerate(normals):
                if dot(axis, m):
                    return 0, i, j
    raise AssertionError("unbounded")


def _meeting(a: Homogeneous, b: Homogeneous, c: Homogeneous) -> Homogeneous:
    """The point in which three planes meet, by Cramer's rule."""
    bc, ca, ab = (cross(p[:3], q[:3]) for p, q in ((b, c), (c, a), (a, b)))  # type: ignore[arg-type]
    determinant = dot(a[:3], bc)  # type: ignore[arg-type]
    numerator = plus(plus(scaled(-a[3], bc), scaled(-b[3], ca)), scaled(-c[3], ab))
    sign = 1 if determinant > 0 else -1
    return primitive((*scaled(sign, numerator), sign * determinant))
