"""Short translations that separate two overlapping unions.

Of a convex pair, the signed distance as a function of the translation t is convex. So its tangent at any t, the plane
n·(t' − t) ≥ −σ, tells of translations t' that surely free this pair. One such plane for each pair that stands in the
way leaves a convex set of translations, of which the shortest is found exactly; where other pairs overlap there, they
join. Each round is sure of more pairs, so it ends: with a translation that frees all, or with planes that contradict.
From a free translation the same step, with tangents taken there, leads to one that is no longer: a descent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from refimpl.linear import Array, Bools, dot, norm
from refimpl.results import Separation
from refimpl.signs import Indices

ROUNDS = 64
DESCENTS = 4


class Pairs(NamedTuple):
    """Pairs of convex atoms near each other: their numbers, and the signed distance of each."""

    part_a: Indices
    part_b: Indices
    found: Separation


class Way(NamedTuple):
    """A translation of B, how deep the deepest pair still is after it, and the pair nearest to touching there."""

    move: Array
    rest: float
    contact: Separation | None

    @property
    def length(self) -> float:
        """Length that surely is enough: what is left by rounding is added."""
        return float(norm(self.move)) + self.rest


Look = Callable[[Array], Pairs]
"""Answers of the pairs that can meet after a translation of B."""


def shortest(normals: Array, levels: Array) -> Array | None:
    """Shortest vector t with normals·t ≥ levels; None where there is none.

    The constraint that is broken most joins, and of those that held the vector so far, at most two stay: the dual
    method of Goldfarb and Idnani (1983), with its small systems solved by trial. The vector only grows, so it ends.
    """
    t = np.zeros(3)
    active: list[int] = []
    size = float(np.max(np.abs(levels), initial=0.0))
    for _ in range(8 * len(levels) + 8):
        slack = dot(normals, t[None]) - levels
        worst = int(np.argmin(slack))
        if slack[worst] >= -1e-14 * size:
            return t
        found = _held(normals, levels, [*active, worst], 1e-13 * size)
        if found is None:
            return None
        t, active = found
    return None


def _held(normals: Array, levels: Array, rows: list[int], slack: float) -> tuple[Array, list[int]] | None:
    """Shortest vector for up to four constraints of which the last must be held, and those that hold it."""
    for count in (1, 2, 3):
        for others in combinations(rows[:-1], count - 1):
            chosen = [*others, rows[-1]]
            m = normals[chosen]
            gram = m @ m.T
            if np.linalg.cond(gram) > 1e12:
                continue
            weights = np.linalg.solve(gram, levels[chosen])
            t = weights @ m
            if np.all(weights >= 0) and np.all(normals[rows] @ t >= levels[rows] - slack):
                return t, chosen
    return None


class _Planes:
    """Tangents of pairs that stand in the way: for each pair one."""

    def __init__(self) -> None:
        self.rows: dict[tuple[int, int], tuple[Array, float]] = {}

    def take(self, pairs: Pairs, which: Bools, t: Array) -> None:
        """Add or renew the tangents of some pairs at t."""
        for i in np.flatnonzero(which).tolist():
            n = pairs.found.normal[i]
            level = float(dot(n, t)) - float(pairs.found.distance[i])
            self.rows[int(pairs.part_a[i]), int(pairs.part_b[i])] = (n, level)

    def known(self, pairs: Pairs) -> Bools:
        """Which pairs have a tangent."""
        keys = zip(pairs.part_a.tolist(), pairs.part_b.tolist(), strict=True)
        return np.array([key in self.rows for key in keys], dtype=bool)

    def shortest(self) -> Array | None:
        """Shortest translation on the right side of all tangents."""
        normals = np.array([n for n, _ in self.rows.values()])
        return shortest(normals, np.array([level for _, level in self.rows.values()]))


def _free(look: Look, planes: _Planes, t: Array | None, limit: float, tolerance: float) -> tuple[Way, Pairs] | None:
    """From t on, let pairs that overlap join until none does; None when it fails or grows beyond `limit`."""
    for _ in range(ROUNDS):
        if t is None or norm(t) >= limit:
            return None
        pairs = look(t)
        gap = pairs.found.distance
        inside = gap < -tolerance
        if not np.any(inside):
            return _way(t, pairs), pairs
        if not np.all(np.isfinite(gap[inside])):
            return None
        planes.take(pairs, inside, t)
        t = planes.shortest()
    return None


def _way(t: Array, pairs: Pairs) -> Way:
    gap = pairs.found.distance
    if not len(gap):
        return Way(t, 0.0, None)
    row = int(np.argmin(gap))
    return Way(t, max(0.0, -float(gap[row])), pairs.found[row])


def _descended(look: Look, way: Way, pairs: Pairs, tolerance: float) -> Way:
    """Shorten a way by tangents at its end, as long as that gains something."""
    for _ in range(DESCENTS):
        planes = _Planes()
        planes.take(pairs, pairs.found.distance < norm(way.move), way.move)
        if not planes.rows:
            return way
        better = _free(look, planes, planes.shortest(), way.length * (1 - 1e-9), tolerance)
        if better is None:
            return way
        way, pairs = better
    return way


def _pushed(look: Look, direction: Array, limit: float, tolerance: float) -> tuple[Way, Pairs] | None:
    """Shortest free translation along a direction, or a little longer."""
    s, seen = 0.0, None
    for _ in range(ROUNDS):
        pairs = look(s * direction)
        gap, slope = pairs.found.distance, dot(pairs.found.normal, direction[None])
        inside = gap < -tolerance
        if not np.any(inside):
            return _way(s * direction, pairs), pairs
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = np.where(slope[inside] > 1e-6, -gap[inside] / slope[inside], np.inf)
        finite = needed[np.isfinite(needed)]
        if not len(finite):
            s = limit if seen is None else s + seen
        else:
            seen = float(np.max(finite))
            s += seen
        if not s < limit:
            return None
    return None


def escape(
    look: Look, directions: Callable[[], Iterator[tuple[Array, float]]], lower: float, tolerance: float
) -> Way | None:
    """Find a short translation of B that frees it.

    Parameters
    ----------
    look
    directions
        Gives unit directions, each with a length that is known to free along it (or inf), the best first.
    lower : float
        No shorter translation frees: what comes as short as this is taken at once.
    tolerance : float
        Depths that are rounding.

    Returns
    -------
    Way or None
        None when nothing is found that frees, as there may be nothing.
    """
    best: Way | None = None
    found = _free(look, _Planes(), np.zeros(3), np.inf, tolerance)
    if found is not None:
        best = _descended(look, *found, tolerance)
    if best is not None and best.length <= lower + 2 * tolerance:
        return best
    for direction, enough in directions():
        limit = enough if best is None else min(enough, best.length)
        found = _pushed(look, direction, limit, tolerance)
        if found is not None:
            way = _descended(look, *found, tolerance)
            if best is None or way.length < best.length:
                best = way
        elif (best is None or enough < best.length) and np.isfinite(enough):
            pairs = look(enough * direction)
            way = _descended(look, _way(enough * direction, pairs), pairs, tolerance)
            best = way if best is None or way.length < best.length else best
        if best is not None and best.length <= lower + 2 * tolerance:
            break
    return best
