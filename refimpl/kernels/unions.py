"""Unions against unions: the pairs of atoms that decide, found by branch and bound.

Apart, the least distance over all pairs counts: the pairs are asked in the order in which the boxes around them
promise most, as long as they promise less than what is known; and of those, only the ones that are not farther apart
along the normal found last. Where two atoms overlap, all pairs that do are wanted.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import kernel
from .atom_pairs import GAPS, ORDER, answer
from .atoms import ANSWER, Scene, box_gap, prepare, support_gap
from .polytopes import Row, Scratch
from .polytopes_pair import HERE, Answer
from .vectors import Vector



@kernel
def _write(row: Scratch, key: int, found: Answer) -> None:
    """Write an answered pair."""
    sigma, n, x, y = found
    row[0], row[1] = key, sigma
    row[2], row[3], row[4] = n
    row[5], row[6], row[7] = x
    row[8], row[9], row[10] = y


@kernel
def _ask(scene: Scene, key: int, count: int, best: float, normal: Vector) -> tuple[int, float, Vector]:
    """Answer one more pair, unless it is farther apart than the best along its normal."""
    across = len(scene.b)
    i, j = key // across, key % across
    if best < math.inf:
        apart = support_gap(scene, i, j, HERE, normal)
        if apart > 0.0 and apart >= best:
            return count, best, normal
    found = answer(scene, i, j, HERE)
    _write(scene.pairs[len(scene.a) * across + count], key, found)
    if found[0] < best:
        best, normal = found[0], found[1]
    return count + 1, best, normal


@kernel
def _least(gaps: Row, count: int) -> int:
    """Place of the least number."""
    best = 0
    for i in range(1, count):
        if gaps[i] < gaps[best]:
            best = i
    return best


@kernel
def _comes_first(pair: Row, other: Row) -> bool:
    return pair[1] < other[1] or (pair[1] == other[1] and pair[0] < other[0])


@kernel
def _sort(pairs: Sequence[Scratch], start: int, count: int, order: MutableSequence[int]) -> int:
    """Copy answered pairs from row `start` on to the first rows, the deepest first; gives how many overlap."""
    overlapping = 0
    for k in range(count):
        at = k
        while at > 0 and _comes_first(pairs[start + k], pairs[order[at - 1]]):
            order[at] = order[at - 1]
            at -= 1
        order[at] = start + k
        overlapping += pairs[start + k][1] < 0.0
    for k in range(count):
        for i in range(ANSWER):
            pairs[k][i] = pairs[order[k]][i]
    return overlapping


@kernel
def nearest(scene: Scene) -> tuple[int, int]:
    """Answer the pairs that can be nearest, or overlap; gives how many overlap, and how many are answered.

    They are left in `scene.pairs`, `ANSWER` numbers each, sorted by their distance.
    """
    prepare(scene)
    across = len(scene.b)
    total, gaps = len(scene.a) * across, scene.work[GAPS]
    count, best, normal = 0, math.inf, HERE
    for key in range(total):
        gaps[key] = box_gap(scene, key // across, key % across, HERE)
        if gaps[key] == 0.0:
            count, best, normal = _ask(scene, key, count, best, normal)
            gaps[key] = math.inf
    while best > 0.0:
        key = _least(gaps, total)
        if gaps[key] >= best:
            break
        gaps[key] = math.inf
        count, best, normal = _ask(scene, key, count, best, normal)
    return _sort(scene.pairs, total, count, scene.whole[ORDER]), count


@kernel
def separations(
    unions_a: Sequence[Sequence[Row]],
    unions_b: Sequence[Sequence[Row]],
    shapes_a: Sequence[Row],
    shapes_b: Sequence[Row],
    work: Sequence[Scratch],
    whole: Sequence[MutableSequence[int]],
    pairs: Sequence[Scratch],
    answers: Sequence[Scratch],
) -> None:
    """Answer a batch: signed distance of the nearest or deepest pair, its normal and witness points, 10 numbers."""
    for row in range(len(unions_a)):
        scene = Scene(unions_a[row], unions_b[row], shapes_a, shapes_b, work, whole, pairs)
        nearest(scene)
        for i in range(10):
            answers[row][i] = pairs[0][i + 1]
