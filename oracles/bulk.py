"""The bulk hunter: scenes of every regime of one pair before every engine, screened by floats and proven by samples."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from oracles.adapters import UnsoundAdapter
from oracles.answers import add_to_digest, reference_for, take
from oracles.batch import Batch, PairKey
from oracles.bench import Bench, Workshop
from oracles.clock import timed
from oracles.engine import Answers
from oracles.judge import Screening
from oracles.judges import audit_of, finding_of
from oracles.outcome import FINDINGS, SUSPECT, Kind, Outcome
from oracles.reference import is_quick
from oracles.scene import DISTANCE, IMPACT, RAYCAST, Cell, cells_of
from oracles.sheets import Sheet
from oracles.words import decade_of
from refimpl.pairs import TABLE

SEARCHED = 6
"""Pairs that need a search, corners or pieces get so many times fewer scenes than pairs with a closed form."""
STEPPED = 3
"""Impacts get so many times fewer scenes: engines make two bodies for each, which takes a millisecond."""
AUDITED = 4
"""One regime in so many is audited, where a proof is no closed form."""
GIVE_UP_AFTER = 1


@dataclass
class Proofs:
    """Which suspects of a task are proven one by one: proofs cost milliseconds, of searches a hundred.

    Of findings that look alike the first few are, in each regime where proofs are quick; the rest is counted.
    """

    per_regime: int = 1
    of_searched: int = 2
    _tried: Counter[tuple[object, ...]] = field(default_factory=Counter)

    def wanted(self, engine: str, cell: Cell, symptom: str, decade: int | None, regime: str) -> bool:
        """Whether another finding of this kind is worth a proof; counts the answer yes."""
        quick = is_quick(cell.type_a, cell.type_b) and cell.query != IMPACT
        key = (engine, cell, symptom, decade, regime if quick else "")
        self._tried[key] += 1
        return self._tried[key] <= (self.per_regime if quick else self.of_searched)


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
        for batch in self.drawn():
            self.audit(batch)
            for cell in cells_of(self.pair):
                if batch.is_of(cell.query):
                    self.ask(cell, batch)
        self.outcome.digest = self.digest.hexdigest()
        return self.outcome

    def drawn(self) -> list[Batch]:
        """Scenes of the pair, fewer where each costs a search; those at rest also where the reference alone answers."""
        asked = {cell.query for cell in cells_of(self.pair) if self.shop.asked(cell)}
        shard = self.number, list(TABLE).index(self.pair)  # the same scenes whatever pairs are asked for
        seed = self.shop.setup.seed
        with timed("scenes"):
            many = self.each if is_quick(*self.pair) else max(1, self.each // SEARCHED)
            batches = Batch.draw(self.pair, seed, shard, many) if self.shop.at_rest else []
            if IMPACT in asked:
                batches += Batch.draw_impacts(self.pair, seed, shard, max(1, self.each // STEPPED))
            return batches

    def ask(self, cell: Cell, batch: Batch) -> None:
        """Put a batch before every engine that supports the cell, one after the other."""
        rows, asked = batch.rows, self.shop.asked(cell)
        for bench in asked:
            answers = bench.answer(cell, rows, batch.groups, GIVE_UP_AFTER)
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
        kinds, proven = list(screening.kind), np.zeros(len(batch), dtype=bool)
        for i in [i for i, kind in enumerate(kinds) if kind in SUSPECT]:
            found = len(self.outcome.findings)
            kinds[i] = self.weigh(bench, cell, batch, i, answers, screening)
            proven[i] = len(self.outcome.findings) > found
        for (regime, kind), number in Counter(zip(batch.regimes, kinds, strict=True)).items():
            self.outcome.counts[bench.name, cell.query, cell.pair, regime, kind] += number
        with timed("store"):
            sheet = Sheet.of_batch(bench.name, cell, batch, answers, screening, kinds, proven)
            self.outcome.sheets.append(sheet)

    def weigh(self, bench: Bench, cell: Cell, batch: Batch, i: int, answers: Answers, screening: Screening) -> Kind:
        """Prove a suspect answer, or count it to the proven ones that it is like."""
        scene, regime = batch.scene(cell.query, i), batch.regimes[i]
        kind, symptom, amount = screening.kind[i], screening.symptom[i], float(screening.amount[i])
        decade = decade_of(amount, scene.size)
        if not self.proofs.wanted(bench.name, cell, symptom, decade, regime) and kind is Kind.WRONG:
            if not screening.certain[i]:
                return Kind.UNDECIDED
            self.outcome.count((bench.name, cell.query, cell.pair, symptom, decade, regime), amount)
            return Kind.WRONG
        alone = take(answers, [i])
        with timed("proofs"):
            verdict = bench.judges.convict(scene, alone)
        if verdict.kind in FINDINGS:
            self.outcome.findings.append(finding_of(bench.name, scene, alone, verdict))
        return verdict.kind

    def audit(self, batch: Batch) -> None:
        """Prove the reference's own answer on one scene of each regime, or of some in turn where proofs take time."""
        first = np.unique(batch.groups, return_index=True)[1]
        if batch.motion is not None or not is_quick(*self.pair):
            turn = self.number + list(TABLE).index(self.pair)
            first = first[batch.groups[first] % AUDITED == turn % AUDITED]
        query = next(q for q in (RAYCAST, DISTANCE, IMPACT) if batch.is_of(q))
        with timed("audit"):
            for i in first:
                scene = batch.scene(query, int(i))
                verdict = audit_of(scene)
                self.outcome.counts["refimpl", query, scene.cell.pair, scene.regime, verdict.kind] += 1
                if verdict.kind is Kind.REFERENCE_WRONG:
                    self.outcome.findings.append(finding_of("refimpl", scene, reference_for(scene), verdict))


def bulk(shop: Workshop, pair: PairKey, number: int, each: int) -> Outcome:
    """Question every engine about `each` scenes of every regime of a pair, or some times fewer of costly ones."""
    return _Bulk(shop, pair, number, each).go()
