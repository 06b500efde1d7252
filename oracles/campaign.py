"""The campaign: scenes to engines, answers to the judge, findings to buckets, until the time is used.

The first pass puts scenes of every regime before every cell of every engine; then larger passes of the bulk
hunter take turns with Hypothesis. The reference itself is audited all along, and a failed audit ends the run.
"""

from __future__ import annotations

import platform
import time
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

import numpy as np

from oracles.answers import reference_for, said, take
from oracles.batch import Batch, PairKey
from oracles.buckets import Buckets
from oracles.engine import Answers, Engine, EngineUnavailable, SupportKind
from oracles.engines import load_engine, require_sound
from oracles.hunt import hunt
from oracles.impact_regimes import impact_reasons, regimes_of
from oracles.judges import Judges, audit_of
from oracles.ledger import Ledger, settle
from oracles.ledger.replay import Replayed, replay, to_replay
from oracles.library import Library, shipped, using
from oracles.outcome import ANSWERED, Finding, Kind, Run, SupportNote, Verdict
from oracles.reference import is_quick
from oracles.regimes import reasons
from oracles.scene import DISTANCE, IMPACT, RAYCAST, Cell, Scene, cells
from oracles.words import decade_of
from oracles.worker import EngineWorker
from refimpl.pairs import TABLE

FIRST_PASS, LARGEST_PASS = 6, 100
SEARCHED = 6
"""Pairs that need a search, corners or pieces get so many times fewer scenes than pairs with a closed form."""
STEPPED = 3
"""Impacts get so many times fewer scenes: engines make two bodies for each, which takes a millisecond."""
AUDITED = 4
"""One regime in so many is audited, where a proof is no closed form."""
GIVE_UP_AFTER = 1
HUNT_SHARE = 0.35
PATIENCE = 60.0
"""Seconds beyond the budget that the first pass over all cells may take."""
LOOK_AHEAD = 2


class Listener(Protocol):
    """Told how the campaign goes on."""

    def started(self, engines: Sequence[str], cells: int) -> None:
        """Tell once the engines answer."""

    def advanced(self, run: Run, elapsed: float) -> None:
        """Tell after each batch; `run` holds the counts and buckets so far."""


class ReferenceFailed(Exception):
    """A proof spoke against the reference; the run stops."""


