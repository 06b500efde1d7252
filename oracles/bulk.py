"""The bulk hunter: scenes of every regime of one pair before every engine, screened by floats and proven by samples."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from oracles.accuracy import ABSOLUTE, RELATIVE, Extreme, ExtremeKey, keep_worst
from oracles.adapters import UnsoundAdapter
from oracles.answers import add_to_digest, reference_for, take
from oracles.batch import Batch, PairKey
from oracles.bench import Bench, Workshop
from oracles.clock import timed
from oracles.clumsiness import PLAIN
from oracles.engine import Answers
from oracles.impact_regimes import impact_regimes_for
from oracles.judges import audited, finding_of
from oracles.outcome import FINDINGS, SUSPECT, Kind, Outcome, Verdict
from oracles.reference import gaps, is_quick
from oracles.regimes import Regime, regimes_for
from oracles.scene import CONTACTS, DISTANCE, IMPACT, MOVING, PAIRS, RAYCAST, SWEEP, Cell, cells_of
from oracles.screening import KINDS, Screening
from oracles.sheets import Sheet
from oracles.words import decade_of
from oracles.world import is_flat
from refimpl.compiling import batch_of
from refimpl.shapes import KDOP, Composite, ConvexPolyhedron, HalfSpace, Polyhedron

QUICK, SEARCHED = 16, 6
"""Pairs with a closed form get so many times more scenes, pairs that need a search, corners or pieces so many times
fewer: drawing and judging cost by the batch rather than by the scene."""
MOST = 800
"""Scenes of a regime and pair in one task."""
MESHES, MOST_OF_MESHES = 4, 800
"""The same of meshes: those of a regime share theirs and are a batch by themselves, so few cost as much as many."""
FORMED, MESHED = {KDOP, ConvexPolyhedron, Composite}, 2
"""Types of which an engine makes another hull, or several objects, for each scene: that costs more than judging it, so
that beside meshes they get so many times fewer."""
FEWER = 3
"""Searches at rest without hulls or meshes get so many times fewer: all regimes go in one batch."""
POLYGONS, MOST_OF_POLYGONS = 2, 40
"""Flat pairs with a polygon get twice as many, up to so many: there is no search, and half a millisecond is a scene."""
STEPPED = 6
"""Impacts get so many times fewer scenes: engines make two bodies for each, which takes a millisecond."""
SWEPT = 16
"""Sweeps get so many times fewer: the reference takes many distances for each."""
AUDITED = 4
"""One regime in so many is audited in a task, in turn: a proof costs as much as a hundred answers."""
SWEEPS_AUDITED = 12
"""The same of sweeps: the proof of one costs as much as several of distances."""
GIVE_UP_AFTER = 1
AT_REST = (DISTANCE, CONTACTS)
"""Queries of which the signed distance of the two is known once an answer is judged."""


@dataclass
class Proofs:
    """Which suspects of a task are proven one by one: proofs cost milliseconds, of searches a hundred.

    Of findings that look alike the first two of each decade of the error are; where proofs are quick, the first of each
    decade and of each regime. The rest is counted, under the symptom that the proofs gave to those it looks like, for
    floats may see another claim broken first; what looks like nothing that a proof spoke against is proven itself.
    """

    _tried: Counter[tuple[object, ...]] = field(default_factory=Counter)
    _told: dict[tuple[object, ...], str] = field(default_factory=dict)

    def wanted(self, engine: str, cell: Cell, symptom: str, decade: int | None, regime: str) -> bool:
        """Whether another finding of this kind is worth a proof; counts the answer yes."""
        quick = is_quick(cell.type_a, cell.type_b) and cell.query not in MOVING
        kinds = [(engine, cell, symptom, decade), *([(engine, cell, symptom, regime)] if quick else [])]
        new = any(self._tried[kind] < (1 if quick else 2) for kind in kinds)
        if new:
            self._tried.update(kinds)
        return new

    def symptom(self, engine: str, cell: Cell, symptom: str, decade: int | None) -> str | None:
        """What findings are that look like this one, by the first proof that convicted; None if none did."""
        return self._told.get((engine, cell, symptom, decade))

    def take_note(self, engine: str, cell: Cell, symptom: str, decade: int | None, verdict: Verdict) -> None:
        """Remember what a proof found."""
        if verdict.kind is Kind.WRONG:
            self._told.setdefault((engine, cell, symptom, decade), verdict.symptom)


@dataclass
class _Bulk:
    shop: Workshop
    pair: PairKey
    number: int
    each: int
    outcome: Outcome = field(default_factory=Outcome)
    proofs: Proofs = field(default_factory=Proofs)
    digest: hashlib._Hash = field(default_factory=hashlib.sha256)

    def go(self) -> Outcome:
        with batch_of(self.many * len(self.regimes)):  # small groups of one form are parts of a large batch
            for batch in self.drawn():
                self.audit(batch)
                for cell in cells_of(self.pair):
                    if batch.is_of(cell.query):
                        self.ask(cell, batch)
        self.outcome.digest = self.digest.hexdigest()
        return self.outcome

    @property
    def many(self) -> int:
        """Scenes of each regime, at rest."""
        return scenes_each(self.pair, self.each)

    @cached_property
    def regimes(self) -> dict[str, Regime]:
        """All regimes, with those about the thresholds of the engines of this world."""
        flat = is_flat(self.pair[0])
        return regimes_for(bench.engine for bench in self.shop.benches if bench.engine.flat == flat)

    def drawn(self) -> list[Batch]:
        """Scenes of the pair, fewer where each costs a search; those at rest also where the reference alone answers."""
        asked = {cell.query for cell in cells_of(self.pair) if self.shop.asked(cell)}
        shard = self.number, PAIRS.index(self.pair)  # the same scenes whatever pairs are asked for
        seed = self.shop.setup.seed
        with timed("scenes"):
            batches = Batch.draw(self.pair, seed, shard, self.many, self.regimes) if self.shop.at_rest else []
            moving = scenes_each(self.pair, self.each, moving=True)
            if IMPACT in asked:
                impacts = impact_regimes_for(bench.engine for bench in self.shop.benches)
                batches += Batch.draw_impacts(self.pair, seed, shard, max(1, moving // STEPPED), impacts)
            if SWEEP in asked:
                batches += Batch.draw_sweeps(self.pair, seed, shard, max(1, moving // SWEPT))
            return batches

    def ask(self, cell: Cell, batch: Batch) -> None:
        """Put a batch before every engine that supports the cell, one after the other."""
        rows, asked = batch.rows, self.shop.asked(cell)
        for bench in asked:
            answers = bench.answer(cell, rows, batch.groups, GIVE_UP_AFTER)
            self.outcome.spend({(bench.name, cell.query, cell.pair): bench.worker.effort})
            self.outcome.hunters["bulk"] += len(answers)
            add_to_digest(self.digest, bench.name, cell, answers)
            try:
                self.judge(bench, cell, batch, answers)
            except UnsoundAdapter as unsound:  # one engine's adapter does not cost the others their answers
                self.outcome.problems.append(f"{bench.name} cannot be judged: {unsound}")
        for bench in self.shop.benches:
            if bench not in asked:
                for regime, number in Counter(batch.regimes).items():
                    self.outcome.counts[bench.name, cell.query, cell.pair, regime, Kind.UNSUPPORTED] += number

    def judge(self, bench: Bench, cell: Cell, batch: Batch, answers: Answers) -> None:
        """Screen all answers, and weigh the suspects one by one."""
        with timed("judge"):
            screening = bench.judges.screen(cell, batch.a, batch.b, batch.motion, answers)
        suspects, proven = screening.rows_of(SUSPECT), np.zeros(len(batch), dtype=bool)
        for i in suspects[np.argsort(_odd_numbers(batch, suspects), kind="stable")].tolist():
            found, size = len(self.outcome.findings), float(batch.sizes[i])
            screening.codes[i] = KINDS.index(self.weigh(bench, cell, batch, i, answers, screening, size))
            proven[i] = len(self.outcome.findings) > found
        names = dict(zip(batch.groups.tolist(), batch.regimes, strict=True))
        for (group, kind), number in screening.counts(batch.groups).items():
            self.outcome.counts[bench.name, cell.query, cell.pair, names[group], kind] += number
        keep_worst(self.outcome.extremes, self.extremes(bench, cell, batch, screening.error))
        with timed("store"):
            gap = gaps(batch.a, batch.b, ~np.isnan(screening.error) & (cell.query in AT_REST))
            sheet = Sheet.of_batch(bench.name, cell, batch, answers, screening, proven, gap)
            self.outcome.sheets.append(sheet)

    def extremes(
        self, bench: Bench, cell: Cell, batch: Batch, error: NDArray[np.float64]
    ) -> Iterator[tuple[ExtremeKey, Extreme]]:
        """The worst errors of a batch, where there are any."""
        if not np.nanmax(error, initial=0.0) > 0:
            return
        with np.errstate(divide="ignore", invalid="ignore"):
            measured = {ABSOLUTE: error, RELATIVE: error / batch.sizes}
        for measure, amounts in measured.items():
            worst = int(np.nanargmax(amounts))
            extreme = Extreme(batch.scene(cell.query, worst), float(error[worst]))
            yield (bench.name, cell.query, cell.pair, measure), extreme

    def weigh(
        self, bench: Bench, cell: Cell, batch: Batch, i: int, answers: Answers, screening: Screening, size: float
    ) -> Kind:
        """Prove a suspect answer, or count it to the proven ones that it is like."""
        regime, kind = batch.regimes[i], KINDS[screening.codes[i]]
        symptom, amount = screening.symptom[i], float(screening.amount[i])
        decade = decade_of(amount, size)
        look = bench.name, cell, symptom, decade
        if not self.proofs.wanted(*look, regime) and kind is Kind.WRONG:
            if not screening.certain[i]:
                return Kind.UNDECIDED
            told = self.proofs.symptom(*look)
            if told is not None:
                self.outcome.count((bench.name, cell.query, cell.pair, told, decade, regime), amount)
                return Kind.WRONG
        scene, alone = batch.scene(cell.query, i), take(answers, [i])
        with timed("proofs"):
            verdict = bench.judges.convict(scene, alone)
        self.proofs.take_note(*look, verdict)
        if verdict.kind in FINDINGS:
            self.outcome.findings.append(finding_of(bench.name, scene, alone, verdict))
        return verdict.kind

    def audit(self, batch: Batch) -> None:
        """Prove the reference's own answer on one scene of each regime whose turn it is."""
        first = np.unique(batch.groups, return_index=True)[1]
        turn = self.number + PAIRS.index(self.pair)
        query = next(q for q in (RAYCAST, DISTANCE, IMPACT, SWEEP) if batch.is_of(q))
        each = SWEEPS_AUDITED if query == SWEEP else AUDITED
        first = first[batch.groups[first] % each == turn % each]
        with timed("audit"):
            for i in first:
                scene = batch.scene(query, int(i))
                verdict = audited(scene)
                self.outcome.counts["refimpl", query, scene.cell.pair, scene.regime, verdict.kind] += 1
                if verdict.kind is Kind.REFERENCE_WRONG:
                    self.outcome.findings.append(finding_of("refimpl", scene, reference_for(scene), verdict))


