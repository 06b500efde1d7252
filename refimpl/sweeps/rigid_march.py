"""Conservative advancement: how long pairs of moving bodies are proven to be apart, and when they are found to meet.

Each row has a time up to which it is free. A step tries a later time, predicted from the gap, its rate and how it may
bend; if the bodies are apart then and planes show that they are so in between, it is free up to there. So the way to a
contact shrinks quadratically, not by a factor. The first time that is not free is closed in from both sides: by free
times below and times of certain overlap above. What rounding leaves undecided, a graze or a rest, is left behind as a
stretch that may hold the contact, and the row goes on behind it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array, Bools, unit_or
from refimpl.motions import AXIS
from refimpl.sweeps.rigid_pairs import Pairs, State

NARROW = 1e-10
"""Widest stretch of time between free and touching that is not narrowed further."""
LEAST = 2.0**-48
"""Steps this short get nowhere."""
MOST = 5_000
"""So many steps at most; what is left then counts as undecided."""
CAREFUL = 0.9


class Times(NamedTuple):
    """First contacts of rows of pairs.

    Attributes
    ----------
    lower : (n,)
        Free before; inf for rows that are free up to the end.
    upper : (n,)
        Contact by then, or the end of all stretches that are undecided; inf for free rows.
    decided : (n,) bool
        Whether `upper` is a time of certain overlap, or the row is free.
    steps : (n,) int
        How many times were tried.
    """

    lower: Array
    upper: Array
    decided: Bools
    steps: NDArray[np.int64]


class March:
    """Rows of pairs on their way from t = 0 to their `ends`.

    `free` is the time up to which a row is free, `state` what it is like then. `closed` is the first time known not to
    be free, `overlap` one of certain overlap, `doubtful` the last doubtful one of a stretch; `since` and `until` bound
    the undecided stretches left behind. A row is `behind` when it looks for overlap or freedom beyond `doubtful`.
    `trail`, if given, keeps the free times of all steps.
    """

    def __init__(self, pairs: Pairs, ends: Array, trail: list[Array] | None = None) -> None:
        n = len(ends)
        self.trail = trail
        self.pairs, self.ends = pairs, ends
        self.slack, self.doubt = pairs.slack(), pairs.doubt()
        self.free, self.doubtful = np.zeros(n), np.zeros(n)
        self.closed, self.overlap, self.since = np.full(n, np.inf), np.full(n, np.inf), np.full(n, np.inf)
        self.until, self.depth, self.beyond = np.zeros(n), np.zeros(n), np.zeros(n)
        self.share, self.steps = np.full(n, CAREFUL), np.zeros(n, dtype=np.int64)
        self.behind, self.done = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        self.state = pairs.state(np.zeros(n))
        self._stop(self.state.gap <= 0, np.zeros(n))

    def run(self) -> Times:
        """Advance all rows until each is decided, or as good as can be."""
        while len(rows := np.flatnonzero(~self.done)):
            self._step(rows)
            self.steps[rows] += 1
            self._finish(~self.done & (self.steps >= MOST), self.ends)
        met = np.isfinite(self.overlap) | np.isfinite(self.since)
        lower = np.where(met, np.minimum(self.since, self.free), np.inf)
        upper = np.where(np.isfinite(self.overlap), self.overlap, np.where(met, self.until, np.inf))
        return Times(lower, upper, np.isfinite(self.overlap) | ~met, self.steps)

    def _step(self, rows: NDArray[np.int64]) -> None:
        """Try one more time in each of some rows."""
        there, full = self.pairs.at(rows), np.zeros(len(self.free), dtype=bool)
        t = np.where(self.behind[rows], self.doubtful[rows] + self.beyond[rows], self._ahead(rows))
        t = np.minimum(t, np.where(self.behind[rows], np.minimum(self.overlap, self.ends)[rows], self.ends[rows]))
        found = there.state(t)
        free, over = found.gap > 0, found.distance <= -self.doubt[rows]
        ahead = ~self.behind[rows]
        known = State(*(column[rows] for column in self.state))
        proven = free & ahead
        proven[proven] = _free_between(
            there.at(proven), self.free[rows][proven], t[proven], *_some(proven, known, found)
        )
        times = np.zeros(len(full))
        times[rows] = t

        def mask(chosen: Bools) -> Bools:
            marked = full.copy()
            marked[rows[chosen]] = True
            return marked

        leaving = free & ~ahead  # an undecided stretch lies behind
        left = rows[leaving]
        self.since[left] = np.minimum(self.since[left], self.free[left])
        self.until[left] = t[leaving]
        self.behind[left], self.closed[left] = False, np.inf
        moved = proven | leaving
        self.free[rows[moved]] = t[moved]
        if self.trail is not None:
            self.trail.append(self.free.copy())
        self.state = State(*(_put(old, rows[moved], new[moved]) for old, new in zip(self.state, found, strict=True)))
        self.share[rows[moved]] = np.minimum(CAREFUL, 1.5 * self.share[rows[moved]])
        short = ahead & free & ~proven
        self.share[rows[short]] *= 0.5
        self.overlap[rows[over]] = t[over]
        self.depth[rows[over]] = -found.distance[over]
        doubtful = ~free & ~over & ~ahead
        self.doubtful[rows[doubtful]] = t[doubtful]
        self.beyond[rows[doubtful]] *= 2.0
        self._stop(mask(ahead & ~free | short & (t - self.free[rows] <= LEAST)), times)
        self._finish(mask(moved | doubtful) & (times >= self.ends), self.ends)
        self._finish(mask(over & ~ahead), times)

    def _ahead(self, rows: NDArray[np.int64]) -> Array:
        """A time to try next, after the free one and before the closed one."""
        free, gap, rate = self.free[rows], self.state.gap[rows], self.state.rate[rows]
        room = np.minimum(self.closed[rows], self.ends[rows]) - free
        half = self.pairs.at(rows).bend(*2 * (self.state.normal[rows],), free, free + room) / 2
        calm = np.sqrt(half) * np.sqrt(gap)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            root = gap / -rate
            off = np.clip(half * (root / -rate), 0.0, 0.5)  # the root may be off by this part of it
            clear = 2.0 * (self.slack[rows] + self.doubt[rows]) / -rate
            aimed = np.where(root <= NARROW / 8, 4.0 * root + clear, np.maximum(root * (1.0 - off) - clear, root / 2))
            far = np.where(half > 0, (rate + 2.0 * calm) / half, np.inf)
        share = self.share[rows]
        eager = np.where(share < CAREFUL, share, 1.0)
        calmly = np.where(CAREFUL * far >= room, eager * room, share * far)
        step = np.where(rate < -calm, eager * np.fmin(aimed, room), calmly)
        closed = np.isfinite(self.closed[rows])
        between = gap / (gap + self.depth[rows]) * np.isfinite(self.overlap[rows])
        inside = room * np.clip(between, 0.25, 0.75)
        return np.asarray(free + np.where(closed & (step >= CAREFUL * room), inside, np.fmin(step, room)))

    def _stop(self, stopped: Bools, times: Array) -> None:
        """A time is not free: close in on it, or look behind it when that is done."""
        self.closed = np.where(stopped, np.minimum(self.closed, times), self.closed)
        near = stopped & (self.closed - self.free <= NARROW)
        self._finish(near & (self.overlap == self.closed), self.closed)
        near &= ~self.done
        with np.errstate(divide="ignore"):
            step = np.clip(2.0 * self.doubt / np.abs(self.state.rate), LEAST, NARROW / 2)
        self.behind |= near
        self.doubtful = np.where(near, times, self.doubtful)
        self.beyond = np.where(near, step, self.beyond)
        self._finish(near & (times >= self.ends), self.ends)

    def _finish(self, rows: Bools, times: Array) -> None:
        """Close rows: what is not free by then, and not known to overlap, stays undecided."""
        unsure = rows & ~np.isfinite(self.overlap) & ((self.free < times) | self.behind)
        self.since = np.where(unsure, np.minimum(self.since, self.free), self.since)
        self.until = np.where(unsure, times, self.until)
        self.done = self.done | rows


def _some(chosen: Bools, *states: State) -> list[State]:
    return [State(*(column[chosen] for column in state)) for state in states]


def _put(column: Array, rows: NDArray[np.int64], values: Array) -> Array:
    changed = column.copy()
    changed[rows] = values
    return changed


def _free_between(pairs: Pairs, t0: Array, t1: Array, first: State, last: State) -> Bools:
    """Whether nothing touches from t0 to t1, by planes that turn from one normal to the other, or stay."""
    found = pairs.is_free(first.normal, last.normal, t0, t1, first.gap, last.gap)
    middle = unit_or(first.normal + last.normal, AXIS)[0]
    for n in (middle, last.normal, first.normal):
        rest = np.flatnonzero(~found)
        if not len(rest):
            break
        there, way, start, end = pairs.at(rest), n[rest], t0[rest], t1[rest]
        slack = there.slack()
        g0, g1 = there.gap(way, start) - slack, there.gap(way, end) - slack
        found[rest] = there.is_free(way, way, start, end, g0, g1)
    return found


def first_contacts(pairs: Pairs, ends: Array) -> Times:
    """First contacts of rows that are apart at t = 0, up to their `ends`."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return March(pairs, ends).run()
