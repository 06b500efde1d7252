"""Which features of two bodies meet, guessed from a few support points, and the best direction that follows.

A search leaves three support points of each body. Equal ones mean a vertex; two different ones an edge; points on both
caps of a cylinder its side. Were the guess the whole truth, the direction of the greatest gap would follow from it to
the last digits (`newton.climb`). So it is tried, and believed only as far as the gap g(n) that it really has.
"""

from __future__ import annotations

import math

from . import kernel
from .bodies import AXES, CENTER, COUNT, CYLINDER, ELLIPSOID, HULL, KIND, SIZES, VERTICES, Row, support, three
from .newton import ZERO, Feature, climb, gap_of
from .vectors import Vector, along, cross, dot, length, minus, opposite, times, unit_or, without

Points = tuple[Vector, Vector, Vector]
Polished = tuple[float, Vector, float, float, float]
NEARLY_PARALLEL = 1e-4
"""Squared sine of the angle between two edges below which they may meet at an end, not where they cross."""


@kernel
def gap_along(a: Row, b: Row, n: Vector) -> float:
    """Gap g(n) of two bodies, as they are, along a unit direction."""
    return dot(minus(support(b, opposite(n)), support(a, n)), n)


@kernel
def same(u: Vector, v: Vector) -> bool:
    """Whether two points are equal."""
    return u[0] == v[0] and u[1] == v[1] and u[2] == v[2]


@kernel
def straight(x: Points) -> tuple[Vector, Vector]:
    """Edge of a hull that three of its vertices span, as the way from the first to another one, or normal of a face.

    Zero for what they do not span.
    """
    step, other = minus(x[1], x[0]), minus(x[2], x[0])
    if same(x[0], x[1]):
        return other, ZERO
    if same(x[0], x[2]) or same(x[1], x[2]):
        return step, ZERO
    normal = cross(step, other)
    if dot(normal, normal) <= 1e-24 * dot(step, step) * dot(other, other):
        return step, ZERO
    return ZERO, normal


@kernel
def cap_of(row: Row, x: Vector) -> float:
    """On which cap of a cylinder a point lies: 1 for the one that its axis points to, −1 for the other."""
    return 1.0 if dot(minus(x, three(row, CENTER)), three(row, AXES + 6)) > 0.0 else -1.0


@kernel
def feature(row: Row, x: Points) -> tuple[Feature, Vector]:
    """Feature of a body at which three support points lie, and the normal of a face of a hull, or zero."""
    center = three(row, CENTER)
    u, v, w = three(row, AXES), three(row, AXES + 3), three(row, AXES + 6)
    sizes = three(row, SIZES)
    if row[KIND] == HULL:
        edge, normal = straight(x)
        return (x[0], u, v, w, ZERO, edge), normal
    if row[KIND] == CYLINDER:
        radii = (sizes[0], sizes[0], 0.0)
        caps = cap_of(row, x[0]), cap_of(row, x[1]), cap_of(row, x[2])
        if caps[0] != caps[1] or caps[0] != caps[2]:
            return (center, u, v, w, radii, times(-2.0 * caps[0] * sizes[2], w)), ZERO
        return (along(center, caps[0] * sizes[2], w), u, v, w, radii, ZERO), ZERO
    return (center, u, v, w, sizes, ZERO), ZERO


@kernel
def moved(row: Row, x: Vector, n: Vector) -> Vector:
    """Support point along `n` on the same feature as the support point x."""
    if row[KIND] == ELLIPSOID:
        return support(row, n)
    if row[KIND] == CYLINDER:
        axis = three(row, AXES + 6)
        sideways = unit_or(without(n, axis), ZERO)
        if dot(sideways, sideways) > 0.0:
            cap = along(three(row, CENTER), cap_of(row, x) * row[SIZES + 2], axis)
            return along(cap, row[SIZES], sideways)
    return x


@kernel
def across(e: Vector, f: Vector, n: Vector) -> Vector:
    """Unit vector at right angles to two directions, on the side of `n`; zero if they are parallel."""
    e, f = unit_or(e, ZERO), unit_or(f, ZERO)
    normal = unit_or(cross(e, without(f, e)), ZERO)
    for _ in range(2):
        normal = without(without(normal, e), f)
    side = -1.0 if dot(normal, n) < 0.0 else 1.0
    return unit_or(times(side, normal), ZERO)


@kernel
def guess(f: Feature, normal_f: Vector, g: Feature, normal_g: Vector, n: Vector) -> tuple[Vector, float]:
    """Direction near `n` in which two features have their greatest gap, and the gap that it would be."""
    for normal in (normal_f, normal_g):
        if dot(normal, normal) > 0.0:
            side = -1.0 if dot(normal, n) < 0.0 else 1.0
            found = unit_or(times(side, normal), n)
            return found, gap_of(f, g, found)
    if dot(f[5], f[5]) > 0.0 and dot(g[5], g[5]) > 0.0:
        normal = across(f[5], g[5], n)
        if dot(normal, normal) > 0.0:
            return normal, gap_of(f, g, normal)
    edge = f[5] if dot(f[5], f[5]) > 0.0 else g[5]
    edge = unit_or(edge, ZERO)
    found = climb(f, g, unit_or(without(n, edge), n), edge)
    return found, gap_of(f, g, found)


