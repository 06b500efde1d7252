"""Signed distance of two convex bodies of which at least one is curved: the whole search.

σ is the greatest g(n) over all unit directions n (`expanding`), apart and overlapping alike; so whatever proposes a
direction, g decides. A single point is projected. Otherwise the closest points of the *cores* are sought first: every
ellipsoid is a smaller convex body widened by a ball whose radius is its least radius of curvature (Blaschke's rolling
theorem; Schneider, Convex Bodies, 3.2), and cores that are apart have one pair of closest points, easily found
(`gjk`), also where the bodies themselves overlap. Only when the cores overlap as well, the least depth has to be
searched for among many, by the expanding polytope, each of whose facets is finished by Newton's method (`features`).
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import kernel
from .bodies import AXES, CENTER, COUNT, CYLINDER, ELLIPSOID, HULL, KIND, RADIUS, SIZES, VERTICES, Row, support, three
from .expanding import (
    CLOSED,
    MARK,
    MOST_POINTS,
    Floats,
    Ints,
    add_point,
    begin,
    expand,
    facet_below,
    highest,
    insert,
)
from .features import Points, better_along, gap_along, moved, points_of_face, polish
from .gjk import ON_A, ON_B, OVERLAPPING, Simplex, gjk, store, weighted
from .newton import ZERO
from .projection import nearest_to_point
from .vectors import Vector, along, dot, length, minus, opposite, plus, times, unit_or, without

EPS = 2.0**-52
DOUBTFUL = 1e-13
"""Misfit of witness points, relative to the scene, above which the search is repeated more carefully."""
COARSE = 1e-2
"""Depth of a facet below the surface, relative to the difference's size, from which Newton's method is tried."""


@kernel
def inset_of(row: Row) -> float:
    """Radius of a ball that rolls freely inside an ellipsoid: the square of its least radius over its greatest."""
    if row[KIND] != ELLIPSOID:
        return 0.0
    least = min(row[SIZES], row[SIZES + 1], row[SIZES + 2])
    return least * (least / max(row[SIZES], row[SIZES + 1], row[SIZES + 2]))


@kernel
def extent(row: Row) -> float:
    """Bound of a body's coordinates, up to a factor of about 2."""
    if row[KIND] != HULL:
        center, sizes = three(row, CENTER), three(row, SIZES)
        return max(abs(center[0]), abs(center[1]), abs(center[2])) + max(sizes[0], sizes[1], sizes[2])
    size = 0.0
    for i in range(VERTICES, VERTICES + 3 * int(row[COUNT])):
        size = max(size, abs(row[i]))
    return size


@kernel
def middle(row: Row) -> Vector:
    """Some point of a body, for a first guess."""
    if row[KIND] == HULL:
        return three(row, VERTICES)
    return three(row, CENTER)


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


@kernel
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
    slack, used, next_point = 4.0 * EPS * size, 4, 4
    fine, coarse = 16.0 * EPS * size, COARSE * size
    while True:
        while next_point < known:
            f, depth = facet_below(planes, facets, used, three(points, 9 * next_point))
            if depth > slack:
                used = max(used, insert(points, planes, facets, scratch, f, next_point, used, slack))
            next_point += 1
        f = highest(planes, facets, used)
        if f < 0 or planes[4 * f + 3] - inset <= best + fine or known >= MOST_POINTS - 4:
            return best, direction
        m = three(planes, 4 * f)
        there = add_point(a, b, inset_a, inset_b, m, points, known)
        if there - inset > best + fine:
            best, direction, best_rest = there - inset, m, math.inf
        below = planes[4 * f + 3] - there
        if below <= slack:
            facets[7 * f + MARK] = CLOSED
            continue
        known += 1
        if below <= coarse:
            x, y = corners(points, facets, f, 3), corners(points, facets, f, 6)
            gap, m, doubt, rest = polish(a, b, x, y, m)
            if gap > best + fine or (gap >= best - fine and rest < best_rest):
                best, direction, best_rest = gap, m, rest
            if is_tangent(points, facets, f, m, gap + inset + 4.0 * coarse):
                if doubt <= fine and rest <= 1e-6 * size:
                    facets[7 * f + MARK] = CLOSED
                    known -= 1
                    continue
                add_corners(a, b, inset_a, inset_b, m, points, facets, f, known)
                known += 3
        grown = insert(points, planes, facets, scratch, f, next_point, used, slack)
        next_point += 1
        if grown == 0:
            facets[7 * f + MARK] = CLOSED
        else:
            used = grown


