"""The least depth of two bodies whose cores overlap, the global one: an expanding polytope with a Newton finish.

The polytope alone (`expanding.expand`) closes in on a smooth minimum by ever smaller facets. Here a facet that is
nearly at the surface shows which features meet there, and Newton's method (`features.polish`) gives the local minimum
at once; then the facet need not be divided further. So candidates compete by their value, and a whole circle of
equal minima costs no more than its coarse polygon.
"""

from __future__ import annotations

import math

from . import inlined, kernel
from .bodies import Row, three
from .expanding import (
    CLOSED,
    MARK,
    MOST_POINTS,
    Floats,
    Ints,
    add_point,
    begin,
    highest,
    insert,
    insert_all,
)
from .features import better_along, moved, polish
from .gjk import store
from .vectors import Vector, along, dot, minus, opposite

EPS = 2.0**-52
MANY = 128
"""Points at which the search ends: 4 for a facet that leads to a minimum equal to the best one, as on a circle or a
sphere of them, 1 where that is not quite sure to be the facet's own."""
FINE = 16.0 * EPS
"""What is rounding, relative to the difference's size."""
COARSE = 1e-2
"""Depth of a facet below the surface, relative to the difference's size, from which Newton's method is tried."""


@kernel
def corners(points: Floats, facets: Ints, f: int, start: int) -> tuple[Vector, Vector, Vector]:
    """Points of A (start 3) or of B (6) at a facet's corners."""
    return (
        three(points, 9 * facets[7 * f] + start),
        three(points, 9 * facets[7 * f + 1] + start),
        three(points, 9 * facets[7 * f + 2] + start),
    )


@kernel
def is_tangent(points: Floats, facets: Ints, f: int, n: Vector, most: float) -> bool:
    """Whether no corner of a facet is higher than `most` along `n`: whether it lies along a supporting plane."""
    highest_corner = -math.inf
    for i in range(3):
        highest_corner = max(highest_corner, dot(three(points, 9 * facets[7 * f + i]), n))
    return highest_corner <= most


@kernel
def add_corners(
    a: Row, b: Row, inset_a: float, inset_b: float, n: Vector, points: Floats, facets: Ints, f: int, known: int
) -> None:
    """Note three points of the difference: the corners of facet f, each moved along its features to fit `n`."""
    for i in range(3):
        at = 9 * facets[7 * f + i]
        x = along(moved(a, three(points, at + 3), n), -inset_a, n)
        y = along(moved(b, three(points, at + 6), opposite(n)), inset_b, n)
        to = 9 * (known + i)
        store(points, to, minus(y, x))
        store(points, to + 3, x)
        store(points, to + 6, y)


@inlined
def finished(
    a: Row, b: Row, inset: float, points: Floats, facets: Ints, f: int, n: Vector, size: float
) -> tuple[float, Vector, float, bool, bool]:
    """Finish a facet with normal `n` by the features at its corners.

    Returns
    -------
    gap, direction, rest, beside, closed
        As `polish` gives them; whether the facet lies along the tangent plane found, so that this is its own; and
        whether it is done with, because the same features lead uphill from it, or from beside it, to a local maximum.
    """
    x, y = corners(points, facets, f, 3), corners(points, facets, f, 6)
    gap, m, doubt, rest, began = polish(a, b, x, y, n)
    fine = FINE * size
    beside = is_tangent(points, facets, f, m, gap + inset + 4.0 * COARSE * size)
    return gap, m, rest, beside, (beside or began <= fine) and doubt <= fine and rest <= 1e-6 * size


@inlined
def deepest(
    a: Row,
    b: Row,
    inset_a: float,
    inset_b: float,
    gap: float,
    n: Vector,
    points: Floats,
    planes: Floats,
    facets: Ints,
    scratch: Ints,
) -> tuple[float, Vector]:
    """Find the greatest gap g(n) of two bodies over all directions, also where it has many local maxima.

    Starts from the gap along `n`. A facet whose level is no greater than the best gap is done with. One that is
    nearly at the surface shows which features meet there: if these lead, by Newton's method, to a local maximum in a
    tangent plane along the facet, it is done with, too. All others are expanded.
    """
    inset = inset_a + inset_b
    best, direction, best_rest = gap, n, math.inf
    known, size, normal = begin(a, b, inset_a, inset_b, n, points, planes, facets)
    if known == 0:
        best, direction = better_along(a, b, normal, best, direction)
        return better_along(a, b, opposite(normal), best, direction)
    slack, fine = 4.0 * EPS * size, FINE * size
    used = insert_all(points, planes, facets, scratch, 4, known, 4, slack)
    ties = 0
    while ties < MANY:
        f = highest(planes, facets, used)
        if f < 0 or planes[4 * f + 3] - inset <= best + fine or known >= MOST_POINTS - 4:
            break
        m, level, first = three(planes, 4 * f), planes[4 * f + 3], known
        there = add_point(a, b, inset_a, inset_b, m, points, first)
        known += 1
        if there - inset > best + fine:
            best, direction, best_rest = there - inset, m, math.inf
        done = level - there <= slack
        if not done and level - there <= COARSE * size:
            gap, m, rest, beside, done = finished(a, b, inset, points, facets, f, m, size)
            if abs(gap - best) <= fine:
                ties += 4 if done else 1
            if gap > best + fine or (gap >= best - fine and rest < best_rest):
                best, direction, best_rest = gap, m, rest
            if beside and not done:
                add_corners(a, b, inset_a, inset_b, m, points, facets, f, known)
                known += 3
        grown = 0 if done else insert(points, planes, facets, scratch, f, first, used, slack)
        if grown == 0:
            facets[7 * f + MARK] = CLOSED
        used = insert_all(points, planes, facets, scratch, first + 1, known, max(used, grown), slack)
    return best, direction
