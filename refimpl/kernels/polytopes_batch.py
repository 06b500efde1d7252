"""Batches of polytopes: their numbers become geometries and poses, pair by pair, scaled so that nothing overflows.

A side of a batch is one kind of proxy. Its numbers stand in a row each; derived geometries are shared by many rows
and stand in a table, with a note of where each lies and how large it is. All lengths of a pair are multiplied by one
power of two, which is exact, so that the largest becomes about 1; the answer is multiplied back.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from . import kernel
from .axes import three
from .boxes import SEGMENT, TURNED, axes_of
from .gjk import store
from .polytopes import DIRECTION, FACE, FACTOR, FIRST, OFFSET, Row, Scratch, first_edge, first_face
from .polytopes_pair import HERE, separation, write
from .scaling import Powers, exponent_of, larger, power, powers, scaled
from .vectors import Vector, dot, minus, opposite, plus, times, unit_or

POINT, STANDING, PLACED = 3, 4, 5
"""Kinds beside those of `boxes`, and their rows: a position (and more); a derived geometry, no numbers; a derived
geometry in a frame of its own, position and quaternion."""
MIDDLE, POWER = 0, 3
"""A note on a geometry: where its origin lies, the exponent of its scale, and two numbers that tell it from others."""
NOTE = 6
"""How many numbers a note has."""
Ints = Sequence[int]


class Side(NamedTuple):
    """One side of a batch.

    Attributes
    ----------
    kind
        What the rows are.
    rows, width
        Numbers of all proxies, one after the other, and how many each has.
    geometries, notes
        Table of derived geometries, and notes on them, one after the other.
    which, powers
        For each proxy: its geometry, and the exponent by which that is to be scaled.
    own
        Geometry of a point, a segment or a box, to be filled in for each row.
    """

    kind: int
    rows: Row
    width: int
    geometries: Sequence[Row]
    notes: Row
    which: Ints
    powers: Ints
    own: Scratch


@kernel
def _exponent(kind: int, rows: Row, at: int, derived: int) -> int:
    """Exponent of the largest coordinate or extent of a proxy, of whose geometry it is `derived`."""
    if kind in (STANDING, PLACED):
        return max(derived, exponent_of(rows, at, 3 if kind == PLACED else 0))
    return exponent_of(rows, at, 3 if kind == POINT else 6)


@kernel
def _put_segment(p: Vector, q: Vector, row: Scratch) -> None:
    """Write the ends and the direction of a segment."""
    store(row, FIRST, p)
    store(row, FIRST + 3, q)
    store(row, first_edge(row) + DIRECTION, unit_or(minus(q, p), (1.0, 0.0, 0.0)))


@kernel
def _put_box(lower: Vector, upper: Vector, row: Scratch) -> None:
    """Write the corners of a box, of which the z coordinate changes fastest, and the offsets of its faces."""
    at, face = FIRST, first_face(row) + OFFSET
    for i in range(8):
        row[at] = upper[0] if i & 4 else lower[0]
        row[at + 1] = upper[1] if i & 2 else lower[1]
        row[at + 2] = upper[2] if i & 1 else lower[2]
        at += 3
    row[face], row[face + FACE], row[face + 2 * FACE] = upper
    row[face + 3 * FACE], row[face + 4 * FACE], row[face + 5 * FACE] = opposite(lower)


@kernel
def _put_axes(u: Vector, v: Vector, w: Vector, pose: Scratch) -> None:
    """Write the matrix that has these columns."""
    for i in range(3):
        store(pose, 3 + 3 * i, (u[i], v[i], w[i]))


@kernel
def _put_derived(
    kind: int, rows: Row, at: int, notes: Row, note: int, factor: float, by: Powers, pose: Scratch
) -> None:
    """Write the pose of a derived geometry, which is multiplied by `factor`."""
    middle = times(factor, three(notes, note + MIDDLE))
    pose[FACTOR] = factor
    if kind == STANDING:
        _put_axes((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), pose)
        store(pose, 0, middle)
        return
    u, v, w = axes_of(rows, at + 3)
    _put_axes(u, v, w, pose)
    turned = (dot(three(pose, 3), middle), dot(three(pose, 6), middle), dot(three(pose, 9), middle))
    store(pose, 0, plus(scaled(three(rows, at), by), turned))


@kernel
def _put_own(kind: int, rows: Row, at: int, by: Powers, own: Scratch, pose: Scratch) -> None:
    """Write the pose of a point, a segment or a box, and its geometry."""
    p = scaled(three(rows, at), by)
    store(pose, 0, p)
    pose[FACTOR] = 1.0
    if kind == TURNED:
        u, v, w = axes_of(rows, at + 6)
        _put_axes(u, v, w, pose)
        half = scaled(three(rows, at + 3), by)
        _put_box(opposite(half), half, own)
        return
    _put_axes((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), pose)
    if kind != POINT:
        q = scaled(three(rows, at + 3), by)
        origin = plus(times(0.5, p), times(0.5, q))
        store(pose, 0, origin)
        if kind == SEGMENT:
            _put_segment(minus(p, origin), minus(q, origin), own)
        else:
            _put_box(minus(p, origin), minus(q, origin), own)


@kernel
def put(
    kind: int, rows: Row, at: int, notes: Row, note: int, total: int, by: Powers, own: Scratch, pose: Scratch
) -> None:
    """Write the pose of a proxy, lengths times `by`: with its own geometry, or a derived one times 2^total."""
    if kind in (STANDING, PLACED):
        _put_derived(kind, rows, at, notes, note, power(total), by, pose)
    else:
        _put_own(kind, rows, at, by, own, pose)


@kernel
def _order(x: Row, at: int, y: Row, to: int, count: int) -> float:
    """Positive if the first of the numbers that differ is greater in x, negative if it is in y, else 0."""
    for i in range(count):
        if x[at + i] != y[to + i]:
            return 1.0 if x[at + i] > y[to + i] else -1.0
    return 0.0


@kernel
def separations(
    a: Side,
    b: Side,
    pose_a: Scratch,
    pose_b: Scratch,
    placed_a: Scratch,
    placed_b: Scratch,
    s: Scratch,
    listed_a: Scratch,
    listed_b: Scratch,
    answers: Sequence[Scratch],
) -> None:
    """Answer a batch: signed distance, normal and both witness points, in world coordinates, 10 numbers a row.

    Of two of a kind, the one with the smaller numbers is put first, so that both orders give the same bits.
    """
    kind_a, rows_a, width_a, geometries_a, notes_a, which_a, powers_a, own_a = a
    kind_b, rows_b, width_b, geometries_b, notes_b, which_b, powers_b, own_b = b
    derived_a, derived_b = kind_a in (STANDING, PLACED), kind_b in (STANDING, PLACED)
    for i in range(len(answers)):
        at, to, note_a, note_b = width_a * i, width_b * i, NOTE * which_a[i], NOTE * which_b[i]
        exponent_a, exponent_b = int(notes_a[note_a + POWER]) + powers_a[i], int(notes_b[note_b + POWER]) + powers_b[i]
        exponent = larger(_exponent(kind_a, rows_a, at, exponent_a), _exponent(kind_b, rows_b, to, exponent_b))
        by, back = powers(-exponent), powers(exponent)
        put(kind_a, rows_a, at, notes_a, note_a, exponent_a - exponent, by, own_a, pose_a)
        put(kind_b, rows_b, to, notes_b, note_b, exponent_b - exponent, by, own_b, pose_b)
        geometry_a = geometries_a[which_a[i]] if derived_a else own_a
        geometry_b = geometries_b[which_b[i]] if derived_b else own_b
        order = 0.0
        if kind_a == kind_b:
            order = _order(rows_a, at, rows_b, to, width_a)
            order = 1.0 * (powers_a[i] - powers_b[i]) if order == 0.0 else order
            order = _order(notes_a, note_a, notes_b, note_b, NOTE) if order == 0.0 else order
        if order > 0.0:
            found = separation(geometry_b, pose_b, geometry_a, pose_a, HERE, placed_b, placed_a, s, listed_b, listed_a)
        else:
            found = separation(geometry_a, pose_a, geometry_b, pose_b, HERE, placed_a, placed_b, s, listed_a, listed_b)
        sigma, n, x, y = found
        origin = three(pose_b, 0) if order > 0.0 else three(pose_a, 0)
        x, y = scaled(plus(origin, x), back), scaled(plus(origin, y), back)
        if order > 0.0:
            n, x, y = opposite(n), y, x
        write(answers[i], sigma * back[0] * back[1], n, x, y)
