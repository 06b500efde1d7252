"""What is known of the signed distances of pairs of convex atoms, as functions of B's translation: their tangents.

Of a convex pair, the signed distance σ(t) after a translation t is a convex function. So its tangent where it was
answered, n·(t' − t) + σ(t), is nowhere greater than σ(t'): where a tangent is not negative, the pair is surely free
and need not be answered again. Pairs are whole numbers; their tangents hang in chains, the latest first.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import NamedTuple

from . import kernel
from .axes import three
from .leastmove import LEVEL, PLANE
from .vectors import Vector, dot, times

START, NO_PLACE = 0, -1
"""Numbers of translations: that by nothing; and for tangents that are known without having been taken anywhere."""
UNKNOWN = (math.nan, math.nan, math.nan)
Floats = MutableSequence[float]
Ints = MutableSequence[int]


class Tangents(NamedTuple):
    """Tangents of pairs, in the order in which they came.

    Attributes
    ----------
    first : whole numbers
        Chain number pair % len(first) holds the tangents of a pair, maybe among those of others: here is its latest
        one, counted from 1; 0 for none.
    next, pair, place : whole numbers, for each tangent
        The one before it in its chain, counted likewise; its pair; the number of the translation at which it was
        taken.
    plane : 4 floats for each tangent
        The pair is free where n·t ≥ level.
    touch : 3 floats for each tangent
        The witness point on A.
    listed : whole numbers, one for each chain
        The pair there of which a list of tangents has been learned, counted from 1, or minus that number where the list
        tells the signed distance wherever the pair overlaps; 0 for none.
    used : one whole number
        How many there are.
    """

    first: Ints
    next: Ints
    pair: Ints
    place: Ints
    plane: Floats
    touch: Floats
    listed: Ints
    used: Ints


@kernel
def _chain(known: Tangents, pair: int) -> int:
    """Number of a pair's chain; dividing is slow, and mostly there is one for each."""
    chains = len(known.first)
    return pair if pair < chains else pair % chains


@kernel
def forget(known: Tangents) -> None:
    """Remove all tangents."""
    if len(known.first) < known.used[0]:
        for chain in range(len(known.first)):
            known.first[chain] = known.listed[chain] = 0
    else:
        for i in range(known.used[0]):
            chain = _chain(known, known.pair[i])
            known.first[chain] = known.listed[chain] = 0
    known.used[0] = 0


@kernel
def begin_again(known: Tangents, pair: int) -> None:
    """Leave out the tangents of a pair that are known so far, for they will be learned once more."""
    known.first[_chain(known, pair)] = 0


@kernel
def note_list(known: Tangents, pair: int, whole: bool) -> None:
    """Note that a list of a pair's tangents has been learned, and whether it is the whole one."""
    known.listed[_chain(known, pair)] = -(pair + 1) if whole else pair + 1


@kernel
def is_listed(known: Tangents, pair: int) -> bool:
    """Whether a list of a pair's tangents is known."""
    return abs(known.listed[_chain(known, pair)]) == pair + 1


@kernel
def is_whole(known: Tangents, pair: int) -> bool:
    """Whether known tangents tell the signed distance of a pair wherever it overlaps."""
    return known.listed[_chain(known, pair)] == -(pair + 1)


@kernel
def is_full(known: Tangents) -> bool:
    """Whether no tangent fits any more."""
    return known.used[0] >= len(known.pair)


@kernel
def learn(known: Tangents, pair: int, place: int, move: Vector, sigma: float, n: Vector, touch: Vector) -> None:
    """Add the tangent of a pair, from its finite signed distance, normal and witness point after a translation."""
    i = known.used[0]
    chain = _chain(known, pair)
    known.next[i], known.pair[i], known.place[i] = known.first[chain], pair, place
    at = PLANE * i
    known.plane[at], known.plane[at + 1], known.plane[at + 2] = n
    known.plane[at + LEVEL] = dot(n, move) - sigma
    at = 3 * i
    known.touch[at], known.touch[at + 1], known.touch[at + 2] = touch
    known.first[chain] = i + 1
    known.used[0] = i + 1


@kernel
def first_of(known: Tangents, pair: int) -> int:
    """First tangent of a pair's chain, the latest one; −1 for none."""
    return known.first[_chain(known, pair)] - 1


@kernel
def height(known: Tangents, i: int, move: Vector) -> float:
    """Value of tangent number `i` after a translation."""
    return dot(three(known.plane, PLANE * i), move) - known.plane[PLANE * i + LEVEL]


@kernel
def foot(known: Tangents, i: int) -> Vector:
    """Shortest translation from which on a tangent of an overlapping pair is not negative."""
    return times(known.plane[PLANE * i + LEVEL], three(known.plane, PLANE * i))


@kernel
def highest(known: Tangents, pair: int, move: Vector) -> tuple[int, float]:
    """Tangent of a pair that is greatest after a translation, −1 for none, and its value there: no more than σ is."""
    best, most = -1, -math.inf
    i = first_of(known, pair)
    while i >= 0:
        here = height(known, i, move)
        if here > most and known.pair[i] == pair:
            best, most = i, here
        i = known.next[i] - 1
    return best, most


@kernel
def taken_at(known: Tangents, pair: int, place: int) -> int:
    """Tangent of a pair that was taken at a translation; −1 for none."""
    i = first_of(known, pair)
    while i >= 0 and not (known.place[i] == place and known.pair[i] == pair):
        i = known.next[i] - 1
    return i


@kernel
def free_from(known: Tangents, i: int, direction: Vector, end: float, tolerance: float) -> float:
    """Least multiple of a direction from which on, up to `end`, a tangent is not negative; inf for none."""
    slope, level = dot(three(known.plane, PLANE * i), direction), known.plane[PLANE * i + LEVEL]
    if slope * end - level < -tolerance:
        return math.inf
    return max(0.0, min(level / slope, end)) if slope > 0.0 else 0.0


@kernel
def soonest(known: Tangents, pair: int, direction: Vector, end: float, tolerance: float) -> float:
    """The same for all tangents of a pair: from where on it is surely free; inf where nothing is known."""
    least = math.inf
    i = first_of(known, pair)
    while i >= 0:
        if known.pair[i] == pair:
            least = min(least, free_from(known, i, direction, end, tolerance))
        i = known.next[i] - 1
    return least


@kernel
def touch_of(known: Tangents, i: int) -> Vector:
    """Witness point on A of a tangent."""
    return three(known.touch, 3 * i)
