"""Ways out of overlapping unions drawn back to where B first touches A on the way in."""

from __future__ import annotations

import math

from . import inlined
from .atoms import Scene
from .nearby import near
from .tangents import START, UNKNOWN, foot, height, highest, soonest, taken_at, touch_of
from .vectors import Vector, length, times, unit_or
from .ways import HERE, ROUNDS, Search, Way, ask, ended, lacks_room, near_pairs

MOST_BACK = 4096
"""So many pairs are looked at to draw a way back."""


@inlined
def _touching(scene: Scene, search: Search, way: Way) -> tuple[float, Vector]:
    """Distance of the pair that is nearest at the end of a way, and its point of A; only what matters is answered."""
    known = search.known
    for _ in range(len(search.listed) + 1):  # in each but the last one more pair may have to be answered
        nearest, least = -1, math.inf
        for k in range(near_pairs(scene, search, way.move, 0.0)):
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
        if lacks_room(search, 0):
            break
        ask(scene, search, pair, way.move, way.place)
    return math.inf, UNKNOWN


@inlined
def _way_back(scene: Scene, search: Search, way: Way, direction: Vector, size: float, tolerance: float) -> float:
    """How much of a way is left when going back to the foot of the first tangent."""
    left, known = 0.0, search.known
    count = near(scene, way.move, size, search.listed)
    if count > MOST_BACK:
        return size
    if count > len(search.listed):
        search.short[0] = 1
        return size
    for k in range(count):
        pair = search.listed[k]
        if soonest(known, pair, direction, size, tolerance) > left:
            if taken_at(known, pair, way.place) < 0 and not lacks_room(search, 0):
                ask(scene, search, pair, way.move, way.place)
            left = max(left, min(size, soonest(known, pair, direction, size, tolerance)))
    return left


@inlined
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
