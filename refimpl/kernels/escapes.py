"""The way out of overlapping unions: a short translation of B that separates, and a length that none falls below.

No pair of atoms comes apart with less than its own depth, so the depth of the deepest pair is a lower bound. Where its
own way frees all others too, nothing is left to do. Otherwise branch and bound finds the shortest way (`branches`): of
polytopes that is the depth, and both bounds; of round atoms, of which only some tangents are looked at, the way is
shortened further by tangents at its end (`ways`).
"""

from __future__ import annotations

import math

from . import inlined, kernel
from .atoms import Scene, height, support_gap
from .axes import three
from .branches import branched
from .drawback import drawn_back
from .facets import AROUND, around
from .leastmove import PLANE, shortest
from .polytopes import Scratch
from .polytopes_pair import write
from .tangents import START, UNKNOWN, foot, forget, learn
from .tangents import height as height_of_tangent
from .vectors import Vector, along, length, opposite, times, unit_or
from .ways import (
    HERE,
    Search,
    Way,
    descended,
    ended,
    lacks_room,
    list_tangents,
    long,
    near_pairs,
    no_way,
    respect,
)

RESULT = 15
"""Numbers of an answer: signed distance, normal, witness points; a length that no translation that frees falls below;
a point of the deepest overlap; and the depth of that overlap."""
DESCENTS = 4
"""Steps by which a way is shortened that may not be the shortest."""


@kernel
def _begin(scene: Scene, search: Search, answered: int) -> None:
    """Forget the last scene; take the tangents of the pairs that have been answered, the deepest first."""
    forget(search.known)
    search.places[0], search.short[0] = START, 0
    for k in range(answered):
        row = scene.pairs[k]
        learn(search.known, int(row[0]), START, HERE, row[1], three(row, 2), three(row, 5))


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
def _hulls_parted(scene: Scene, search: Search, tolerance: float) -> Way:
    """The shortest way along a direction all around that parts the convex hulls."""
    best, least = HERE, math.inf
    for i in range(AROUND):
        reach = _reach(scene, around(i)) if around(i) != HERE else math.inf
        if reach < least:
            best, least = around(i), reach
    return ended(scene, search, times(least, best), tolerance) if least < math.inf else no_way()


@inlined
def escape(scene: Scene, search: Search, lower: float, tolerance: float) -> tuple[Way, float]:
    """Find a short translation of B that frees it, and a length that none falls below.

    Parameters
    ----------
    scene
    search
        With the tangents of the pairs that have been answered, the deepest first.
    lower
        Such a length that is known: what comes as short as this is not shortened further.
    tolerance
        Depths that are rounding.
    """
    way, sure = ended(scene, search, foot(search.known, 0), tolerance), False
    if long(way) > lower + 2.0 * tolerance:
        deepest = search.known.pair[0]
        list_tangents(scene, search, deepest)
        way, sure = branched(scene, search, deepest, way, tolerance)
        if not way.found:
            way = _hulls_parted(scene, search, tolerance)
        lower = max(lower, length(way.move)) if sure else lower
    return descended(scene, search, way, lower, tolerance, DESCENTS), lower


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
    lower = result[14] = -deepest[1]
    for k in range(3):
        result[11 + k] = 0.5 * deepest[5 + k] + 0.5 * deepest[8 + k]
    way = no_way()
    if lower < math.inf:
        _begin(scene, search, answered)
        way, lower = escape(scene, search, lower, tolerance)
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
