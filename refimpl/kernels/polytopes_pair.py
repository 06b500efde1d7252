"""Signed distance of two polytopes: nearest points, then separating axes where those leave doubt.

Every unit direction bounds the signed distance from below, by the gap along it, and every pair of points from above.
Where the two bounds of the nearest points agree up to rounding, nothing is left to do. Otherwise the polytopes touch,
nearly so, or overlap, as they surely do where one holds a middle point of the other. The direction is taken from their
features then, which are known to full precision, and the widest gap wins. The witness points are those at which B,
moved along the direction until it touches, meets A; most often the features that gave the direction tell them at once.
"""

from __future__ import annotations

import math

from . import kernel
from .axes import ROUNDING, crossed, some_axis, three, widest_axis
from .polytopes import (
    CENTRE,
    FACE,
    FACTOR,
    N_FACES,
    N_VERTICES,
    OFFSET,
    Row,
    Scratch,
    first_face,
    gap_along,
    lowest,
    place_faces,
    place_vertices,
    vertex,
)
from .polytopes_nearest import APART, ENTRY, MEETING, nearest, on_first, on_second
from .vectors import Vector, along, cross, dot, minus, opposite, times, unit_or, without

FEATURES = 36
"""Room for the directions of all edges of a simplex."""
MOST_STARTS = 4
PARALLEL = 2.0**-20
"""Squared sine of the angle between two edges up to which they count as parallel, where that is the safe side."""
CORNER = 2.0**-10
"""Part of an edge at its ends that counts as its ends."""
HERE = (0.0, 0.0, 0.0)
Answer = tuple[float, Vector, Vector, Vector]
"""Signed distance; normal; witness points on A and on B."""


@kernel
def _directions(a: Row, b: Row, s: Row, k: int, found: Scratch) -> int:
    """Unit directions of the edges that the nearest simplex has in A and in B; gives how many."""
    count = 0
    for side in range(2):
        body = a if side == 0 else b
        for i in range(k):
            for j in range(i):
                p, q = int(s[ENTRY * i + side]), int(s[ENTRY * j + side])
                if p != q:
                    e = unit_or(minus(vertex(body, p), vertex(body, q)), HERE)
                    found[count], found[count + 1], found[count + 2] = e
                    count += 3
    return count // 3


@kernel
def across_features(
    a: Row, b: Row, s: Row, k: int, w: Vector, best: Vector, gap: float, enough: float, listed: Scratch
) -> tuple[Vector, float]:
    """Clean the direction between nearest points of rounding, by the edges that carry them.

    It is at right angles to each edge that it truly joins. So it is tried as it is, across each one edge of the
    simplex, and across each two; the widest gap wins.
    """
    count = _directions(a, b, s, k, listed)
    for i in range(-1, count):
        e = three(listed, 3 * i) if i >= 0 else HERE
        for j in range(i, count if i >= 0 else 0):
            if i == j or i < 0:
                n = unit_or(without(unit_or(without(w, e), HERE), e), HERE)
            else:
                n = crossed(e, three(listed, 3 * j))
                n = opposite(n) if dot(n, w) < 0.0 else n
            if n != HERE:
                here = gap_along(a, b, n)
                if here > gap:
                    best, gap = n, here
                    if gap >= enough:
                        return best, gap
    return best, gap


@kernel
def touching_points(a: Row, b: Row, sigma: float, n: Vector, close: float, s: Scratch) -> tuple[Vector, Vector]:
    """Witness points: where A and B meet once B is moved along the normal by minus the signed distance.

    A search that ends before, because rounding misled it, starts again from the direction where it ended.
    """
    shift, start = times(-sigma, n), n
    x, y, least = HERE, HERE, math.inf
    for _ in range(MOST_STARTS):
        status, k, start, rest = nearest(a, b, shift, start, close, s)
        if rest < least:
            x, y, least = on_first(a, s, k), on_second(b, s, k), rest
        if status == MEETING or rest <= 8.0 * close:
            break
    return x, y


@kernel
def _on_one_face(body: Row, x: Vector, close: float) -> bool:
    """Whether a point is in one face's plane up to `close`, and clearly behind all others."""
    count, start = 0, first_face(body)
    for at in range(start, start + FACE * int(body[N_FACES]), FACE):
        height = dot(three(body, at), x) - body[at + OFFSET]
        if height > -close:
            count += 1
            if count > 1 or height > close:
                return False
    return count == 1


@kernel
def _corner_on_face(a: Row, b: Row, sigma: float, n: Vector, close: float) -> tuple[bool, Vector]:
    """Vertex of B that lies inside a face of A once B is moved along n by −sigma, and whether there is one."""
    lowest_one = vertex(b, lowest(b, n))
    level = dot(n, lowest_one) + close
    for i in range(int(b[N_VERTICES])):
        y = vertex(b, i)
        if dot(n, y) <= level and _on_one_face(a, along(y, -sigma, n), close):
            return True, y
    return False, lowest_one


@kernel
def _crossing(p: Vector, e: Vector, q: Vector, f: Vector) -> tuple[float, float]:
    """Where the edges p + s·e and q + t·f are nearest, as s and t; −1 if they are nearly parallel."""
    c, d = cross(e, f), minus(q, p)
    square = dot(c, c)
    if square <= PARALLEL * dot(e, e) * dot(f, f):
        return -1.0, -1.0
    return dot(cross(d, f), c) / square, dot(cross(d, e), c) / square


