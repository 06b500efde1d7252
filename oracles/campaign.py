"""The campaign: tasks to an executor, what they find to the buckets, until the time or the work is used up.

Outcomes are filed in the order of the plan, whatever order they arrive in: what a campaign finds does not depend on
how many workers there are.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Protocol

from oracles import closing, opening, plan
from oracles.batch import PairKey
from oracles.bench import MANY_EXAMPLES, Setup, Workshop, close_workshop
from oracles.buckets import Buckets
from oracles.clock import timed
from oracles.executors import Here, room
from oracles.filing import Filing, ReferenceFailed
from oracles.interrupts import held, ignored
from oracles.ledger import Ledger
from oracles.outcome import Outcome, Run
from oracles.scene import Cell, cells_of
from oracles.store import Store
from oracles.tasks import CertifyTask, ShrinkTask, Task, perform

CERTIFYING = 30.0
"""Seconds that may be spent on proving the worst errors."""
SHRINKING = 30.0
"""Seconds beyond the budget that may be spent on making witnesses small."""
PATIENCE = 120.0
"""Seconds beyond the budget that the first pass over all cells may take."""
BOILING = 0.3
"""Share of the budget that is kept for shrinking."""
MOST_HOLES = 100
"""Tasks not done between recorded ones, where a run was ended: those that were under way."""
MOST_FAILURES = 10
"""Tasks that may fail for other reasons than their engine's before the run is given up."""


class Listener(Protocol):
    """Told how the campaign goes on."""

    def started(self, engines: Sequence[str], cells: int) -> None:
        """Tell once the engines answer."""

    def advanced(self, run: Run, elapsed: float) -> None:
        """Tell after each task; `run` holds the counts and buckets so far."""


class GaveUp(Exception):
    """Too many tasks failed."""


@dataclass
class Campaign:
    """A campaign on the way.

    Attributes
    ----------
    ahead
        How many tasks are given to the executor before the first of them is done.
    """

    shop: Workshop
    run: Run
    pairs: list[PairKey]
    passes: int | None
    listener: Listener | None
    filing: Filing
    executor: Executor
    ahead: int
    enough: Callable[[Run], bool] | None = None
    store: Store | None = None
    start: float = field(default_factory=time.monotonic)
    flying: dict[Future[Outcome], tuple[int, Task]] = field(default_factory=dict)
    landed: dict[int, tuple[Task, Outcome]] = field(default_factory=dict)
    begun: int = 0
    filed: int = 0
    failures: int = 0
    recalling: float = 0.0
    """Seconds that reading an older record took, which are no part of the budget."""

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.start - self.recalling

    # -- the way through -------------------------------------------------------------------------------------

    def go(self) -> None:
        """All tasks of the plan that there is time for."""
        budget = self.run.budget
        late = max(2 * budget, budget + PATIENCE)
        asked = self.filing.buckets.ledger, self.run.engines, self.pairs
        for known in (plan.replays, plan.crowds, plan.surveys):
            self._do(known(*asked), until=late)
        begun = self.elapsed
        self._do(plan.first_pass(self.answered, self.run.seed), until=begun + late)
        if not self.passes and (took := self.elapsed - begun) > budget + PATIENCE:
            self.run.problems.append(f"the first pass took {took:.0f} s of a budget of {budget:g} s")
        hunted = (1 - BOILING) * budget
        self._do(plan.later_passes(self.answered, self.targets(), self.run.seed, self.passes), until=hunted)
        while self.flying:
            self._land()
        self.certify()
        self.boil_down()

    def certify(self) -> None:
        """Prove the worst errors of each cell."""
        tasks = (CertifyTask(extremes) for extremes in self.filing.extremes())
        self._do(tasks, until=max(self.run.budget, self.elapsed) + CERTIFYING)
        while self.flying:
            self._land()

    def boil_down(self) -> None:
        """Shrink the witnesses, so that findings with one cause come together."""
        self.enough = None
        groups = self.filing.buckets.to_shrink()
        self._do((ShrinkTask(group) for group in groups), until=max(self.run.budget, self.elapsed) + SHRINKING)
        while self.flying:
            self._land()
        left = self.filing.buckets.new_to_shrink()
        if left:
            self.run.problems.append(f"no time was left to shrink what is new of {left} of {len(groups)} symptoms")

    @cached_property
    def answered(self) -> list[PairKey]:
        """Pairs of which any engine answers anything: scenes of the others would be drawn for nobody."""
        return [pair for pair in self.pairs if any(self.shop.asked(cell) for cell in cells_of(pair))]

    def targets(self) -> list[tuple[str, Cell]]:
        """Every supported cell of every engine."""
        every = [cell for pair in self.pairs for cell in cells_of(pair)]
        return [(bench.name, cell) for cell in every for bench in self.shop.asked(cell)]

    def _do(self, tasks: Iterator[Task], until: float) -> None:
        """Have tasks done, a few at once, for as long as there is time; with a fixed number of passes, all."""
        holes = 0
        for task in tasks:
            if self._recalled(task):
                continue
            while len(self.flying) >= self.ahead:
                self._land()
            if self._over(until):
                holes += 1
                if holes > MOST_HOLES or not (self.store and self.store.waiting):
                    return
                continue
            self.flying[self.executor.submit(perform, task, self.shop.setup)] = self.begun, task
            self.begun += 1

    def _over(self, until: float) -> bool:
        """Whether no more tasks are to be begun."""
        if self.enough is not None and self.enough(self.run):
            return True
        return not self.passes and self.elapsed > until

    def _recalled(self, task: Task) -> bool:
        """Take a task's outcome from the record of an earlier run, where it is there."""
        began = time.monotonic()
        outcome = self.store.recall(task) if self.store else None
        if outcome is None:
            return False
        with held():
            self.landed[self.begun] = task, outcome
            self.begun += 1
            self.run.recalled += 1
            self._file_in_turn()
        self.recalling += time.monotonic() - began
        return True

    def _land(self) -> None:
        """Wait for a task to be done, record it, and file what it found when its turn has come."""
        done = wait(self.flying, return_when=FIRST_COMPLETED).done
        with held():
            for future in done:
                number, task = self.flying.pop(future)
                outcome = self._outcome_of(task, future)
                self.landed[number] = task, outcome
            self._file_in_turn()

    def _file_in_turn(self) -> None:
        while self.filed in self.landed:
            self.filed += 1
            self.filing.file(*self.landed.pop(self.filed - 1))
            self.run.seconds = self.elapsed
            if self.listener is not None:
                self.listener.advanced(self.run, self.elapsed)

    def _outcome_of(self, task: Task, future: Future[Outcome]) -> Outcome:
        error = future.exception()
        if error is None:
            outcome = future.result()
            if self.store and task.recorded:
                with timed("store"):
                    if self.store.record(task, outcome):
                        outcome.sheets = []
            return outcome
        self.failures += 1
        if self.failures >= MOST_FAILURES:
            raise GaveUp(f"{self.failures} tasks failed, at last {task.name}: {type(error).__name__}: {error}")
        return Outcome(problems=[f"{task.name} failed: {type(error).__name__}: {error}"])

    def finish(self) -> None:
        """File what has landed out of turn, and say what is missing."""
        with suppress(ReferenceFailed):
            for number in sorted(self.landed):
                self.filing.file(*self.landed[number])
        self.run.seconds = self.elapsed
        self.filing.settle(self.shop)
        self.filing.measure(self.store.samples if self.store else ())
        if not (self.run.interrupted or self.run.reference_wrong):
            self.run.problems += closing.silent_cells(self.run)
        if self.store:
            self.run.problems += self.store.problems


