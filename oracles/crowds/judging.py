"""The judge of broad phases: which pairs are missing, which are false alarms, and the smallest crowd that shows it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from oracles.crowds.asking import Answer, ask
from oracles.crowds.boxes import BoxCrowd, Ids, Pair
from oracles.crowds.engine import BroadPhaseEngine
from oracles.crowds.failing import LOST, MISSING, NOT_NEAREST, Asker, Failure, Witness, witness_of
from oracles.crowds.repro import crowd_script
from oracles.fault import Known, unknown
from oracles.outcome import Kind, Met
from refimpl.linear import Array, Bools

COUNTED = {MISSING: "missing", NOT_NEAREST: "not_nearest", LOST: "lost"}
"""Where a failure is counted that the ledger does not explain."""


@dataclass
class CrowdCount:
    """What became of the crowds of one regime before one engine.

    Attributes
    ----------
    crowds, bodies : int
        Asked, all together.
    pairs : int
        Pairs of bodies whose bounding boxes overlap by more than may be rounded, or touch where nothing has to be
        rounded and the engine promises that: all must be named.
    missing : int
        Of these, what the engine left out.
    close : int
        Other pairs whose boxes touch up to rounding: either answer is right.
    extra : int
        Named, although the boxes are apart.
    false_alarms : int
        Of these, what is farther apart than the margin that the engine declares.
    nearest, not_nearest : int
        Crowds, thinned out, of which the nearest pair was asked, and those of which another one was given.
    lost : int
        Crowds without an answer.
    known : int
        What is missing, not the nearest or lost by a fault that the ledger has, and is counted nowhere else.
    """

    engine: str
    regime: str
    crowds: int = 0
    bodies: int = 0
    pairs: int = 0
    missing: int = 0
    known: int = 0
    close: int = 0
    extra: int = 0
    false_alarms: int = 0
    nearest: int = 0
    not_nearest: int = 0
    lost: int = 0
    widest: float = 0.0
    """The largest gap between boxes of a pair that was named."""
    errors: list[str] = field(default_factory=list)
    """Why crowds were lost, each reason once."""
    explained: dict[str, int] = field(default_factory=dict)
    """How many failures are known by which entry of the ledger."""
    calls: str = ""
    margin: float = 0.0
    margin_why: str = ""
    """What the engine says of its broad phase (`oracles.crowds.engine`)."""
    witnesses: list[Witness] = field(default_factory=list)
    """One for each symptom and entry of the ledger."""

    def counted(self) -> dict[str, object]:
        """Return everything but the witnesses, as plain data."""
        return {name: value for name, value in vars(self).items() if name != "witnesses"}

    @property
    def wrong(self) -> bool:
        """Whether the engine broke its promise in a way that the ledger does not explain."""
        return any(getattr(self, name) > 0 for name in COUNTED.values())

    def add(self, failure: Failure) -> None:
        """Count one failure."""
        if failure.entry:
            self.known += 1
            self.explained[failure.entry] = self.explained.get(failure.entry, 0) + 1
        else:
            name = COUNTED[failure.symptom]
            setattr(self, name, getattr(self, name) + 1)


@dataclass(frozen=True)
class Judge:
    """Judges what one engine says of crowds.

    Attributes
    ----------
    name
        Of the engine.
    known
        What the ledger says of a failure.
    """

    name: str
    solver: BroadPhaseEngine
    known: Known = unknown

    def failed(self, symptom: str, crowd: BoxCrowd, pair: Pair | None, amount: float) -> Failure:
        """A failure, and what the ledger says of it."""
        made = Failure(symptom, pair, amount)
        return replace(made, entry=self.known(made.fault(self.name, crowd)))

    def weigh(self, count: CrowdCount, crowd: BoxCrowd, answer: Answer) -> list[Failure]:
        """Add one answer to the counts; gives what is wrong with it."""
        count.crowds += 1
        count.bodies += len(crowd)
        failures = self.failures(crowd, answer)
        for failure in failures:
            count.add(failure)
        if answer.lost:
            count.errors += [answer.lost] * (answer.lost not in count.errors)
            return failures
        count.nearest += self.solver.finds_nearest
        upper, depth, slack, named = _pairs(crowd, answer)
        must = self._must(crowd, upper, depth, slack)
        count.pairs += int(np.count_nonzero(must))
        count.close += int(np.count_nonzero((np.abs(depth) <= slack) & ~must))
        extra = named & (depth < -slack)
        count.extra += int(np.count_nonzero(extra))
        count.false_alarms += int(np.count_nonzero(extra & (depth < -slack - self.solver.margin)))
        count.widest = max(count.widest, float(np.max(-depth, where=extra, initial=0.0)))
        return failures

    def failures(self, crowd: BoxCrowd, answer: Answer) -> list[Failure]:
        """What is wrong with an answer."""
        if answer.lost:
            return [self.failed(LOST, crowd, None, 0.0)]
        found = []
        if self.solver.finds_nearest and not _is_nearest(crowd.thinned(), answer.nearest):
            found.append(self.failed(NOT_NEAREST, crowd, None, _beyond(crowd.thinned(), answer.nearest)))
        upper, depth, slack, named = _pairs(crowd, answer)
        missing = np.flatnonzero(self._must(crowd, upper, depth, slack) & ~named)
        for i, j, by in zip(*(column[missing].tolist() for column in (*upper, depth)), strict=True):
            found.append(self.failed(MISSING, crowd, (i, j), by))
        return found

    def _must(self, crowd: BoxCrowd, upper: tuple[Ids, Ids], depth: Array, slack: Array) -> Bools:
        """Which pairs have to be named."""
        return np.asarray((depth > slack) | (self.solver.closed & crowd.exact()[upper] & (depth >= 0)))

    def shows(self, crowd: BoxCrowd, answer: Answer, failure: Failure) -> bool:
        """Whether an answer on another crowd shows the same failure; of a missing pair that of its first two bodies."""
        pair = None if failure.pair is None else (0, 1)
        wanted = (failure.symptom, pair, failure.entry)
        return any((one.symptom, one.pair, one.entry) == wanted for one in self.failures(crowd, answer))


def _beyond(crowd: BoxCrowd, pair: Pair | None) -> float:
    """How much farther apart than the nearest pair's boxes another's are; infinite where none is named."""
    gaps = crowd.gaps()
    return math.inf if pair is None else float(gaps[pair] - np.min(gaps[_upper(crowd)]))


def _is_nearest(crowd: BoxCrowd, pair: Pair | None) -> bool:
    """Whether no pair's boxes are nearer to each other, but for rounding."""
    if pair is None:
        return len(crowd) < 2
    gaps = crowd.gaps()
    least = float(np.min(gaps[_upper(crowd)]))
    return bool(gaps[pair] <= least + 4 * float(np.max(crowd.slack())))


