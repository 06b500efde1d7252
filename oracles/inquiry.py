"""Asking an engine about scene after scene: on which of them it fails as it did, and what that cost."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from oracles.allowance import MOST_LOST, is_lost
from oracles.degeneracy import gaps_of
from oracles.engine import Answers, Array, Status
from oracles.forms import batch_of, by_form
from oracles.judges import finding_of
from oracles.likeness import Failing, key_of
from oracles.outcome import Finding, Kind
from oracles.relations import Bench, question
from oracles.scene import MOVING, UNPACK_MOTION, Cell, Scene, packed_rows

GIVE_UP_AFTER = 1
"""Candidates of a batch that may run out of time before the rest of it is left."""


@dataclass
class Inquiry:
    """All that has been learned of one symptom of an engine in one cell.

    Attributes
    ----------
    known
        Scenes on which the engine fails in this way.
    asked
        Keys of all scenes that it was asked about.
    tries
        How many more it may be asked about.
    losses
        How often it has been lost.
    """

    bench: Bench
    cell: Cell
    kind: Kind
    symptom: str
    known: dict[bytes, Failing] = field(default_factory=dict)
    asked: set[bytes] = field(default_factory=set)
    tries: int = 0
    losses: int = 0

    @property
    def lost(self) -> bool:
        """Whether it is no answer at all, and may be none again."""
        return is_lost(self.kind, self.symptom)

    @property
    def is_spent(self) -> bool:
        """Whether the engine has been lost so often that it is not asked any more."""
        return self.losses >= MOST_LOST

    def ask(self, scenes: Iterable[Scene]) -> bool:
        """Put candidates before the engine, as many as are allowed, and keep those on which it fails alike.

        Answers whether there were any that had not been asked.
        """
        new: dict[bytes, Scene] = {}
        for scene in scenes:
            if len(new) >= self.tries:
                break
            key = key_of(scene)
            if key not in self.asked:
                new[key] = scene
        self.tries -= len(new)
        self.asked |= new.keys()
        for group in by_form(list(new.values())):
            self._put(group)
        return bool(new)

    def _put(self, group: list[Scene]) -> None:
        a, b = batch_of([scene.a for scene in group]), batch_of([scene.b for scene in group])
        motion = UNPACK_MOTION[self.cell.query](_rows_of_motion(group)) if self.cell.query in MOVING else None
        answers = self.bench.answer(self.cell, packed_rows(a, b, motion), give_up_after=GIVE_UP_AFTER)
        if self.lost:
            self._count_losses(group, answers)
        found = self.bench.judges.screen(self.cell, a, b, motion, answers)
        alike = np.flatnonzero((found.kind == self.kind) & (found.symptom == self.symptom) & found.certain)
        if alike.size:
            gaps = gaps_of(a[alike], b[alike]) if motion is None else [()] * len(alike)
            for i, gap in zip(alike.tolist(), gaps, strict=True):
                new = Failing(group[i], float(found.amount[i]), gap)
                self.known[new.key] = new

    def _count_losses(self, group: list[Scene], answers: Answers) -> None:
        """Take note of scenes that cost the engine; those behind a time-out were not asked."""
        self.losses += int(np.isin(answers.status, (Status.CRASHED, Status.TIMED_OUT)).sum())
        left = [key_of(group[i]) for i in np.flatnonzero(answers.status == Status.SKIPPED)]
        self.asked -= set(left)
        self.tries = 0 if self.is_spent else self.tries + len(left)

    def convict(self, scene: Scene) -> Finding | None:
        """A finding on this scene, proven; none where a fresh engine does not fail there in the same way."""
        self.bench.renew()
        first, second = scene.rows
        answers = self.bench.answer(self.cell, (first[None], second[None]))
        verdict = self.bench.judges.convict(scene, answers)
        if verdict.kind is not self.kind or verdict.symptom != self.symptom:
            return None
        return finding_of(self.bench.engine.name, scene, answers, verdict)


@dataclass
class InquiryOfRelated(Inquiry):
    """The same for an engine that contradicts itself about two scenes, of which one is made from the other."""

    relation: str = ""

    def _put(self, group: list[Scene]) -> None:
        for scene in group:
            found = question(self.bench, self.relation, scene)
            if found is not None and found.verdict.symptom == self.symptom:
                new = Failing(scene, found.verdict.amount)
                self.known[new.key] = new

    def convict(self, scene: Scene) -> Finding | None:
        """A finding on this scene; none where a fresh engine does not contradict itself there in the same way."""
        self.bench.renew()
        found = question(self.bench, self.relation, scene)
        return found if found is not None and found.verdict.symptom == self.symptom else None


def _rows_of_motion(group: list[Scene]) -> Array:
    return np.stack([scene.motion.pack() for scene in group if scene.motion is not None])