@dataclass
class Campaign:
    """A campaign on the way."""

    engines: dict[str, Engine]
    workers: dict[str, EngineWorker]
    run: Run
    pairs: list[PairKey]
    listener: Listener | None
    ledger: Ledger
    buckets: Buckets = field(init=False)
    judges: dict[str, Judges] = field(init=False)
    start: float = field(default_factory=time.monotonic)
    turn: int = 0
    replays: list[Replayed] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.buckets = Buckets(self.ledger)
        self.judges = {name: Judges(engine) for name, engine in self.engines.items()}

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.start

    @contextmanager
    def timed(self, what: str) -> Iterator[None]:
        """Add the block's time to the split."""
        begin = time.monotonic()
        try:
            yield
        finally:
            self.run.timing[what] = self.run.timing.get(what, 0.0) + time.monotonic() - begin

    def supported(self, engine: str, cell: Cell) -> bool:
        """Whether the engine answers this cell."""
        return self.engines[engine].support(cell.query, cell.type_a, cell.type_b).kind is not SupportKind.UNSUPPORTED

    @cached_property
    def asks_at_rest(self) -> bool:
        """Whether any engine answers anything but impacts."""
        asked = (cell for pair in self.pairs for cell in self.cells_of(pair) if cell.query != IMPACT)
        return any(self.supported(name, cell) for cell in asked for name in self.engines)

    def cells_of(self, pair: PairKey) -> list[Cell]:
        """Cells of one pair."""
        return [cell for cell in cells() if (cell.type_a, cell.type_b) == pair]

    # -- the way through -------------------------------------------------------------------------------------

    def go(self) -> None:
        """Bulk passes and hunts in turn, until the budget is used; the first pass may take longer, within reason."""
        self.replay()
        each, number = FIRST_PASS, 0
        self.bulk_pass(number, each, until=max(2 * self.run.budget, self.run.budget + PATIENCE))
        if self.elapsed > self.run.budget + PATIENCE:
            self.run.problems.append(f"the first pass took {self.elapsed:.0f} s of a budget of {self.run.budget:g} s")
        while self.elapsed < self.run.budget:
            before = self.elapsed
            until = min(self.run.budget, before + max(1.0, HUNT_SHARE * (self.run.budget - before)))
            self.hunting(number, until)
            number, each = number + 1, min(4 * each, LARGEST_PASS)
            self.bulk_pass(number, each, until=self.run.budget)

    def replay(self) -> None:
        """Ask the ledger's witnesses again, those of the cells that are asked."""
        for name, judges in self.judges.items():
            for witness in to_replay(self.ledger, name):
                cell = witness.scene.cell
                if (cell.type_a, cell.type_b) not in self.pairs:
                    continue
                with self.timed("replay"):
                    found = replay(witness, self.workers[name].ask, judges)
                self.replays.append(found)
                self.run.hunters["replay"] += 1
                self.run.counts[name, cell.query, cell.pair, witness.scene.regime, found.kind] += 1
                if found.finding is not None:
                    self.file_finding(found.finding)
                self._tell()

    def bulk_pass(self, number: int, each: int, until: float = float("inf")) -> None:
        """One batch of every pair to every engine; engines answer ahead while the judge works."""
        waiting: deque[tuple[Batch, list[tuple[str, Cell, Future[Answers]]]]] = deque()
        with ExitStack() as stack:
            pools = {name: stack.enter_context(ThreadPoolExecutor(1)) for name in self.engines}
            try:
                for index in np.random.default_rng([self.run.seed, number]).permutation(len(self.pairs)):
                    if self.elapsed > until:
                        break
                    pair = self.pairs[index]
                    shard = number, list(TABLE).index(pair)  # the same scenes whatever pairs are asked for
                    for batch in self._drawn(pair, shard, each):
                        waiting.append((batch, self._ask(pair, batch, pools)))
                        if len(waiting) > LOOK_AHEAD:
                            self._judge(*waiting.popleft())
                while waiting:
                    self._judge(*waiting.popleft())
            except BaseException:
                for _, jobs in waiting:
                    for _, _, future in jobs:
                        future.cancel()
                for worker in self.workers.values():
                    worker.interrupt()
                raise

    def _drawn(self, pair: PairKey, shard: tuple[int, int], each: int) -> list[Batch]:
        """Scenes of a pair; fewer where each costs a search."""
        with self.timed("scenes"):
            many = each if is_quick(*pair) else max(1, each // SEARCHED)
            batches = Batch.draw(pair, self.run.seed, shard, many) if self.asks_at_rest else []
            if any(self.supported(name, Cell(IMPACT, *pair)) for name in self.engines):
                batches += Batch.draw_impacts(pair, self.run.seed, shard, max(1, each // STEPPED))
            return batches

    def _ask(
        self, pair: PairKey, batch: Batch, pools: dict[str, ThreadPoolExecutor]
    ) -> list[tuple[str, Cell, Future[Answers]]]:
        jobs = []
        for cell in self.cells_of(pair):
            if not batch.is_of(cell.query):
                continue
            for name in self.engines:
                if self.supported(name, cell):
                    jobs.append((name, cell, pools[name].submit(self._answers, name, cell, batch)))
                else:
                    for regime in batch.regimes:
                        self.run.counts[name, cell.query, cell.pair, regime, Kind.UNSUPPORTED] += 1
        return jobs

    def _answers(self, name: str, cell: Cell, batch: Batch) -> Answers:
        with self.timed(f"engine {name}"):
            worker = self.workers[name]
            return worker.answer(
                cell.query, cell.type_a, cell.type_b, *batch.rows, groups=batch.groups, give_up_after=GIVE_UP_AFTER
            )

    def _judge(self, batch: Batch, jobs: list[tuple[str, Cell, Future[Answers]]]) -> None:
        self._audit(batch)
        for name, cell, future in jobs:
            answers = future.result()
            self.run.hunters["bulk"] += len(answers)
            with self.timed("judge"):
                screening = self.judges[name].screen(cell, batch.a, batch.b, batch.motion, answers)
            for i, kind in enumerate(screening.kind):
                if kind in (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT):
                    decade = decade_of(float(screening.amount[i]), batch.scene(cell.query, i).size)
                    estimate = (
                        screening.symptom[i],
                        decade,
                        float(screening.amount[i]),
                        bool(screening.certain[i]),
                    )
                    kind = self._weigh(name, cell, batch, i, answers, kind, estimate)  # noqa: PLW2901
                self.run.counts[name, cell.query, cell.pair, batch.regimes[i], kind] += 1
            self._tell()

    def _weigh(
        self,
        name: str,
        cell: Cell,
        batch: Batch,
        i: int,
        answers: Answers,
        kind: Kind,
        estimate: tuple[str, int | None, float, bool],
    ) -> Kind:
        """Prove a suspect answer, or count it to the proven ones of its bucket."""
        symptom, decade, amount, certain = estimate
        regime = batch.regimes[i]
        proof_wanted = self.buckets.wants_proof(name, cell, symptom, decade, regime)
        scene = batch.scene(cell.query, i)
        if kind is Kind.WRONG and not proof_wanted:
            if certain:
                self.buckets.add_counted(name, scene, Verdict(kind, symptom, amount=amount))
            return Kind.WRONG if certain else Kind.UNDECIDED
        with self.timed("proofs"):
            verdict = self.judges[name].convict(scene, take(answers, [i]))
        if verdict.kind in (Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT, Kind.REFERENCE_WRONG):
            self.file(name, scene, take(answers, [i]), verdict)
        return verdict.kind

    def file(self, name: str, scene: Scene, answers: Answers, verdict: Verdict) -> None:
        """File a proven finding."""
        reference = reference_for(scene)
        if verdict.kind is Kind.REFERENCE_WRONG:
            name = "refimpl"
        self.file_finding(
            Finding(name, scene, said(answers, 0), said(reference, 0), verdict, answers.errors.get(0, ""))
        )

    def file_finding(self, finding: Finding) -> None:
        """File a proven finding; one against the reference ends the run."""
        self.buckets.add_proven(finding)
        self.run.buckets = list(self.buckets.found.values())
        if finding.verdict.kind is Kind.REFERENCE_WRONG:
            raise ReferenceFailed(finding.verdict.claim)

    def _audit(self, batch: Batch) -> None:
        """Prove the reference's own answer on one scene of each regime, or of some in turn where proofs take time."""
        with self.timed("audit"):
            first = np.unique(batch.groups, return_index=True)[1]
            if batch.motion is not None or not is_quick(type(batch.a), type(batch.b)):
                first = first[batch.groups[first] % AUDITED == self.turn % AUDITED]
                self.turn += 1
            for i in first:
                query = next(q for q in (RAYCAST, DISTANCE, IMPACT) if batch.is_of(q))
                scene = batch.scene(query, int(i))
                verdict = audit_of(scene)
                self.run.counts["refimpl", query, scene.cell.pair, scene.regime, verdict.kind] += 1
                if verdict.kind is Kind.REFERENCE_WRONG:
                    self.file("refimpl", scene, reference_for(scene), verdict)

    def hunting(self, number: int, until: float) -> None:
        """Let Hypothesis attack every supported cell in turn, in an order drawn from the seed."""
        targets = [(n, c) for p in self.pairs for c in self.cells_of(p) for n in self.engines if self.supported(n, c)]
        order = np.random.default_rng([self.run.seed, number, 1]).permutation(len(targets))
        for done, index in enumerate(order):
            left = until - self.elapsed
            if left <= 0:
                return
            name, cell = targets[index]
            slice_end = time.monotonic() + max(0.2, 2.0 * left / (len(order) - done))
            with self.timed("hunt"):
                caught = hunt(
                    self.judges[name],
                    self.workers[name],
                    cell,
                    seed=self.run.seed + number,
                    deadline=slice_end,
                )
            self.run.counts.update(caught.counts)
            self.run.hunters["hypothesis"] += caught.scenes
            for finding in caught.findings:
                self.file(name, finding.scene, finding.answers, finding.verdict)
            self._tell()

    def _tell(self) -> None:
        self.run.seconds = self.elapsed
        if self.listener is not None:
            self.listener.advanced(self.run, self.elapsed)

    def finish(self) -> None:
        """Sort the buckets, write their repro scripts, and say what is missing."""
        self.run.seconds = self.elapsed
        self.run.buckets = self.buckets.sorted()
        settle(self.run, self.ledger, self.replays)
        for bucket in self.run.buckets:
            if bucket.engine in self.engines:
                bucket.repro = self._repro(self.engines[bucket.engine], bucket.witness.scene)
        if not (self.run.interrupted or self.run.reference_wrong):
            self.run.problems += self._silent_cells()

    @staticmethod
    def _repro(engine: Engine, scene: Scene) -> str:
        rows = [row.tolist() for row in scene.rows]
        try:
            return engine.repro(scene.query, scene.cell.type_a, scene.cell.type_b, *rows)
        except Exception as error:  # an adapter's mistake must not cost the report
            return f"# {engine.name} wrote no script for this scene: {type(error).__name__}: {str(error)[:500]!r}\n"

    def _silent_cells(self) -> list[str]:
        """Supported cells and regimes in which nothing was compared: silence would look like agreement."""
        silent = []
        for engine in self.engines:
            if not self.run.total(engine=engine, kinds=ANSWERED):
                silent.append(f"{engine}: no answer was compared at all")
        compared: set[tuple[str, str, str, str]] = set()
        for key, count in self.run.counts.items():
            if count and key[4] not in (Kind.UNSUPPORTED, Kind.SKIPPED):
                compared.add(key[:4])
        for cell, note in self.run.support.items():
            engine, query, pair = cell
            wanted = regimes_of(query)
            lacking = [regime for regime in wanted if (*cell, regime) not in compared]
            if note.kind != "unsupported" and lacking:
                regimes = f"{len(lacking)} of {len(wanted)} regimes: {', '.join(lacking)}"
                where = "any regime" if len(lacking) == len(wanted) else regimes
                silent.append(f"{engine}: nothing compared in {query} {pair} in {where}")
        return silent


def own_versions() -> dict[str, str]:
    """Versions of whatever the verdicts depend on besides the engines."""
    found = {"python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
    return found | {name: version(name) for name in ("proxyproof", "numpy", "hypothesis")}


def run_campaign(
    engines: Sequence[str],
    *,
    budget: float,
    seed: int,
    listener: Listener | None = None,
    pairs: Sequence[str] | None = None,
    call_limit: float = 0.5,
    ledger: Ledger | None = None,
    models: Library | None = None,
) -> Run:
    """Question engines for about `budget` seconds and answer with everything that was found.

    Parameters
    ----------
    engines
        Names of shipped engines, or ``module:attribute`` of one's own.
    budget
        Seconds; the first pass over all cells may take a minute longer, and a problem says so.
    seed
        Names the bulk hunter's scenes.
    pairs
        Names such as ``Sphere–Box``; all by default.
    call_limit
        Seconds an engine may take for one scene.
    ledger
        What is known of the engines' faults; by default what is shipped.
    models
        Where the regime `models` takes its geometry from; by default what PyBullet ships.

    Raises
    ------
    EngineUnavailable
        When an engine cannot be loaded or started, or its adapter is not sound.

    Returns
    -------
    Run
        Complete also after an interrupt (Ctrl-C), which it names.
    """
    loaded = {spec: load_engine(spec) for spec in engines}
    for engine in loaded.values():
        require_sound(engine)
    names = [engine.name for engine in loaded.values()]
    if len(set(names)) < len(names) or "refimpl" in names:
        raise EngineUnavailable(f"engines must have names of their own, none of them refimpl: {', '.join(names)}")
    wanted = sorted(
        {(c.type_a, c.type_b) for c in cells() if not pairs or c.pair in pairs},
        key=lambda p: (p[0].__name__, p[1].__name__),
    )
    run = Run(seed, budget, datetime.now(UTC).isoformat(timespec="seconds"), regimes=reasons())
    with ExitStack() as stack:
        library = stack.enter_context(using(models or shipped()))
        workers = {e.name: stack.enter_context(EngineWorker(spec, call_limit)) for spec, e in loaded.items()}
        named = {engine.name: engine for engine in loaded.values()}
        run.engine_versions = {name: next(iter(engine.versions().values()), "") for name, engine in named.items()}
        at_hand = (ledger if ledger is not None else Ledger.load()).at(run.engine_versions)
        campaign = Campaign(named, workers, run, wanted, listener, at_hand)
        run.engines = list(named)
        run.versions = own_versions()
        for engine in named.values():
            run.versions |= engine.versions()
        for cell in (c for c in cells() if (c.type_a, c.type_b) in wanted):
            for engine in named.values():
                support = engine.support(cell.query, cell.type_a, cell.type_b)
                run.support[engine.name, cell.query, cell.pair] = SupportNote(support.kind.value, support.reason)
        if any(query == IMPACT and note.kind != "unsupported" for (_, query, _), note in run.support.items()):
            run.regimes |= impact_reasons()
        if listener is not None:
            listener.started(run.engines, len(run.support))
        try:
            campaign.go()
        except KeyboardInterrupt:
            run.interrupted = True
        except ReferenceFailed as failed:
            run.problems.append(f"the reference was proven wrong, so the run stopped: {failed}")
        except Exception as error:  # whatever went wrong, what was found is worth a report
            last = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{last.name}, line {last.lineno} of {Path(last.filename).name}"
            run.problems.append(f"the run ended early: {type(error).__name__}: {error} (in {place})")
        campaign.finish()
        run.models = library.account()
    return run
