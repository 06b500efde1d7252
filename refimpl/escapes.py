"""Short translations that separate overlapping unions, for a batch of rows at once.

Of a convex pair, the signed distance as a function of the translation t is convex. So its tangent at any t, the plane
n·(t' − t) ≥ −σ, tells of translations t' that surely free this pair. One such plane for each pair that stands in the
way leaves a convex set of translations, of which the shortest is found exactly; where other pairs overlap there, they
join. Each round is sure of more pairs, so it ends: with a translation that frees all, or with planes that contradict.
From a free translation the same step, with tangents taken there, leads to one that is no longer: a descent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from refimpl.leastmove import shortest
from refimpl.linear import Array, Bools, dot, norm, scale
from refimpl.results import Separation
from refimpl.signs import Indices

ROUNDS = 64
DESCENTS = 3


class Pairs(NamedTuple):
    """Pairs of convex atoms near each other: the row of the batch, the atoms' numbers, and their signed distance."""

    row: Indices
    part_a: Indices
    part_b: Indices
    found: Separation

    def at(self, index: Indices | Bools) -> Pairs:
        """Some of the pairs."""
        return Pairs(self.row[index], self.part_a[index], self.part_b[index], self.found[index])


Look = Callable[[Indices, Array], Pairs]
"""Answers of the pairs that can meet: for some rows, and a translation of B for each; pairs count those rows from 0."""

Near = Callable[[Indices, Array, Array], Pairs]
"""The same, with all pairs whose boxes are no farther apart than a length for each row."""


@dataclass
class Ways:
    """For each row a translation of B; the signed distance there; and the point of A nearest to B there.

    A distance of −inf says that no translation is known that frees; one of inf that no pair has been looked at.
    """

    move: Array
    gap: Array
    touch: Array

    @classmethod
    def none(cls, count: int) -> Ways:
        """No ways yet."""
        return cls(np.zeros((count, 3)), np.full(count, -np.inf), np.full((count, 3), np.nan))

    @property
    def length(self) -> Array:
        """Length that surely is enough: what is left by rounding is added."""
        return norm(self.move) + np.maximum(0.0, -self.gap)

    def put(self, rows: Indices, other: Ways) -> None:
        """Take over the ways of some rows where they are shorter."""
        better = other.length < self.length[rows]
        for mine, theirs in ((self.move, other.move), (self.gap, other.gap), (self.touch, other.touch)):
            mine[rows[better]] = theirs[better]

    def at(self, rows: Indices) -> Ways:
        """Those of some rows."""
        return Ways(self.move[rows], self.gap[rows], self.touch[rows])


class _Planes:
    """Tangents of the pairs that stand in the way: for each row and pair the latest one."""

    def __init__(self) -> None:
        self.keys = np.zeros((0, 3), dtype=np.int64)
        self.normals = np.zeros((0, 3))
        self.levels = np.zeros(0)

    def take(self, pairs: Pairs, moves: Array) -> None:
        """Add or renew the tangents of pairs at the moves of their rows."""
        keys = np.concatenate([np.stack([pairs.row, pairs.part_a, pairs.part_b], axis=1), self.keys])
        levels = dot(pairs.found.normal, moves[pairs.row]) - pairs.found.distance
        _, first = np.unique(keys, axis=0, return_index=True)
        self.keys = keys[first]
        self.normals = np.concatenate([pairs.found.normal, self.normals])[first]
        self.levels = np.concatenate([levels, self.levels])[first]

    def shortest(self, rows: Indices) -> tuple[Array, Bools]:
        """Shortest translations on the right side of all tangents of each row, and which rows have one."""
        mine = np.flatnonzero(np.isin(self.keys[:, 0], rows))
        place = np.searchsorted(rows, self.keys[mine, 0])
        count = np.bincount(place, minlength=len(rows))
        column = np.arange(len(mine)) - np.repeat(np.cumsum(count) - count, count)
        normals = np.zeros((len(rows), int(count.max(initial=0)), 3))
        levels = np.full(normals.shape[:2], -np.inf)
        normals[place, column], levels[place, column] = self.normals[mine], self.levels[mine]
        return shortest(normals, levels)


