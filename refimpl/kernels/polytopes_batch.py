"""Batches of polytopes: their numbers become geometries and poses, pair by pair, scaled so that nothing overflows.

A side of a batch is one kind of proxy. Its numbers stand in a row each; derived geometries are shared by many rows
and stand in a table, with a note of where each lies and how large it is. All lengths of a pair are multiplied by one
power of two, which is exact, so that the largest becomes about 1; the answer is multiplied back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from . import kernel
from .axes import three
from .boxes import SEGMENT, TURNED, axes_of
from .gjk import store
from .polytopes import DIRECTION, FACE, FACTOR, FIRST, OFFSET, Row, Scratch, first_edge, first_face
from .polytopes_pair import comes_later, separation, write
from .vectors import Vector, dot, minus, opposite, plus, times, unit_or

POINT, STANDING, PLACED = 3, 4, 5
"""Kinds beside those of `boxes`, and their rows: a position (and more); a derived geometry, no numbers; a derived
geometry in a frame of its own, position and quaternion."""
MIDDLE, POWER = 0, 3
"""A note on a geometry: where its origin lies, the exponent of its scale, and two numbers that tell it from others."""
STEP = 1000
"""Powers of two beyond ±1000 are taken in two steps, so that neither overflows."""
NOTHING = -10_000
"""Exponent of the size of what has none."""
Ints = Sequence[int]


class Side(NamedTuple):
    """One side of a batch.

    Attributes
    ----------
    kind
        What the rows are.
    rows
        Numbers of each proxy.
    geometries, notes
        Table of derived geometries, and a note on each.
    which, powers
        For each proxy: its geometry, and the exponent by which that is to be scaled.
    own
        Geometry of a point, a segment or a box, to be filled in for each row.
    """

    kind: int
    rows: Sequence[Row]
    geometries: Sequence[Row]
    notes: Sequence[Row]
    which: Ints
    powers: Ints
    own: Scratch


@kernel
def _exponent(kind: int, row: Row, note: Row, power: int) -> int:
    """Exponent of the largest coordinate or extent of a proxy."""
    most, found = 0.0, NOTHING
    for i in range(0 if kind == STANDING else 3 if kind in (POINT, PLACED) else 6):
        most = max(most, abs(row[i]))
    if most > 0.0:
        found = math.frexp(most)[1]
    return max(found, int(note[POWER]) + power) if kind in (STANDING, PLACED) else found


@kernel
def _power(exponent: int) -> float:
    """2^exponent, by repeated squaring."""
    factor, found, n = 2.0 if exponent > 0 else 0.5, 1.0, abs(exponent)
    while n > 0:
        if n & 1:
            found *= factor
        factor *= factor
        n >>= 1
    return found


@kernel
def _powers(exponent: int) -> tuple[float, float]:
    """Two factors that make 2^exponent, of which neither overflows."""
    first = max(min(exponent, STEP), -STEP)
    return _power(first), _power(exponent - first)


@kernel
def _scaled(v: Vector, by: tuple[float, float]) -> Vector:
    """Vector times two factors."""
    return times(by[1], times(by[0], v))


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
def _put_derived(kind: int, row: Row, note: Row, factor: float, by: tuple[float, float], pose: Scratch) -> None:
    """Write the pose of a derived geometry, which is multiplied by `factor`."""
    middle = times(factor, three(note, MIDDLE))
    pose[FACTOR] = factor
    if kind == STANDING:
        _put_axes((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), pose)
        store(pose, 0, middle)
        return
    u, v, w = axes_of(row, 3)
    _put_axes(u, v, w, pose)
    turned = (dot(three(pose, 3), middle), dot(three(pose, 6), middle), dot(three(pose, 9), middle))
    store(pose, 0, plus(_scaled(three(row, 0), by), turned))


@kernel
def _put_own(kind: int, row: Row, by: tuple[float, float], own: Scratch, pose: Scratch) -> None:
    """Write the pose of a point, a segment or a box, and its geometry."""
    p = _scaled(three(row, 0), by)
    store(pose, 0, p)
    pose[FACTOR] = 1.0
    if kind == TURNED:
        u, v, w = axes_of(row, 6)
        _put_axes(u, v, w, pose)
        half = _scaled(three(row, 3), by)
        _put_box(opposite(half), half, own)
        return
    _put_axes((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), pose)
    if kind != POINT:
        q = _scaled(three(row, 3), by)
        origin = plus(times(0.5, p), times(0.5, q))
        store(pose, 0, origin)
        if kind == SEGMENT:
            _put_segment(minus(p, origin), minus(q, origin), own)
        else:
            _put_box(minus(p, origin), minus(q, origin), own)


@kernel
def _put(
    kind: int, row: Row, note: Row, power: int, exponent: int, by: tuple[float, float], own: Scratch, pose: Scratch
) -> None:
    """Write the pose of a proxy, all lengths times 2^exponent, and its geometry where that is its own."""
    if kind in (STANDING, PLACED):
        _put_derived(kind, row, note, _power(int(note[POWER]) + power + exponent), by, pose)
    else:
        _put_own(kind, row, by, own, pose)


@kernel
def _later(row: Row, note: Row, power: int, other_row: Row, other_note: Row, other_power: int) -> bool:
    """Whether the first of two proxies of one kind comes later in the order of their numbers."""
    if comes_later(row, other_row):
        return True
    if comes_later(other_row, row):
        return False
    return power > other_power if power != other_power else comes_later(note, other_note)


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
    derived_a, derived_b = a.kind in (STANDING, PLACED), b.kind in (STANDING, PLACED)
    for i in range(len(answers)):
        j, k, power_a, power_b, row_a, row_b = a.which[i], b.which[i], a.powers[i], b.powers[i], a.rows[i], b.rows[i]
        note_a, note_b = a.notes[j], b.notes[k]
        exponent = max(_exponent(a.kind, row_a, note_a, power_a), _exponent(b.kind, row_b, note_b, power_b))
        exponent = 0 if exponent == NOTHING else exponent
        by, back = _powers(-exponent), _powers(exponent)
        _put(a.kind, row_a, note_a, power_a, -exponent, by, a.own, pose_a)
        _put(b.kind, row_b, note_b, power_b, -exponent, by, b.own, pose_b)
        geometry_a, geometry_b = a.geometries[j] if derived_a else a.own, b.geometries[k] if derived_b else b.own
        turned = a.kind == b.kind and _later(row_a, note_a, power_a, row_b, note_b, power_b)
        if turned:
            found = separation(geometry_b, pose_b, geometry_a, pose_a, placed_b, placed_a, s, listed_b, listed_a)
        else:
            found = separation(geometry_a, pose_a, geometry_b, pose_b, placed_a, placed_b, s, listed_a, listed_b)
        sigma, n, x, y = found
        origin = three(pose_b, 0) if turned else three(pose_a, 0)
        x, y = _scaled(plus(origin, x), back), _scaled(plus(origin, y), back)
        if turned:
            n, x, y = opposite(n), y, x
        write(answers[i], sigma * back[0] * back[1], n, x, y)
