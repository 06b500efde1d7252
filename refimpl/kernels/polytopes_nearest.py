"""Nearest points of two placed polytopes: the point of their difference that is nearest to the origin.

The search of Gilbert, Johnson and Keerthi (1988), with Wolfe's rule for the simplex (Finding the nearest point in
a polytope, 1976): from the last point it walks straight towards the foot of the perpendicular on the simplex's span,
and drops the vertices whose weights vanish on the way. So every step comes nearer, also where the simplex is so
flat that no sign of a determinant could be trusted; and it ends when the plane through the point found has
nothing in front of it, or when rounding leaves nothing to gain.
"""

from __future__ import annotations

import math

from . import kernel
from .polytopes import Row, Scratch, farthest, lowest, vertex
from .vectors import Vector, along, cross, dot, minus, opposite, times, unit_or, without

ENTRY = 7
"""A vertex of the simplex: its indices in A and B, the difference b − a (3), its weight, and a wished weight."""
WEIGHT, WISH = 5, 6
SAVED = 4 * ENTRY
"""Where the simplex before the last step is kept."""
ROOM = 8 * ENTRY
APART, STOPPED, MEETING = 1, 0, -1
NOTHING = 2.0**-50
"""A weight this near to 0 may be 0 or less. Its vertex is kept: it may turn the direction of the next step."""
MOST_STEPS, MOST_PAUSES = 200, 12
"""Steps in all, and steps that bring nothing but another direction."""


@kernel
def _point(s: Row, i: int) -> Vector:
    at = ENTRY * i + 2
    return (s[at], s[at + 1], s[at + 2])


@kernel
def _add(a: Row, b: Row, shift: Vector, i: int, j: int, k: int, s: Scratch) -> Vector:
    """Append the difference of vertices `i` of A and `j` of B as entry `k`, with weight 0."""
    p, q = vertex(a, i), vertex(b, j)
    y = ((q[0] + shift[0]) - p[0], (q[1] + shift[1]) - p[1], (q[2] + shift[2]) - p[2])
    at = ENTRY * k
    s[at], s[at + 1], s[at + 2], s[at + 3], s[at + 4], s[at + WEIGHT] = i, j, y[0], y[1], y[2], 0.0
    return y


@kernel
def _wish_on_edge(s: Scratch) -> bool:
    e = minus(_point(s, 1), _point(s, 0))
    square = dot(e, e)
    if square == 0.0:
        return False
    t = dot(opposite(_point(s, 0)), e) / square
    s[WISH], s[ENTRY + WISH] = 1.0 - t, t
    return True


@kernel
def _square_of_edge(s: Row, i: int, j: int) -> float:
    e = minus(_point(s, j), _point(s, i))
    return dot(e, e)


@kernel
def _by_edges(s: Row, i: int, j: int, k: int) -> tuple[int, int, int]:
    """Corners of a triangle, turned so that the edge from the first to the second is the shortest."""
    ij, jk, ki = _square_of_edge(s, i, j), _square_of_edge(s, j, k), _square_of_edge(s, k, i)
    if jk < ij and jk <= ki:
        return j, k, i
    if ki < ij:
        return k, i, j
    return i, j, k


@kernel
def _wish_on_triangle(s: Scratch, l: int, m: int, n: int) -> bool:
    """Gram and Schmidt from the end of the shortest edge: so a needle loses no digits across its length."""
    i, j, k = _by_edges(s, l, m, n)
    base = _point(s, i)
    e, f = minus(_point(s, j), base), minus(_point(s, k), base)
    ee, fe = dot(e, e), dot(f, e)
    if ee == 0.0:
        return False
    across = along(f, -fe / ee, e)
    across = along(across, -dot(across, e) / ee, e)
    square = dot(across, across)
    if square == 0.0:
        return False
    v = -dot(base, across) / square
    u = (-dot(base, e) - v * fe) / ee
    s[ENTRY * i + WISH], s[ENTRY * j + WISH], s[ENTRY * k + WISH] = (1.0 - u) - v, u, v
    return True


