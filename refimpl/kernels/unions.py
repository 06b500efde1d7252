"""Unions against unions: the pairs of atoms that decide, found by branch and bound.

Apart, the least distance over all pairs counts: the pairs are asked in the order in which the boxes around them
promise most, as long as they promise less than what is known; and of those, only the ones that are not farther apart
along the normal found last. Where two atoms overlap, all pairs that do are wanted.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import NamedTuple

from . import kernel
from .atom_pairs import GAPS, ORDER, answer
from .atoms import ANSWER, Scene, box_gap, near, prepare, support_gap
from .axes import three
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


class Batch(NamedTuple):
    """Pairs of unions, row by row, and what a `Scene` of them needs besides."""

    a: Sequence[Sequence[Row]]
    b: Sequence[Sequence[Row]]
    shapes_a: Sequence[Row]
    shapes_b: Sequence[Row]
    work: Sequence[Scratch]
    whole: Sequence[MutableSequence[int]]
    pairs: Sequence[Scratch]


@kernel
def scene_of(batch: Batch, row: int) -> Scene:
    """One pair of a batch."""
    return Scene(batch.a[row], batch.b[row], batch.shapes_a, batch.shapes_b, batch.work, batch.whole, batch.pairs)


@kernel
def separations(batch: Batch, answers: Sequence[Scratch]) -> None:
    """Answer a batch: signed distance of the nearest or deepest pair, its normal and witness points, 10 numbers."""
    for row in range(len(batch.a)):
        nearest(scene_of(batch, row))
        for i in range(10):
            answers[row][i] = batch.pairs[0][i + 1]


@kernel
def _meet(scene: Scene) -> bool:
    """Whether two unions have a point in common; as soon as two atoms do."""
    prepare(scene)
    across, normal = len(scene.b), HERE
    for key in range(len(scene.a) * across):
        i, j = key // across, key % across
        if box_gap(scene, i, j, HERE) == 0.0 and not (key > 0 and support_gap(scene, i, j, HERE, normal) > 0.0):
            sigma, normal, _, _ = answer(scene, i, j, HERE)
            if sigma <= 0.0:
                return True
    return False


@kernel
def meetings(batch: Batch, hits: MutableSequence[bool]) -> None:
    """Answer a batch: whether unions have a point in common."""
    for row in range(len(batch.a)):
        hits[row] = _meet(scene_of(batch, row))


@kernel
def near_pairs(
    batch: Batch, rows: Sequence[int], moves: Sequence[Row], within: Sequence[float], answers: Sequence[Scratch]
) -> int:
    """Answer the pairs whose boxes are near once B is moved, in some rows of a batch; gives how many there are.

    Parameters
    ----------
    batch
    rows, moves, within
        For each question a row of the batch, a translation of B, and the largest gap of boxes that counts.
    answers
        `ANSWER` numbers for each pair, and the number of the question; with fewer rows, pairs are only counted.
    """
    count = 0
    for question in range(len(rows)):
        scene, move = scene_of(batch, rows[question]), three(moves[question], 0)
        prepare(scene)
        keys = scene.whole[ORDER]
        listed = near(scene, move, within[question], keys)
        for k in range(listed):
            if count + k < len(answers):
                across = len(scene.b)
                found = answer(scene, keys[k] // across, keys[k] % across, move)
                _write(answers[count + k], keys[k], found)
                answers[count + k][ANSWER] = question
        count += listed
    return count
