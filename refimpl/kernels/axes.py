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
    CHORD,
    DIRECTORY,
    EDGE,
    FACE,
    GAP,
    LEFT,
    N_EDGES,
    N_FACES,
    OFFSET,
    RIGHT,
    SEEN,
    Row,
    Scratch,
    edge_direction,
    farthest,
    first_edge,
    first_face,
    gap_along,
    lowest,
    rather_low,
    vertex,
)
from .vectors import Vector, along, cross, dot, minus, opposite, perpendicular, unit_or

CLEARLY = 2.0**-44
"""A product of two cosines beyond this is not made of rounding."""
ROUNDING = 2.0**-51
"""Lengths that differ by no more than this, relative to the coordinates, are equal up to rounding."""
ROOT_3 = 1.7320508075688774
NOWHERE = (0.0, 0.0, 0.0)
LISTED = 4
"""An edge in a list: where it starts in its geometry, and its direction."""


@kernel
def three(row: Row, at: int) -> Vector:
    """Three numbers of a row."""
    return (row[at], row[at + 1], row[at + 2])


@kernel
def widest_face(body: Scratch, other: Row, geometry: Row, pose: Row, first: int, gap: float) -> tuple[int, float]:
    """Where the face of `body` starts in front of which the gap to `other` is widest, and that gap.

    −1 and `gap` when none has more than `gap`. Leaves at each face a vertex of the other, and the gap that it leaves,
    which is the face's own where that could be the widest. `geometry` and `pose` are those of the other, whose
    vertex `first` is tried before others.
    """
    start = first_face(body)
    end = start + FACE * int(body[N_FACES])
    found, most, top, by_directory = -1, gap, -1, geometry[DIRECTORY] > 0.0
    v = vertex(other, first)
    for at in range(start, end, FACE):
        n, offset = three(body, at), body[at + OFFSET]
        i, here = first, dot(n, v) - offset
        if here > gap:
            i = rather_low(geometry, pose, n) if by_directory else lowest(other, n)
            here = dot(n, vertex(other, i)) - offset
        body[at + SEEN], body[at + GAP] = i, here
        if here > most:
            most, top = here, at
            gap = gap if by_directory else most
    if not by_directory:
        return top, most
    for at in range(start - FACE if top >= 0 else end, end, FACE):  # the most promising one comes first
        face = at if at >= start else top
        if body[face + GAP] > gap:
            n = three(body, face)
            i = lowest(other, n)
            here = dot(n, vertex(other, i)) - body[face + OFFSET]
            body[face + SEEN], body[face + GAP] = i, here
            if here > gap:
                found, gap = face, here
    return found, gap


@kernel
def _promise(geometry: Row, at: int, body: Row, other: Row) -> float:
    """Bound from above of the gap along all directions between the normals of an edge's two faces.

    Along m = α·u + β·v, α + β = 1, the gap times ‖m‖ is at most (q − p)·m, for p on the edge and any q of the other
    polytope: two such lines over α, from the vertices seen by the two faces, bound it.
    """
    if geometry[at + LEFT] < 0.0:
        return math.inf
    start = first_face(body)
    left, right = start + FACE * int(geometry[at + LEFT]), start + FACE * int(geometry[at + RIGHT])
    u, v = three(body, left), three(body, right)
    qu, rv = body[left + GAP], body[right + GAP]
    qv = dot(v, vertex(other, int(body[left + SEEN]))) - body[right + OFFSET]
    ru = dot(u, vertex(other, int(body[right + SEEN]))) - body[left + OFFSET]
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
def promising_edges(geometry: Row, pose: Row, body: Row, other: Row, gap: float, span: float, found: Scratch) -> int:
    """List the edges over whose arcs the gap may exceed `gap`; gives how many.

    A vertex that both faces see bounds the gap over all the arc by the gaps that it leaves at its ends. And no two
    points of the two polytopes are farther apart than `span`: so the gap grows by less than that times the turn from
    either end. This dismisses most edges of a large polytope.
    """
    start, faces, count = first_edge(geometry), first_face(body), 0
    for at in range(start, start + EDGE * int(geometry[N_EDGES]), EDGE):
        if geometry[at + LEFT] >= 0.0:
            left, right = faces + FACE * int(geometry[at + LEFT]), faces + FACE * int(geometry[at + RIGHT])
            most = max(body[left + GAP], body[right + GAP])
            if body[left + SEEN] != body[right + SEEN]:
                most = (body[left + GAP] + body[right + GAP] + span * geometry[at + CHORD]) / 2.0
            if most <= gap and most <= 0.0:
                continue
        if _promise(geometry, at, body, other) > gap:
            to = LISTED * count
            found[to] = at
            found[to + 1], found[to + 2], found[to + 3] = edge_direction(geometry, at, pose)
            count += 1
    return count


@kernel
def crossed(e: Vector, f: Vector) -> Vector:
    """Unit vector at right angles to two unit vectors; zero for parallel ones.

    Nearly parallel ones leave noise in their product, but only across both is it harmless: it is cleaned against the
    first, after which its part along the second is smaller still.
    """
    n = unit_or(cross(e, f), NOWHERE)
    n = along(n, -dot(n, e), e)
    n = along(n, -dot(n, f), f)
    return unit_or(along(n, -dot(n, e), e), NOWHERE)