@kernel
def _wish_in_tetrahedron(s: Scratch) -> bool:
    base = _point(s, 3)
    e, f, g = minus(_point(s, 0), base), minus(_point(s, 1), base), minus(_point(s, 2), base)
    fg = cross(f, g)
    volume = dot(e, fg)
    if volume == 0.0:
        return False
    p = opposite(base)
    u, v, w = dot(p, fg) / volume, dot(p, cross(g, e)) / volume, dot(p, cross(e, f)) / volume
    s[WISH], s[ENTRY + WISH], s[2 * ENTRY + WISH], s[3 * ENTRY + WISH] = u, v, w, ((1.0 - u) - v) - w
    return True


@kernel
def _wish(s: Scratch, k: int) -> bool:
    """Weights of the foot of the perpendicular from 0 on the simplex's span; false where there is no foot."""
    if k == 1:
        s[WISH] = 1.0
        return True
    if k == 2:
        return _wish_on_edge(s)
    if k == 3:
        return _wish_on_triangle(s, 0, 1, 2)
    return _wish_in_tetrahedron(s)


@kernel
def _drop(s: Scratch, i: int, k: int) -> None:
    """Remove entry `i` of `k`."""
    for at in range(ENTRY * i, ENTRY * (k - 1)):
        s[at] = s[at + ENTRY]


@kernel
def _settle(s: Scratch, k: int) -> tuple[int, bool]:
    """Walk to the foot on the simplex's span, dropping what is in the way.

    Gives the number of vertices left, and whether the foot was reached.
    """
    while k > 1:
        if not _wish(s, k):
            return k, False
        step, blocked = 1.0, -1
        for i in range(k):
            weight, wish = s[ENTRY * i + WEIGHT], s[ENTRY * i + WISH]
            if wish <= -NOTHING:
                way = max(weight, 0.0) / (max(weight, 0.0) - wish)
                if blocked < 0 or way < step:
                    step, blocked = way, i
        for i in range(k):
            at = ENTRY * i
            s[at + WEIGHT] += step * (s[at + WISH] - s[at + WEIGHT])
        if blocked < 0:
            return k, True
        _drop(s, blocked, k)
        k -= 1
    s[WEIGHT] = 1.0
    return 1, True


@kernel
def _mean(s: Row, k: int) -> Vector:
    w = (0.0, 0.0, 0.0)
    for i in range(k):
        w = along(w, s[ENTRY * i + WEIGHT], _point(s, i))
    return w


@kernel
def _flattened(s: Scratch, least: float) -> bool:
    """Replace a tetrahedron by its triangle at the last vertex nearest to 0, if that is nearer than `least`, squared.

    The weights in a flat tetrahedron are noise, but it is as good as the triangles that it consists of.
    """
    best = -1
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if _wish_on_triangle(s, j, k, 3):
            u, v, t = s[ENTRY * j + WISH], s[ENTRY * k + WISH], s[3 * ENTRY + WISH]
            w = along(along(times(u, _point(s, j)), v, _point(s, k)), t, _point(s, 3))
            if min(u, v, t) >= -NOTHING and dot(w, w) < least:
                best, least = i, dot(w, w)
    if best < 0:
        return False
    _wish_on_triangle(s, (best + 1) % 3, (best + 2) % 3, 3)
    _drop(s, best, 4)
    for i in range(3):
        s[ENTRY * i + WEIGHT] = s[ENTRY * i + WISH]
    return True


