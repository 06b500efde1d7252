"""Short ways out of a solid for a ball that overlaps it.

A ball is free exactly where the signed height of its centre above the solid is no less than its radius r. The height
h changes no faster than the centre moves. So no way out from c is shorter than r − h(c), and along any direction,
steps of r − h pass over no free place (Hart, Sphere Tracing, 1996). Over a flat face, or out of a convex solid, the way
of that length along the height's slope is free, and nothing is left to search.

Elsewhere other faces stand in the way. The plane through the point nearest to the centre, r beyond it, has no place of
the ball on its far side that meets this face: each face that is met adds its plane, and the shortest move beyond all
planes is tried next. From a free place the same step, begun with that place's own plane, leads to one that is no
farther: a descent.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import inlined, kernel
from .axes import three
from .heights import Spot, height
from .leastmove import LEVEL, NOWHERE, PLANE, shortest
from .polytopes import Row, Scratch
from .surface import OUTWARD, foot_on_face
from .vectors import Vector, dot, length, minus, plus, times, unit_or

ROUNDS = 24
"""Planes that may stand in the way; a search that meets more is given up."""
DESCENTS = 10
STEPS = 16
SAME = 1e-4
"""Lengths that differ by less than this part of them are on their way to the same."""
DETOUR = 1.1
"""A way this much longer than the best may still lead, by descent, to a shorter one."""
GAIN = 1.0 - 1e-9
ROUNDING = 2.0**-49
"""Part of the coordinates by which heights are rounded, and more."""

WAY = 8
"""Numbers of an answer."""

Keys = MutableSequence[int]
Way = tuple[Vector, Spot, bool]
"""A move of the ball, what is near it there, and whether it is free."""


@kernel
def _normal(row: Row, spot: Spot) -> Vector:
    """Direction in which the ball leaves the nearest face: from inside across the face, whatever its sides do."""
    return spot[1] if spot[0] > 0.0 else three(row, spot[3] + OUTWARD)


@kernel
def _put(ball: Row, n: Vector, foot: Vector, place: int, planes: Scratch) -> None:
    """Write the plane across `n`, r beyond a point of the surface, for moves of the ball."""
    at = PLANE * place
    planes[at], planes[at + 1], planes[at + 2] = n
    planes[at + LEVEL] = dot(n, minus(foot, three(ball, 0))) + ball[3]


@kernel
def _add(row: Row, ball: Row, spot: Spot, planes: Scratch, keys: Keys, count: int) -> int:
    """Add or renew the plane of the face that is nearest to the ball; how many there are then."""
    place = 0
    while place < count and keys[place] != spot[3]:
        place += 1
    _put(ball, _normal(row, spot), spot[2], place, planes)
    keys[place] = spot[3]
    return max(count, place + 1)


@kernel
def _renewed(row: Row, ball: Row, way: Way, planes: Scratch, keys: Keys, count: int) -> int:
    """Renew the planes of all faces that were met, at a free place, which is beyond all of them then."""
    p = plus(three(ball, 0), way[0])
    for place in range(count):
        foot = foot_on_face(row, keys[place], p)
        _put(ball, unit_or(minus(p, foot), three(row, keys[place] + OUTWARD)), foot, place, planes)
    return _add(row, ball, way[1], planes, keys, count) if count < ROUNDS else count


@kernel
def _freed(
    row: Row, ball: Row, blur: float, limit: float, count: int, planes: Scratch, keys: Keys, stack: Scratch
) -> tuple[Way, int]:
    """Let faces that are met add their planes until none is, unless the move becomes longer than `limit`."""
    t, spot = NOWHERE, (0.0, NOWHERE, NOWHERE, 0, True)
    for _ in range(ROUNDS):
        t, _, possible = shortest(planes, count)
        if not possible or not length(t) < limit:
            break
        spot = height(row, plus(three(ball, 0), t), 0, stack)
        if spot[0] >= ball[3] - blur:
            return (t, spot, True), count
        if count == ROUNDS:
            break
        count = _add(row, ball, spot, planes, keys, count)
    return (t, spot, False), count


@kernel
def _descended(
    row: Row, ball: Row, blur: float, way: Way, best: float, count: int, planes: Scratch, keys: Keys, stack: Scratch
) -> Way:
    """Shorten a free way, as long as that gains something, or faces are met that were not known.

    It is given up where it only comes to what is the best so far, or would not come to that in as many steps again.
    """
    for _ in range(DESCENTS):
        before = length(way[0])
        count = _renewed(row, ball, way, planes, keys, count)
        better, met = _freed(row, ball, blur, GAIN * before, count, planes, keys, stack)
        count, known = met, count
        if better[2]:
            way = better
            over = length(way[0]) - best
            if over > 0.0 and (over < SAME * best or DESCENTS * (before - length(way[0])) < over):
                break
        elif met == known:
            break
    return way


@kernel
def _step(ball: Row, p: Vector, spot: Spot, d: Vector) -> float:
    """How far a ball whose centre is at `p` has to move along a direction for certain before it is free.

    From outside, until the nearest point of the surface is r away; from inside, by r − h.
    """
    if not spot[0] > 0.0:
        return ball[3] - spot[0]
    aside = minus(p, spot[2])
    rise = dot(aside, d)
    return math.sqrt(max(rise * rise + (ball[3] - spot[0]) * (ball[3] + spot[0]), 0.0)) - rise


@inlined
def _marched(row: Row, ball: Row, blur: float, spot: Spot, d: Vector, limit: float, stack: Scratch) -> Way:
    """First free place along a direction, by steps that pass over none."""
    s, t = 0.0, NOWHERE
    for _ in range(STEPS):
        s += _step(ball, plus(three(ball, 0), t), spot, d)
        if not s < limit:
            break
        t = times(s, d)
        spot = height(row, plus(three(ball, 0), t), 0, stack)
        if spot[0] >= ball[3] - blur:
            return t, spot, True
    return t, spot, False


@kernel
def _back(row: Row, ball: Row, t: Vector, step: float, stack: Scratch) -> tuple[Vector, Spot]:
    """A way that is shorter by a step, and what is near its end."""
    t = times(max(1.0 - step / length(t), 0.0), t)
    return t, height(row, plus(three(ball, 0), t), 0, stack)


@inlined
def _drawn_back(row: Row, ball: Row, blur: float, way: Way, stack: Scratch) -> Way:
    """Shorten a free way while it ends above the surface.

    By as much as the ball is above it, it surely can; by what the nearest plane allows, it mostly can.
    """
    for _ in range(STEPS):
        t, spot, _ = way
        size, spare = length(t), spot[0] - ball[3]
        if not spare > blur or not size > spare:
            break
        slope = dot(spot[1], t) / size
        t, spot = _back(row, ball, way[0], spare / slope if slope > 0.0 else spare, stack)
        if spot[0] < ball[3] - blur:
            t, spot = _back(row, ball, way[0], spare, stack)
        if spot[0] < ball[3] - blur:
            break
        way = (t, spot, True)
    return way


@inlined
def way_out(
    row: Row, ball: Row, here: Spot, directions: Sequence[Row], planes: Scratch, keys: Keys, stack: Scratch
) -> tuple[Vector, Vector, float, float]:
    """A short way out of the solid for a ball that overlaps it: the move, and where the ball touches the surface then.

    Third, a length that is enough, what rounding left added; fourth, one below which none is. The two are the same
    where they differ by rounding.

    Parameters
    ----------
    ball
        Centre and radius.
    here
        What is near the centre.
    directions
        Unit vectors to try, and how far along each the solid reaches.
    """
    c, r = three(ball, 0), ball[3]
    blur = ROUNDING * (max(abs(c[0]), abs(c[1]), abs(c[2])) + r + 1.0)
    lower = r - here[0]
    count = _add(row, ball, here, planes, keys, 0)
    way, count = _freed(row, ball, blur, math.inf, count, planes, keys, stack)
    best = math.inf
    if way[2]:
        way = _descended(row, ball, blur, way, math.inf, count, planes, keys, stack)
        best = length(way[0])
    if best > lower + 2.0 * blur:
        for i in range(len(directions)):
            d = three(directions[i], 0)
            enough = directions[i][3] - dot(d, c) + r
            if enough < best:
                t = times(enough, d)
                way, best = (t, height(row, plus(c, t), 0, stack), True), enough
        for i in range(len(directions)):
            other = _marched(row, ball, blur, here, three(directions[i], 0), DETOUR * best, stack)
            if other[2]:
                other = _descended(row, ball, blur, other, best, 0, planes, keys, stack)
                if length(other[0]) < best:
                    way, best = other, length(other[0])
        way = _drawn_back(row, ball, blur, way, stack)
    depth = length(way[0]) + max(0.0, r - way[1][0])
    return way[0], way[1][2], lower if depth <= lower + 2.0 * blur else depth, lower


@kernel
def ways_out(
    row: Row,
    balls: Sequence[Row],
    spots: Sequence[Row],
    directions: Sequence[Row],
    answers: Sequence[Scratch],
    planes: Scratch,
    keys: Keys,
    stack: Scratch,
) -> None:
    """Answer a batch: depth, least length of a way out, point of the surface touched at its end, the way itself."""
    for i in range(len(balls)):
        spot, answer = spots[i], answers[i]
        here = (spot[0], three(spot, 1), three(spot, 4), int(spot[8]), spot[7] > 0.0)
        t, foot, depth, lower = way_out(row, balls[i], here, directions, planes, keys, stack)
        answer[0], answer[1] = depth, lower
        answer[2], answer[3], answer[4] = foot
        answer[5], answer[6], answer[7] = t
