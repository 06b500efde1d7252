"""The adversarial hunter: Hypothesis searches one cell, steered by the error, and shrinks what it finds."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from oracles.answers import add_to_digest
from oracles.bench import MANY_EXAMPLES, Bench
from oracles.clock import timed
from oracles.clumsiness import clumsiness
from oracles.constants import constants_of
from oracles.degeneracy import degeneracy
from oracles.engine import Answers
from oracles.judges import finding_of
from oracles.outcome import FINDINGS, SUSPECT, Finding, Kind, Outcome
from oracles.scene import Cell, Scene
from oracles.screening import KINDS, Screening
from oracles.search import Enough, Search
from oracles.sheets import Row, Sheet
from oracles.steering import strain
from oracles.strategies import scenes
from oracles.words import decade_of

MANY_SCENES, MANY_PROOFS = 500, 60
"""Scenes and proofs of a hunt, the steps of shrinking included: numbers and no deadline, so that the same seed brings
the same on any machine."""
STOP_AFTER_LOSSES = 2
MOST_OF_ONE = 2
"""Kinds of failures of one symptom for which a search stops to shrink them; of others one is proven, and it goes on."""


@dataclass
class _Attack:
    bench: Bench
    cell: Cell
    outcome: Outcome = field(default_factory=Outcome)
    digest: hashlib._Hash = field(default_factory=hashlib.sha256)
    proven: dict[str, Finding] = field(default_factory=dict)
    simplest: dict[str, tuple[Scene, Answers]] = field(default_factory=dict)
    symptoms: dict[str, set[str]] = field(default_factory=dict)
    """The kinds of failures of each symptom, that are shrunk."""
    rows: list[Row] = field(default_factory=list)
    losses: int = 0
    proofs: int = 0

    def __call__(self, scene: Scene) -> str | None:
        """Put one scene before the engine; answers the kind of what is wrong, if anything is."""
        tried = self.outcome.hunters["hypothesis"]
        if tried >= MANY_SCENES or self.proofs >= MANY_PROOFS or self.losses >= STOP_AFTER_LOSSES:
            raise Enough
        self.outcome.hunters["hypothesis"] += 1
        cell, motion = self.cell, None if scene.motion is None else scene.motion[None]
        answers = self.bench.ask(scene)
        add_to_digest(self.digest, self.bench.name, cell, answers)
        with timed("judge"):
            strained = strain(self.bench.engine, scene, answers)
            strained.steer(self.symptoms)
        kind, symptom, amount, found = Kind.AGREES, "", 0.0, None
        if not strained.calm:
            with timed("judge"):
                screening = self.bench.judges.screen(cell, scene.a[None], scene.b[None], motion, answers)
            kind, symptom, amount = screening.kind[0], screening.symptom[0], float(screening.amount[0])
            if kind in SUSPECT:
                kind, found = self._weigh(scene, answers, screening)
        proven = kind in FINDINGS
        said = KINDS.index(kind), symptom, amount, max(0.0, strained.worst), np.nan, scene.size, np.nan, np.nan
        self.rows.append(Row(scene.regime, tried, int(answers.status[0]), *said, proven))
        if not proven:
            self.outcome.counts[self.bench.name, cell.query, cell.pair, scene.regime, kind] += 1
        return found

    def _weigh(self, scene: Scene, answers: Answers, screening: Screening) -> tuple[Kind, str | None]:
        """Kind of the verdict on a suspect answer, and name of the kind of failure.

        Each kind is proven once when it is met and once when it has become simple; between, floats that are certain do.
        """
        decade = decade_of(float(screening.amount[0]), scene.size)
        name = f"{screening.symptom[0]} · {degeneracy(scene)} · {decade}"
        if screening.kind[0] is Kind.WRONG and name in self.proven and screening.certain[0]:
            simplest = self.simplest.get(name, (self.proven[name].scene, answers))[0]
            if clumsiness(scene) < clumsiness(simplest):
                self.simplest[name] = scene, answers
            return Kind.WRONG, self._shown(name, screening)
        kind = self._prove(name, scene, answers)
        return kind, self._shown(name, screening) if kind in (Kind.WRONG, Kind.REFERENCE_WRONG) else None

    def _shown(self, name: str, screening: Screening) -> str | None:
        """The kind of a failure, unless there are enough of its symptom: no bug may take up the whole search."""
        kinds = self.symptoms.setdefault(str(screening.symptom[0]), set())
        if len(kinds) < MOST_OF_ONE:
            kinds.add(name)
        return name if name in kinds else None

    def _prove(self, name: str, scene: Scene, answers: Answers) -> Kind:
        self.proofs += 1
        with timed("proofs"):
            verdict = self.bench.judges.convict(scene, answers)
        self.losses += verdict.kind in (Kind.CRASHED, Kind.TIMED_OUT)
        if verdict.kind in FINDINGS:
            known = self.proven.get(name)
            if known is None or clumsiness(scene) < clumsiness(known.scene):
                self.proven[name] = finding_of(self.bench.name, scene, answers, verdict)
        return verdict.kind

    def findings(self) -> list[Finding]:
        """One for each kind: the simplest that can be proven."""
        for name, (scene, answers) in self.simplest.items():
            self._prove(name, scene, answers)
        return list(self.proven.values())


def hunting(
    bench: Bench, cell: Cell, *, seed: int, examples: int = MANY_EXAMPLES, database: Path | None = None
) -> Outcome:
    """Search one cell for a few hundred scenes; the same seed brings the same.

    Parameters
    ----------
    examples
        How many scenes are generated; those of shrinking are not counted.
    database
        Folder of failures of this cell alone, which are tried first, and kept; by default none.
    """
    attack = _Attack(bench, cell)
    with timed("hunt"), constants_of(bench.engine):
        Search(attack, seed, examples, database=database).run(scenes(cell, engines=(bench.engine,)))
    outcome = attack.outcome
    outcome.findings = attack.findings()
    for finding in outcome.findings:  # one count for each finding that is filed, none for the steps of its shrinking
        outcome.counts[finding.engine, cell.query, cell.pair, finding.scene.regime, finding.verdict.kind] += 1
    outcome.digest = attack.digest.hexdigest()
    outcome.sheets.append(Sheet.of_rows(bench.name, cell, attack.rows))
    return outcome
