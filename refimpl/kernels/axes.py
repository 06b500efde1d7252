"""Separating axes of two placed polytopes: the direction along which the gap is widest, over all that can be it.

Where two polytopes overlap, the shortest way out leads along a face's normal of either, or across an edge of each
(Gottschalk, Lin and Manocha 1996). Faces are tried one by one. For edges there is a Gauss map: an edge can only
meet another along directions between the normals of its own two faces, on an arc (Gregorius, The Separating Axis
Test between Convex Polyhedra, 2013). Over an arc the gap is bounded from above by the vertices found for the
faces at its ends, and few arcs promise more than the best face does; only these are crossed with each other.

Every direction tried has its gap measured against all vertices, so none can claim too much; a bound that rounding
spoils costs no more than rounding.
"""

from __future__ import annotations

import math

from . import kernel
from .polytopes import (
    CENTRE,
    DIRECTION,
    EDGE,
    FACE,
    LEFT,
    N_EDGES,
    N_FACES,
    N_VERTICES,
    OFFSET,
    RIGHT,
    SEEN,
    Row,
    Scratch,
    first_edge,
    first_face,
    gap_along,
    lowest,
    vertex,
)
from .vectors import Vector, along, cross, dot, minus, opposite, perpendicular, unit_or

FEW = 16
"""So many vertices are simply all tried."""
REMEMBERED = 24
"""So many vertices, found far against some face, are tried on the next face first."""


@kernel
def three(row: Row, at: int) -> Vector:
    """Three numbers of a row."""
    return (row[at], row[at + 1], row[at + 2])


@kernel
def _shown_useless(body: Scratch, at: int, other: Row, known: Row, count: int, gap: float) -> bool:
    """Whether one of the remembered vertices keeps the gap in front of a face below `gap`; notes which."""
    n, offset = three(body, at), body[at + OFFSET]
    for i in range(count):
        if dot(n, vertex(other, int(known[i]))) - offset <= gap:
            body[at + SEEN] = known[i]
            return True
    return False


@kernel
def widest_face(body: Scratch, other: Row, gap: float, known: Scratch) -> tuple[int, float]:
    """Where the face of `body` starts in front of which the gap to `other` is widest, and that gap.

    −1 and `gap` when none has more than `gap`. Leaves at each face a vertex of the other that shows it.
    """
    start, found, count, latest = first_face(body), -1, 0, 0
    many = other[N_VERTICES] > FEW
    for at in range(start, start + FACE * int(body[N_FACES]), FACE):
        if many and _shown_useless(body, at, other, known, count, gap):
            continue
        n = three(body, at)
        i = lowest(other, n)
        body[at + SEEN] = i
        here = dot(n, vertex(other, i)) - body[at + OFFSET]
        if here > gap:
            found, gap = at, here
        if many:
            known[latest] = i
            latest = (latest + 1) % REMEMBERED
            count = min(count + 1, REMEMBERED)
    return found, gap


@kernel
def _promise(body: Row, other: Row, at: int) -> float:
    """Bound from above of the gap along all directions between the normals of an edge's two faces.

    Along m = α·u + β·v, α + β = 1, the gap times ‖m‖ is at most (q − p)·m, for p on the edge and any q of the other
    polytope: two such lines over α, from the vertices seen by the two faces, bound it.
    """
    if body[at + LEFT] < 0.0:
        return math.inf
    start = first_face(body)
    left, right = start + FACE * int(body[at + LEFT]), start + FACE * int(body[at + RIGHT])
    u, v, p = three(body, left), three(body, right), vertex(body, int(body[at]))
    q, r = minus(vertex(other, int(body[left + SEEN])), p), minus(vertex(other, int(body[right + SEEN])), p)
    qu, qv, ru, rv = dot(q, u), dot(q, v), dot(r, u), dot(r, v)
    most = max(min(qu, ru), min(qv, rv))
    rise, fall = qu - ru, rv - qv
    if rise * fall > 0.0:  # the lines cross between the ends
        middle = (qu * fall + qv * rise) / (rise + fall)
        most = max(most, middle)
    if most > 0.0:  # ‖m‖ is shortest in the middle
        shortest = math.sqrt(max(0.0, (1.0 + dot(u, v)) / 2.0))
        most = most / shortest if shortest > 0.0 else math.inf
    return most