@kernel
def face_towards(row: Row, n: Vector, shift: Vector, slack: float, face: Floats) -> None:
    """Write the face of a body that is farthest along `n`, moved by `shift`, as the row of a body of its own.

    A vertex, an edge, a polygon; the side of a cylinder, a segment there; its cap, a flat cylinder.
    """
    for i in range(VERTICES):
        face[i] = row[i]
    face[KIND], face[COUNT] = HULL, 1.0
    top = support(row, n)
    axis = three(row, AXES + 6)
    count = 0
    if row[KIND] == HULL:
        for i in range(int(row[COUNT])):
            v = three(row, VERTICES + 3 * i)
            if dot(minus(top, v), n) <= slack:
                store(face, VERTICES + 3 * count, plus(v, shift))
                count += 1
        face[COUNT] = float(count)
    elif row[KIND] == CYLINDER and length(without(n, axis)) * row[SIZES] <= slack:
        face[KIND], face[COUNT], face[SIZES + 2] = CYLINDER, 0.0, 0.0
        cap = along(three(row, CENTER), math.copysign(row[SIZES + 2], dot(n, axis)), axis)
        store(face, CENTER, plus(cap, shift))
    elif row[KIND] == CYLINDER and abs(dot(n, axis)) * row[SIZES + 2] <= slack:
        out = along(three(row, CENTER), row[SIZES], unit_or(without(n, axis), n))
        store(face, VERTICES, plus(along(out, row[SIZES + 2], axis), shift))
        store(face, VERTICES + 3, plus(along(out, -row[SIZES + 2], axis), shift))
        face[COUNT] = 2.0
    else:
        store(face, VERTICES, plus(top, shift))


@kernel
def witnesses(
    a: Row, b: Row, sigma: float, n: Vector, size: float, simplex: Simplex, face_a: Floats, face_b: Floats
) -> tuple[Vector, Vector, float]:
    """Find points of two bodies that are σ·n apart, and how much they fail to be.

    They are where the extreme faces along n meet, when B is moved by −σ·n.

    Of a very flat ellipsoid a direction does not tell the point well; it is projected from the other body instead.
    """
    slack = 256.0 * EPS * size
    face_towards(a, n, (0.0, 0.0, 0.0), slack, face_a)
    face_towards(b, opposite(n), times(-sigma, n), slack, face_b)
    start = unit_or(minus(middle(face_b), middle(face_a)), n)
    _, count, _, _ = gjk(face_a, face_b, 0.0, 0.0, start, simplex, 0, EPS * size, 40)
    x, y = weighted(simplex, count, ON_A), along(weighted(simplex, count, ON_B), sigma, n)
    misfit = length(along(minus(y, x), -sigma, n))
    for _ in range(8):
        if misfit <= 2.0 * EPS * size:
            break
        if a[KIND] == ELLIPSOID:
            x = nearest_to_point(a, along(y, -sigma, n))[2]
        if b[KIND] == ELLIPSOID:
            y = nearest_to_point(b, along(x, sigma, n))[2]
        misfit = length(along(minus(y, x), -sigma, n))
    return x, y, misfit


@kernel
def corner(simplex: Simplex, count: int, start: int) -> Points:
    """Points of A or of B at the corners of a simplex of up to three."""
    return (
        three(simplex, start),
        three(simplex, start + 3 * min(1, count - 1)),
        three(simplex, start + 3 * (count - 1)),
    )


@kernel
def sharpened(a: Row, b: Row, gap: float, n: Vector, simplex: Simplex, count: int, fine: float) -> tuple[float, Vector]:
    """Improve a direction by the features at a simplex's corners; it stays where that does not help."""
    there, m, _, _ = polish(a, b, corner(simplex, count, ON_A), corner(simplex, count, ON_B), n)
    return (there, m) if there >= gap - fine else (gap, n)


@kernel
def settled(
    a: Row, b: Row, sigma: float, n: Vector, size: float, simplex: Simplex, face_a: Floats, face_b: Floats
) -> tuple[float, Vector, Vector, Vector, float]:
    """Witness points for a distance and its direction, and both sharpened once more where the points do not fit.

    What g(n) tells in rounded numbers leaves n a little free. So the features are tried that would meet if n were
    wrong by ever less.

    Returns
    -------
    sigma, direction, x, y, misfit
        The last is the length of y − x − σ·n.
    """
    x, y, misfit = witnesses(a, b, sigma, n, size, simplex, face_a, face_b)
    start = n
    slack = 1e-4 * size
    while misfit > 32.0 * EPS * size and slack > EPS * size:
        gap, m, _, _ = polish(a, b, points_of_face(a, start, slack), points_of_face(b, opposite(start), slack), start)
        if gap >= sigma - 16.0 * EPS * size:
            p, q, rest = witnesses(a, b, gap, m, size, simplex, face_a, face_b)
            if rest < misfit or gap > sigma + 16.0 * EPS * size:
                sigma, n, x, y, misfit = gap, m, p, q, rest
        slack *= 0.1
    return sigma, n, x, y, misfit


