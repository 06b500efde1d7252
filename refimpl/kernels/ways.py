"""Translations that separate overlapping unions: found from tangents, and shortened.

One tangent for each pair of atoms that stands in the way leaves a convex set of translations, of which the shortest is
found exactly; where other pairs overlap there, they join. Each round is sure of more pairs, so it ends: with a
translation that frees all, or with planes that contradict. From a free translation the same step, with tangents taken
there, leads to one that is no longer: a descent.

No pair is asked that a known tangent proves free. Of those that are in the way the tangents are listed first
(`facets`): of polytopes all of them, so that these never have to be answered at all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from . import inlined, kernel
from .atom_pairs import answer
from .atoms import HALF_SPACE, KIND, Scene, support_gap
from .axes import three
from .facets import learn_list
from .leastmove import PLANE, Corner, shortest
from .nearby import near
from .tangents import (
    NO_PLACE,
    START,
    UNKNOWN,
    Floats,
    Ints,
    Tangents,
    height,
    highest,
    is_full,
    is_listed,
    is_whole,
    learn,
    note_list,
    taken_at,
)
from .vectors import Vector, length, unit_or

ROUNDS = 64
GAIN = 1e-9
"""A descent goes on as long as it shortens the way by this part."""
HERE = (0.0, 0.0, 0.0)


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
    levels, spots
        For each level of a branching what `branches` keeps.
    """

    known: Tangents
    planes: Floats
    source: Ints
    listed: Ints
    places: Ints
    short: Ints
    levels: Ints
    spots: Floats


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
def near_pairs(scene: Scene, search: Search, move: Vector, within: float) -> int:
    """List the pairs that are near after a translation."""
    count = near(scene, move, within, search.listed)
    if count > len(search.listed):
        search.short[0] = 1
        return 0
    return count


@kernel
def lacks_room(search: Search, planes: int) -> bool:
    """Whether there is no room for one more tangent, or plane after so many."""
    full = is_full(search.known) or planes >= len(search.source)
    if full:
        search.short[0] = 1
    return full


@kernel
def new_place(search: Search) -> int:
    """Number of another translation."""
    search.places[0] += 1
    return search.places[0]


