"""Tasks: the pieces of work of a campaign, each a pure function of its fields and of the setup.

A task can be done in any process, in any order and again; that is what lets a campaign run anywhere, lose workers
and go on where it ended. What a task finds is filed by the campaign alone (`oracles.campaign`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from threading import Lock, Thread
from typing import ClassVar

from oracles.accuracy import Extreme, ExtremeKey
from oracles.adapters import UnsoundAdapter
from oracles.batch import PairKey
from oracles.bench import Setup, Workshop, close_workshop, workshop
from oracles.bulk import bulk
from oracles.clock import timed, watch
from oracles.crowds.boxes import crowds
from oracles.crowds.judging import question
from oracles.hunt import hunting
from oracles.judges import finding_of
from oracles.ledger import Entry, Ledger
from oracles.ledger.replay import Replayed, replay
from oracles.ledger.studies import CaseWitness, CrowdWitness
from oracles.ledger.witness import AnyWitness, Witness
from oracles.library import using
from oracles.outcome import ID_DIGITS, Finding, Kind, Outcome, Verdict
from oracles.relating import relating
from oracles.scene import Cell
from oracles.shrink import shrink_all
from oracles.surveys import judging as surveys

CROWD = 40
"""Bodies of a crowd."""


class Task(ABC):
    """A piece of work; equal tasks have equal outcomes, but for the time they take."""

    samples: ClassVar[bool] = False
    """Whether its answers are a sample of the regimes, and not of where a search has led."""
    recorded: ClassVar[bool] = True
    """Whether its outcome is part of a record, or had again by doing it again."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Unique within a campaign, in letters that a file's name can have."""

    @abstractmethod
    def do(self, shop: Workshop) -> Outcome:
        """Do it."""

    def replayed(self, outcome: Outcome) -> list[Replayed]:
        """What the outcome says of the ledger's witnesses, where the task has asked any of them again."""
        del outcome
        return []


@dataclass(frozen=True)
class BulkTask(Task):
    """Scenes of every regime of one pair, before every engine that answers it; with an audit of the reference."""

    samples = True
    pair: PairKey
    number: int
    each: int

    @property
    def name(self) -> str:
        """Pass and pair."""
        return f"bulk-{self.number}-{self.pair[0].__name__}-{self.pair[1].__name__}"

    def do(self, shop: Workshop) -> Outcome:
        """Draw, ask, judge and prove."""
        return bulk(shop, self.pair, self.number, self.each)


@dataclass(frozen=True)
class HuntTask(Task):
    """An attack of Hypothesis on one cell of one engine."""

    engine: str
    cell: Cell
    number: int

    @property
    def name(self) -> str:
        """Round, engine and cell."""
        pair = self.cell.pair.replace("–", "-")
        return f"hunt-{self.number}-{self.engine}-{self.cell.query}-{pair}"

    def do(self, shop: Workshop) -> Outcome:
        """Search, shrink and prove."""
        setup, words = shop.setup, (self.engine, self.cell.query, self.cell.pair)
        own = sha256(" ".join(words).encode()).hexdigest()[:ID_DIGITS]  # an engine's name may lead anywhere
        kept = None if setup.database is None else Path(setup.database) / own
        return hunting(
            shop.bench(self.engine), self.cell, seed=setup.seed + self.number, examples=setup.examples, database=kept
        )


@dataclass(frozen=True)
class RelateTask(Task):
    """Relations between the answers of one engine on one pair."""

    engine: str
    pair: PairKey
    number: int

    @property
    def name(self) -> str:
        """Round, engine and pair."""
        return f"relate-{self.number}-{self.engine}-{self.pair[0].__name__}-{self.pair[1].__name__}"

    def do(self, shop: Workshop) -> Outcome:
        """Draw, ask, compare and prove."""
        return relating(shop.bench(self.engine), self.pair, self.number, shop.setup.seed)


@dataclass(frozen=True)
class ShrinkTask(Task):
    """Findings of one engine, cell and symptom, each to be shrunk to the simplest scene with the same fault."""

    findings: tuple[Finding, ...]

    @property
    def name(self) -> str:
        """Engine, cell, and the scenes."""
        first = self.findings[0]
        every = "".join(f"{finding.verdict.symptom} {finding.scene.id}" for finding in self.findings)
        pair = first.scene.cell.pair.replace("–", "-")
        return f"shrink-{first.engine}-{first.scene.query}-{pair}-{sha256(every.encode()).hexdigest()[:12]}"

    def do(self, shop: Workshop) -> Outcome:
        """Shrink; the outcome's findings are those of the task, in their order."""
        with timed("shrinking"):
            return Outcome(findings=shrink_all(self.findings, shop.bench(self.findings[0].engine)))


@dataclass(frozen=True)
class CertifyTask(Task):
    """The worst errors of one pair, each to be proven: the engine is asked again, and a certificate takes its measure.

    What is proven is not read from a record, so that nobody has to be believed.
    """

    recorded = False
    extremes: tuple[tuple[ExtremeKey, Extreme], ...]

    @property
    def name(self) -> str:
        """The pair, and the scenes."""
        pair = self.extremes[0][0][2].replace("–", "-")
        every = "".join(f"{key} {extreme.scene.id}" for key, extreme in self.extremes)
        return f"certify-{pair}-{sha256(every.encode()).hexdigest()[:12]}"

    def do(self, shop: Workshop) -> Outcome:
        """Ask and prove."""
        outcome = Outcome()
        verdicts: dict[tuple[str, str], Verdict] = {}
        for key, extreme in self.extremes:
            bench, scene = shop.bench(key[0]), extreme.scene
            about = bench.name, scene.id  # the worst absolute error often is the worst relative one too
            if about not in verdicts:
                answers = bench.ask(scene)
                with timed("proofs"):
                    verdicts[about] = bench.judges.proven_error(scene, answers)
                if verdicts[about].kind is Kind.REFERENCE_WRONG:
                    outcome.findings.append(finding_of(bench.name, scene, answers, verdicts[about]))
            if verdicts[about].kind is Kind.AGREES:
                outcome.certified[key] = Extreme(scene, verdicts[about].amount).amount(key[3])
        return outcome


