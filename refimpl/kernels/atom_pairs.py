"""Signed distance of one atom of a union and one of another: the search that fits their kinds."""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import bodies, inlined, kernel
from .atoms import (
    BOX,
    ELLIPSOID,
    HALF_SPACE,
    HULL,
    KIND,
    MATRIX,
    NOWHERE,
    POINT,
    RADIUS,
    SEGMENT,
    SHAPE,
    SIZES,
    Scene,
    axis,
    core_support,
    origin,
    turned,
)
from .axes import three
from .boxes import AXES as FRAME_AXES
from .boxes import HALF, TURNED, separation_of_boxes
from .boxes import SEGMENT as LINE
from .curved import separation as separation_of_bodies
from .gjk import store
from .polytopes import DIRECTION, FACE, FACTOR, FIRST, N_VERTICES, OFFSET, Row, Scratch, first_edge, first_face
from .polytopes_pair import HERE, Answer
from .polytopes_pair import separation as separation_of_polytopes
from .segments import separation_of_segments
from .vectors import Vector, along, cross, dot, length, minus, opposite, perpendicular, plus, times, unit_or

PLACED_A, PLACED_B, SIMPLEX, LISTED_A, LISTED_B, FRAME_A, FRAME_B, POSE_B = 4, 5, 6, 7, 8, 9, 10, 11
GEOMETRY_A, GEOMETRY_B, LINE_A, LINE_B, DOT = 12, 13, 14, 15, 16
BODY_A, BODY_B, FACE_A, FACE_B, POINTS, PLANES = 17, 18, 19, 20, 21, 22
GAPS, ROWS = 23, 24
"""Rows of a scene's scratch space, after those of `nearby`: what polytopes and boxes need; geometries of boxes,
segments and points, of which all but the sizes is written already; what curved bodies need; a number for each pair of
atoms."""
FACETS, MARKS, KEYS, ORDER, WHOLE = 1, 2, 3, 4, 5
"""Rows of whole numbers, after that of `nearby`."""


@inlined
def _between_segments(a: Row, b: Row, offset: Vector) -> Answer:
    """Points and segments."""
    p, q = three(a, SIZES), three(b, SIZES)
    return separation_of_segments(opposite(p), p, minus(offset, q), plus(offset, q))


@kernel
def _put_frame(atom: Row, frame: Scratch) -> None:
    """Frame of a point, a segment or a box, as `boxes` describes it."""
    if atom[KIND] == BOX:
        store(frame, HALF, three(atom, SIZES))
        for k in range(3):
            store(frame, FRAME_AXES + 3 * k, axis(atom, k))
        return
    step = three(atom, SIZES)
    way = unit_or(step, (1.0, 0.0, 0.0))
    across = perpendicular(way)
    store(frame, HALF, (length(step), 0.0, 0.0))
    store(frame, FRAME_AXES, way)
    store(frame, FRAME_AXES + 3, across)
    store(frame, FRAME_AXES + 6, cross(way, across))


@inlined
def _with_box(a: Row, b: Row, offset: Vector, work: Sequence[Scratch]) -> Answer:
    """A point, a segment or a box, and a box."""
    _put_frame(a, work[FRAME_A])
    _put_frame(b, work[FRAME_B])
    kind = TURNED if a[KIND] == BOX else LINE
    return separation_of_boxes(
        kind, work[FRAME_A], work[FRAME_B], offset, work[PLACED_A], work[PLACED_B], work[SIMPLEX], work[LISTED_A]
    )


@kernel
def _box_geometry(atom: Row, row: Scratch) -> Row:
    """Geometry of a box, from that of the box from −1 to 1."""
    for i in range(8):
        for k in range(3):
            at = FIRST + 3 * i + k
            row[at] = math.copysign(atom[SIZES + k], row[at])
    at = first_face(row)
    for k in range(3):
        row[at + OFFSET + FACE * k] = row[at + OFFSET + FACE * (3 + k)] = atom[SIZES + k]
    return row


@kernel
def _line_geometry(atom: Row, row: Scratch) -> Row:
    """Geometry of a segment."""
    h = three(atom, SIZES)
    store(row, FIRST, opposite(h))
    store(row, FIRST + 3, h)
    store(row, first_edge(row) + DIRECTION, unit_or(h, (1.0, 0.0, 0.0)))
    return row


@inlined
def geometry_of(atom: Row, shapes: Sequence[Row], box: Scratch, line: Scratch, point: Row) -> Row:
    """Geometry of a point, a segment, a box or a hull."""
    if atom[KIND] == HULL:
        return shapes[int(atom[SHAPE])]
    if atom[KIND] == BOX:
        return _box_geometry(atom, box)
    return _line_geometry(atom, line) if atom[KIND] == SEGMENT else point


@inlined
def _between_polytopes(
    a: Row,
    shapes_a: Sequence[Row],
    b: Row,
    shapes_b: Sequence[Row],
    offset: Vector,
    start: Vector,
    work: Sequence[Scratch],
) -> Answer:
    """Points, segments, boxes and hulls."""
    pose = work[POSE_B]
    for i in range(3):
        pose[i] = a[i] + offset[i]
    for i in range(3, FACTOR + 1):
        pose[i] = b[i]
    first = geometry_of(a, shapes_a, work[GEOMETRY_A], work[LINE_A], work[DOT])
    second = geometry_of(b, shapes_b, work[GEOMETRY_B], work[LINE_B], work[DOT])
    return separation_of_polytopes(
        first, a, second, pose, start, work[PLACED_A], work[PLACED_B], work[SIMPLEX], work[LISTED_A], work[LISTED_B]
    )