@kernel
def meeting_points(
    geometry_a: Row, geometry_b: Row, a: Row, b: Row, sigma: float, n: Vector, of_a: int, of_b: int, close: float
) -> tuple[bool, Vector, Vector]:
    """Witness points where the features that gave the direction meet in their inside, and whether they do.

    A face meets a vertex of the other polytope, an edge another edge. `of_a` and `of_b` are what `widest_axis` gives.
    """
    if of_a < 0 or of_b < 0:
        met, y = _corner_on_face(a, b, sigma, n, close)
        if met:
            return True, along(y, -sigma, n), y
        met, x = _corner_on_face(b, a, sigma, opposite(n), close)
        return met, x, along(x, sigma, n)
    p, q = vertex(a, int(geometry_a[of_a])), vertex(b, int(geometry_b[of_b]))
    e, f = minus(vertex(a, int(geometry_a[of_a + 1])), p), minus(vertex(b, int(geometry_b[of_b + 1])), q)
    s, t = _crossing(p, e, q, f)
    inside = CORNER < s < 1.0 - CORNER and CORNER < t < 1.0 - CORNER
    x = along(p, s, e)
    return inside and abs(dot(minus(q, p), n) - sigma) <= close, x, along(x, sigma, n)


@kernel
def _first_axis(
    geometry_a: Row, pose_a: Row, geometry_b: Row, pose_b: Row, a: Row, b: Row, start: Vector
) -> tuple[Vector, float]:
    """Direction to begin with, and the gap along it: that of the centres, or one that polytopes without faces need."""
    best = unit_or(start, HERE)
    gap = -math.inf if best == HERE else gap_along(a, b, best)
    if gap == -math.inf or a[N_FACES] == 0.0 or b[N_FACES] == 0.0:
        other = some_axis(geometry_a, pose_a, geometry_b, pose_b)
        here = gap_along(a, b, other)
        if here > gap:
            return other, here
    return best, gap


@kernel
def _holds(geometry: Row, pose: Row, x: Vector, close: float) -> bool:
    """Whether a polytope clearly holds a point, given relative to its pose's origin."""
    own = (
        pose[3] * x[0] + pose[6] * x[1] + pose[9] * x[2],
        pose[4] * x[0] + pose[7] * x[1] + pose[10] * x[2],
        pose[5] * x[0] + pose[8] * x[1] + pose[11] * x[2],
    )
    start = first_face(geometry)
    for at in range(start, start + FACE * int(geometry[N_FACES]), FACE):
        if dot(three(geometry, at), own) >= pose[FACTOR] * geometry[at + OFFSET] - close:
            return False
    return geometry[N_FACES] > 0.0


@kernel
def separation(
    geometry_a: Row,
    pose_a: Row,
    geometry_b: Row,
    pose_b: Row,
    start: Vector,
    a: Scratch,
    b: Scratch,
    s: Scratch,
    listed_a: Scratch,
    listed_b: Scratch,
) -> Answer:
    """Signed distance, normal and witness points, relative to the origin of A's pose.

    Parameters
    ----------
    geometry_a, pose_a, geometry_b, pose_b
        Rows as `polytopes` describes them.
    start
        Direction to begin with; zero for that of the centres.
    a, b
        Room for the two placed polytopes.
    s, listed_a, listed_b
        Room for a simplex, and for the edges of each, which are lists of `FEATURES` numbers at least.
    """
    offset = (pose_b[0] - pose_a[0], pose_b[1] - pose_a[1], pose_b[2] - pose_a[2])
    size = max(place_vertices(geometry_a, pose_a, HERE, a), place_vertices(geometry_b, pose_b, offset, b))
    blur = ROUNDING * size
    start = minus(three(b, CENTRE), three(a, CENTRE)) if start == HERE else start
    status, k, w, upper = MEETING, 0, HERE, 0.0
    if not _holds(geometry_a, pose_a, three(b, CENTRE), blur) and not _holds(
        geometry_b, pose_b, minus(three(a, CENTRE), offset), blur
    ):
        status, k, w, upper = nearest(a, b, HERE, start, blur / 2, s)
    if status == APART:
        return upper, w, on_first(a, s, k), on_second(b, s, k)
    best, gap = HERE, -math.inf
    if status != MEETING:
        best, gap = across_features(a, b, s, k, w, best, gap, upper - blur, listed_a)
    if status == MEETING or gap < upper - blur:
        place_faces(geometry_a, pose_a, HERE, a)
        place_faces(geometry_b, pose_b, offset, b)
        if gap == -math.inf:
            best, gap = _first_axis(geometry_a, pose_a, geometry_b, pose_b, a, b, start)
        best, gap, of_a, of_b = widest_axis(
            geometry_a, pose_a, geometry_b, pose_b, a, b, best, gap, size, listed_a, listed_b
        )
        met, x, y = meeting_points(geometry_a, geometry_b, a, b, gap, best, of_a, of_b, 2.0 * blur)
        if met:
            return gap, best, x, y
    x, y = touching_points(a, b, gap, best, blur / 2, s)
    return gap, best, x, y


@kernel
def write(answer: Scratch, sigma: float, n: Vector, x: Vector, y: Vector) -> None:
    """Put an answer into its row."""
    answer[0], answer[1], answer[2], answer[3] = sigma, n[0], n[1], n[2]
    answer[4], answer[5], answer[6], answer[7], answer[8], answer[9] = x[0], x[1], x[2], y[0], y[1], y[2]


@kernel
def comes_later(row: Row, other: Row) -> bool:
    """Whether a row of numbers comes after another in the order of the first numbers that differ."""
    for i in range(len(row)):
        if row[i] != other[i]:
            return row[i] > other[i]
    return False