@kernel
def _towards(s: Row, k: int, close: float) -> tuple[Vector, float]:
    """Unit vector from 0 to the foot on a simplex's span, and their distance.

    The foot is a sum that is small where the bodies nearly touch, and mostly noise then. The edges are not: so the
    vector is taken at right angles to them, unless they are so nearly parallel that it misses the foot.
    """
    w = _mean(s, k)
    foot = math.sqrt(dot(w, w))
    if foot <= close:
        return unit_or(w, (1.0, 0.0, 0.0)), foot
    if k > 1:
        i, j, m = (0, 1, 1) if k == 2 else _by_edges(s, 0, 1, 2)
        base = _point(s, i)
        e = minus(_point(s, j), base)
        n = without(w, e) if k == 2 else cross(e, minus(_point(s, m), base))
        square = dot(n, n)
        if square > 0.0:
            n = times(1.0 / math.sqrt(square), n)
            h = dot(n, base)
            if abs(abs(h) - foot) <= 16.0 * close:
                return (n, h) if h >= 0.0 else (opposite(n), -h)
    return times(1.0 / foot, w), foot


@kernel
def _advance(s: Scratch, k: int, least: float, height: float, close: float) -> tuple[int, int]:
    """Take a fourth or earlier new vertex into account: the new count, and MEETING, APART (go on) or STOPPED."""
    k, reached = _settle(s, k)
    if k < 4:
        return k, APART if reached else STOPPED
    w = _mean(s, 4)
    square = dot(w, w)
    enclosed = reached and height <= 0.0 and square < least
    if reached and square <= 16.0 * close * close:
        return 4, MEETING
    if _flattened(s, least):
        return 3, APART
    return 4, MEETING if enclosed else STOPPED


@kernel
def nearest(a: Row, b: Row, shift: Vector, start: Vector, close: float, s: Scratch) -> tuple[int, int, Vector, float]:
    """Nearest points of A and of B moved by `shift`.

    Parameters
    ----------
    start
        A first guess of the direction from A to B.
    close
        A length that counts as rounding.
    s
        Room for `ROOM` numbers: the simplex, and the one before.

    Returns
    -------
    int
        APART when the distance found is the shortest up to `close`, MEETING when 0 lies in the simplex, STOPPED when
        they touch up to `close`, or when no step helps any more: rounding has the last word then.
    int
        How many entries of `s`, with their weights, make the nearest points.
    vector, float
        The unit direction from the nearest point of A to that of B, and their distance.
    """
    _add(a, b, shift, farthest(a, start), lowest(b, start), 0, s)
    s[WEIGHT] = 1.0
    k = 1
    pauses = 0
    n, h = _towards(s, k, close)
    for _ in range(MOST_STEPS):
        if h <= close:
            break
        i, j = farthest(a, n), lowest(b, n)
        known = False
        for m in range(k):
            known = known or (s[ENTRY * m] == i and s[ENTRY * m + 1] == j)
        height = dot(_add(a, b, shift, i, j, k, s), n)
        if h - height <= close:
            return APART, k, n, h
        if known:
            break
        kept, point, before = k, n, h
        for at in range(ENTRY * k):
            s[SAVED + at] = s[at]
        k, status = _advance(s, k + 1, h * h, height, close)
        if status == MEETING:
            return MEETING, 4, n, 0.0
        if status == APART:
            n, h = _towards(s, k, close)
        pauses += h >= before
        if status == STOPPED or h > before + close or pauses > MOST_PAUSES:
            k, n, h = kept, point, before
            for at in range(ENTRY * k):
                s[at] = s[SAVED + at]
            break
    return STOPPED, k, n, h


@kernel
def on_first(a: Row, s: Row, k: int) -> Vector:
    """Nearest point of A, of the simplex."""
    x = (0.0, 0.0, 0.0)
    for i in range(k):
        x = along(x, s[ENTRY * i + WEIGHT], vertex(a, int(s[ENTRY * i])))
    return x


@kernel
def on_second(b: Row, s: Row, k: int) -> Vector:
    """Nearest point of B, before its shift, of the simplex."""
    x = (0.0, 0.0, 0.0)
    for i in range(k):
        x = along(x, s[ENTRY * i + WEIGHT], vertex(b, int(s[ENTRY * i + 1])))
    return x
