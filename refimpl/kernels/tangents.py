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
    used : one whole number
        How many there are.
    """

    first: Ints
    next: Ints
    pair: Ints
    place: Ints
    plane: Floats
    touch: Floats
    used: Ints


@kernel
def _chain(known: Tangents, pair: int) -> int:
    """Number of a pair's chain; dividing is slow, and mostly there is one for each."""
    chains = len(known.first)
    return pair if pair < chains else pair % chains


@kernel
def forget(known: Tangents) -> None:
    """Remove all tangents."""
    for i in range(known.used[0]):
        known.first[_chain(known, known.pair[i])] = 0
    known.used[0] = 0


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
    i = known.first[_chain(known, pair)] - 1
    while i >= 0:
        here = height(known, i, move)
        if here > most and known.pair[i] == pair:
            best, most = i, here
        i = known.next[i] - 1
    return best, most


@kernel
def taken_at(known: Tangents, pair: int, place: int) -> int:
    """Tangent of a pair that was taken at a translation; −1 for none."""
    i = known.first[_chain(known, pair)] - 1
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
    i = known.first[_chain(known, pair)] - 1
    while i >= 0:
        if known.pair[i] == pair:
            least = min(least, free_from(known, i, direction, end, tolerance))
        i = known.next[i] - 1
    return least


@kernel
def touch_of(known: Tangents, i: int) -> Vector:
    """Witness point on A of a tangent."""
    return three(known.touch, 3 * i)
