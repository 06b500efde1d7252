"""Tangents of a pair of atoms by the list: all facets of the difference of two polytopes, else some from all around.

The points b − a, a ∈ A and b ∈ B, of two polytopes form a polytope. Its facets lie along the faces of either, and
across an edge of each where their arcs on the Gauss map cross (`axes`). As long as the two overlap after a
translation, their signed distance is its greatest height above any of these planes. So once they are listed, nothing
need be searched for that pair any more.

Four edges of a box have one direction, and their arcs make a whole circle: what crosses it crosses one of them.
"""

from __future__ import annotations

import math
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
from .axes import CLEARLY, crossed, miss_on_sphere, normals_of, three
from .gjk import store
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
from .vectors import Vector, cross, dot, minus, opposite, plus, times, unit_or

HERE = (0.0, 0.0, 0.0)
AROUND = 27
"""Directions to the middles of the sides, edges and corners of a cube, and none."""
MOST_CROSSINGS = 1024
"""Pairs of edges that are worth looking at."""
SIDE = 9
"""An edge in a list: its direction, and the normals of the faces at it: where its arc begins and ends."""
SLANT = 0.25
"""Squared sine of an angle from which on a cross product is precise enough as it is."""


@kernel
def around(i: int) -> Vector:
    """One of the directions all around."""
    return unit_or((i // 9 - 1.0, i // 3 % 3 - 1.0, i % 3 - 1.0), HERE)


@kernel
def _edges(atom: Row, shapes: Sequence[Row]) -> float:
    """How many edges of an atom are listed, before it is widened; infinitely many of what is round."""
    if atom[KIND] == HULL:
        geometry = shapes[int(atom[SHAPE])]
        return 3.0 if geometry[DIRECTORY] == BOX else geometry[N_EDGES]
    return 3.0 if atom[KIND] == SOLID_BOX else atom[KIND] if atom[KIND] < SOLID_BOX else math.inf


@kernel
def _put_edges(geometry: Row, pose: Row, body: Row, found: Scratch) -> int:
    """List the edges of a placed polytope, and of a box one for each direction. Gives the length of the list."""
    start, to = first_edge(geometry), 0
    if geometry[DIRECTORY] == BOX:
        for k in range(3):
            store(found, to, unit_or(three(body, start + 3 * k), HERE))
            store(found, to + 3, HERE)
            store(found, to + 6, HERE)
            to += SIDE
        return to
    for at in range(start, start + EDGE * int(geometry[N_EDGES]), EDGE):
        u, v = normals_of(geometry, at, body)
        store(found, to, edge_direction(geometry, at, pose))
        store(found, to + 3, u)
        store(found, to + 6, v)
        to += SIDE
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
def _across(e: Vector, f: Vector) -> Vector:
    """Unit vector at right angles to two unit vectors; zero for parallel ones."""
    c = cross(e, f)
    square = dot(c, c)
    return times(1.0 / math.sqrt(square), c) if square > SLANT else crossed(e, f)


@kernel
def _learn_crossings(
    known: Tangents, pair: int, a: Row, listed_a: Row, end_a: int, b: Row, listed_b: Row, end_b: int, radius: float
) -> None:
    """Learn the facets across listed edges of two polytopes, where their arcs cross; of whole circles on both sides."""
    for k in range(0, end_a, SIDE):
        e, arc = three(listed_a, k), (three(listed_a, k + 3), three(listed_a, k + 6))
        for m in range(0, end_b, SIDE):
            f, other = three(listed_b, m), (three(listed_b, m + 3), three(listed_b, m + 6))
            if miss_on_sphere(arc, e, other, f):
                continue
            n = _across(e, f)
            side = dot(plus(arc[0], arc[1]), n) - dot(plus(other[0], other[1]), n)
            if n != HERE and side > -CLEARLY:
                _learn_side(known, pair, n, gap_along(a, b, n) - radius)
            if n != HERE and side < CLEARLY:
                _learn_side(known, pair, opposite(n), gap_along(a, b, opposite(n)) - radius)


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
    listed_a, listed_b = work[LISTED_A], work[LISTED_B]
    end_a, end_b = _put_edges(first, atom_a, a, listed_a), _put_edges(second, atom_b, b, listed_b)
    _learn_crossings(known, pair, a, listed_a, end_a, b, listed_b, end_b, radius)


@inlined
def learn_list(scene: Scene, known: Tangents, pair: int) -> None:
    """Learn tangents of a pair of bounded atoms by the list."""
    across = len(scene.b)
    i, j = pair // across, pair % across
    a, b = scene.a[i], scene.b[j]
    edges_a, edges_b = _edges(a, scene.shapes_a), _edges(b, scene.shapes_b)
    begin_again(known, pair)
    if max(edges_a, edges_b) > 1.0 and edges_a * edges_b <= MOST_CROSSINGS:
        _learn_facets(scene, known, pair, i, j)
        note_list(known, pair, a[RADIUS] + b[RADIUS] == 0.0)
        return
    for k in range(AROUND):
        n = around(k)
        if n != HERE and not is_full(known):
            learn(known, pair, NO_PLACE, HERE, support_gap(scene, i, j, HERE, n), n, UNKNOWN)
    note_list(known, pair, False)
