"""Filing: what tasks bring home is added up in the run; nothing that a campaign finds is known in another way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path

import duckdb

from oracles import closing
from oracles.accuracy import Accuracy, Extreme, ExtremeKey, keep_worst
from oracles.bench import Workshop
from oracles.buckets import Buckets
from oracles.clock import watch
from oracles.ledger import settle
from oracles.ledger.replay import Replayed
from oracles.measuring import Measured, speeds_of
from oracles.outcome import Kind, Outcome, Run
from oracles.tasks import ShrinkTask, Task


class ReferenceFailed(Exception):
    """A proof spoke against the reference; the run stops."""


@dataclass
class Filing:
    """The run so far, its buckets, and what has become of the ledger's witnesses."""

    run: Run
    buckets: Buckets
    replayed: list[Replayed] = field(default_factory=list)
    digests: dict[str, str] = field(default_factory=dict)
    lacking: set[str] = field(default_factory=set)
    sums: Outcome = field(default_factory=Outcome)
    """Extremes, what is proven of them, efforts, and the sheets that are in no record."""

    def file(self, task: Task, outcome: Outcome) -> None:
        """Add what a task found.

        Raises
        ------
        ReferenceFailed
            For a finding against the reference, once it is filed.
        """
        run = self.run
        self.digests[task.name] = outcome.digest
        run.counts.update(outcome.counts)
        run.hunters.update(outcome.hunters)
        run.relations.update(outcome.relations)
        run.crowds += outcome.crowds
        run.surveys += outcome.surveys
        run.problems += [problem for problem in outcome.problems if problem not in run.problems]
        run.incidents += outcome.incidents
        self.lacking |= outcome.lacking
        for what, spent in (*outcome.timing.items(), *watch.taken().items()):
            run.timing[what] = run.timing.get(what, 0.0) + spent
        self._file_errors(task, outcome)
        self._file_findings(task, outcome)
        run.buckets = list(self.buckets.piles.values())
        for finding in outcome.findings:
            if finding.verdict.kind is Kind.REFERENCE_WRONG:
                raise ReferenceFailed(finding.verdict.claim)

    def _file_errors(self, task: Task, outcome: Outcome) -> None:
        keep_worst(self.sums.extremes, outcome.extremes.items())
        self.sums.certified |= outcome.certified
        self.sums.spend(outcome.efforts)
        if task.samples:
            self.sums.sheets += outcome.sheets

    def extremes(self) -> list[tuple[tuple[ExtremeKey, Extreme], ...]]:
        """The worst errors, pair by pair."""
        every: dict[str, list[tuple[ExtremeKey, Extreme]]] = {}
        for key, extreme in self.sums.extremes.items():
            every.setdefault(key[2], []).append((key, extreme))
        return [tuple(of_pair) for of_pair in every.values()]

    def measure(self, files: Sequence[Path]) -> None:
        """Take errors by rank from the files of a record, and from what is in none; a lost file costs no more."""
        self.run.accuracy = Accuracy(speeds=speeds_of(self.sums.efforts))
        try:
            with Measured(files, self.sums.sheets) as measured:
                errors, points = measured.errors(self.sums.certified), measured.points()
        except duckdb.Error as error:
            self.run.problems.append(f"the accuracy is not known: {str(error).splitlines()[0][:300]}")
        else:
            self.run.accuracy = replace(self.run.accuracy, errors=errors, points=points)

    def _file_findings(self, task: Task, outcome: Outcome) -> None:
        if isinstance(task, ShrinkTask):
            whole = len(outcome.findings) == len(task.findings)
            self.buckets.rekey(task.findings, outcome.findings if whole else task.findings)
            return
        for finding in outcome.findings:
            self.buckets.add_proven(finding)
        for key, (number, worst) in outcome.counted.items():
            self.buckets.add_counted(key, number, worst)
        self.replayed += task.replayed(outcome)

    def settle(self, shop: Workshop) -> None:
        """Put the buckets in order, with scripts and with what the ledger says of them."""
        run = self.run
        run.buckets = self.buckets.sorted()
        settle(run, self.buckets.ledger, self.replayed)
        closing.write_scripts(run, shop)
        shop.library.lacking |= self.lacking
        run.models = shop.library.account()
        run.digest = sha256("".join(f"{n} {d}\n" for n, d in sorted(self.digests.items())).encode()).hexdigest()
