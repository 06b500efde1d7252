"""The way out of overlapping unions: a short translation of B that separates, and a length that none falls below.

No pair of atoms comes apart with less than its own depth, so the depth of the deepest pair is a lower bound. Where its
own way frees all others too, nothing is left to do. Otherwise the search starts several times: from the tangent of
the deepest pair, from those of all pairs that overlap, and along the directions in which the convex hulls part soonest.
Each way that it finds is shortened by one step, the shortest one by several.
"""

from __future__ import annotations

import math

from . import inlined, kernel
from .atoms import Scene, height, support_gap
from .axes import three
from .drawback import drawn_back
from .leastmove import PLANE, shortest
from .polytopes import Scratch
from .polytopes_pair import write
from .tangents import forget, learn
from .tangents import height as height_of_tangent
from .vectors import Vector, along, opposite, times, unit_or
from .ways import (
    HERE,
    START,
    UNKNOWN,
    Search,
    Way,
    descended,
    ended,
    freed_from_start,
    lacks_room,
    long,
    near_pairs,
    no_way,
    pushed,
    respect,
    shorter,
)

AROUND = 27
"""Directions to the middles of the sides, edges and corners of a cube, and none."""
RESULT = 14
"""Numbers of an answer: signed distance, normal, witness points; a length that no translation that frees falls below;
and a point of the deepest overlap."""
HULL_WAYS = 6
"""Of these directions, so many are tried: those along which the convex hulls part soonest."""
DESCENTS = 4
"""Steps of the last descent; on the way to it each takes one."""
SLACK = 1.5
"""Ways that are longer than the shortest one by no more than this factor may become shorter by descent."""


@kernel
def _begin(scene: Scene, search: Search, answered: int) -> None:
    """Forget the last scene; take the tangents of the pairs that have been answered, the deepest first."""
    forget(search.known)
    search.places[0], search.short[0] = START, 0
    for k in range(answered):
        row = scene.pairs[k]
        learn(search.known, int(row[0]), START, HERE, row[1], three(row, 2), three(row, 5))


@kernel
def _around(i: int) -> Vector:
    return unit_or((i // 9 - 1.0, i // 3 % 3 - 1.0, i % 3 - 1.0), HERE)


@kernel
def _reach(scene: Scene, n: Vector) -> float:
    """Length along a unit vector after which the convex hulls are apart."""
    most_a, most_b = -math.inf, -math.inf
    for i in range(len(scene.a)):
        most_a = max(most_a, height(scene, 0, i, n))
    for j in range(len(scene.b)):
        most_b = max(most_b, height(scene, 1, j, opposite(n)))
    return most_a + most_b


@inlined
def _tried(scene: Scene, search: Search, n: Vector, reach: float, limit: float, lower: float, tolerance: float) -> Way:
    """A short way along a direction or from there, unless the limit is reached first."""
    way = pushed(scene, search, n, min(reach, limit), tolerance)
    if not way.found and reach < limit:
        way = ended(scene, search, times(reach, n), tolerance)  # hulls that part leave no doubt, but for rounding
    return descended(scene, search, way, lower, tolerance, 1)


@inlined
def _tried_all(scene: Scene, search: Search, way: Way, lower: float, tolerance: float) -> Way:
    """The shortest of a way and those that start along several directions."""
    limit = SLACK * long(way)
    for i in range(AROUND):
        search.reach[i] = math.inf if i == AROUND // 2 else _reach(scene, _around(i))
    for _ in range(HULL_WAYS):
        best = 0
        for i in range(AROUND):
            if search.reach[i] < search.reach[best]:
                best = i
        way = shorter(way, _tried(scene, search, _around(best), search.reach[best], limit, lower, tolerance))
        search.reach[best] = math.inf
    return descended(scene, search, way, lower, tolerance, DESCENTS)


@inlined
def escape(scene: Scene, search: Search, lower: float, tolerance: float) -> Way:
    """Find a short translation of B that frees it.

    Parameters
    ----------
    scene
    search
        With the tangents of the pairs that have been answered, the deepest first.
    lower
        No shorter translation frees: what comes as short as this is not shortened further.
    tolerance
        Depths that are rounding.
    """
    way = freed_from_start(scene, search, True, tolerance)
    if long(way) > lower + 2.0 * tolerance:
        other = freed_from_start(scene, search, False, tolerance)
        way = shorter(
            descended(scene, search, other, lower, tolerance, 1), descended(scene, search, way, lower, tolerance, 1)
        )
    if long(way) > lower + 2.0 * tolerance:
        way = _tried_all(scene, search, way, lower, tolerance)
    return way


@kernel
def _leads_out(scene: Scene, search: Search, move: Vector, n: Vector, tolerance: float) -> bool:
    """Whether all pairs that are near each other after a translation are apart along a direction."""
    across = len(scene.b)
    for k in range(near_pairs(scene, search, move, 0.0)):
        pair = search.listed[k]
        if support_gap(scene, pair // across, pair % across, move, n) < -tolerance:
            return False
    return True


@inlined
def _outwards(scene: Scene, search: Search, way: Way, n: Vector, tolerance: float) -> Vector:
    """Direction in which unions that only touch come apart: `n`, if it does for all pairs, or what does.

    Where several pairs touch at one place, not every normal of one of them suits the others.
    """
    if _leads_out(scene, search, way.move, n, tolerance):
        return n
    known, count = search.known, 0
    for i in range(known.used[0]):
        if abs(height_of_tangent(known, i, way.move)) <= tolerance and not lacks_room(search, count):
            normal = three(known.plane, PLANE * i)
            if _leads_out(scene, search, way.move, normal, tolerance):
                return normal
            count = respect(search, count, i)
            search.planes[PLANE * count - 1] = 1.0
    between, _, possible = shortest(search.planes, count)
    return unit_or(between, n) if possible else n


@inlined
def way_out(scene: Scene, search: Search, answered: int, tolerance: float, result: Scratch) -> bool:
    """Write the answer for two unions that overlap, `RESULT` numbers; false where there is not enough room to find it.

    The signed distance is minus the length of a translation that frees, −inf where none was found.
    """
    deepest = scene.pairs[0]
    lower = -deepest[1]
    for k in range(3):
        result[11 + k] = 0.5 * deepest[5 + k] + 0.5 * deepest[8 + k]
    way = no_way()
    if lower < math.inf:
        _begin(scene, search, answered)
        way = escape(scene, search, lower, tolerance)
    if not way.found:
        write(result, -math.inf, UNKNOWN, UNKNOWN, UNKNOWN)
        result[10] = lower
        return search.short[0] == 0
    way, touch = drawn_back(scene, search, way, tolerance)
    depth = long(way)
    n = unit_or(way.move, three(deepest, 2))
    if depth <= 2.0 * tolerance:
        n = _outwards(scene, search, way, n, tolerance)
    if math.isnan(touch[0]):  # nothing is near the end of the way
        touch = three(deepest, 5)
    write(result, -depth, n, touch, along(touch, -depth, n))
    result[10] = min(lower, depth)
    return search.short[0] == 0
