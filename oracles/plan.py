"""The plan of a campaign: which tasks, in which order. It depends on nothing but the options and the seed.

First the ledger's witnesses are asked again, so that what is known does not hang on luck: scenes on their own, the
others where crowds come before every broad phase, and surveys before the libraries that answer other things than
pairs. Then the bulk hunter puts scenes of every regime before every cell of every engine. Then larger passes of it
take turns with Hypothesis and with relations, a few tasks each, so that however soon the time is used up, all have had
their share.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np

from oracles.batch import PairKey
from oracles.engines import SHIPPED
from oracles.ledger import Ledger
from oracles.ledger.replay import to_replay
from oracles.ledger.studies import CaseWitness, CrowdWitness
from oracles.ledger.witness import Witness
from oracles.scene import Cell
from oracles.surveys import SURVEYS, load_survey
from oracles.tasks import BulkTask, CrowdTask, HuntTask, RelateTask, ReplayTask, SurveyTask, Task
from oracles.world import SPACE

FIRST_PASS, LARGEST_PASS = 1, 200
"""Scenes of each regime and pair in the first pass and in the largest: the first is to see every cell and regime once,
and to leave time for all hunters."""
FEW_PAIRS, FEWEST = 30, 4
"""Of no more pairs than these the first pass is as large as the second: there is time for it, and an engine that errs
every 1 000th call is asked so often in the first task of each pair with a closed form, which finds it without a
memory."""
HUNT_EVERY = 3
"""A hunt costs as much as several tasks of the bulk hunter, who finds most: it comes after so many of them."""


def replays(ledger: Ledger, engines: Sequence[str], pairs: Sequence[PairKey]) -> Iterator[Task]:
    """The ledger's witnesses of the cells that are asked."""
    for engine in engines:
        for witness in to_replay(ledger, engine):
            if isinstance(witness, Witness) and _pair_of(witness) in pairs:
                yield ReplayTask(witness)


def _pair_of(witness: Witness) -> PairKey:
    cell = witness.scene.cell
    return cell.type_a, cell.type_b


def first_pass(pairs: Sequence[PairKey], seed: int) -> Iterator[Task]:
    """Every pair once, in an order drawn from the seed."""
    return _bulk(pairs, seed, 0)


def crowds(ledger: Ledger, engines: Sequence[str], pairs: Sequence[PairKey]) -> Iterator[Task]:
    """Crowds before each engine's broad phase, where all pairs of space are asked: a crowd is of no pair."""
    for engine in engines if set(SPACE.table) <= set(pairs) else ():
        again = [w for w in to_replay(ledger, engine) if isinstance(w, CrowdWitness)]
        yield CrowdTask(engine, ledger.live(engine), tuple(again))


def surveyed(engines: Sequence[str], pairs: Sequence[PairKey]) -> Iterator[tuple[str, str]]:
    """Surveys and engines of theirs, where all pairs and any of the shipped engines are asked.

    An engine that answers surveys and pairs is surveyed where it is asked about pairs. A run that is about nothing but
    an engine of the user's own asks nobody else.
    """
    if set(SPACE.table) <= set(pairs) and any(engine in SHIPPED for engine in engines):
        for name in SURVEYS:
            others = (one for one in load_survey(name).engines if one not in SHIPPED or one in engines)
            yield from ((name, engine) for engine in others)


def surveys(ledger: Ledger, engines: Sequence[str], pairs: Sequence[PairKey]) -> Iterator[Task]:
    """Each survey before each of its engines (`surveyed`)."""
    for name, engine in surveyed(engines, pairs):
        every = (w for w in to_replay(ledger, engine) if isinstance(w, CaseWitness))
        again = tuple(witness for witness in every if witness.survey == name)
        yield SurveyTask(name, engine, ledger.live(engine), again)


def versions(engines: Sequence[str], pairs: Sequence[PairKey]) -> dict[str, str]:
    """Of the libraries that surveys will ask, by the names of their engines."""
    return {engine: load_survey(name).engines[engine].version() for name, engine in surveyed(engines, pairs)}


def later_passes(
    pairs: Sequence[PairKey], targets: Sequence[tuple[str, Cell]], seed: int, passes: int | None
) -> Iterator[Task]:
    """Larger and larger passes, without end or up to so many in all, in turn with hunts for every target."""
    hunts, relations = _hunts(targets, seed), _relations(targets, seed)
    for number in range(1, passes) if passes else count(1):
        for done, task in enumerate(_bulk(pairs, seed, number)):
            if done % HUNT_EVERY == 0:
                yield from (other for other in (next(hunts, None), next(relations, None)) if other)
            yield task


def _bulk(pairs: Sequence[PairKey], seed: int, number: int) -> Iterator[Task]:
    least = FEWEST if len(pairs) <= FEW_PAIRS else FIRST_PASS
    each = min(max(FIRST_PASS * 4**number, least), LARGEST_PASS)
    for index in np.random.default_rng([seed, number]).permutation(len(pairs)):
        yield BulkTask(pairs[index], number, each)


def _relations(targets: Sequence[tuple[str, Cell]], seed: int) -> Iterator[Task]:
    """Relations on every pair of every engine, round after round."""
    asked = list(dict.fromkeys((engine, (cell.type_a, cell.type_b)) for engine, cell in targets))
    for number in count() if asked else ():
        for index in np.random.default_rng([seed, number, 2]).permutation(len(asked)):
            engine, pair = asked[int(index)]
            yield RelateTask(engine, pair, number)


def _hunts(targets: Sequence[tuple[str, Cell]], seed: int) -> Iterator[Task]:
    """Attacks on every cell of every engine, round after round."""
    for number in count() if targets else ():
        for index in np.random.default_rng([seed, number, 1]).permutation(len(targets)):
            engine, cell = targets[index]
            yield HuntTask(engine, cell, number)
