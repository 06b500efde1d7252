"""Translations that separate overlapping unions: found from tangents, shortened, and drawn back to first touch.

One tangent for each pair of atoms that stands in the way leaves a convex set of translations, of which the shortest is
found exactly; where other pairs overlap there, they join. Each round is sure of more pairs, so it ends: with a
translation that frees all, or with planes that contradict. From a free translation the same step, with tangents taken
there, leads to one that is no longer: a descent.

No pair is answered that a tangent proves free: so a scene that the deepest pair's way frees costs no answer at all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from . import kernel
from .atom_pairs import answer
from .atoms import Scene, support_gap
from .leastmove import LEVEL, PLANE, Corner, shortest
from .nearby import near
from .tangents import Floats, Ints, Tangents, foot, height, highest, is_full, learn, soonest, taken_at, touch_of
from .vectors import Vector, dot, length, times, unit_or

ROUNDS, DESCENTS = 64, 3
MOST_BACK = 4096
"""So many pairs are looked at to draw a way back; there is room for them."""
GAIN = 1e-9
"""A descent goes on as long as it shortens the way by this part."""
SLOPE = 1e-6
"""A direction that rises less than this over a tangent does not lead out of its pair."""
HERE = (0.0, 0.0, 0.0)
UNKNOWN = (math.nan, math.nan, math.nan)
START, NO_PLACE = 0, -1
"""Numbers of translations: that by nothing; and for tangents that are known without having been taken anywhere."""


class Search(NamedTuple):
    """What a search for ways knows, and room to work in.

    Attributes
    ----------
    known
        Tangents.
    planes, source
        Those that a translation has to respect, and their numbers.
    listed
        Pairs that are near.
    places
        One number: how many translations have been looked at.
    short
        One number: 1 once there was no room for something, so that nothing that is found may count.
    reach
        Lengths of ways along directions.
    """

    known: Tangents
    planes: Floats
    source: Ints
    listed: Ints
    places: Ints
    short: Ints
    reach: Floats


class Way(NamedTuple):
    """A translation.

    Attributes
    ----------
    found
        Whether it frees; if not, the rest means nothing.
    move, gap, place
        The translation; the least value of a tangent there over the pairs near each other, negative by rounding only;
        its number.
    """

    found: bool
    move: Vector
    gap: float
    place: int


@kernel
def no_way() -> Way:
    """Nothing found."""
    return Way(False, HERE, -math.inf, NO_PLACE)


@kernel
def long(way: Way) -> float:
    """Length that surely is enough: what is left by rounding is added."""
    return length(way.move) + max(0.0, -way.gap) if way.found else math.inf


@kernel
def shorter(way: Way, other: Way) -> Way:
    """The shorter one of two ways; the first, where they are equal."""
    return other if long(other) < long(way) else way


@kernel
def _near(scene: Scene, search: Search, move: Vector, within: float) -> int:
    """List the pairs that are near after a translation."""
    count = near(scene, move, within, search.listed)
    if count > len(search.listed):
        search.short[0] = 1
        return 0
    return count


@kernel
def _is_full(search: Search, planes: int) -> bool:
    """Whether there is no room for one more tangent, or plane after so many."""
    full = is_full(search.known) or planes >= len(search.source)
    if full:
        search.short[0] = 1
    return full


@kernel
def _new_place(search: Search) -> int:
    search.places[0] += 1
    return search.places[0]


@kernel
def _ask(scene: Scene, search: Search, pair: int, move: Vector, place: int) -> float:
    """Signed distance of a pair after a translation; its tangent is kept."""
    across = len(scene.b)
    sigma, n, x, _ = answer(scene, pair // across, pair % across, move)
    if sigma > -math.inf:
        learn(search.known, pair, place, move, sigma, n, x)
    return sigma


@kernel
def _parted(scene: Scene, search: Search, pair: int, move: Vector) -> bool:
    """Whether an unknown pair is apart along the way itself; cheaper than an answer."""
    across = len(scene.b)
    n = unit_or(move, (1.0, 0.0, 0.0))
    gap = support_gap(scene, pair // across, pair % across, move, n)
    if gap >= 0.0:
        learn(search.known, pair, NO_PLACE, move, gap, n, UNKNOWN)
    return gap >= 0.0


@kernel
def _respect(search: Search, count: int, i: int) -> int:
    """Make tangent number `i` a plane that translations have to respect, after `count` others."""
    search.source[count] = i
    for k in range(PLANE):
        search.planes[PLANE * count + k] = search.known.plane[PLANE * i + k]
    return count + 1


@kernel
def _blocked(scene: Scene, search: Search, move: Vector, place: int, tolerance: float, count: int) -> tuple[int, float]:
    """Add the tangents of all pairs that overlap after a translation to `count` planes.

    Gives how many planes there are then, −1 where there is no room for them, or no end to an overlap; and the least
    that is known of the distances of all pairs near each other.
    """
    known, least = search.known, math.inf
    for k in range(_near(scene, search, move, 0.0)):
        pair = search.listed[k]
        best, sigma = highest(known, pair, move)
        if sigma < -tolerance and taken_at(known, pair, place) < 0:
            if _is_full(search, 0):
                return -1, -math.inf
            if best < 0 and _parted(scene, search, pair, move):
                sigma = highest(known, pair, move)[1]
            else:
                sigma = _ask(scene, search, pair, move, place)
        if sigma < -tolerance:
            if sigma == -math.inf or _is_full(search, count):
                return -1, -math.inf
            count = _respect(search, count, taken_at(known, pair, place))
        least = min(least, sigma)
    return count, least


@kernel
def freed(scene: Scene, search: Search, count: int, limit: float, tolerance: float) -> Way:
    """From `count` planes on, let pairs that overlap join until none does, unless the way grows beyond a limit."""
    for _ in range(ROUNDS):
        move, _, possible = shortest(search.planes, count)
        if not possible or length(move) >= limit:
            break
        place = _new_place(search)
        all_planes, gap = _blocked(scene, search, move, place, tolerance, count)
        if all_planes == count:
            return Way(True, move, gap, place)
        if all_planes < 0:
            break
        count = all_planes
    return no_way()


@kernel
def freed_from_start(scene: Scene, search: Search, deepest: int, limit: float, tolerance: float) -> Way:
    """The same from the tangents number 0 to `deepest` on, which are those of the pairs that overlap at first."""
    count = 0
    for i in range(deepest):
        if _is_full(search, count):
            return no_way()
        count = _respect(search, count, i)
    return freed(scene, search, count, limit, tolerance)


@kernel
def _stale(search: Search, corner: Corner, place: int) -> int:
    """One of the planes that hold a translation whose tangent was not taken at a place; −1 for none."""
    for k in corner:
        if k >= 0 and search.known.place[search.source[k]] != place:
            return k
    return -1


@kernel
def _planes_at(scene: Scene, search: Search, way: Way) -> int:
    """Collect tangents of all pairs near each other at the end of a way; those that matter are taken just there.

    Gives how many, −1 where there is no room for them.
    """
    known, count = search.known, _near(scene, search, way.move, 0.0)
    for k in range(count):
        if _is_full(search, k):
            return -1
        _respect(search, k, highest(known, search.listed[k], way.move)[0])
    for _ in range(count):
        k = _stale(search, shortest(search.planes, count)[1], way.place)
        if k < 0:
            break
        pair = search.listed[k]
        if taken_at(known, pair, way.place) < 0:
            if _is_full(search, k):
                return -1
            _ask(scene, search, pair, way.move, way.place)
        _respect(search, k, taken_at(known, pair, way.place))
    return count


@kernel
def descended(scene: Scene, search: Search, way: Way, lower: float, tolerance: float) -> Way:
    """Shorten a way by tangents at its end, as long as that gains something, but not below a lower bound."""
    for _ in range(DESCENTS):
        if long(way) <= lower + 2.0 * tolerance or not way.found:
            break
        count = _planes_at(scene, search, way)
        if count < 0:
            break
        better = freed(scene, search, count, long(way) * (1.0 - GAIN), tolerance)
        if long(better) >= long(way):
            break
        way = better
    return way


@kernel
def pushed(scene: Scene, search: Search, direction: Vector, limit: float, tolerance: float) -> Way:
    """A short way along a direction: each pair that stands in it is left by its tangent."""
    s = 0.0
    for _ in range(ROUNDS):
        move = times(s, direction)
        place = _new_place(search) if s > 0.0 else START
        count, gap = _blocked(scene, search, move, place, tolerance, 0)
        if count == 0:
            return Way(True, move, gap, place)
        beyond = s
        for k in range(count):
            slope = dot(
                (search.planes[PLANE * k], search.planes[PLANE * k + 1], search.planes[PLANE * k + 2]), direction
            )
            if slope > SLOPE:
                beyond = max(beyond, search.planes[PLANE * k + LEVEL] / slope)
        if not s < beyond < limit:
            break
        s = beyond
    return no_way()


@kernel
def ended(scene: Scene, search: Search, move: Vector, tolerance: float) -> Way:
    """A way that is known to free, looked at."""
    place = _new_place(search)
    count, gap = _blocked(scene, search, move, place, tolerance, 0)
    return Way(True, move, gap, place) if count == 0 else no_way()


@kernel
def _touching(scene: Scene, search: Search, way: Way) -> tuple[float, Vector]:
    """Distance of the pair that is nearest at the end of a way, and its point of A; only what matters is answered."""
    known = search.known
    for _ in range(len(search.listed)):
        nearest, least = -1, math.inf
        for k in range(_near(scene, search, way.move, 0.0)):
            best, here = highest(known, search.listed[k], way.move)
            if here < least:
                nearest, least = best, here
        if nearest < 0:
            break
        if known.place[nearest] == START and foot(known, nearest) == way.move:
            return least, touch_of(known, nearest)
        pair = known.pair[nearest]
        here = taken_at(known, pair, way.place)
        if here >= 0:
            return height(known, here, way.move), touch_of(known, here)
        if _is_full(search, 0):
            break
        _ask(scene, search, pair, way.move, way.place)
    return math.inf, UNKNOWN


@kernel
def _way_back(scene: Scene, search: Search, way: Way, direction: Vector, size: float, tolerance: float) -> float:
    """How much of a way is left when going back to the foot of the first tangent."""
    left, known = 0.0, search.known
    count = near(scene, way.move, size, search.listed)
    if count > MOST_BACK:
        return size
    for k in range(count):
        pair = search.listed[k]
        if soonest(known, pair, direction, size, tolerance) > left:
            if taken_at(known, pair, way.place) < 0 and not _is_full(search, 0):
                _ask(scene, search, pair, way.move, way.place)
            left = max(left, min(size, soonest(known, pair, direction, size, tolerance)))
    return left


@kernel
def drawn_back(scene: Scene, search: Search, way: Way, tolerance: float) -> tuple[Way, Vector]:
    """Draw a way back to where B first touches A on the way in, if it leads farther; and the point of A there.

    Going back, no pair overlaps before the foot of its tangent, and pairs that are farther apart than the way is long
    cannot meet at all.
    """
    gap, touch = _touching(scene, search, way)
    size = length(way.move)
    direction = unit_or(way.move, HERE)
    for _ in range(ROUNDS):
        if gap <= tolerance or not size > 0.0:
            break
        left = _way_back(scene, search, way, direction, size, tolerance)
        if not left < size:
            break
        back = ended(scene, search, times(left, direction), tolerance)
        if not back.found:
            break
        way, size = back, left
        gap, touch = _touching(scene, search, way)
    return way, touch
