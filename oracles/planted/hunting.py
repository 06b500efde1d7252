"""The hunter's own test: a campaign against an engine that is wrong on purpose, and what it has to say of it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from oracles.campaign import run_campaign
from oracles.clumsiness import clumsiness, odd_numbers
from oracles.engine import Engine
from oracles.ledger import Ledger
from oracles.outcome import Bucket, Run
from oracles.planted.mutant import Mutant
from oracles.planted.textbook import Textbook
from oracles.scene import Scene, cells

FOREVER = 1e9
"""Seconds: an end is set by other means."""
MOST_BUCKETS = 2
MOST_ODD = 3
"""A witness is small when no more of its numbers are others than 0, 1, −1, 0.5 and 2."""


def supported_pairs(engine: Engine) -> list[str]:
    """Names of the pairs that an engine answers in any query."""
    return sorted({c.pair for c in cells() if engine.support(c.query, c.type_a, c.type_b)})


@dataclass
class Enough:
    """Ends a campaign some time after its first finding, so that it has time for others of the same cause."""

    settle: float
    first: float | None = None
    """Seconds to the first finding."""
    _start: float = field(default_factory=time.monotonic)

    def __call__(self, run: Run) -> bool:
        """Whether the campaign has found enough."""
        elapsed = time.monotonic() - self._start
        if self.first is None and run.buckets:
            self.first = elapsed
        return self.first is not None and elapsed >= self.first + self.settle


@dataclass(frozen=True)
class Hunted:
    """What became of the hunt for one wrong engine.

    Attributes
    ----------
    seconds
        To the first finding, from the start of the campaign; None when nothing was found.
    """

    mutant: Mutant
    seconds: float | None
    buckets: list[Bucket]
    problems: list[str]

    @property
    def found(self) -> bool:
        """Whether anything was found in the right cell."""
        return any((b.query, b.pair) == (self.mutant.query, self.mutant.pair) for b in self.buckets)

    @property
    def named(self) -> bool:
        """Whether every finding has the right cell, and a symptom that names the fault."""
        mutant = self.mutant
        return self.found and all(
            (b.query, b.pair) == (mutant.query, mutant.pair) and b.symptom in mutant.symptoms for b in self.buckets
        )

    @property
    def gathered(self) -> bool:
        """Whether the findings are in few buckets."""
        return len(self.buckets) <= MOST_BUCKETS

    @property
    def witnesses(self) -> list[Scene]:
        """The buckets' witnesses, the simplest first."""
        return sorted((bucket.witness.scene for bucket in self.buckets), key=clumsiness)

    @property
    def small(self) -> int:
        """How many of them are small to a person's eye."""
        return sum(odd_numbers(scene) <= MOST_ODD for scene in self.witnesses)

    @property
    def faults(self) -> list[str]:
        """What the hunter did not do as it should."""
        if not self.found:
            return ["not found"]
        wrong = [] if self.named else ["not named rightly"]
        return wrong if self.gathered else [*wrong, f"{len(self.buckets)} buckets"]


def hunted(mutant: Mutant, *, budget: float, settle: float, seed: int = 0, pairs: Sequence[str] = ()) -> Hunted:
    """Run a campaign on one wrong engine.

    Parameters
    ----------
    budget
        Seconds until which it has to be found.
    settle
        Seconds for which the campaign goes on after that.
    pairs
        All that the engine answers, by default.
    """
    enough = Enough(settle)
    run = run_campaign(
        [mutant.spec],
        budget=budget,
        seed=seed,
        pairs=list(pairs) or supported_pairs(Textbook()),
        ledger=Ledger(),
        enough=enough,
    )
    return Hunted(mutant, enough.first, run.buckets, run.problems)


def questioned(*, scenes: int, seed: int) -> Run:
    """Put so many scenes before the engine that is right."""
    return run_campaign(
        [f"{Textbook.__module__}:{Textbook.__name__}"],
        budget=FOREVER,
        seed=seed,
        pairs=supported_pairs(Textbook()),
        ledger=Ledger(),
        enough=lambda run: run.hunters.total() >= scenes,
    )
