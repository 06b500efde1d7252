"""The plan of a campaign: which tasks, in which order. It depends on nothing but the options and the seed.

First the ledger's witnesses are asked again, so that what is known does not hang on luck. Then the bulk hunter puts
scenes of every regime before every cell of every engine. Then larger passes of it take turns with Hypothesis, task by
task, so that however soon the time is used up, both have had their share.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np

from oracles.batch import PairKey
from oracles.ledger import Ledger
from oracles.ledger.replay import to_replay
from oracles.scene import Cell
from oracles.tasks import BulkTask, HuntTask, ReplayTask, Task

FIRST_PASS, LARGEST_PASS = 6, 100
"""Scenes of each regime and pair in the first pass and in the largest."""
GROWTH = 8
"""Many scenes of a batch cost hardly more than a few: once every cell has had its turn, passes soon are large."""


def replays(ledger: Ledger, engines: Sequence[str], pairs: Sequence[PairKey]) -> Iterator[Task]:
    """The ledger's witnesses of the cells that are asked."""
    for engine in engines:
        for witness in to_replay(ledger, engine):
            cell = witness.scene.cell
            if (cell.type_a, cell.type_b) in pairs:
                yield ReplayTask(witness)


def first_pass(pairs: Sequence[PairKey], seed: int) -> Iterator[Task]:
    """Every pair once, in an order drawn from the seed."""
    return _bulk(pairs, seed, 0)


def later_passes(
    pairs: Sequence[PairKey], targets: Sequence[tuple[str, Cell]], seed: int, passes: int | None
) -> Iterator[Task]:
    """Larger and larger passes, without end or up to so many in all, in turn with hunts for every target."""
    hunts = _hunts(targets, seed)
    for number in range(1, passes) if passes else count(1):
        for task in _bulk(pairs, seed, number):
            yield from (hunt for hunt in [next(hunts, None)] if hunt)
            yield task


def _bulk(pairs: Sequence[PairKey], seed: int, number: int) -> Iterator[Task]:
    each = min(FIRST_PASS * GROWTH**number, LARGEST_PASS)
    for index in np.random.default_rng([seed, number]).permutation(len(pairs)):
        yield BulkTask(pairs[index], number, each)


def _hunts(targets: Sequence[tuple[str, Cell]], seed: int) -> Iterator[Task]:
    """Attacks on every cell of every engine, round after round."""
    for number in count() if targets else ():
        for index in np.random.default_rng([seed, number, 1]).permutation(len(targets)):
            engine, cell = targets[index]
            yield HuntTask(engine, cell, number)
