"""Gap between two segments: the axes of two capsules.

Ericson, Real-Time Collision Detection, 5.1.9; Eberly, Robust Computation of Distance Between Line Segments.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import kernel
from .axes import three
from .polytopes import Row, Scratch
from .polytopes_pair import HERE, Answer, comes_later, write
from .vectors import Vector, along, cross, dot, minus, opposite, perpendicular, times, unit_or, without


@kernel
def on_segment(x: Vector, p: Vector, q: Vector) -> Vector:
    """Point of the segment pq nearest to `x`; counted from the nearer end, it reaches both exactly."""
    step = minus(q, p)
    square = dot(step, step)
    t = dot(minus(x, p), step) / square if square > 0.0 else 0.0
    t = min(max(t, 0.0), 1.0)
    return along(p, t, step) if t < 0.5 else along(q, t - 1.0, step)


@kernel
def _gap_along(offset: Vector, a: Vector, b: Vector, n: Vector) -> float:
    """Gap along `n` from the segment [0, 1]·a to the segment offset + [0, 1]·b."""
    return dot(offset, n) + min(dot(b, n), 0.0) - max(dot(a, n), 0.0)


@kernel
def _error(offset: Vector, a: Vector, b: Vector, between: Vector, length: float, n: Vector) -> float:
    """How badly `n` serves as the normal of nearest points `between` apart: it should point along, and part them."""
    aside = minus(between, times(length, n))
    return (length - _gap_along(offset, a, b, n)) + math.sqrt(dot(aside, aside))


@kernel
def _normal(offset: Vector, a: Vector, b: Vector, between: Vector) -> tuple[Vector, float]:
    """Unit normal of nearest points `between` apart, and their distance.

    When they are hardly apart, their own direction is noise; then it is cleaned against the segments, or is the
    common perpendicular.
    """
    sideways = perpendicular(a if dot(a, a) >= dot(b, b) else b)
    length = math.sqrt(dot(between, between))
    best = unit_or(between, sideways)
    least = _error(offset, a, b, between, length, best)
    if least == 0.0:
        return best, length
    common = unit_or(without(cross(a, b), a), sideways)
    for i in range(6):
        n = common
        if i == 0:
            n = unit_or(without(between, a), best)
        elif i == 1:
            n = unit_or(without(between, b), best)
        elif i >= 4:
            n = sideways
        if i % 2 and i > 1:
            n = opposite(n)
        error = _error(offset, a, b, between, length, n)
        if error < least:
            best, least = n, error
    return best, length


@kernel
def separation_of_segments(p: Vector, q: Vector, r: Vector, s: Vector) -> Answer:
    """Gap between the segments pq and rs, normal, and nearest points.

    Of five candidates, one of which is the answer, the nearest counts: the feet of the common perpendicular, and each
    of the four ends with its nearest point on the other segment. The perpendicular is found in the plane across pq:
    there the nearly parallel case loses nothing that matters, because an error along the common direction does
    not change the gap.
    """
    a, b, offset = minus(q, p), minus(s, r), minus(r, p)
    across = without(b, a)
    square = dot(across, across)
    t = -dot(without(offset, a), across) / square if square > 0.0 else 0.0
    t = min(max(t, 0.0), 1.0)
    x, y, least = HERE, HERE, math.inf
    for i in range(5):
        if i < 3:
            on_b = r if i == 1 else s
            if i == 0:
                on_b = along(r, t, b) if t < 0.5 else along(s, t - 1.0, b)
            on_a = on_segment(on_b, p, q)
        else:
            on_a = p if i == 3 else q
            on_b = on_segment(on_a, r, s)
        between = minus(on_b, on_a)
        here = dot(between, between)
        if here < least:
            x, y, least = on_a, on_b, here
    n, gap = _normal(offset, a, b, minus(y, x))
    for _ in range(2):  # nearly parallel: of many pairs with equal gaps, one that lies along the normal
        x = on_segment(along(y, -gap, n), p, q)
        y = on_segment(along(x, gap, n), r, s)
    return gap, n, x, y


@kernel
def segment_separations(rows_a: Sequence[Row], rows_b: Sequence[Row], answers: Sequence[Scratch]) -> None:
    """Answer a batch of rows p, q (and more), as `polytopes_batch.separations` does; the same bits in either order."""
    for i in range(len(rows_a)):
        turned = comes_later(rows_a[i], rows_b[i])
        a, b = rows_a[i], rows_b[i]
        if turned:
            a, b = rows_b[i], rows_a[i]
        gap, n, x, y = separation_of_segments(three(a, 0), three(a, 3), three(b, 0), three(b, 3))
        if turned:
            n, x, y = opposite(n), y, x
        write(answers[i], gap, n, x, y)