@kernel
def better_along(a: Row, b: Row, n: Vector, best: float, direction: Vector) -> tuple[float, Vector]:
    """Greater gap of that along `n` and the best one so far, and its direction."""
    gap = gap_along(a, b, n)
    return (gap, n) if gap > best else (best, direction)


@kernel
def along_edges(rest: Vector, e: Vector, f: Vector, n: Vector) -> Vector:
    """What is left of a vector across n when the best s·e − t·f is taken off it, 0 ≤ s, t ≤ 1, for edges e and f.

    Infinite when some s or t would have to lie outside. One of the edges, or both, may be zero, or both parallel.
    """
    ee, ff = dot(e, e), dot(f, f)
    area = dot(cross(e, f), n)
    if area * area > 1e-20 * ee * ff:
        s, t = dot(cross(rest, f), n) / area, dot(cross(rest, e), n) / area
        if s < 0.0 or s > 1.0 or t < 0.0 or t > 1.0:
            return (math.inf, math.inf, math.inf)
        return along(along(rest, -s, e), t, f)
    longer = e if ee >= ff else f
    square = dot(longer, longer)
    if square == 0.0:
        return rest
    here, first, second = dot(rest, longer) / square, dot(e, longer) / square, -dot(f, longer) / square
    if here < min(first, 0.0) + min(second, 0.0) or here > max(first, 0.0) + max(second, 0.0):
        return (math.inf, math.inf, math.inf)
    return along(rest, -here, longer)


@kernel
def attempt(a: Row, b: Row, x: Points, y: Points, n: Vector) -> Polished:
    """Give what `polish` does, for the features exactly as three support points of each body show them."""
    (f, normal_f), (g, normal_g) = feature(a, x), feature(b, y)
    found, promised = guess(f, normal_f, g, normal_g, n)
    gap = gap_along(a, b, found)
    began, rest = math.inf, math.inf
    if dot(normal_f, normal_f) == 0.0 and dot(normal_g, normal_g) == 0.0:
        offset = minus(moved(b, y[0], opposite(found)), moved(a, x[0], found))
        rest = length(along_edges(along(offset, -gap, found), f[5], g[5], found))
        start = unit_or(without(without(n, f[5]), g[5]), n)
        began = gap_of(f, g, start) - gap_along(a, b, start)
    return gap, found, promised - gap, rest, began


@kernel
def polish(a: Row, b: Row, x: Points, y: Points, n: Vector) -> Polished:
    """Improve a direction by the features at which support points of both bodies lie.

    Tried as well: the caps of cylinders; and of two nearly parallel edges, only one with an end of the other.

    Parameters
    ----------
    a, b
        Rows of bodies.
    x, y
        Three support points of each, which may be equal.
    n
        Unit direction near the one sought.

    Returns
    -------
    gap, direction, doubt, rest, began
        The gap g(n) along the direction that follows, and the direction; how much more the features promise: 0 up
        to rounding where they were guessed rightly; how far they are from having points gap·n apart, which makes
        the gap a local maximum; and how much more they promise where the way uphill began. The last two are infinite
        where they were not found out.
    """
    best = attempt(a, b, x, y, n)
    for row in (a, b):
        if row[KIND] == CYLINDER:
            axis = three(row, AXES + 6)
            cap = times(-1.0 if dot(axis, n) < 0.0 else 1.0, axis)
            there = gap_along(a, b, cap)
            if there > best[0]:
                best = (there, cap, 0.0, math.inf, math.inf)
    e, f = feature(a, x)[0][5], feature(b, y)[0][5]
    sine = cross(unit_or(e, ZERO), unit_or(f, ZERO))
    if dot(e, e) > 0.0 and dot(f, f) > 0.0 and dot(sine, sine) < NEARLY_PARALLEL:
        for i in range(2):
            p, q = along(x[0], float(i), e), along(y[0], float(i), f)
            for other in (attempt(a, b, (p, p, p), y, n), attempt(a, b, x, (q, q, q), n)):
                if other[0] > best[0]:
                    best = other
    return best


@kernel
def hull_face(row: Row, n: Vector, slack: float) -> Points:
    """Three vertices of a hull, as different as can be, among those less than `slack` below the highest along `n`."""
    top = support(row, n)
    p, q, r = top, top, top
    far, wide = 0.0, 0.0
    for i in range(int(row[COUNT])):
        v = three(row, VERTICES + 3 * i)
        way = minus(v, top)
        if dot(way, n) >= -slack and dot(way, way) > far:
            q, far = v, dot(way, way)
    step = minus(q, p)
    for i in range(int(row[COUNT])):
        v = three(row, VERTICES + 3 * i)
        way = minus(v, top)
        normal = cross(way, step)
        if dot(way, n) >= -slack and dot(normal, normal) > max(wide, 1e-20 * far * far):
            r, wide = v, dot(normal, normal)
    return p, q, r


@kernel
def points_of_face(row: Row, n: Vector, slack: float) -> Points:
    """Three support points that show the feature of a body which is extreme along `n`, up to `slack`."""
    if row[KIND] == HULL:
        return hull_face(row, n, slack)
    top = support(row, n)
    if row[KIND] == CYLINDER:
        axis = three(row, AXES + 6)
        if abs(dot(axis, n)) * row[SIZES + 2] <= slack:
            other = along(top, -2.0 * cap_of(row, top) * row[SIZES + 2], axis)
            return top, other, other
    return top, top, top
