"""Tasks: the pieces of work of a campaign, each a pure function of its fields and of the setup.

A task can be done in any process, in any order and again; that is what lets a campaign run anywhere, lose workers
and go on where it ended. What a task finds is filed by the campaign alone (`oracles.campaign`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from threading import Lock, Thread

from oracles.batch import PairKey
from oracles.bench import Setup, Workshop, close_workshop, workshop
from oracles.bulk import bulk
from oracles.clock import watch
from oracles.hunt import hunting
from oracles.library import using
from oracles.outcome import Outcome
from oracles.relating import relating
from oracles.scene import Cell


class Task(ABC):
    """A piece of work; equal tasks have equal outcomes, but for the time they take."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Unique within a campaign, in letters that a file's name can have."""

    @abstractmethod
    def do(self, shop: Workshop) -> Outcome:
        """Do it."""


@dataclass(frozen=True)
class BulkTask(Task):
    """Scenes of every regime of one pair, before every engine that answers it; with an audit of the reference."""

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
        return hunting(shop.bench(self.engine), self.cell, seed=shop.setup.seed + self.number)


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


_one_at_a_time = Lock()
"""Where an executor's workers are threads: benches, caches and Hypothesis belong to one task at a time."""


def perform(task: Task, setup: Setup) -> Outcome:
    """Do a task in this process."""
    with _one_at_a_time:
        shop = workshop(setup)
        with using(shop.library):
            watch.taken()
            before = set(shop.library.lacking)
            outcome = task.do(shop)
            outcome.lacking = shop.library.lacking - before
            outcome.timing = watch.taken()
        return outcome


def release() -> None:
    """Have this process end its engines once its task is done, without waiting for that."""

    def when_idle() -> None:
        with _one_at_a_time:
            close_workshop()

    Thread(target=when_idle, daemon=True).start()
