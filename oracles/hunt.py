"""The adversarial hunter: Hypothesis searches one cell, steered by the error, and shrinks what it finds."""

from __future__ import annotations

import hashlib
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings, target
from hypothesis.configuration import set_hypothesis_home_dir

from oracles.answers import add_to_digest
from oracles.bench import Bench
from oracles.clock import timed
from oracles.clumsiness import clumsiness
from oracles.constants import constants_of
from oracles.engine import Answers
from oracles.judges import finding_of
from oracles.outcome import FINDINGS, SUSPECT, Finding, Kind, Outcome, Verdict
from oracles.scene import Cell, Scene
from oracles.sheets import KINDS, Row, Sheet
from oracles.strategies import scenes
from oracles.words import decade_of

MANY_EXAMPLES = 150
MANY_SCENES, MANY_PROOFS = 500, 60
"""Scenes and proofs of a hunt, the steps of shrinking included: numbers and no deadline, so that the same seed brings
the same on any machine."""
STOP_AFTER_LOSSES = 2


class Caught(AssertionError):
    """A proven wrong answer; each bucket has a subclass of its own, or Hypothesis would merge them."""


class Enough(BaseException):
    """The hunt has had its share; no `Exception`, because Hypothesis would take that for a finding."""


@dataclass
class _Attack:
    bench: Bench
    cell: Cell
    outcome: Outcome = field(default_factory=Outcome)
    digest: hashlib._Hash = field(default_factory=hashlib.sha256)
    best: dict[tuple[str, int | None], Finding] = field(default_factory=dict)
    types: dict[tuple[str, int | None], type[Caught]] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)
    losses: int = 0
    proofs: int = 0

    def __call__(self, scene: Scene) -> None:
        """Put one scene before the engine; raise when its answer is proven wrong."""
        tried = self.outcome.hunters["hypothesis"]
        if tried >= MANY_SCENES or self.proofs >= MANY_PROOFS or self.losses >= STOP_AFTER_LOSSES:
            raise Enough
        self.outcome.hunters["hypothesis"] += 1
        cell, motion = self.cell, None if scene.motion is None else scene.motion[None]
        answers = self.bench.ask(scene)
        add_to_digest(self.digest, self.bench.name, cell, answers)
        with timed("judge"):
            screening = self.bench.judges.screen(cell, scene.a[None], scene.b[None], motion, answers)
        kind = screening.kind[0]
        target(float(min(screening.pressure[0], 1e300)), label="error by tolerance")
        if kind in SUSPECT:
            self.proofs += 1
            with timed("proofs"):
                verdict = self.bench.judges.convict(scene, answers)
            kind = verdict.kind
            self._remember(scene, answers, verdict)
        proven = kind in FINDINGS
        said = screening.symptom[0], float(screening.amount[0]), float(screening.pressure[0])
        self.rows.append(Row(scene.regime, tried, int(answers.status[0]), KINDS.index(kind), *said, scene.size, proven))
        if kind not in FINDINGS:
            self.outcome.counts[self.bench.name, cell.query, cell.pair, scene.regime, kind] += 1
        if kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
            raise self._type_for(verdict.symptom, decade_of(verdict.amount, scene.size))

    def _remember(self, scene: Scene, answers: Answers, verdict: Verdict) -> None:
        if verdict.kind in (Kind.CRASHED, Kind.TIMED_OUT):
            self.losses += 1
        elif verdict.kind not in (Kind.WRONG, Kind.REFERENCE_WRONG):
            return
        key = verdict.symptom, decade_of(verdict.amount, scene.size)
        if key not in self.best or clumsiness(scene) < clumsiness(self.best[key].scene):
            self.best[key] = finding_of(self.bench.name, scene, answers, verdict)

    def _type_for(self, symptom: str, decade: int | None) -> type[Caught]:
        key = symptom, decade
        if key not in self.types:
            self.types[key] = type(f"Caught {symptom} {decade}", (Caught,), {})
        return self.types[key]


def hunting(bench: Bench, cell: Cell, *, seed: int) -> Outcome:
    """Search one cell for a few hundred scenes; the same seed brings the same."""
    attack = _Attack(bench, cell)
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
        with timed("hunt"), constants_of(bench.engine):
            search()
    except (Caught, BaseExceptionGroup) as raised:
        _only_caught(raised)
    except (Enough, hypothesis.errors.Flaky):
        pass  # flaky is an answer that depends on earlier calls: what was proven is remembered
    outcome = attack.outcome
    outcome.findings = list(attack.best.values())
    for finding in outcome.findings:  # one count for each finding that is filed, none for the steps of its shrinking
        outcome.counts[finding.engine, cell.query, cell.pair, finding.scene.regime, finding.verdict.kind] += 1
    outcome.digest = attack.digest.hexdigest()
    outcome.sheets.append(Sheet.of_rows(bench.name, cell, attack.rows))
    return outcome


def _only_caught(found: BaseException) -> None:
    """Raise again whatever in a group is not ours."""
    if isinstance(found, BaseExceptionGroup):
        _, rest = found.split((Caught, Enough, hypothesis.errors.Flaky))
        if rest is not None:
            raise rest