@kernel
def apart(
    a: Row, b: Row, inset_a: float, inset_b: float, size: float, simplex: Simplex, face_a: Floats, face_b: Floats
) -> tuple[bool, float, Vector, Vector, Vector]:
    """Answer for two bodies whose cores are apart: whether they are, then σ, normal and witness points.

    Points that are σ·n apart, in planes across n between which there is nothing of either core, are the closest ones:
    that proves the answer. When it cannot be had, the direction is at least a good start.
    """
    inset, fine = inset_a + inset_b, 8.0 * EPS * size
    n = unit_or(minus(middle(b), middle(a)), (0.0, 0.0, 1.0))
    state, count, gap, n = gjk(a, b, inset_a, inset_b, n, simplex, 0, 2.0 * EPS * size, 50)
    x, y = ZERO, ZERO
    if state == OVERLAPPING:
        return False, gap - inset, n, x, y
    v = weighted(simplex, count, 0)
    m = unit_or(v, n)
    if length(v) - gap <= fine and gap_along(a, b, m) + inset >= gap - fine and gap > 0.0:
        x, y = weighted(simplex, count, ON_A), weighted(simplex, count, ON_B)
        return True, length(v) - inset, m, along(x, inset_a, m), along(y, -inset_b, m)
    sigma, n = sharpened(a, b, gap - inset, n, simplex, count, fine)
    if sigma + inset <= 0.0:
        return False, sigma, n, x, y
    sigma, n, x, y, misfit = settled(a, b, sigma, n, size, simplex, face_a, face_b)
    return misfit <= 256.0 * EPS * size, sigma, n, x, y


@kernel
def general(
    a: Row,
    b: Row,
    simplex: Simplex,
    points: Floats,
    planes: Floats,
    facets: Ints,
    scratch: Ints,
    face_a: Floats,
    face_b: Floats,
) -> tuple[float, Vector, Vector, Vector]:
    """Signed distance, normal and witness points of two bodies, without the balls by which they are widened."""
    size = extent(a) + extent(b)
    inset_a, inset_b = inset_of(a), inset_of(b)
    found, sigma, n, x, y = apart(a, b, inset_a, inset_b, size, simplex, face_a, face_b)
    if not found:
        sigma, n = deepest(a, b, inset_a, inset_b, sigma, n, points, planes, facets, scratch)
        sigma, n, x, y, misfit = settled(a, b, sigma, n, size, simplex, face_a, face_b)
        if misfit > DOUBTFUL * size:
            # nearly equal features were too much for the shortcuts: once more, by support points only
            _, _, _, m, _ = expand(a, b, n, EPS * size, points, planes, facets, scratch)
            gap, m, p, q, rest = settled(a, b, gap_along(a, b, m), m, size, simplex, face_a, face_b)
            if gap > sigma + DOUBTFUL * size or rest < misfit:
                sigma, n, x, y = gap, m, p, q
    return sigma, n, x, y


@kernel
def separation(
    a: Row,
    b: Row,
    simplex: Simplex,
    points: Floats,
    planes: Floats,
    facets: Ints,
    scratch: Ints,
    face_a: Floats,
    face_b: Floats,
) -> tuple[float, Vector, Vector, Vector]:
    """Signed distance, normal from A to B, and witness points of two bodies, at least one of them curved."""
    if a[KIND] == HULL and a[COUNT] == 1.0:
        x = three(a, VERTICES)
        sigma, outwards, y = nearest_to_point(b, x)
        n = opposite(outwards)
    elif b[KIND] == HULL and b[COUNT] == 1.0:
        y = three(b, VERTICES)
        sigma, n, x = nearest_to_point(a, y)
    else:
        sigma, n, x, y = general(a, b, simplex, points, planes, facets, scratch, face_a, face_b)
    r, s = a[RADIUS], b[RADIUS]
    return sigma - (r + s), n, along(x, r, n), along(y, -s, n)


@kernel
def separations(
    rows_a: Sequence[Row],
    rows_b: Sequence[Row],
    out: MutableSequence[Floats],
    simplex: Simplex,
    points: Floats,
    planes: Floats,
    facets: Ints,
    scratch: Ints,
    face_a: Floats,
    face_b: Floats,
) -> None:
    """Answer a batch: σ, normal, point of A and point of B, ten numbers a pair, into the rows of `out`."""
    for i in range(len(rows_a)):
        sigma, n, x, y = separation(rows_a[i], rows_b[i], simplex, points, planes, facets, scratch, face_a, face_b)
        row = out[i]
        row[0] = sigma
        store(row, 1, n)
        store(row, 4, x)
        store(row, 7, y)