def _upper(crowd: BoxCrowd) -> tuple[Ids, Ids]:
    i, j = np.triu_indices(len(crowd), 1)
    return i, j


def _pairs(crowd: BoxCrowd, answer: Answer) -> tuple[tuple[Ids, Ids], Array, Array, Bools]:
    """Rows and columns of every pair i < j; its depth, what may be rounded of that, and whether it was named."""
    named = np.zeros((len(crowd), len(crowd)), dtype=bool)
    if answer.pairs:
        named[tuple(np.array(sorted(answer.pairs)).T)] = True
    upper = _upper(crowd)
    return upper, crowd.depths()[upper], crowd.slack()[upper], named[upper]


def judged(
    engine: str,
    solver: BroadPhaseEngine,
    crowds: Sequence[BoxCrowd],
    answers: Sequence[Answer],
    asker: Asker,
    known: Known = unknown,
) -> list[CrowdCount]:
    """Weigh the answers on crowds of several regimes, with a witness for each symptom and entry of a regime."""
    judge = Judge(engine, solver, known)
    counts: dict[str, CrowdCount] = {}
    said: dict[str, Any] = {name: getattr(solver, name) for name in ("calls", "margin", "margin_why")}
    for crowd, answer in zip(crowds, answers, strict=True):
        count = counts.setdefault(crowd.regime, CrowdCount(engine, crowd.regime, **said))
        for failure in judge.weigh(count, crowd, answer):
            if not any((one.symptom, one.entry) == (failure.symptom, failure.entry) for one in count.witnesses):
                found = witness_of(asker, judge.shows, crowd, failure, answer)
                if found is not None:
                    text = "" if found.pair is None else crowd_script(solver, engine, found.crowd, found.pair)
                    count.witnesses.append(replace(found, script=text))
    return list(counts.values())


def question(
    spec: str,
    engine: str,
    solver: BroadPhaseEngine,
    crowds: Sequence[BoxCrowd],
    known: Known = unknown,
    again: Mapping[str, Witness] = MappingProxyType({}),
) -> tuple[list[CrowdCount], list[Met]]:
    """Ask an engine's broad phase about the ledger's witnesses (`again`, by id) and some crowds, and judge it."""

    def asker(some: Sequence[BoxCrowd]) -> list[Answer]:
        return ask(spec, some)

    every = [*(witness.crowd for witness in again.values()), *crowds]
    answers, judge = asker(every), Judge(engine, solver, known)
    met = [_met(judge, *witness, answer) for witness, answer in zip(again.items(), answers, strict=False)]
    return judged(engine, solver, every, answers, asker, known), met


def _met(judge: Judge, name: str, witness: Witness, answer: Answer) -> Met:
    """What becomes of a witness that is asked again."""
    failures = judge.failures(witness.crowd, answer)
    same = [one for one in failures if (one.symptom, one.pair) == (witness.symptom, witness.pair)]
    failure = next(iter([*same, *failures]), None)
    if failure is None:
        return Met(name, Kind.AGREES, None)
    kind = Kind.CRASHED if failure.symptom == LOST else Kind.WRONG
    return Met(name, kind, failure.fault(judge.name, witness.crowd))
