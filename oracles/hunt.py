"""The adversarial hunter: Hypothesis searches one cell, steered by the error, and shrinks what it finds."""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings, target
from hypothesis.configuration import set_hypothesis_home_dir

from oracles.buckets import clumsiness_of_scene
from oracles.engine import Answers
from oracles.judges import Judges
from oracles.outcome import FINDINGS, CountKey, Kind, Verdict
from oracles.scene import Cell, Scene
from oracles.strategies import scenes
from oracles.words import decade_of
from oracles.worker import EngineWorker

MANY_EXAMPLES = 150
STOP_AFTER_LOSSES = 2


class Caught(AssertionError):
    """A proven wrong answer; each bucket has a subclass of its own, or Hypothesis would merge them."""


class TimeUp(BaseException):
    """The hunt's time is over; no `Exception`, because Hypothesis would take that for a finding."""


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
    best: dict[tuple[str, int | None], Catch] = field(default_factory=dict)
    types: dict[tuple[str, int | None], type[Caught]] = field(default_factory=dict)
    losses: int = 0
    scenes: int = 0

    def __call__(self, scene: Scene) -> None:
        """Put one scene before the engine; raise when its answer is proven wrong."""
        if time.monotonic() > self.deadline or self.losses >= STOP_AFTER_LOSSES:
            raise TimeUp
        self.scenes += 1
        cell, motion = self.cell, None if scene.motion is None else scene.motion[None]
        rows = (row[None] for row in scene.rows)
        answers = self.worker.answer(cell.query, cell.type_a, cell.type_b, *rows)
        screening = self.judge.screen(cell, scene.a[None], scene.b[None], motion, answers)
        kind = screening.kind[0]
        target(float(min(screening.pressure[0], 1e300)), label="error by tolerance")
        if kind in (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT):
            verdict = self.judge.convict(scene, answers)
            kind = verdict.kind
            self._remember(scene, answers, verdict)
        if kind not in FINDINGS:
            self.counts[self.judge.engine.name, cell.query, cell.pair, scene.regime, kind] += 1
        if kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
            raise self._type_for(verdict.symptom, decade_of(verdict.amount, scene.size))

    def _remember(self, scene: Scene, answers: Answers, verdict: Verdict) -> None:
        if verdict.kind in (Kind.CRASHED, Kind.TIMED_OUT):
            self.losses += 1
        elif verdict.kind not in (Kind.WRONG, Kind.REFERENCE_WRONG):
            return
        key = verdict.symptom, decade_of(verdict.amount, scene.size)
        if key not in self.best or clumsiness_of_scene(scene) < clumsiness_of_scene(self.best[key].scene):
            self.best[key] = Catch(scene, answers, verdict)

    def _type_for(self, symptom: str, decade: int | None) -> type[Caught]:
        key = symptom, decade
        if key not in self.types:
            self.types[key] = type(f"Caught {symptom} {decade}", (Caught,), {})
        return self.types[key]


def hunt(judge: Judges, worker: EngineWorker, cell: Cell, *, seed: int, deadline: float) -> Hunt:
    """Search one cell until the deadline (of `time.monotonic`) or for a few hundred scenes."""
    attack = _Attack(judge, worker, cell, deadline)
    set_hypothesis_home_dir(Path(tempfile.gettempdir()) / "proxyproof-hypothesis")  # not in the caller's folder

    @hypothesis.seed(seed)
    @settings(
        max_examples=MANY_EXAMPLES,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.target, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=True,
        print_blob=False,
    )
    @given(scene=scenes(cell))
    def search(scene: Scene) -> None:
        attack(scene)

    try:
        search()
    except (Caught, BaseExceptionGroup) as raised:
        _only_caught(raised)
    except (TimeUp, hypothesis.errors.Flaky):
        pass  # flaky is an answer that depends on earlier calls: what was proven is remembered
    found = list(attack.best.values())
    for catch in found:  # one count for each finding that is filed, none for the steps of its shrinking
        attack.counts[judge.engine.name, cell.query, cell.pair, catch.scene.regime, catch.verdict.kind] += 1
    return Hunt(found, attack.counts, attack.scenes)


def _only_caught(found: BaseException) -> None:
    """Raise again whatever in a group is not ours."""
    if isinstance(found, BaseExceptionGroup):
        _, rest = found.split((Caught, TimeUp, hypothesis.errors.Flaky))
        if rest is not None:
            raise rest
