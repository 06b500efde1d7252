"""The shortest way out by branch and bound, over the tangents beyond which each pair in the way may be left.

A pair of convex atoms is free beyond any one of its tangents. So from a translation at which a pair overlaps, a branch
leads to each of that pair's tangents: the shortest translation beyond it and beyond those that led here. A branch that
becomes longer than the shortest way that is known is given up. Where all pairs in the way are polytopes, all facets of
whose differences are known, no way is overlooked, and the one that is found is the shortest there is (Land and Doig, An
automatic method of solving discrete programming problems, 1960).
"""

from __future__ import annotations

import math

from . import inlined, kernel
from .atoms import Scene
from .axes import three
from .gjk import store
from .leastmove import FREE, Corner, lengthened
from .tangents import first_of, height, is_whole
from .vectors import Vector, dot, length
from .ways import HERE, Search, Way, lacks_room, long, most_blocked, new_place, respect

LEVEL, SPOT = 5, 4
"""Numbers of a level: the pair, the branch that was tried last, and three tangents that hold the translation; this
translation, and how far it is below that branch."""
LEVELS = 48
"""Most tangents that one way is held by."""
STEPS = 256
"""Branches that are looked at."""
SAME = 1.0 - 2.0**-44
"""A way as long as another one, but for rounding, is no shorter one."""


@kernel
def _open(search: Search, level: int, pair: int, move: Vector, corner: Corner) -> None:
    """Begin to branch at a translation that is held by some of the tangents that led there."""
    at = LEVEL * level
    search.levels[at], search.levels[at + 1] = pair, -1
    search.levels[at + 2], search.levels[at + 3], search.levels[at + 4] = corner
    store(search.spots, SPOT * level, move)
    search.spots[SPOT * level + 3] = -math.inf


@kernel
def _next(search: Search, level: int) -> int:
    """Next branch of a level: the tangents of its pair, the highest first; −1 for none."""
    known, pair, last = search.known, search.levels[LEVEL * level], search.levels[LEVEL * level + 1]
    move, below = three(search.spots, SPOT * level), search.spots[SPOT * level + 3]
    found, least = -1, math.inf
    i = first_of(known, pair)
    while i >= 0:
        here = -height(known, i, move)
        if known.pair[i] == pair and here < least and (here > below or (here == below and i < last)):
            found, least = i, here
        i = known.next[i] - 1
    if found >= 0:
        search.levels[LEVEL * level + 1], search.spots[SPOT * level + 3] = found, least
    return found


@kernel
def _next_move(search: Search, level: int, limit: float) -> tuple[int, Vector, Corner]:
    """Next branch of a level, or of a former one, that is shorter than a limit: its level, −1 for none; where it leads.

    And what holds that translation.
    """
    while level >= 0:
        i, at = _next(search, level), LEVEL * level
        move, below = three(search.spots, SPOT * level), search.spots[SPOT * level + 3]
        if i < 0 or lacks_room(search, level) or dot(move, move) + below * below >= limit * limit:
            level -= 1
            continue
        respect(search, level, i)
        corner = (search.levels[at + 2], search.levels[at + 3], search.levels[at + 4])
        move, corner, possible = lengthened(search.planes, level + 1, move, corner)
        if possible and length(move) < limit:
            return level, move, corner
    return -1, HERE, FREE


@inlined
def branched(scene: Scene, search: Search, first: int, way: Way, tolerance: float) -> tuple[Way, bool]:
    """Find a way shorter than one that is known, from the tangents of a first pair on, which overlaps.

    Also whether there surely is none shorter, but for rounding.
    """
    level, known = 0, search.known
    _open(search, 0, first, HERE, FREE)
    sure = is_whole(known, first)
    for _ in range(STEPS):
        level, move, corner = _next_move(search, level, SAME * long(way))
        if level < 0:
            return way, sure
        place = new_place(search)
        i, gap = most_blocked(scene, search, move, place, tolerance)
        if i >= 0 and level + 1 < LEVELS:
            level += 1
            _open(search, level, known.pair[i], move, corner)
            sure = sure and is_whole(known, known.pair[i])
        elif i < 0 and gap > -math.inf:
            way = Way(True, move, gap, place)
        else:
            sure = False
    return way, False