@kernel
def ask(scene: Scene, search: Search, pair: int, move: Vector, place: int) -> float:
    """Signed distance of a pair after a translation; its tangent is kept."""
    across, best = len(scene.b), highest(search.known, pair, move)[0]
    start = three(search.known.plane, PLANE * best) if best >= 0 else HERE
    sigma, n, x, _ = answer(scene, pair // across, pair % across, move, start)
    if sigma > -math.inf:
        learn(search.known, pair, place, move, sigma, n, x)
    return sigma


@kernel
def _parted(scene: Scene, search: Search, pair: int, move: Vector) -> bool:
    """Whether an unknown pair is apart along the way itself, or that of the first tangent; cheaper than an answer."""
    across = len(scene.b)
    n = unit_or(move, three(search.known.plane, 0))
    gap = support_gap(scene, pair // across, pair % across, move, n)
    if gap >= 0.0:
        learn(search.known, pair, NO_PLACE, move, gap, n, UNKNOWN)
    return gap >= 0.0


@kernel
def list_tangents(scene: Scene, search: Search, pair: int) -> None:
    """Learn the tangents of a pair that can be told beforehand; of one with a half-space there is just one."""
    a, b = scene.a[pair // len(scene.b)], scene.b[pair % len(scene.b)]
    if a[KIND] != HALF_SPACE and b[KIND] != HALF_SPACE:
        learn_list(scene, search.known, pair)
    elif taken_at(search.known, pair, START) >= 0 or ask(scene, search, pair, HERE, START) > -math.inf:
        note_list(search.known, pair, True)


@kernel
def tangent_at(
    scene: Scene, search: Search, pair: int, move: Vector, place: int, tolerance: float
) -> tuple[int, float]:
    """Tangent of a pair after a translation, and its height: its own, unless any one proves it free.

    −1 and minus infinity where there is no room, or no end to the overlap.
    """
    known = search.known
    best, sigma = highest(known, pair, move)
    if sigma < -tolerance and not is_listed(known, pair) and not lacks_room(search, 0):
        if best >= 0 or not _parted(scene, search, pair, move):
            list_tangents(scene, search, pair)
        best, sigma = highest(known, pair, move)
    if sigma >= -tolerance or is_whole(known, pair):
        return best, sigma
    if taken_at(known, pair, place) < 0 and not lacks_room(search, 0):
        ask(scene, search, pair, move, place)
    best = taken_at(known, pair, place)
    return best, height(known, best, move) if best >= 0 else -math.inf


@kernel
def respect(search: Search, count: int, i: int) -> int:
    """Make tangent number `i` a plane that translations have to respect, after `count` others."""
    search.source[count] = i
    for k in range(PLANE):
        search.planes[PLANE * count + k] = search.known.plane[PLANE * i + k]
    return count + 1


@kernel
def most_blocked(scene: Scene, search: Search, move: Vector, place: int, tolerance: float) -> tuple[int, float]:
    """Tangent of the pair that overlaps most after a translation, −1 where none does, and its height.

    Minus infinity, with −1, where that cannot be told. Where none overlaps, the least height of those near each other.
    """
    worst, least = -1, math.inf
    for k in range(near_pairs(scene, search, move, 0.0)):
        i, sigma = tangent_at(scene, search, search.listed[k], move, place, tolerance)
        if i < 0:
            return -1, -math.inf
        if sigma < least:
            worst, least = i, sigma
    return worst if least < -tolerance else -1, least


@kernel
def _blocked(scene: Scene, search: Search, move: Vector, place: int, tolerance: float, count: int) -> tuple[int, float]:
    """Add the tangents of all pairs that overlap after a translation to `count` planes.

    Gives how many planes there are then, −1 where there is no room for them, or no end to an overlap; and the least
    that is known of the distances of all pairs near each other.
    """
    least = math.inf
    for k in range(near_pairs(scene, search, move, 0.0)):
        i, sigma = tangent_at(scene, search, search.listed[k], move, place, tolerance)
        if sigma < -tolerance:
            if i < 0 or lacks_room(search, count):
                return -1, -math.inf
            count = respect(search, count, i)
        least = min(least, sigma)
    return count, least


@inlined
def freed(scene: Scene, search: Search, count: int, limit: float, tolerance: float) -> Way:
    """From `count` planes on, let pairs that overlap join until none does, unless the way grows beyond a limit."""
    for _ in range(ROUNDS):
        move, _, possible = shortest(search.planes, count)
        if not possible or length(move) >= limit:
            break
        place = new_place(search)
        all_planes, gap = _blocked(scene, search, move, place, tolerance, count)
        if all_planes == count:
            return Way(True, move, gap, place)
        if all_planes < 0:
            break
        count = all_planes
    return no_way()


@kernel
def _stale(search: Search, corner: Corner, place: int) -> int:
    """One of the planes that hold a translation whose tangent was not taken at a place; −1 for none."""
    known = search.known
    for k in corner:
        if k >= 0 and known.place[search.source[k]] != place and not is_whole(known, known.pair[search.source[k]]):
            return k
    return -1


@inlined
def _planes_at(scene: Scene, search: Search, way: Way) -> int:
    """Collect tangents of all pairs near each other at the end of a way; those that matter are taken just there.

    Gives how many, −1 where there is no room for them.
    """
    known, count = search.known, near_pairs(scene, search, way.move, 0.0)
    for k in range(count):
        if lacks_room(search, k):
            return -1
        respect(search, k, highest(known, search.listed[k], way.move)[0])
    for _ in range(count):
        k = _stale(search, shortest(search.planes, count)[1], way.place)
        if k < 0:
            break
        pair = search.listed[k]
        if taken_at(known, pair, way.place) < 0:
            if lacks_room(search, k):
                return -1
            ask(scene, search, pair, way.move, way.place)
        respect(search, k, taken_at(known, pair, way.place))
    return count


@kernel
def descended(scene: Scene, search: Search, way: Way, lower: float, tolerance: float, steps: int) -> Way:
    """Shorten a way by tangents at its end, as long as that gains something, but not below a lower bound."""
    for _ in range(steps):
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


@inlined
def ended(scene: Scene, search: Search, move: Vector, tolerance: float) -> Way:
    """A way that is known to free, looked at."""
    place = new_place(search)
    count, gap = _blocked(scene, search, move, place, tolerance, 0)
    return Way(True, move, gap, place) if count == 0 else no_way()
