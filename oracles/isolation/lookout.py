"""The lookout: says when a hand takes too much time, memory or company."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from oracles.engine import Status
from oracles.isolation.board import Board, Phase
from oracles.isolation.processes import NAN, Process, below, end_all_below, main_thread_time, process

PATIENCE = 5.0
"""On a busy machine a call may take this many limits of wall time, as long as it gets no processor time."""
MAKING_LIMITS = 10.0
"""Making a solver may take as long as so many scenes: it may have to compile."""
MOST_PROCESSES = 64
NEVER, RESTING = (-2, 0), (-3, 0)
"""In place of what the board shows."""
LOOK = 0.03
"""Seconds between two looks at memory and processes, which take a few tenths of a millisecond."""
BUSY = 0.5
"""Seconds of processor that a hand may use while it has nothing to do."""


@dataclass(frozen=True)
class Fate:
    """How the asking of a scene ended."""

    status: Status
    text: str


@dataclass(frozen=True)
class Family:
    """The guard, its fork server, and the processes that the import of the engine started."""

    guard: int
    server: int
    kept: frozenset[int] = frozenset()

    def strangers(self) -> list[Process]:
        """All other processes below the guard: the hand, what it started, and what is left of earlier ones."""
        return [p for p in below((self.guard, self.server), {self.server, *self.kept}) if not p.ended]

    def end_strangers(self) -> None:
        """End all others."""
        end_all_below((self.guard, self.server), {self.server, *self.kept})


@dataclass
class Lookout:
    """Watches one hand, and whatever it started."""

    board: Board
    hand: int
    family: Family
    call_limit: float
    memory_limit: int
    memory_at_first: int
    seen: tuple[int, int] = NEVER
    since: float = 0.0
    used: float = NAN
    next_look: float = 0.0

    def reset(self) -> None:
        """Forget what was seen: a job begins, or the hand has nothing to do from now on."""
        self.seen = NEVER

    def too_large(self) -> Fate | None:
        """Whether the memory or number of processes is over the limit; looked at now and then."""
        if time.monotonic() < self.next_look:
            return None
        self.next_look = time.monotonic() + LOOK
        found = self.family.strangers()
        if len(found) > MOST_PROCESSES:
            return Fate(Status.CRASHED, f"the process started more than {MOST_PROCESSES} others")
        if sum(max(0, p.memory - self.memory_at_first) for p in found) > self.memory_limit:
            return Fate(Status.CRASHED, f"the process used more than {in_words(self.memory_limit)} of memory")
        return None

    def too_long(self) -> Fate | None:
        """Whether a call is over its limit of processor time, or has waited for several times as long."""
        at = int(self.board.at[0]), int(self.board.phase[0])
        now = time.monotonic()
        if at != self.seen:
            self.seen, self.since, self.used = at, now, NAN
            return None
        used = main_thread_time(self.hand)
        if math.isnan(self.used):
            self.used = used  # a call that is seen only once is not worth the question
        limit = self.call_limit * (1.0 if at[1] == Phase.ASKING else MAKING_LIMITS)
        if used - self.used >= limit or now - self.since >= PATIENCE * limit:
            return Fate(Status.TIMED_OUT, f"no answer within {limit:g} s")
        return None

    def left_behind(self) -> str:
        """Say what a hand that has nothing to do has left going, if anything."""
        others = sum(p.number != self.hand for p in self.family.strangers())
        if others:
            return f"left {others} process{'es' if others > 1 else ''} running"
        known = process(self.hand)
        used = 0.0 if known is None else known.processor
        if self.seen != RESTING:
            self.seen, self.used = RESTING, used
        return "kept the processor busy while no scene was asked" if used - self.used > BUSY else ""


def in_words(size: int) -> str:
    """Say a size in the largest unit of which it has at least one."""
    unit, name = next(((u, n) for u, n in ((1 << 30, "GiB"), (1 << 20, "MiB")) if size >= u), (1 << 10, "KiB"))
    return f"{size / unit:g} {name}"
