"""What is known of the signed distances of pairs of convex atoms, as functions of B's translation: their tangents.

Of a convex pair, the signed distance σ(t) after a translation t is a convex function. So its tangent where it was
answered, n·(t' − t) + σ(t), is nowhere greater than σ(t'): where a tangent is not negative, the pair is surely free, and
need not be answered again. Pairs are whole numbers; the tangents of each hang together in a list, the latest first.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import NamedTuple

from . import kernel
from .axes import three
from .leastmove import LEVEL, PLANE
from .vectors import Vector, dot

Floats = MutableSequence[float]
Ints = MutableSequence[int]


class Tangents(NamedTuple):
    """Tangents of pairs, in the order in which they came.

    Attributes
    ----------
    first : a whole number for each pair
        Its latest tangent, counted from 1; 0 for none.
    next, pair, place : whole numbers, for each tangent
        The one of the same pair before it, counted likewise; its pair; the number of the translation at which it
        was taken.
    plane : 4 floats for each tangent
        The pair is free where n·t ≥ level.
    touch : 3 floats for each tangent
        The witness point on A.
    count : one whole number
        How many there are.
    """

    first: Ints
    next: Ints
    pair: Ints
    place: Ints
    plane: Floats
    touch: Floats
    count: Ints


ROOM = 1 << 13
"""How many tangents fit; a search that needs more ends with what it has."""
SLOPE = 1e-6
"""Directions that rise less than this lead out of nothing."""


@kernel
def forget(known: Tangents) -> None:
    """Remove all tangents."""
    for i in range(known.count[0]):
        known.first[known.pair[i]] = 0
    known.count[0] = 0


@kernel
def is_full(known: Tangents) -> bool:
    """Whether no tangent fits any more."""
    return known.count[0] >= len(known.pair)


@kernel
def learn(known: Tangents, pair: int, place: int, move: Vector, sigma: float, n: Vector, touch: Vector) -> None:
    """Add the tangent of a pair, from its finite signed distance, normal and witness point after a translation."""
    i = known.count[0]
    known.next[i], known.pair[i], known.place[i] = known.first[pair], pair, place
    at = PLANE * i
    known.plane[at], known.plane[at + 1], known.plane[at + 2], known.plane[at + LEVEL] = *n, dot(n, move) - sigma
    at = 3 * i
    known.touch[at], known.touch[at + 1], known.touch[at + 2] = touch
    known.first[pair] = i + 1
    known.count[0] = i + 1


@kernel
def height(known: Tangents, i: int, move: Vector) -> float:
    """Value of tangent number `i` after a translation."""
    return dot(three(known.plane, PLANE * i), move) - known.plane[PLANE * i + LEVEL]


@kernel
def highest(known: Tangents, pair: int, move: Vector) -> tuple[int, float]:
    """Tangent of a pair that is greatest after a translation, −1 for none, and its value there: no more than σ is."""
    best, most = -1, -math.inf
    i = known.first[pair] - 1
    while i >= 0:
        here = height(known, i, move)
        if here > most:
            best, most = i, here
        i = known.next[i] - 1
    return best, most


@kernel
def taken_at(known: Tangents, pair: int, place: int) -> int:
    """Tangent of a pair that was taken at a translation; −1 for none."""
    i = known.first[pair] - 1
    while i >= 0 and known.place[i] != place:
        i = known.next[i] - 1
    return i


@kernel
def leave(known: Tangents, i: int, direction: Vector) -> float:
    """Least multiple s ≥ 0 of a direction from which on a tangent is not negative; inf for none."""
    level = known.plane[PLANE * i + LEVEL]
    slope = dot(three(known.plane, PLANE * i), direction)
    if level <= 0.0 and slope >= 0.0:
        return 0.0
    return level / slope if slope > SLOPE else math.inf


@kernel
def soonest(known: Tangents, pair: int, direction: Vector) -> tuple[int, float]:
    """Tangent of a pair that is left soonest along a direction, −1 for none, and from which multiple on."""
    best, least = -1, math.inf
    i = known.first[pair] - 1
    while i >= 0:
        here = leave(known, i, direction)
        if best < 0 or here < least:
            best, least = i, here
        i = known.next[i] - 1
    return best, least


def touch_of(known: Tangents, i: int) -> Sequence[float]:
    """Witness point on A of a tangent."""
    return three(known.touch, 3 * i)
