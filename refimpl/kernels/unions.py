"""Unions against unions: the pairs of atoms that decide, found by branch and bound.

Apart, the least distance over all pairs counts: the pairs are asked in the order in which the boxes around them
promise most, as long as they promise less than what is known; and of those, only the ones that are not farther apart
along the normal found last. Where two atoms overlap, all pairs that do are wanted.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import NamedTuple

from . import inlined, kernel
from .atom_pairs import GAPS, KEYS, ORDER, answer
from .atoms import ANSWER, HALF_SPACE, KIND, Scene, support_gap
from .escapes import way_out
from .nearby import box_gap, near, prepare, promising
from .polytopes import Row, Scratch
from .polytopes_pair import HERE, Answer
from .vectors import Vector
from .ways import Search


@kernel
def _write(row: Scratch, key: int, found: Answer) -> None:
    """Write an answered pair."""
    sigma, n, x, y = found
    row[0], row[1] = key, sigma
    row[2], row[3], row[4] = n
    row[5], row[6], row[7] = x
    row[8], row[9], row[10] = y


@kernel
def _ask(scene: Scene, key: int, every: bool, count: int, best: float, normal: Vector) -> tuple[int, float, Vector]:
    """Answer one more pair, unless it is farther apart, or not so deep, as the best along its normal.

    If `every` one that overlaps is wanted, a lesser depth is no reason.
    """
    across = len(scene.b)
    i, j = key // across, key % across
    if best < math.inf:
        apart = support_gap(scene, i, j, HERE, normal)
        if apart >= best and (apart > 0.0 or not every):
            return count, best, normal
    found = answer(scene, i, j, HERE, HERE)
    _write(scene.pairs[len(scene.pairs) // 2 + count], key, found)
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


@inlined
def _nearest_of_few(scene: Scene, count: int, best: float, normal: Vector) -> int:
    """Answer pairs whose boxes are apart, the nearest boxes first, as long as they promise less than the best."""
    across = len(scene.b)
    total, gaps = len(scene.a) * across, scene.work[GAPS]
    for key in range(total):
        gap = box_gap(scene, key // across, key % across, HERE)
        gaps[key] = gap if gap > 0.0 else math.inf
    key = _least(gaps, total)
    while gaps[key] < best:
        gaps[key] = math.inf
        count, best, normal = _ask(scene, key, True, count, best, normal)
        key = _least(gaps, total)
    return count


@inlined
def _nearest_of_many(scene: Scene, count: int, best: float, normal: Vector) -> int:
    """The same, as they come; −1 where there is no room for all that are near."""
    across, keys = len(scene.b), scene.whole[KEYS]
    if count == 0:
        count, best, normal = _ask(scene, promising(scene, HERE), True, count, best, normal)
    known = int(scene.pairs[len(scene.pairs) // 2][0])
    listed = near(scene, HERE, best, keys)
    if count + listed > len(scene.pairs) // 2:
        return -1
    for k in range(listed):
        gap = box_gap(scene, keys[k] // across, keys[k] % across, HERE)
        if 0.0 < gap < best and keys[k] != known:
            count, best, normal = _ask(scene, keys[k], True, count, best, normal)
    return count


@kernel
def nearest(scene: Scene, every: bool) -> tuple[int, int]:
    """Answer the pairs that can be nearest, or deepest; gives how many of them overlap, and how many are answered.

    If `every` one that overlaps is wanted, they all are. They are left in `scene.pairs`, `ANSWER` numbers each, sorted
    by their distance. −1 for both where there is no room for them.
    """
    prepare(scene)
    keys, room, count, best, normal = scene.whole[KEYS], len(scene.pairs) // 2, 0, math.inf, HERE
    meeting = near(scene, HERE, 0.0, keys)
    if meeting > room:
        return -1, -1
    for k in range(meeting):
        count, best, normal = _ask(scene, keys[k], every, count, best, normal)
    if best > 0.0:
        if len(scene.a) * len(scene.b) <= room:
            count = _nearest_of_few(scene, count, best, normal)
        else:
            count = _nearest_of_many(scene, count, best, normal)
    if count < 0:
        return -1, -1
    return _sort(scene.pairs, room, count, scene.whole[ORDER]), count


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


@inlined
def _answered(scene: Scene, search: Search, tolerance: float, ways: bool, row: Scratch) -> bool:
    """Answer one pair of unions, overlapping ones by a way out, if that is wanted; whether there was room."""
    overlapping, answered = nearest(scene, False)
    if overlapping < 0:
        return False
    alone_a, alone_b = len(scene.a) == 1, len(scene.b) == 1
    # a single half-space is left by all along its normal, by the deepest last
    plain = (alone_a and scene.a[0][KIND] == HALF_SPACE) or (alone_b and scene.b[0][KIND] == HALF_SPACE)
    if ways and overlapping > 0 and not plain and not (alone_a and alone_b):
        return way_out(scene, search, answered, tolerance, row)
    for i in range(10):
        row[i] = scene.pairs[0][i + 1]
    row[10] = row[14] = max(0.0, -row[0])
    return True


@kernel
def separations(
    batch: Batch, search: Search, tolerances: Sequence[float], ways: bool, first: int, answers: Sequence[Scratch]
) -> int:
    """Answer a batch from row `first` on, as far as there is room; gives the row that it comes to.

    Each row gets `RESULT` numbers (`escapes`); those that do not overlap have no use for the point.
    """
    for row in range(first, len(batch.a)):
        if not _answered(scene_of(batch, row), search, tolerances[row], ways, answers[row]):
            return row
    return len(batch.a)


@inlined
def _meet(scene: Scene) -> int:
    """Whether two unions have a point in common, 1 or 0; −1 where there is no room. As soon as two atoms have one."""
    prepare(scene)
    across, keys, normal = len(scene.b), scene.whole[KEYS], HERE
    meeting = near(scene, HERE, 0.0, keys)
    if meeting > len(keys):
        return -1
    for k in range(meeting):
        i, j = keys[k] // across, keys[k] % across
        if k == 0 or support_gap(scene, i, j, HERE, normal) <= 0.0:
            sigma, normal, _, _ = answer(scene, i, j, HERE, HERE)
            if sigma <= 0.0:
                return 1
    return 0


@kernel
def meetings(batch: Batch, first: int, hits: MutableSequence[int]) -> int:
    """Answer whether unions have a point in common, from row `first` on; gives the row that it comes to."""
    for row in range(first, len(batch.a)):
        hits[row] = _meet(scene_of(batch, row))
        if hits[row] < 0:
            return row
    return len(batch.a)


@kernel
def contacts(batch: Batch) -> tuple[int, int]:
    """Overlapping pairs of atoms of the only row of a batch, as `nearest` gives them."""
    return nearest(scene_of(batch, 0), True)