@dataclass(frozen=True)
class CrowdTask(Task):
    """Crowds of every regime before the broad phase of one engine."""

    recorded = False
    engine: str
    entries: tuple[Entry, ...] = ()
    """Of the ledger, on this engine."""
    again: tuple[CrowdWitness, ...] = ()
    """Witnesses of the ledger, which are asked first."""

    @property
    def name(self) -> str:
        """The engine."""
        return f"crowds-{self.engine}"

    def do(self, shop: Workshop) -> Outcome:
        """Ask, judge, and prove what is missing."""
        bench = shop.bench(self.engine)
        solver = bench.engine.broad_phase()
        if solver is None:
            return Outcome()
        with timed("broad phases"):
            again = {kept.id: kept.witness for kept in self.again}
            made = crowds(shop.setup.seed, CROWD)
            found, met = question(bench.spec, bench.name, solver, made, Ledger(self.entries).name_of, again)
        digest = sha256(repr([count.counted() for count in found]).encode()).hexdigest()
        return Outcome(crowds=found, met=met, digest=digest)

    def replayed(self, outcome: Outcome) -> list[Replayed]:
        """What the outcome says of the witnesses."""
        return _met(self.again, outcome)


@dataclass(frozen=True)
class SurveyTask(Task):
    """All questions of a survey before one of its engines."""

    recorded = False
    survey: str
    engine: str
    entries: tuple[Entry, ...] = ()
    """Of the ledger, on this engine."""
    again: tuple[CaseWitness, ...] = ()
    """Witnesses of the ledger, which are asked first."""

    @property
    def name(self) -> str:
        """Survey and engine."""
        return f"survey-{self.survey}-{self.engine}"

    def do(self, shop: Workshop) -> Outcome:
        """Ask, judge, and show what is wrong."""
        with timed(f"survey {self.survey}"):
            again = {kept.id: kept.shown.case for kept in self.again}
            found, met = surveys.question(
                self.survey, self.engine, shop.setup.seed, Ledger(self.entries).name_of, again
            )
        digest = sha256(repr([count.counted() for count in found]).encode()).hexdigest()
        return Outcome(surveys=found, met=met, digest=digest)

    def replayed(self, outcome: Outcome) -> list[Replayed]:
        """What the outcome says of the witnesses."""
        return _met(self.again, outcome)


def _met(again: Sequence[AnyWitness], outcome: Outcome) -> list[Replayed]:
    """What became of witnesses that are no scenes."""
    by_id = {witness.id: witness for witness in again}
    return [Replayed(by_id[met.witness], met.kind, None, met.fault) for met in outcome.met]


@dataclass(frozen=True)
class ReplayTask(Task):
    """A witness of the ledger, asked again."""

    witness: Witness

    @property
    def name(self) -> str:
        """Engine and witness."""
        return f"replay-{self.witness.engine}-{self.witness.id}"

    def do(self, shop: Workshop) -> Outcome:
        """Ask and judge anew; the digest is of the verdict, for it is not known what the engine says."""
        bench, scene = shop.bench(self.witness.engine), self.witness.scene
        outcome = Outcome(hunters=Counter({"replay": 1}))
        with timed("replay"):
            found = replay(self.witness, bench)
        outcome.counts[bench.name, scene.query, scene.cell.pair, scene.regime, found.kind] += 1
        if found.finding is not None:
            outcome.findings.append(found.finding)
        outcome.digest = sha256(f"{found.kind} {found.finding and found.finding.answer}".encode()).hexdigest()
        return outcome

    def replayed(self, outcome: Outcome) -> list[Replayed]:
        """What the outcome says of the witness; nothing where the task failed."""
        kinds = [key[4] for key in outcome.counts]
        return [Replayed(self.witness, kinds[0], next(iter(outcome.findings), None))] if kinds else []


_one_at_a_time = Lock()
"""Where an executor's workers are threads: benches, caches and Hypothesis belong to one task at a time."""


def perform(task: Task, setup: Setup) -> Outcome:
    """Do a task in this process."""
    with _one_at_a_time:
        shop = workshop(setup)
        with using(shop.library):
            watch.taken()
            before = set(shop.library.lacking)
            for bench in shop.benches:
                bench.renew()  # an engine with a memory answers the same whatever was done here before
            try:
                outcome = task.do(shop)
            except UnsoundAdapter as unsound:
                outcome = Outcome(problems=[f"not judged: {unsound}"])
            for bench in shop.benches:
                outcome.incidents += bench.incidents()
            outcome.lacking = shop.library.lacking - before
            outcome.timing = watch.taken()
        return outcome


def release() -> None:
    """Have this process end its engines once its task is done, without waiting for that."""

    def when_idle() -> None:
        with _one_at_a_time:
            close_workshop()

    Thread(target=when_idle, daemon=True).start()
