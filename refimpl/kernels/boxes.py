"""Signed distance of two boxes, or of a segment and a box: fifteen or six axes, and nearest points when apart.

A frame is a row of 15 numbers: centre, half extents, and three unit axes one after the other. A segment is the frame
whose first axis alone has an extent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import kernel
from .axes import ROUNDING, crossed, three
from .polytopes import BOX, CENTRE, DIRECTORY, EDGES, FIRST, N_VERTICES, Row, Scratch
from .polytopes_nearest import APART, nearest, on_first, on_second
from .polytopes_pair import HERE, Answer, across_features, comes_later, touching_points, write
from .scaling import Powers, exponent_of, larger, powers, scaled
from .vectors import Vector, cross, dot, length, minus, opposite, perpendicular, plus, times, unit_or

SEGMENT, ALIGNED, TURNED = 0, 1, 2
"""What a row of numbers is: p, q (and a radius); lower, upper; centre, half extents, quaternion."""
HALF, AXES, FRAME = 3, 6, 15
NUMBERS = 10
"""How many numbers a proxy has at most."""
PLACED = FIRST + 33
"""Room for the corners and half edges of a box."""


@kernel
def _write(row: Scratch, at: int, v: Vector) -> None:
    row[at], row[at + 1], row[at + 2] = v


@kernel
def axes_of(row: Row, at: int) -> tuple[Vector, Vector, Vector]:
    """Axes of a frame from the quaternion at `at`, of any length: the homogeneous form, divided once."""
    size = max(abs(row[at]), abs(row[at + 1]), abs(row[at + 2]), abs(row[at + 3]))
    x, y, z, w = row[at] / size, row[at + 1] / size, row[at + 2] / size, row[at + 3] / size
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    total = (xx + yy) + (zz + ww)
    return (
        (((ww + xx) - (yy + zz)) / total, 2 * (x * y + w * z) / total, 2 * (x * z - w * y) / total),
        (2 * (x * y - w * z) / total, ((ww + yy) - (xx + zz)) / total, 2 * (y * z + w * x) / total),
        (2 * (x * z + w * y) / total, 2 * (y * z - w * x) / total, ((ww + zz) - (xx + yy)) / total),
    )


@kernel
def set_frame(kind: int, row: Row, frame: Scratch) -> None:
    """Frame of a proxy."""
    if kind == TURNED:
        for i in range(AXES):
            frame[i] = row[i]
        u, v, w = axes_of(row, AXES)
        _write(frame, AXES, u)
        _write(frame, AXES + 3, v)
        _write(frame, AXES + 6, w)
        return
    _write(frame, 0, plus(times(0.5, three(row, 0)), times(0.5, three(row, 3))))
    step = minus(times(0.5, three(row, 3)), times(0.5, three(row, 0)))
    if kind == ALIGNED:
        _write(frame, HALF, step)
        _write(frame, AXES, (1.0, 0.0, 0.0))
        _write(frame, AXES + 3, (0.0, 1.0, 0.0))
        _write(frame, AXES + 6, (0.0, 0.0, 1.0))
        return
    way = unit_or(step, (1.0, 0.0, 0.0))
    across = perpendicular(way)
    _write(frame, HALF, (length(step), 0.0, 0.0))
    _write(frame, AXES, way)
    _write(frame, AXES + 3, across)
    _write(frame, AXES + 6, cross(way, across))


@kernel
def set_corners(kind: int, frame: Row, offset: Vector, body: Scratch) -> float:
    """Corners of a frame with its centre at `offset`, as a placed polytope's; gives their largest coordinate."""
    sides = 2 if kind == SEGMENT else 8
    body[N_VERTICES], body[EDGES], body[DIRECTORY] = sides, FIRST + 24, 0.0 if kind == SEGMENT else BOX
    _write(body, CENTRE, offset)
    u, v = times(frame[HALF], three(frame, AXES)), times(frame[HALF + 1], three(frame, AXES + 3))
    w, at, most = times(frame[HALF + 2], three(frame, AXES + 6)), FIRST, 0.0
    for i in range(sides):
        x = plus(offset, u) if i % 2 else minus(offset, u)
        if sides == 8:
            x = plus(x, v) if i // 2 % 2 else minus(x, v)
            x = plus(x, w) if i // 4 else minus(x, w)
        _write(body, at, x)
        most = max(most, abs(x[0]), abs(x[1]), abs(x[2]))
        at += 3
    _write(body, FIRST + 24, u)
    _write(body, FIRST + 27, v)
    _write(body, FIRST + 30, w)
    return most


