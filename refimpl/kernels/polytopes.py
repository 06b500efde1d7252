"""Polytopes as flat rows of floats: their layout, their placing in space, their support vertices.

A polytope's own geometry is a row::

    [vertices, faces, edges, centre (3), where the faces start, where the edges start, where the directory starts,
     vertices (3 each), faces (6 each), edges (8 each), directory]

centre
    Some point of the polytope.
vertex
    x, y, z.
face
    Outward unit normal, its offset (the support function along it), and two places for the separating axes: a
    vertex of *another* polytope that lies far against the normal, and the gap that it leaves.
edge
    Its two vertices, the two faces at it (−1 twice for a lone segment), its unit direction, and how far the faces'
    normals are apart.
directory
    Of a polytope with many vertices: the vertex farthest along each of the directions through the cells of a
    grid on the six sides of a cube. Others have none, and start it at 0; a box, maybe a skew one, whose vertex number
    i lies ahead along those of its three edges of which i has the bit, says `BOX`.

A pose is a row of 13 numbers: where the geometry's origin lies, its rotation matrix row by row, and a factor, a power
of two, by which all lengths of the geometry are multiplied. A placed polytope has the same layout without edges and
directory, but a box has its three half edges there; all lengths are then relative to one point near both polytopes of
a pair, so that nothing is lost far from the world's origin.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

from . import kernel
from .vectors import Vector

N_VERTICES, N_FACES, N_EDGES, CENTRE, FACES, EDGES, DIRECTORY, FIRST = 0, 1, 2, 3, 6, 7, 8, 9
FACE, EDGE, GRID = 6, 8, 8
OFFSET, SEEN, GAP = 3, 4, 5
LEFT, RIGHT, DIRECTION, CHORD = 2, 3, 4, 7
BOX = -1.0
"""Instead of the start of a directory."""
FACTOR = 12
"""Where a pose keeps its factor."""

Row = Sequence[float]
Scratch = MutableSequence[float]


@kernel
def first_face(body: Row) -> int:
    """Where the faces of a polytope start."""
    return int(body[FACES])


@kernel
def first_edge(body: Row) -> int:
    """Where the edges of a polytope start."""
    return int(body[EDGES])


@kernel
def vertex(body: Row, i: int) -> Vector:
    """Vertex number `i`."""
    at = FIRST + 3 * i
    return (body[at], body[at + 1], body[at + 2])


@kernel
def farthest(body: Row, n: Vector) -> int:
    """Index of the first vertex that is farthest along `n`."""
    x, y, z = n
    if body[DIRECTORY] == BOX:
        at = first_edge(body)
        i = 1 if body[at] * x + body[at + 1] * y + body[at + 2] * z > 0.0 else 0
        i += 2 if body[at + 3] * x + body[at + 4] * y + body[at + 5] * z > 0.0 else 0
        return i + (4 if body[at + 6] * x + body[at + 7] * y + body[at + 8] * z > 0.0 else 0)
    best, at = 0, FIRST
    most = body[at] * x + body[at + 1] * y + body[at + 2] * z
    for i in range(1, int(body[N_VERTICES])):
        at += 3
        here = body[at] * x + body[at + 1] * y + body[at + 2] * z
        if here > most:
            best, most = i, here
    return best


@kernel
def farthest_of(geometry: Row, n: Vector) -> int:
    """The same of a geometry that is not placed."""
    if geometry[DIRECTORY] != BOX:
        return farthest(geometry, n)
    x, y, z = n
    start = geometry[FIRST] * x + geometry[FIRST + 1] * y + geometry[FIRST + 2] * z
    best = 0
    for k in range(3):
        at = FIRST + 3 * (1 << k)
        best += (1 << k) if geometry[at] * x + geometry[at + 1] * y + geometry[at + 2] * z > start else 0
    return best


@kernel
def lowest(body: Row, n: Vector) -> int:
    """Index of the first vertex that is farthest against `n`."""
    return farthest(body, (-n[0], -n[1], -n[2]))


@kernel
def gap_along(a: Row, b: Row, n: Vector) -> float:
    """Gap between two placed polytopes along the unit vector `n`, from the first to the second."""
    p, q = vertex(a, farthest(a, n)), vertex(b, lowest(b, n))
    return (q[0] - p[0]) * n[0] + (q[1] - p[1]) * n[1] + (q[2] - p[2]) * n[2]


@kernel
def _turned(geometry: Row, at: int, pose: Row, factor: float, shift: Vector, body: Scratch) -> None:
    x, y, z = factor * geometry[at], factor * geometry[at + 1], factor * geometry[at + 2]
    body[at] = shift[0] + (pose[3] * x + pose[4] * y + pose[5] * z)
    body[at + 1] = shift[1] + (pose[6] * x + pose[7] * y + pose[8] * z)
    body[at + 2] = shift[2] + (pose[9] * x + pose[10] * y + pose[11] * z)


@kernel
def _place_half_edges(geometry: Row, pose: Row, body: Scratch) -> None:
    """Write the turned half edges of a box, from its first corner to those with one bit."""
    half = 0.5 * pose[FACTOR]
    for k in range(3):
        to = FIRST + 3 * (1 << k)
        x = half * (geometry[to] - geometry[FIRST])
        y = half * (geometry[to + 1] - geometry[FIRST + 1])
        z = half * (geometry[to + 2] - geometry[FIRST + 2])
        at = first_edge(geometry) + 3 * k
        body[at] = pose[3] * x + pose[4] * y + pose[5] * z
        body[at + 1] = pose[6] * x + pose[7] * y + pose[8] * z
        body[at + 2] = pose[9] * x + pose[10] * y + pose[11] * z


@kernel
def place_vertices(geometry: Row, pose: Row, shift: Vector, body: Scratch) -> float:
    """Write the turned vertices, and the turned centre, relative to the origin of the pose moved by −`shift`.

    Gives the largest absolute coordinate of the vertices.
    """
    for i in range(FIRST):
        body[i] = geometry[i]
    _turned(geometry, CENTRE, pose, pose[FACTOR], shift, body)
    most = 0.0
    for at in range(FIRST, FIRST + 3 * int(geometry[N_VERTICES]), 3):
        _turned(geometry, at, pose, pose[FACTOR], shift, body)
        most = max(most, abs(body[at]), abs(body[at + 1]), abs(body[at + 2]))
    if geometry[DIRECTORY] == BOX:
        _place_half_edges(geometry, pose, body)
    return most


@kernel
def place_faces(geometry: Row, pose: Row, shift: Vector, body: Scratch) -> None:
    """Write the turned faces of a polytope whose vertices are placed already."""
    at = first_face(geometry)
    for _ in range(int(geometry[N_FACES])):
        _turned(geometry, at, pose, 1.0, (0.0, 0.0, 0.0), body)
        moved = body[at] * shift[0] + body[at + 1] * shift[1] + body[at + 2] * shift[2]
        body[at + OFFSET] = pose[FACTOR] * geometry[at + OFFSET] + moved
        at += FACE


@kernel
def edge_direction(geometry: Row, at: int, pose: Row) -> Vector:
    """Turned unit direction of the edge that starts at `at`."""
    x, y, z = geometry[at + DIRECTION], geometry[at + DIRECTION + 1], geometry[at + DIRECTION + 2]
    return (
        pose[3] * x + pose[4] * y + pose[5] * z,
        pose[6] * x + pose[7] * y + pose[8] * z,
        pose[9] * x + pose[10] * y + pose[11] * z,
    )


@kernel
def cell_of(x: float, y: float, z: float) -> int:
    """Cell of the directory that a direction other than zero points through."""
    a, b, c = abs(x), abs(y), abs(z)
    if a >= b and a >= c:
        side, u, v = 0 if x > 0.0 else 1, y / a, z / a
    elif b >= c:
        side, u, v = 2 if y > 0.0 else 3, z / b, x / b
    else:
        side, u, v = 4 if z > 0.0 else 5, x / c, y / c
    i = min(int((u + 1.0) * (GRID / 2)), GRID - 1)
    j = min(int((v + 1.0) * (GRID / 2)), GRID - 1)
    return (side * GRID + i) * GRID + j


@kernel
def rather_low(geometry: Row, pose: Row, n: Vector) -> int:
    """A vertex far against `n`, if not the farthest, of a polytope with a directory."""
    x = pose[3] * n[0] + pose[6] * n[1] + pose[9] * n[2]
    y = pose[4] * n[0] + pose[7] * n[1] + pose[10] * n[2]
    z = pose[5] * n[0] + pose[8] * n[1] + pose[11] * n[2]
    return int(geometry[int(geometry[DIRECTORY]) + cell_of(-x, -y, -z)])
