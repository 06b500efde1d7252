"""A polytope inside the difference of two bodies that grows where it might matter: the expanding polytope.

The differences b − a form a convex set, on whose boundary lies the answer: σ is the greatest g(n) = min n·(b − a)
over all unit n. Every facet of the hull of some of these points, seen with its inward unit normal n, has its plane at
a height `level` above (or, negative, below) the origin which g(n) does not exceed. While the origin lies inside the
hull, no direction at all has a greater g than the highest of the levels. So the facet with the highest level is moved
outwards to the support point, again and again, until the levels come down to the best g.
Van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, 2001.

The polytope is kept in flat buffers: nine floats for a point (b − a, a, b), four for a facet's plane (n, level), and
seven integers for a facet (corners, neighbours across the sides that start at them, mark).
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from . import kernel
from .bodies import Row, three
from .gjk import core_support, store
from .vectors import Vector, cross, dot, minus, opposite, perpendicular, unit_or

Floats = MutableSequence[float]
Ints = MutableSequence[int]

OPEN, CLOSED, DEAD, SEEN = 0, 1, 2, 3
MARK = 6
MOST_POINTS = 400
MOST_FACETS = 1000
POINTS, PLANES, FACETS, SCRATCH = 9 * MOST_POINTS, 4 * MOST_FACETS, 7 * MOST_FACETS, 4 * MOST_FACETS
FLAT = 1e-15
"""Volumes thinner than this, relative to the size of the difference, are rounding."""


@kernel
def add_point(a: Row, b: Row, inset_a: float, inset_b: float, n: Vector, points: Floats, k: int) -> float:
    """Make the point of the difference of the cores that is lowest along `n` the k-th point; give its height g(n)."""
    on_a, on_b = core_support(a, n, inset_a), core_support(b, opposite(n), inset_b)
    w = minus(on_b, on_a)
    store(points, 9 * k, w)
    store(points, 9 * k + 3, on_a)
    store(points, 9 * k + 6, on_b)
    return dot(w, n)


@kernel
def set_facet(points: Floats, planes: Floats, facets: Ints, f: int, u: int, v: int, w: int) -> None:
    """Make f the facet with corners u, v, w, counted so that the normal points inwards; its plane, if it has one."""
    facets[7 * f], facets[7 * f + 1], facets[7 * f + 2], facets[7 * f + MARK] = u, v, w, OPEN
    p, q, r = three(points, 9 * u), three(points, 9 * v), three(points, 9 * w)
    # of the three sides, the two shorter ones give the better normal
    d, e, c = minus(q, p), minus(r, q), minus(p, r)
    dd, ee, cc = dot(d, d), dot(e, e), dot(c, c)
    if cc >= dd and cc >= ee:
        n = unit_or(cross(d, e), (0.0, 0.0, 0.0))
    elif dd >= ee:
        n = unit_or(cross(e, c), (0.0, 0.0, 0.0))
    else:
        n = unit_or(cross(c, d), (0.0, 0.0, 0.0))
    store(planes, 4 * f, n)
    planes[4 * f + 3] = dot(n, p) if dot(n, n) > 0.0 else -math.inf


@kernel
def is_below(planes: Floats, f: int, w: Vector, slack: float) -> bool:
    """Whether a point lies outside the polytope as seen from facet f, or in its plane up to `slack`."""
    return dot(three(planes, 4 * f), w) < planes[4 * f + 3] + slack


@kernel
def horizon(planes: Floats, facets: Ints, scratch: Ints, f: int, w: Vector, slack: float) -> int:
    """Mark every facet below which w lies, from f on, as SEEN, and list the sides where that ends.

    The number of sides; their facet outside and the place of the side in it are put in pairs into the second half of
    `scratch`, the seen facets' number at its end, and they themselves in front.
    """
    facets[7 * f + MARK] += SEEN
    scratch[0] = f
    seen, done, sides = 1, 0, 0
    half = len(scratch) // 2
    while done < seen:
        here = scratch[done]
        done += 1
        for j in range(3):
            other = facets[7 * here + 3 + j]
            if facets[7 * other + MARK] >= SEEN:
                continue
            if is_below(planes, other, w, slack):
                facets[7 * other + MARK] += SEEN
                scratch[seen] = other
                seen += 1
            else:
                place = 0
                start = facets[7 * here + (j + 1) % 3]
                while place < 2 and facets[7 * other + place] != start:
                    place += 1
                scratch[half + 2 * sides], scratch[half + 2 * sides + 1] = other, place
                sides += 1
    scratch[len(scratch) - 1] = seen
    return sides


@kernel
def forget(facets: Ints, scratch: Ints) -> None:
    """Take back the marks of the last `horizon`."""
    for i in range(scratch[len(scratch) - 1]):
        facets[7 * scratch[i] + MARK] -= SEEN


@kernel
def in_order(facets: Ints, scratch: Ints, sides: int) -> bool:
    """Put the sides of a horizon one behind the other; false when they do not form one closed line."""
    half = len(scratch) // 2
    for i in range(sides - 1):
        other, place = scratch[half + 2 * i], scratch[half + 2 * i + 1]
        end = facets[7 * other + place]  # a side seen from outside runs the other way
        j = i + 1
        while j < sides:
            facet, at = scratch[half + 2 * j], scratch[half + 2 * j + 1]
            if facets[7 * facet + (at + 1) % 3] == end:
                break
            j += 1
        if j == sides:
            return False
        for c in range(2):
            p, q = half + 2 * (i + 1) + c, half + 2 * j + c
            scratch[p], scratch[q] = scratch[q], scratch[p]
    first, last = half, half + 2 * (sides - 1)
    start = facets[7 * scratch[first] + (scratch[first + 1] + 1) % 3]
    return sides >= 3 and facets[7 * scratch[last] + scratch[last + 1]] == start


@kernel
def insert(
    points: Floats, planes: Floats, facets: Ints, scratch: Ints, f: int, k: int, count: int, slack: float
) -> int:
    """Add point k, which lies below facet f, to the hull; give the number of facets used, or 0 when it failed."""
    sides = horizon(planes, facets, scratch, f, three(points, 9 * k), slack)
    seen = scratch[len(scratch) - 1]
    if count + sides - seen >= MOST_FACETS or not in_order(facets, scratch, sides):
        forget(facets, scratch)
        return 0
    for i in range(seen):
        facets[7 * scratch[i] + MARK] = DEAD
    half = len(scratch) // 2
    for i in range(sides):
        # scratch[i] becomes the new facet's number: a dead one's, as long as there are some
        if i >= seen:
            scratch[i] = count
            count += 1
    for i in range(sides):
        other, place, new = scratch[half + 2 * i], scratch[half + 2 * i + 1], scratch[i]
        start, end = facets[7 * other + (place + 1) % 3], facets[7 * other + place]
        set_facet(points, planes, facets, new, start, end, k)
        facets[7 * new + 3] = other
        facets[7 * new + 4] = scratch[(i + 1) % sides]
        facets[7 * new + 5] = scratch[(i + sides - 1) % sides]
        facets[7 * other + 3 + place] = new
    return count


@kernel
def swap_points(points: Floats, i: int, j: int) -> None:
    """Exchange two points."""
    for c in range(9):
        points[9 * i + c], points[9 * j + c] = points[9 * j + c], points[9 * i + c]


@kernel
def farthest(points: Floats, count: int, placed: int) -> float:
    """Bring the point that is farthest from the flat hull of the first `placed` ones next; give its distance."""
    best, which = -1.0, placed
    p = three(points, 0)
    u = unit_or(minus(three(points, 9), p), (0.0, 0.0, 0.0)) if placed > 1 else (0.0, 0.0, 0.0)
    n = unit_or(cross(u, minus(three(points, 18), p)), (0.0, 0.0, 0.0)) if placed > 2 else (0.0, 0.0, 0.0)
    for k in range(placed, count):
        v = minus(three(points, 9 * k), p)
        if placed == 3:
            d = abs(dot(v, n))
        else:
            v = v if placed == 1 else cross(u, v)
            d = math.sqrt(dot(v, v))
        if d > best:
            best, which = d, k
    swap_points(points, placed, which)
    return best


@kernel
def tetrahedron(points: Floats, planes: Floats, facets: Ints) -> None:
    """Make the first four points the first polytope, of four facets."""
    p, q, r, s = three(points, 0), three(points, 9), three(points, 18), three(points, 27)
    if dot(cross(minus(q, p), minus(r, p)), minus(s, p)) < 0.0:
        swap_points(points, 1, 2)
    # facet i leaves out point 3 − i; sides are shared with the facets named behind
    set_facet(points, planes, facets, 0, 0, 1, 2)
    set_facet(points, planes, facets, 1, 0, 3, 1)
    set_facet(points, planes, facets, 2, 0, 2, 3)
    set_facet(points, planes, facets, 3, 1, 3, 2)
    neighbours = (1, 3, 2, 2, 3, 0, 0, 3, 1, 1, 2, 0)
    for i in range(4):
        for j in range(3):
            facets[7 * i + 3 + j] = neighbours[3 * i + j]


@kernel
def begin(
    a: Row, b: Row, inset_a: float, inset_b: float, n: Vector, points: Floats, planes: Floats, facets: Ints
) -> tuple[int, float, Vector]:
    """Find a first tetrahedron in the difference of two bodies.

    Returns
    -------
    count, size, normal
        Points found, of which the first four are the tetrahedron's corners; 0 when the difference is flat up to
        rounding, and then `normal` is at right angles to it. `size` is the extent of the difference.
    """
    s = perpendicular(n)
    t = cross(n, s)
    count = 0
    for way in (n, s, t):
        add_point(a, b, inset_a, inset_b, way, points, count)
        add_point(a, b, inset_a, inset_b, opposite(way), points, count + 1)
        count += 2
    size = farthest(points, count, 1)
    thin = FLAT * (size + math.sqrt(dot(three(points, 0), three(points, 0))))
    if size <= thin:
        return 0, size, n
    u = unit_or(minus(three(points, 9), three(points, 0)), n)
    for placed in (2, 3):
        if placed == 2:
            way = perpendicular(u)
            other = cross(u, way)
        else:
            way = unit_or(cross(u, minus(three(points, 18), three(points, 0))), n)
            other = way
        for m in (way, other):
            add_point(a, b, inset_a, inset_b, m, points, count)
            add_point(a, b, inset_a, inset_b, opposite(m), points, count + 1)
            count += 2
        if farthest(points, count, placed) <= thin:
            return 0, size, way
    tetrahedron(points, planes, facets)
    return count, size, n


@kernel
def highest(planes: Floats, facets: Ints, count: int) -> int:
    """Give the open facet with the highest level; −1 if none is open."""
    best, which = -math.inf, -1
    for f in range(count):
        if facets[7 * f + MARK] == OPEN and planes[4 * f + 3] > best:
            best, which = planes[4 * f + 3], f
    return which


@kernel
def facet_below(planes: Floats, facets: Ints, count: int, w: Vector) -> tuple[int, float]:
    """Give the facet below which a point lies deepest, and how deep."""
    best, which = -math.inf, -1
    for f in range(count):
        if facets[7 * f + MARK] < DEAD:
            depth = planes[4 * f + 3] - dot(three(planes, 4 * f), w)
            if depth > best:
                best, which = depth, f
    return which, best


@kernel
def insert_all(
    points: Floats, planes: Floats, facets: Ints, scratch: Ints, first: int, known: int, used: int, slack: float
) -> int:
    """Add the points from `first` up to `known` to the hull, as far as they lie outside; the number of facets used."""
    for k in range(first, known):
        f, depth = facet_below(planes, facets, used, three(points, 9 * k))
        if depth > slack:
            used = max(used, insert(points, planes, facets, scratch, f, k, used, slack))
    return used


@kernel
def expand(
    a: Row,
    b: Row,
    n: Vector,
    gap: float,
    points: Floats,
    planes: Floats,
    facets: Ints,
    scratch: Ints,
) -> tuple[int, int, float, Vector, float]:
    """Expand a polytope inside the difference of two bodies until its highest level is within `gap` of the best g.

    No Newton's method and no features: support points only, so that the polytope proves the answer.

    Parameters
    ----------
    a, b
        Rows of bodies.
    n
        Direction to start from; the nearer to the best one, the better.
    gap
        A length, at least 0.

    Returns
    -------
    points, facets, best, direction, level
        Points noted, of which not all have to be corners; facets used, some of them dead; best g(n) and its n; the
        highest level that is left. No points for a flat difference, and then the level is 0.
    """
    known, size, normal = begin(a, b, 0.0, 0.0, n, points, planes, facets)
    if known == 0:
        return 0, 0, 0.0, normal, 0.0
    slack = 2.0**-50 * size
    used = insert_all(points, planes, facets, scratch, 4, known, 4, slack)
    best, direction, level = -math.inf, n, math.inf
    while True:
        f = highest(planes, facets, used)
        level = planes[4 * f + 3] if f >= 0 else level
        if f < 0 or level <= best + gap or known >= MOST_POINTS - 1:
            return known, used, best, direction, level
        there = add_point(a, b, 0.0, 0.0, three(planes, 4 * f), points, known)
        if there > best:
            best, direction = there, three(planes, 4 * f)
        grown = 0
        if level - there > slack:
            grown = insert(points, planes, facets, scratch, f, known, used, slack)
            known += 1
        if grown == 0:
            facets[7 * f + MARK] = CLOSED
        used = max(used, grown)