@kernel
def promising_edges(body: Row, other: Row, gap: float, found: Scratch) -> int:
    """List where the edges start over whose arcs the gap may exceed `gap`; gives how many."""
    start, count = first_edge(body), 0
    for at in range(start, start + EDGE * int(body[N_EDGES]), EDGE):
        if _promise(body, other, at) > gap:
            found[count] = at
            count += 1
    return count


@kernel
def crossed(e: Vector, f: Vector) -> Vector:
    """Unit vector at right angles to two unit vectors; zero for parallel ones.

    Nearly parallel ones leave noise in their product, but only across both is it harmless: it is cleaned against the
    first, after which its part along the second is smaller still.
    """
    n = unit_or(cross(e, f), (0.0, 0.0, 0.0))
    n = along(n, -dot(n, e), e)
    n = along(n, -dot(n, f), f)
    return unit_or(along(n, -dot(n, e), e), (0.0, 0.0, 0.0))


@kernel
def _widest_of_edge(
    a: Row, b: Row, at: int, found: Row, count: int, best: Vector, gap: float, blur: float
) -> tuple[Vector, float]:
    """Try one edge of A crossed with the listed edges of B; give the best direction so far, and its gap."""
    p, e = vertex(a, int(a[at])), three(a, at + DIRECTION)
    inner_a, inner_b = minus(p, three(a, CENTRE)), three(b, CENTRE)
    for j in range(count):
        to = int(found[j])
        q, f = vertex(b, int(b[to])), three(b, to + DIRECTION)
        c, between = cross(e, f), minus(q, p)
        outwards = dot(c, inner_a) + dot(c, minus(inner_b, q))
        here = dot(c, between)
        if abs(outwards) <= blur:  # both lie flat across it
            outwards = here
        if outwards < 0.0:
            c, here = opposite(c), -here
        if here > gap * math.sqrt(dot(c, c)) - blur:
            n = crossed(e, f)
            n = opposite(n) if dot(n, c) < 0.0 else n
            if dot(n, between) > gap and n != (0.0, 0.0, 0.0):
                measured = gap_along(a, b, n)
                if measured > gap:
                    best, gap = n, measured
    return best, gap


@kernel
def widest_axis(
    a: Scratch, b: Scratch, best: Vector, gap: float, blur: float, listed: Scratch, known: Scratch
) -> tuple[Vector, float]:
    """Unit direction from A to B along which the gap is widest, and that gap, if it is more than `gap` along `best`.

    Parameters
    ----------
    best, gap
        A direction that is known already.
    blur
        A length that counts as rounding: where less is at stake, a direction is tried rather than dismissed.
    listed, known
        Room for as many numbers as the larger of the two has edges, and for `REMEMBERED`.
    """
    face, wider = widest_face(a, b, gap, known)
    if face >= 0:
        best, gap = three(a, face), wider
    face, wider = widest_face(b, a, gap, known)
    if face >= 0:
        best, gap = opposite(three(b, face)), wider
    count = promising_edges(b, a, gap, listed)
    if count > 0:
        start = first_edge(a)
        for at in range(start, start + EDGE * int(a[N_EDGES]), EDGE):
            if _promise(a, b, at) > gap:
                best, gap = _widest_of_edge(a, b, at, listed, count, best, gap, blur)
    return best, gap


@kernel
def some_axis(a: Row, b: Row) -> Vector:
    """Direction for polytopes without faces: across an edge where there is one."""
    if a[N_EDGES] > 0.0:
        return perpendicular(three(a, first_edge(a) + DIRECTION))
    if b[N_EDGES] > 0.0:
        return perpendicular(three(b, first_edge(b) + DIRECTION))
    return (1.0, 0.0, 0.0)