@kernel
def _put_body(atom: Row, shapes: Sequence[Row], offset: Vector, row: Scratch) -> Row:
    """Any bounded atom as a body that `bodies` describes, its origin at `offset`, before it is widened."""
    row[bodies.RADIUS], row[bodies.COUNT] = 0.0, 1.0
    if atom[KIND] >= ELLIPSOID:
        row[bodies.KIND] = bodies.ELLIPSOID if atom[KIND] == ELLIPSOID else bodies.CYLINDER
        store(row, bodies.CENTER, offset)
        store(row, bodies.SIZES, three(atom, SIZES))
        for k in range(3):
            store(row, bodies.AXES + 3 * k, axis(atom, k))
        return row
    row[bodies.KIND] = bodies.HULL
    at = bodies.VERTICES
    if atom[KIND] == POINT:
        store(row, at, offset)
    elif atom[KIND] == SEGMENT:
        h = three(atom, SIZES)
        store(row, at, minus(offset, h))
        store(row, at + 3, plus(offset, h))
        row[bodies.COUNT] = 2.0 if dot(h, h) > 0.0 else 1.0
    elif atom[KIND] == BOX:
        x, y, z = times(atom[SIZES], axis(atom, 0)), times(atom[SIZES + 1], axis(atom, 1)), axis(atom, 2)
        row[bodies.COUNT] = 8.0
        for i in range(8):
            v = plus(offset, x) if i % 2 else minus(offset, x)
            v = plus(v, y) if i // 2 % 2 else minus(v, y)
            store(row, at + 3 * i, along(v, atom[SIZES + 2] if i // 4 else -atom[SIZES + 2], z))
    else:
        geometry = shapes[int(atom[SHAPE])]
        row[bodies.COUNT] = geometry[N_VERTICES]
        for i in range(int(geometry[N_VERTICES])):
            v = three(geometry, FIRST + 3 * i)
            store(row, at + 3 * i, along(offset, atom[FACTOR], turned(atom, v)))
    return row


@inlined
def _between_cores(
    a: Row,
    shapes_a: Sequence[Row],
    b: Row,
    shapes_b: Sequence[Row],
    offset: Vector,
    start: Vector,
    work: Sequence[Scratch],
    whole: Sequence[MutableSequence[int]],
) -> Answer:
    """Bounded atoms before they are widened, relative to the origin of the first, the kind of which comes first."""
    if b[KIND] >= ELLIPSOID:
        first = _put_body(a, shapes_a, HERE, work[BODY_A])
        second = _put_body(b, shapes_b, offset, work[BODY_B])
        return separation_of_bodies(
            first,
            second,
            work[SIMPLEX],
            work[POINTS],
            work[PLANES],
            whole[FACETS],
            whole[MARKS],
            work[FACE_A],
            work[FACE_B],
        )
    if b[KIND] == HULL:
        return _between_polytopes(a, shapes_a, b, shapes_b, offset, start, work)
    return _with_box(a, b, offset, work) if b[KIND] == BOX else _between_segments(a, b, offset)


@kernel
def _above_plane(plane: Row, level: float, atom: Row, shapes: Sequence[Row], place: Vector) -> Answer:
    """Half-space and any bounded atom at `place`, relative to the world's origin: its lowest point decides."""
    n = three(plane, MATRIX)
    lowest = core_support(atom, shapes, opposite(n))
    y = along(plus(place, lowest), -atom[RADIUS], n)
    sigma = (dot(n, place) + level) + (dot(n, lowest) - atom[RADIUS])
    return sigma, n, along(y, -sigma, n), y


@inlined
def _with_half_space(scene: Scene, a: Row, b: Row, move: Vector) -> Answer:
    """Pairs with a half-space, in the world's coordinates; two overlap without end, unless they face exactly."""
    if a[KIND] == HALF_SPACE and b[KIND] == HALF_SPACE:
        n = three(a, MATRIX)
        if a[SHAPE] == 0.0 or a[SHAPE] != b[SHAPE] or dot(n, three(b, MATRIX)) > 0.0:
            return -math.inf, NOWHERE, NOWHERE, NOWHERE
        sigma = (a[SIZES] + b[SIZES]) + dot(n, move)
        x = times(-a[SIZES], n)
        return sigma, n, x, along(x, sigma, n)
    if a[KIND] == HALF_SPACE:
        return _above_plane(a, a[SIZES], b, scene.shapes_b, plus(origin(b), move))
    level = b[SIZES] - dot(three(b, MATRIX), move)
    sigma, n, x, y = _above_plane(b, level, a, scene.shapes_a, origin(a))
    return sigma, opposite(n), y, x


@kernel
def answer(scene: Scene, i: int, j: int, move: Vector, start: Vector) -> Answer:
    """Signed distance of atom `i` of A and atom `j` of B once B is moved; the normal; witness points.

    A search begins with the direction `start`, or with that of the atoms' centres where `start` is zero.
    Minus infinity, with nothing else, for half-spaces that overlap without end.
    """
    a, b = scene.a[i], scene.b[j]
    if a[KIND] == HALF_SPACE or b[KIND] == HALF_SPACE:
        return _with_half_space(scene, a, b, move)
    base = origin(a)
    offset = plus(minus(origin(b), base), move)
    turned = a[KIND] > b[KIND]
    first, shapes = (b, scene.shapes_b) if turned else (a, scene.shapes_a)
    second, other_shapes = (a, scene.shapes_a) if turned else (b, scene.shapes_b)
    between, way = (opposite(offset), opposite(start)) if turned else (offset, start)
    sigma, n, x, y = _between_cores(first, shapes, second, other_shapes, between, way, scene.work, scene.whole)
    if turned:
        n, x, y = opposite(n), plus(y, offset), plus(x, offset)
    r, s = a[RADIUS], b[RADIUS]
    return sigma - (r + s), n, along(plus(base, x), r, n), along(plus(base, y), -s, n)