def _ways(count: int, pairs: Pairs, moves: Array) -> Ways:
    """What is known at moves that free, from the pairs near each other there."""
    gap, touch = np.full(count, np.inf), np.full((count, 3), np.nan)
    order = np.lexsort((pairs.part_b, pairs.part_a, pairs.found.distance, pairs.row))
    rows, first = np.unique(pairs.row[order], return_index=True)
    nearest = order[first]
    gap[rows] = pairs.found.distance[nearest]
    touch[rows] = pairs.found.on_a[nearest]
    return Ways(moves, gap, touch)


def _freed(look: Look, planes: _Planes, moves: Array, limit: Array, tolerance: Array) -> tuple[Ways, Pairs]:
    """From some moves on, let pairs that overlap join until none does, unless a move grows beyond its limit."""
    count = len(moves)
    moves, found, near = moves.copy(), Ways.none(count), []
    open_rows = np.flatnonzero(norm(moves) < limit)
    for _ in range(ROUNDS):
        if not len(open_rows):
            break
        pairs = look(open_rows, moves[open_rows])
        pairs = pairs._replace(row=open_rows[pairs.row])
        inside = pairs.found.distance < -tolerance[pairs.row]
        stuck = np.zeros(count, dtype=bool)
        stuck[pairs.row[inside]] = True
        free = open_rows[~stuck[open_rows]]
        here = pairs.at(~stuck[pairs.row])
        if len(free):
            found.put(free, _ways(count, here, moves).at(free))
            near.append(here)
        endless = np.unique(pairs.row[inside & ~np.isfinite(pairs.found.distance)])
        open_rows = np.setdiff1d(open_rows[stuck[open_rows]], endless)
        planes.take(pairs.at(inside & np.isin(pairs.row, open_rows)), moves)
        if len(open_rows):
            t, feasible = planes.shortest(open_rows)
            moves[open_rows] = t
            open_rows = open_rows[feasible & (norm(t) < limit[open_rows])]
    return found, joined_pairs(near)


def joined_pairs(parts: list[Pairs]) -> Pairs:
    """Several lists of pairs as one."""
    if not parts:
        none = np.zeros(0, dtype=np.int64)
        return Pairs(none, none, none, Separation(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))))
    row, part_a, part_b = (np.concatenate([getattr(p, n) for p in parts]) for n in ("row", "part_a", "part_b"))
    found = (np.concatenate([getattr(p.found, n) for p in parts]) for n in ("distance", "on_a", "on_b", "normal"))
    return Pairs(row, part_a, part_b, Separation(*found))


def _descended(look: Look, ways: Ways, pairs: Pairs, tolerance: Array) -> Ways:
    """Shorten ways by tangents at their ends, as long as that gains something."""
    for _ in range(DESCENTS):
        rows = np.unique(pairs.row)
        if not len(rows):
            break
        planes = _Planes()
        planes.take(pairs, ways.move)
        start, feasible = planes.shortest(rows)
        moves = np.zeros_like(ways.move)
        moves[rows] = start
        limit = np.zeros(len(moves))
        limit[rows[feasible]] = ways.length[rows[feasible]] * (1 - 1e-9)
        better, pairs = _freed(look, planes, moves, limit, tolerance)
        ways.put(np.arange(len(moves)), better)
    return ways


def _pushed(look: Look, directions: Array, limit: Array, tolerance: Array) -> tuple[Ways, Pairs]:
    """Short free translations along directions: each pair in the way is left by its tangent."""
    count = len(directions)
    s, found, near = np.zeros(count), Ways.none(count), []
    open_rows = np.arange(count)
    for _ in range(ROUNDS):
        if not len(open_rows):
            break
        moves = scale(s, directions)
        pairs = look(open_rows, moves[open_rows])
        pairs = pairs._replace(row=open_rows[pairs.row])
        inside = pairs.found.distance < -tolerance[pairs.row]
        stuck = np.zeros(count, dtype=bool)
        stuck[pairs.row[inside]] = True
        free = open_rows[~stuck[open_rows]]
        here = pairs.at(~stuck[pairs.row])
        if len(free):
            found.put(free, _ways(count, here, moves).at(free))
            near.append(here)
        rows, depth = pairs.row[inside], -pairs.found.distance[inside]
        slope = dot(pairs.found.normal[inside], directions[rows])
        steep = (slope > 1e-6) & np.isfinite(depth)
        step = np.zeros(count)
        np.maximum.at(step, rows[steep], depth[steep] / slope[steep])
        s = s + step
        open_rows = open_rows[stuck[open_rows] & (step[open_rows] > 0) & (s[open_rows] < limit[open_rows])]
    return found, joined_pairs(near)


