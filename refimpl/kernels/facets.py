"""Tangents of a pair of atoms by the list: all facets of the difference of two polytopes, else some from all around.

The points b − a, a ∈ A and b ∈ B, of two polytopes form a polytope. Its facets lie across the faces' normals of either,
and across an edge of each where their arcs on the Gauss map cross (`axes`). As long as the two overlap after a
translation, their signed distance is its greatest height above any of these planes. So once they are listed, nothing
need be searched for that pair any more.
"""

from __future__ import annotations

from collections.abc import Sequence

from . import inlined, kernel
from .atom_pairs import (
    DOT,
    GEOMETRY_A,
    GEOMETRY_B,
    LINE_A,
    LINE_B,
    LISTED_A,
    LISTED_B,
    PLACED_A,
    PLACED_B,
    geometry_of,
)
from .atoms import BOX as SOLID_BOX
from .atoms import HULL, KIND, RADIUS, SHAPE, Scene, origin, support_gap
from .axes import LISTED, crossed, miss_on_sphere, normals_of, three
from .polytopes import (
    BOX,
    DIRECTORY,
    EDGE,
    FACE,
    N_EDGES,
    N_FACES,
    OFFSET,
    Row,
    Scratch,
    edge_direction,
    first_edge,
    first_face,
    gap_along,
    lowest,
    place_faces,
    place_vertices,
    vertex,
)
from .tangents import NO_PLACE, UNKNOWN, Tangents, begin_again, is_full, learn, note_list
from .vectors import Vector, dot, minus, opposite, plus, times, unit_or

HERE = (0.0, 0.0, 0.0)
AROUND = 27
"""Directions to the middles of the sides, edges and corners of a cube, and none."""
MOST_EDGES = 48
"""More edges of a polytope are not crossed with all of another."""


@kernel
def around(i: int) -> Vector:
    """One of the directions all around."""
    return unit_or((i // 9 - 1.0, i // 3 % 3 - 1.0, i % 3 - 1.0), HERE)


@kernel
def _edges(atom: Row, shapes: Sequence[Row]) -> float:
    """How many edges an atom has, 0 for what is round or without an end, before it is widened."""
    if atom[KIND] == HULL:
        return shapes[int(atom[SHAPE])][N_EDGES]
    return 12.0 if atom[KIND] == SOLID_BOX else 1.0 if atom[KIND] < SOLID_BOX else 0.0


@kernel
def _put_edges(geometry: Row, pose: Row, found: Scratch) -> int:
    """List all edges: where they start, and their turned directions. Gives the length of the list."""
    start, to = first_edge(geometry), 0
    for at in range(start, start + EDGE * int(geometry[N_EDGES]), EDGE):
        found[to] = at
        found[to + 1], found[to + 2], found[to + 3] = edge_direction(geometry, at, pose)
        to += LISTED
    return to


@kernel
def _learn_side(known: Tangents, pair: int, n: Vector, gap: float) -> None:
    """Learn the tangent across a unit vector, along which there is a gap."""
    if not is_full(known):
        learn(known, pair, NO_PLACE, HERE, gap, n, UNKNOWN)


@kernel
def _learn_faces(known: Tangents, pair: int, body: Row, other: Row, radius: float, sign: float) -> None:
    """Learn the facets along the faces of one of two polytopes."""
    start = first_face(body)
    for at in range(start, start + FACE * int(body[N_FACES]), FACE):
        n = three(body, at)
        gap = dot(n, vertex(other, lowest(other, n))) - body[at + OFFSET]
        _learn_side(known, pair, times(sign, n), gap - radius)


@kernel
def _learn_crossings_of_boxes(known: Tangents, pair: int, a: Row, b: Row, radius: float) -> None:
    """Learn the facets across the edges of two boxes, maybe skew ones: for each two directions there is one each way."""
    for k in range(3):
        e = unit_or(three(a, first_edge(a) + 3 * k), HERE)
        for m in range(3):
            n = crossed(e, unit_or(three(b, first_edge(b) + 3 * m), HERE))
            if n != HERE:
                _learn_side(known, pair, n, gap_along(a, b, n) - radius)
                _learn_side(known, pair, opposite(n), gap_along(a, b, opposite(n)) - radius)


@kernel
def _learn_crossings(
    known: Tangents,
    pair: int,
    geometry_a: Row,
    geometry_b: Row,
    a: Row,
    b: Row,
    listed_a: Row,
    listed_b: Row,
    ends: tuple[int, int],
    radius: float,
) -> None:
    """Learn the facets across listed edges of two polytopes, where their arcs cross."""
    for k in range(0, ends[0], LISTED):
        e, arc = three(listed_a, k + 1), normals_of(geometry_a, int(listed_a[k]), a)
        for m in range(0, ends[1], LISTED):
            f, other = three(listed_b, m + 1), normals_of(geometry_b, int(listed_b[m]), b)
            if not miss_on_sphere(arc, e, other, f):
                n = crossed(e, f)
                outwards = dot(plus(arc[0], arc[1]), n) - dot(plus(other[0], other[1]), n)
                if n != HERE:
                    n = opposite(n) if outwards < 0.0 else n
                    _learn_side(known, pair, n, gap_along(a, b, n) - radius)


@inlined
def _learn_facets(scene: Scene, known: Tangents, pair: int, i: int, j: int) -> None:
    """Learn all facets of the difference of two polytopes."""
    atom_a, atom_b, work = scene.a[i], scene.b[j], scene.work
    radius = atom_a[RADIUS] + atom_b[RADIUS]
    first = geometry_of(atom_a, scene.shapes_a, work[GEOMETRY_A], work[LINE_A], work[DOT])
    second = geometry_of(atom_b, scene.shapes_b, work[GEOMETRY_B], work[LINE_B], work[DOT])
    a, b, offset = work[PLACED_A], work[PLACED_B], minus(origin(atom_b), origin(atom_a))
    place_vertices(first, atom_a, HERE, a)
    place_vertices(second, atom_b, offset, b)
    place_faces(first, atom_a, HERE, a)
    place_faces(second, atom_b, offset, b)
    _learn_faces(known, pair, a, b, radius, 1.0)
    _learn_faces(known, pair, b, a, radius, -1.0)
    if a[DIRECTORY] == BOX and b[DIRECTORY] == BOX:
        _learn_crossings_of_boxes(known, pair, a, b, radius)
        return
    listed_a, listed_b = work[LISTED_A], work[LISTED_B]
    ends = _put_edges(first, atom_a, listed_a), _put_edges(second, atom_b, listed_b)
    _learn_crossings(known, pair, first, second, a, b, listed_a, listed_b, ends, radius)


@inlined
def learn_list(scene: Scene, known: Tangents, pair: int) -> None:
    """Learn tangents of a pair of bounded atoms by the list."""
    across = len(scene.b)
    i, j = pair // across, pair % across
    a, b = scene.a[i], scene.b[j]
    few, other = _edges(a, scene.shapes_a), _edges(b, scene.shapes_b)
    begin_again(known, pair)
    if max(few, other) > 1.0 and min(few, other) > 0.0 and max(few, other) <= MOST_EDGES:
        _learn_facets(scene, known, pair, i, j)
        note_list(known, pair, a[RADIUS] + b[RADIUS] == 0.0)
        return
    for k in range(AROUND):
        n = around(k)
        if n != HERE and not is_full(known):
            learn(known, pair, NO_PLACE, HERE, support_gap(scene, i, j, HERE, n), n, UNKNOWN)
    note_list(known, pair, False)
