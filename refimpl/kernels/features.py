"""Which features of two bodies meet, guessed from a few support points, and the best direction that follows.

A search leaves three support points of each body. Equal ones mean a vertex; two different ones an edge; points on both
caps of a cylinder its side. Were the guess the whole truth, the direction of the greatest gap would follow from it to
the last digits (`newton.climb`). So it is tried, and believed only as far as the gap g(n) that it really has.
"""

from __future__ import annotations

import math

from . import kernel
from .bodies import AXES, CENTER, CYLINDER, HULL, KIND, SIZES, Row, support, three
from .newton import ZERO, Feature, climb, gap_of
from .vectors import Vector, along, cross, dot, minus, opposite, unit_or, without

Points = tuple[Vector, Vector, Vector]


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
    """Edge direction, and face normal, of a hull that its support points span; zero where they span none."""
    p, q, r = x
    if same(p, q):
        p, q, r = q, r, q
    step, other = minus(q, p), minus(r, p)
    if same(q, r) or same(p, r):
        return step, ZERO
    normal = cross(step, other)
    longer = step if dot(step, step) >= dot(other, other) else other
    square = dot(normal, normal)
    if square <= 1e-24 * dot(step, step) * dot(other, other):
        return longer, ZERO
    return ZERO, normal


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
        above = 0
        for i in range(3):
            if dot(minus(x[i], center), w) > 0.0:
                above += 1
        if 0 < above < 3:
            return (center, u, v, w, radii, w), ZERO
        return (along(center, sizes[2] if above == 3 else -sizes[2], w), u, v, w, radii, ZERO), ZERO
    return (center, u, v, w, sizes, ZERO), ZERO


@kernel
def across(e: Vector, f: Vector, n: Vector) -> Vector:
    """Unit vector at right angles to two directions, on the side of `n`; zero if they are parallel."""
    e, f = unit_or(e, ZERO), unit_or(f, ZERO)
    normal = unit_or(cross(e, without(f, e)), ZERO)
    for _ in range(2):
        normal = without(without(normal, e), f)
    side = -1.0 if dot(normal, n) < 0.0 else 1.0
    return unit_or((side * normal[0], side * normal[1], side * normal[2]), ZERO)


@kernel
def guess(f: Feature, normal_f: Vector, g: Feature, normal_g: Vector, n: Vector) -> tuple[Vector, float]:
    """Direction near `n` in which two features have their greatest gap, and the gap that it would be.

    NaN for the gap where a face alone gives the direction.
    """
    for normal in (normal_f, normal_g):
        if dot(normal, normal) > 0.0:
            side = -1.0 if dot(normal, n) < 0.0 else 1.0
            return unit_or((side * normal[0], side * normal[1], side * normal[2]), n), math.nan
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
def polish(a: Row, b: Row, x: Points, y: Points, n: Vector) -> tuple[float, Vector, float]:
    """Improve a direction by the features at which support points of both bodies lie.

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
    gap, direction, doubt
        The greatest gap found and its direction; how much less the gap along the guessed direction is than the
        features promise: 0 up to rounding where the guess was right.
    """
    (f, normal_f), (g, normal_g) = feature(a, x), feature(b, y)
    found, promised = guess(f, normal_f, g, normal_g, n)
    gap = gap_along(a, b, found)
    doubt = 0.0 if math.isnan(promised) else promised - gap
    best, direction = better_along(a, b, n, gap, found)
    for row in (a, b):
        if row[KIND] == CYLINDER:
            axis = three(row, AXES + 6)
            side = -1.0 if dot(axis, n) < 0.0 else 1.0
            best, direction = better_along(a, b, (side * axis[0], side * axis[1], side * axis[2]), best, direction)
    return best, direction, doubt
