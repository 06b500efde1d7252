"""Signed distance of two convex bodies of which at least one is curved: the whole search.

σ is the greatest g(n) over all unit directions n (`expanding`), apart and overlapping alike; so whatever proposes a
direction, g decides. A single point is projected. Otherwise the closest points of the *cores* are sought first: every
ellipsoid is a smaller convex body widened by a ball whose radius is its least radius of curvature (Blaschke's rolling
theorem; Schneider, Convex Bodies, 3.2), and cores that are apart have one pair of closest points, easily found
(`gjk`), also where the bodies themselves overlap. Only when the cores overlap as well, the least depth has to be
searched for among many, by the expanding polytope, each of whose facets is finished by Newton's method (`features`).
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

from . import inlined, kernel
from .bodies import CENTER, COUNT, ELLIPSOID, HULL, KIND, RADIUS, SIZES, VERTICES, Row, three
from .deepest import deepest
from .expanding import Floats, Ints, expand
from .features import Points, gap_along, points_of_face, polish
from .gjk import ON_A, ON_B, OVERLAPPING, Simplex, gjk, store, weighted
from .newton import ZERO
from .projection import nearest_to_point
from .vectors import Vector, along, length, minus, opposite, unit_or
from .witnesses import middle, settled

EPS = 2.0**-52
NEAR = 1e-10
"""How far below the highest point, relative to the scene, points are taken for points of one face."""
DOUBTFUL = 1e-13
"""Misfit of witness points, relative to the scene, above which the search is repeated more carefully."""


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
def corner(simplex: Simplex, count: int, start: int) -> Points:
    """Points of A or of B at the corners of a simplex of up to three."""
    return (
        three(simplex, start),
        three(simplex, start + 3 * min(1, count - 1)),
        three(simplex, start + 3 * (count - 1)),
    )


@inlined
def sharpened(a: Row, b: Row, gap: float, n: Vector, simplex: Simplex, count: int, fine: float) -> tuple[float, Vector]:
    """Improve a direction by the features at a simplex's corners; it stays where that does not help."""
    there, m, _, _, _ = polish(a, b, corner(simplex, count, ON_A), corner(simplex, count, ON_B), n)
    return (there, m) if there >= gap - fine else (gap, n)


@inlined
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


@inlined
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
        faces = points_of_face(a, n, NEAR * size), points_of_face(b, opposite(n), NEAR * size)
        sharp = polish(a, b, faces[0], faces[1], n)
        if sharp[0] > sigma:
            sigma, n = sharp[0], sharp[1]
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
