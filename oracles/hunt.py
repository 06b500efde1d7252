"""The adversarial hunter: Hypothesis searches one cell, steered by the error, and shrinks what it finds."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from oracles.buckets import clumsiness_of_scene
from oracles.engine import Answers
from oracles.judges import Judges
from oracles.outcome import FINDINGS, CountKey, Kind, Verdict
from oracles.scene import Cell, Scene
from oracles.search import Enough, Search
from oracles.steering import steer
from oracles.strategies import scenes
from oracles.words import decade_of
from oracles.worker import EngineWorker

MANY_EXAMPLES = 150
STOP_AFTER_LOSSES = 2


@dataclass(frozen=True)
class Catch:
    """One proven finding of the hunt."""

    scene: Scene
    answers: Answers
    verdict: Verdict


@dataclass
class Hunt:
    """What a hunt brought home: the simplest finding of each kind, and how many scenes it compared."""

    findings: list[Catch] = field(default_factory=list)
    counts: Counter[CountKey] = field(default_factory=Counter)
    scenes: int = 0
    """How many scenes were tried, the steps of shrinking included."""


@dataclass
class _Attack:
    judge: Judges
    worker: EngineWorker
    cell: Cell
    deadline: float
    counts: Counter[CountKey] = field(default_factory=Counter)
    proven: dict[str, Catch] = field(default_factory=dict)
    simplest: dict[str, tuple[Scene, Answers]] = field(default_factory=dict)
    symptoms: set[str] = field(default_factory=set)
    losses: int = 0
    scenes: int = 0

    def __call__(self, scene: Scene) -> str | None:
        """Put one scene before the engine; answers the kind of what is wrong, if anything is.

        A kind is proven once when it is met and once when it has become simple; between, floats that are certain do.
        """
        if time.monotonic() > self.deadline or self.losses >= STOP_AFTER_LOSSES:
            raise Enough
        self.scenes += 1
        cell, motion = self.cell, None if scene.motion is None else scene.motion[None]
        rows = (row[None] for row in scene.rows)
        answers = self.worker.answer(cell.query, cell.type_a, cell.type_b, *rows)
        steer(self.judge.engine, scene, answers, self.symptoms)
        screening = self.judge.screen(cell, scene.a[None], scene.b[None], motion, answers)
        kind, symptom = screening.kind[0], screening.symptom[0]
        if kind in (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT):
            key = f"{symptom} {decade_of(float(screening.amount[0]), scene.size)}"
            if kind is Kind.WRONG and key in self.proven and screening.certain[0]:
                self._keep_simplest(key, scene, answers)
                return key
            kind = self._prove(key, scene, answers)
            if kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                return key
        if kind not in FINDINGS:
            self.counts[self.judge.engine.name, cell.query, cell.pair, scene.regime, kind] += 1
        return None

    def _prove(self, key: str, scene: Scene, answers: Answers) -> Kind:
        verdict = self.judge.convict(scene, answers)
        self.losses += verdict.kind in (Kind.CRASHED, Kind.TIMED_OUT)
        if verdict.kind in FINDINGS:
            known = self.proven.get(key)
            if known is None or clumsiness_of_scene(scene) < clumsiness_of_scene(known.scene):
                self.proven[key] = Catch(scene, answers, verdict)
            self.symptoms.add(verdict.symptom)
        return verdict.kind

    def _keep_simplest(self, key: str, scene: Scene, answers: Answers) -> None:
        simplest = self.simplest.get(key, (self.proven[key].scene, None))[0]
        if clumsiness_of_scene(scene) < clumsiness_of_scene(simplest):
            self.simplest[key] = scene, answers

    def findings(self) -> list[Catch]:
        """One for each kind: the simplest that can be proven."""
        for key, (scene, answers) in self.simplest.items():
            self._prove(key, scene, answers)
        return list(self.proven.values())


def hunt(
    judge: Judges,
    worker: EngineWorker,
    cell: Cell,
    *,
    seed: int,
    deadline: float = float("inf"),
    examples: int = MANY_EXAMPLES,
    database: Path | None = None,
) -> Hunt:
    """Search one cell: `examples` scenes and the steps of shrinking, or until the deadline (of `time.monotonic`).

    Parameters
    ----------
    database
        Folder of failures of this cell, which are tried first.
    """
    attack = _Attack(judge, worker, cell, deadline)
    Search(attack, seed, examples, database=database).run(scenes(cell))
    found = attack.findings()
    for catch in found:  # one count for each finding that is filed, none for the steps of its shrinking
        attack.counts[judge.engine.name, cell.query, cell.pair, catch.scene.regime, catch.verdict.kind] += 1
    return Hunt(found, attack.counts, attack.scenes)