def _odd_numbers(batch: Batch, rows: NDArray[np.int_]) -> NDArray[np.int_]:
    """How many numbers of each of these scenes a reader has to read: what is proven first is what he may see."""
    numbers = np.concatenate([np.asarray(side)[rows] for side in batch.rows], axis=1)
    return np.asarray(np.count_nonzero(~np.isin(numbers, list(PLAIN)), axis=1))


def scenes_each(pair: PairKey, each: int, *, moving: bool = False) -> int:
    """Scenes of each regime in a pass: more where a formula or a lowest point tells, fewer where it needs a search."""
    if is_quick(*pair) or (HalfSpace in pair and not FORMED & set(pair) and not moving):
        return min(MOST, each * QUICK)
    if Polyhedron in pair and not moving:
        return max(1, each // MESHED) if FORMED & set(pair) else min(MOST_OF_MESHES, each * MESHES)
    if is_flat(pair[0]) and not moving:
        return min(MOST_OF_POLYGONS, POLYGONS * each)
    return max(1, each // (SEARCHED if moving or FORMED & set(pair) else FEWER))


def bulk(shop: Workshop, pair: PairKey, number: int, each: int) -> Outcome:
    """Question every engine about `each` scenes of every regime of a pair, or some times fewer of costly ones."""
    return _Bulk(shop, pair, number, each).go()