def escape(look: Look, count: int, lower: Array, tolerance: Array) -> Ways:
    """Find a short translation of B that frees it, for each row, from the tangents of what overlaps at the start.

    Parameters
    ----------
    look
    count : int
        Number of rows.
    lower : (count,)
        No shorter translation frees: what comes as short as this is not shortened further.
    tolerance : (count,)
        Depths that are rounding.

    Returns
    -------
    Ways
    """
    start = np.zeros((count, 3))
    ways, pairs = _freed(look, _Planes(), start, np.full(count, np.inf), tolerance)
    rough = ways.length > lower + 2 * tolerance
    return _descended(look, ways, pairs.at(rough[pairs.row]), tolerance)


def touching(near: Near, ways: Ways, tolerance: Array) -> Ways:
    """Draw ways back to where B first touches A on the way in, if they lead farther.

    Going back, no pair overlaps before the foot of its tangent; pairs that are farther apart than the way is long
    cannot meet at all.

    Parameters
    ----------
    near
    ways : Ways
    tolerance : (n,)
        Gaps that are rounding.
    """
    start = ways.at(np.arange(len(ways.gap)))
    length = norm(ways.move)
    direction = scale(1 / np.where(length > 0, length, 1.0), ways.move)
    open_rows = np.flatnonzero((ways.gap > tolerance) & (length > 0))
    for _ in range(ROUNDS):
        if not len(open_rows):
            break
        pairs = near(open_rows, ways.move[open_rows], length[open_rows])
        pairs = pairs._replace(row=open_rows[pairs.row])
        here = _ways(len(length), pairs, ways.move).at(open_rows)
        ways.gap[open_rows], ways.touch[open_rows] = here.gap, here.touch
        slope = dot(pairs.found.normal, direction[pairs.row])
        against = slope > 0
        step = length.copy()
        np.minimum.at(step, pairs.row[against], pairs.found.distance[against] / slope[against])
        open_rows = open_rows[(ways.gap[open_rows] > tolerance[open_rows]) & (step[open_rows] > 0)]
        length[open_rows] = length[open_rows] - step[open_rows]
        ways.move[open_rows] = scale(length[open_rows], direction[open_rows])
    kept = np.where(ways.gap < -tolerance)[0]  # where rounding led too far
    ways.move[kept], ways.gap[kept], ways.touch[kept] = start.move[kept], start.gap[kept], start.touch[kept]
    return ways


def push(look: Look, directions: Array, enough: Array, limit: Array, tolerance: Array) -> Ways:
    """Find short translations that free along given directions, one for each row, and shorten them by descent.

    Parameters
    ----------
    look
    directions : (n, 3)
    enough : (n,)
        Length that is known to free along the direction, or inf.
    limit : (n,)
        Ways that are no shorter are of no interest.
    tolerance : (n,)
    """
    ways, pairs = _pushed(look, directions, np.minimum(limit, enough), tolerance)
    far = np.flatnonzero(~np.isfinite(ways.length) & (enough < limit))
    if len(far):
        moves = scale(enough[far], directions[far])
        there = look(far, moves)
        end = _ways(len(far), there, moves)
        free = end.gap >= -tolerance[far]  # hulls that part leave no doubt, but for rounding
        ways.put(far[free], end.at(np.flatnonzero(free)))
        pairs = joined_pairs([pairs, there._replace(row=far[there.row]).at(free[there.row])])
    return _descended(look, ways, pairs, tolerance)