@kernel
def normals_of(geometry: Row, at: int, body: Row) -> tuple[Vector, Vector]:
    """Normals of the two faces at an edge; zero for a lone segment."""
    if geometry[at + LEFT] < 0.0:
        return NOWHERE, NOWHERE
    start = first_face(body)
    left, right = start + FACE * int(geometry[at + LEFT]), start + FACE * int(geometry[at + RIGHT])
    return three(body, left), three(body, right)


@kernel
def miss_on_sphere(arc: tuple[Vector, Vector], e: Vector, other: tuple[Vector, Vector], f: Vector) -> bool:
    """Whether the arc of an edge e of A, and that of an edge f of B turned inside out, clearly have no point in common.

    They cross where each has its ends on both sides of the other's great circle, and both are on one hemisphere.
    """
    (u, v), (s, t) = arc, other
    if dot(u, f) * dot(v, f) > CLEARLY or dot(s, e) * dot(t, e) > CLEARLY:
        return True
    c = cross(e, f)
    return (dot(u, c) + dot(v, c)) * (dot(s, c) + dot(t, c)) > CLEARLY


@kernel
def _widest_of_pair(
    a: Row, b: Row, p: Vector, e: Vector, q: Vector, f: Vector, best: Vector, gap: float, blur: float
) -> tuple[Vector, float]:
    """Try the edge of A at `p` along `e` crossed with that of B at `q` along `f`; the better of this and `best`."""
    c, between = cross(e, f), minus(q, p)
    outwards = dot(c, minus(p, three(a, CENTRE))) + dot(c, minus(three(b, CENTRE), q))
    here = dot(c, between)
    if abs(outwards) <= blur:  # both lie flat across it
        outwards = here
    if outwards < 0.0:
        c, here = opposite(c), -here
    if here > gap * math.sqrt(dot(c, c)) - blur:
        n = crossed(e, f)
        n = opposite(n) if dot(n, c) < 0.0 else n
        if dot(n, between) > gap and n != NOWHERE:
            measured = gap_along(a, b, n)
            if measured > gap:
                return n, measured
    return best, gap


@kernel
def widest_axis(
    geometry_a: Row,
    pose_a: Row,
    geometry_b: Row,
    pose_b: Row,
    a: Scratch,
    b: Scratch,
    best: Vector,
    gap: float,
    size: float,
    listed_a: Scratch,
    listed_b: Scratch,
) -> tuple[Vector, float, int, int]:
    """Unit direction from A to B along which the gap is widest, and that gap, if it is more than `gap` along `best`.

    And whose it is: where the edge of A and that of B start in their geometries, or a face of A or of B in the placed
    polytopes, the other being −1; −1 for both if it is that of neither.

    Parameters
    ----------
    geometry_a, pose_a, geometry_b, pose_b, a, b
        The polytopes, and as they are placed, vertices and faces.
    best, gap
        A direction that is known already.
    size
        Largest coordinate of the placed polytopes.
    listed_a, listed_b
        Room for `LISTED` numbers for each edge of either.
    """
    blur, span = ROUNDING * size, 2.0 * ROOT_3 * size
    found_a, gap = widest_face(a, b, geometry_b, pose_b, lowest(b, best), gap)
    if found_a >= 0:
        best = three(a, found_a)
    found_b, gap = widest_face(b, a, geometry_a, pose_a, farthest(a, best), gap)
    if found_b >= 0:
        best, found_a = opposite(three(b, found_b)), -1
    count_b = promising_edges(geometry_b, pose_b, b, a, gap, span, listed_b)
    count_a = promising_edges(geometry_a, pose_a, a, b, gap, span, listed_a) if count_b > 0 else 0
    for i in range(0, LISTED * count_a, LISTED):
        at, e = int(listed_a[i]), three(listed_a, i + 1)
        p, arc = vertex(a, int(geometry_a[at])), normals_of(geometry_a, at, a)
        for j in range(0, LISTED * count_b, LISTED):
            to, f = int(listed_b[j]), three(listed_b, j + 1)
            if not miss_on_sphere(arc, e, normals_of(geometry_b, to, b), f):
                q = vertex(b, int(geometry_b[to]))
                n, wider = _widest_of_pair(a, b, p, e, q, f, best, gap, blur)
                if wider > gap:
                    best, gap, found_a, found_b = n, wider, at, to
    return best, gap, found_a, found_b


@kernel
def some_axis(geometry_a: Row, pose_a: Row, geometry_b: Row, pose_b: Row) -> Vector:
    """Direction for polytopes without faces: across an edge where there is one."""
    if geometry_a[N_EDGES] > 0.0:
        return perpendicular(edge_direction(geometry_a, first_edge(geometry_a), pose_a))
    if geometry_b[N_EDGES] > 0.0:
        return perpendicular(edge_direction(geometry_b, first_edge(geometry_b), pose_b))
    return (1.0, 0.0, 0.0)
