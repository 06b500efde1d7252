"""The third hunter: puts an engine's answers against each other, scenes of every regime of one pair."""

from __future__ import annotations

import hashlib

from oracles.answers import add_to_digest
from oracles.batch import Batch, PairKey
from oracles.bench import Bench
from oracles.clock import timed
from oracles.outcome import Outcome
from oracles.reference import is_quick
from oracles.relations import RELATIONS, relate
from oracles.scene import IMPACT, PAIRS, SWEEP, cells_of

EACH = 2
"""Scenes of each regime."""
QUICK_PARTS, SEARCHED_PARTS = 2, 6
"""A task puts one relation in so many, in turn: each asks as many scenes again, and meshes are slow to change."""
SHARD = 2
"""Keeps the scenes apart from those of the bulk hunter."""


def relating(bench: Bench, pair: PairKey, number: int, seed: int) -> Outcome:
    """Put some of the relations to scenes of every regime of a pair: all of them, as the numbers go on."""
    outcome, digest = Outcome(), hashlib.sha256()
    parts = QUICK_PARTS if is_quick(*pair) else SEARCHED_PARTS
    names = list(RELATIONS)[number % parts :: parts]
    cells = [cell for cell in cells_of(pair) if bench.supports(cell)]
    shard = number, PAIRS.index(pair), SHARD
    with timed("scenes"):
        batches = Batch.draw(pair, seed, shard, EACH if is_quick(*pair) else 1) if cells else []
        if any(cell.query == IMPACT for cell in cells):
            batches += Batch.draw_impacts(pair, seed, shard, 1)
        if any(cell.query == SWEEP for cell in cells):
            batches += Batch.draw_sweeps(pair, seed, shard, 1)
    with timed("relations"):
        for batch in batches:
            for cell in (cell for cell in cells if batch.is_of(cell.query)):
                answers = bench.answer(cell, batch.rows, batch.groups, give_up_after=1)
                add_to_digest(digest, bench.name, cell, answers)
                found = relate(bench, cell, batch, answers=answers, names=names)
                outcome.findings += found.findings
                outcome.relations.update(found.counts)
    outcome.hunters["relations"] = outcome.relations.total()
    outcome.digest = digest.hexdigest()
    for finding in outcome.findings:
        key = finding.engine, finding.scene.query, finding.scene.cell.pair, finding.scene.regime, finding.verdict.kind
        outcome.counts[key] += 1
    return outcome