def run_campaign(
    engines: Sequence[str],
    *,
    budget: float,
    seed: int,
    passes: int | None = None,
    listener: Listener | None = None,
    pairs: Sequence[str] | None = None,
    call_limit: float = 0.5,
    ledger: Ledger | None = None,
    models: str | None = None,
    examples: int = MANY_EXAMPLES,
    database: str | None = None,
    executor: Executor | None = None,
    enough: Callable[[Run], bool] | None = None,
    folder: Path | None = None,
    resume: bool = False,
) -> Run:
    """Question engines for about `budget` seconds and answer with everything that was found.

    Parameters
    ----------
    engines
        Names of shipped engines, or ``module:attribute`` of one's own.
    budget
        Seconds; the first pass over all cells may take two minutes longer, and a problem says so.
    seed
        Names the bulk hunter's scenes.
    passes
        So many passes over all cells instead of the budget: a fixed amount of work, with the same findings whatever
        does it and however long that takes.
    pairs
        Names such as ``Sphere–Box``; all by default.
    call_limit
        Seconds an engine may take for one scene.
    ledger
        What is known of the engines' faults; by default what is shipped.
    models
        Folder from which the regime `models` takes its geometry; by default what PyBullet ships.
    examples
        Scenes that each attack of Hypothesis generates.
    database
        Folder in which Hypothesis keeps what fails, and tries it first the next time: what is found depends on it too.
    executor
        What does the tasks: anything of `concurrent.futures`, by default this process. It is shut down.
    enough
        Asked before each task of the hunt: once it is True, only the witnesses are shrunk.
    folder, resume
        Where every task that is done is recorded, and whether to go on with the record that is there.

    Raises
    ------
    RecordError
        When there is no record to go on with, or it is of another run.
    EngineUnavailable
        When an engine cannot be loaded or started, or its adapter is not sound.
    ModelError
        When there is no such folder, or no model in it.

    Returns
    -------
    Run
        Complete also after an interrupt (Ctrl-C), which it names.
    """
    executor = executor or Here()
    try:
        shop = opening.shop_of(Setup(tuple(engines), seed, call_limit, models, examples, database))
        wanted = opening.wanted_pairs(pairs, [bench.engine for bench in shop.benches])
        run = opening.run_of(shop, wanted, budget)
        run.engine_versions = plan.versions(run.engines, wanted) | run.engine_versions
        run.passes = passes
        if not isinstance(executor, Here):
            shop.rest()
        known = (ledger if ledger is not None else Ledger.load()).at(run.engine_versions)
        store = None if folder is None else opening.store_of(folder, shop, run, wanted, passes, resume=resume)
        filing = Filing(run, Buckets(known))
        campaign = Campaign(shop, run, wanted, passes, listener, filing, executor, room(executor), enough, store)
        if listener is not None:
            listener.started(run.engines, sum(note.kind != "unsupported" for note in run.support.values()))
        _survive(campaign)
        with ignored():
            campaign.finish()
        return run
    finally:
        with ignored():
            executor.shutdown(cancel_futures=True)
            close_workshop()


def _survive(campaign: Campaign) -> None:
    """Go through the campaign; whatever ends it, what was found is worth a report."""
    run = campaign.run
    try:
        campaign.go()
    except KeyboardInterrupt:
        run.interrupted = True
    except ReferenceFailed as failed:
        run.problems.append(f"the reference was proven wrong, so the run stopped: {failed}")
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{last.name}, line {last.lineno} of {Path(last.filename).name}"
        run.problems.append(f"the run ended early: {type(error).__name__}: {error} (in {place})")