@kernel
def _width(frame: Row, n: Vector) -> float:
    """Support function of a frame about its centre."""
    return (
        frame[3] * abs(frame[6] * n[0] + frame[7] * n[1] + frame[8] * n[2])
        + frame[4] * abs(frame[9] * n[0] + frame[10] * n[1] + frame[11] * n[2])
        + frame[5] * abs(frame[12] * n[0] + frame[13] * n[1] + frame[14] * n[2])
    )


@kernel
def widest_axis_of_boxes(kind: int, a: Row, b: Row, offset: Vector, blur: float) -> tuple[Vector, float]:
    """Separating axis of two frames, from the first to the second, with the widest gap, and that gap.

    The faces' normals, and the edges crossed: nearly parallel ones only where the cleaned product can win.
    """
    best, gap = three(b, AXES), -math.inf
    for i in range(3, 6) if kind == SEGMENT else range(6):
        frame = a if i < 3 else b
        n = three(frame, AXES + 3 * (i % 3))
        here = abs(dot(n, offset)) - (_width(a, n) + _width(b, n))
        if here > gap:
            best, gap = n, here
    for i in range(1 if kind == SEGMENT else 3):
        e = three(a, AXES + 3 * i)
        for j in range(3):
            f = three(b, AXES + 3 * j)
            c = cross(e, f)
            here = abs(dot(c, offset)) - (_width(a, c) + _width(b, c))
            if here > gap * math.sqrt(dot(c, c)) - blur:
                n = crossed(e, f)
                here = abs(dot(n, offset)) - (_width(a, n) + _width(b, n))
                if here > gap and n != HERE:
                    best, gap = n, here
    return (opposite(best) if dot(best, offset) < 0.0 else best), gap


@kernel
def separation_of_boxes(
    kind: int, fa: Row, fb: Row, offset: Vector, a: Scratch, b: Scratch, s: Scratch, listed: Scratch
) -> Answer:
    """Signed distance, normal and witness points of two frames, relative to the centre of the first.

    Gottschalk, Lin and Manocha, OBBTree, 1996.
    """
    blur = ROUNDING * max(set_corners(kind, fa, HERE, a), set_corners(TURNED, fb, offset, b))
    best, gap = widest_axis_of_boxes(kind, fa, fb, offset, blur)
    if gap > 0.0:
        status, k, n, upper = nearest(a, b, HERE, best, blur / 2, s)
        if status == APART:
            return upper, n, on_first(a, s, k), on_second(b, s, k)
        best, gap = across_features(a, b, s, k, times(upper, n), best, gap, upper - blur, listed)
    x, y = touching_points(a, b, gap, best, blur / 2, s)
    return gap, best, x, y


@kernel
def _put_scaled(row: Row, by: Powers, found: Scratch) -> None:
    """Copy the numbers of a proxy, of which the first six are lengths, to be scaled."""
    _write(found, 0, scaled(three(row, 0), by))
    _write(found, 3, scaled(three(row, 3), by))
    for i in range(6, len(row)):
        found[i] = row[i]


@kernel
def box_separations(
    kind_a: int,
    rows_a: Sequence[Row],
    kind_b: int,
    rows_b: Sequence[Row],
    row: Scratch,
    fa: Scratch,
    fb: Scratch,
    a: Scratch,
    b: Scratch,
    s: Scratch,
    listed: Scratch,
    answers: Sequence[Scratch],
) -> None:
    """Answer a batch of rows of numbers of the given kinds, as `polytopes_batch.separations` does.

    Of two of a kind, the one with the smaller numbers is put first, so that both orders give the same bits.
    """
    for i in range(len(rows_a)):
        row_a, row_b = rows_a[i], rows_b[i]
        exponent = larger(exponent_of(row_a, 0, 6), exponent_of(row_b, 0, 6))
        by, back = powers(-exponent), powers(exponent)
        turned = kind_a == kind_b and comes_later(row_a, row_b)
        _put_scaled(row_b if turned else row_a, by, row)
        set_frame(kind_a, row, fa)
        _put_scaled(row_a if turned else row_b, by, row)
        set_frame(kind_b, row, fb)
        origin = three(fa, 0)
        offset = minus(three(fb, 0), origin)
        sigma, n, x, y = separation_of_boxes(kind_a, fa, fb, offset, a, b, s, listed)
        x, y = scaled(plus(origin, x), back), scaled(plus(origin, y), back)
        if turned:
            n, x, y = opposite(n), y, x
        write(answers[i], sigma * back[0] * back[1], n, x, y)
