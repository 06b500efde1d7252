"""Benches: the engines under test as one process holds them, each in a process of its own, with its judges."""

from __future__ import annotations

import atexit
from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from numpy.typing import ArrayLike

from oracles import library
from oracles.clock import timed
from oracles.engine import Answers, Engine
from oracles.engines import load_engine
from oracles.judges import Judges
from oracles.scene import MOVING, Cell, Scene, cells
from oracles.worker import EngineWorker

MANY_EXAMPLES = 150
"""Scenes of an attack, unless told otherwise."""


@dataclass(frozen=True)
class Setup:
    """What a task's result depends on besides the task: it can be sent to any process.

    Attributes
    ----------
    engines
        Names of shipped engines, or ``module:attribute`` of one's own.
    models
        Folder of the models for scenes; by default what PyBullet ships.
    examples
        Scenes that each attack of Hypothesis generates.
    database
        Folder in which Hypothesis keeps what fails, to try it first the next time; by default none.
    """

    engines: tuple[str, ...]
    seed: int = 0
    call_limit: float = 0.5
    models: str | None = None
    examples: int = MANY_EXAMPLES
    database: str | None = None


class Bench:
    """One engine with its worker and its judges."""

    def __init__(self, spec: str, call_limit: float) -> None:
        self.spec, self.call_limit = spec, call_limit
        self._worker: EngineWorker | None = EngineWorker(spec, call_limit)
        self.engine: Engine = load_engine(spec)
        self.judges = Judges(self.engine)

    @property
    def name(self) -> str:
        """The engine's name."""
        return self.engine.name

    @property
    def worker(self) -> EngineWorker:
        """The process that holds the engine; another when it has been closed."""
        if self._worker is None:
            self._worker = EngineWorker(self.spec, self.call_limit)
        return self._worker

    def supports(self, cell: Cell) -> bool:
        """Whether the engine answers this cell."""
        return bool(self.engine.support(cell.query, cell.type_a, cell.type_b))

    def answer(
        self,
        cell: Cell,
        rows: tuple[ArrayLike, ArrayLike],
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> Answers:
        """Have a batch answered (see `EngineWorker.answer`)."""
        with timed(f"engine {self.name}"):
            return self.worker.answer(
                cell.query, cell.type_a, cell.type_b, *rows, groups=groups, give_up_after=give_up_after
            )

    def ask(self, scene: Scene) -> Answers:
        """Have one scene answered."""
        first, second = scene.rows
        return self.answer(scene.cell, (first[None], second[None]))

    def renew(self) -> None:
        """Have the engine forget what it was asked before."""
        if self._worker is not None:
            self._worker.renew()

    def incidents(self) -> Counter[str]:
        """What has happened to the engine's process since this was last asked, in sentences, and how often."""
        found = Counter() if self._worker is None else self._worker.take_incidents()
        return Counter({f"{self.name}: {text}": number for text, number in found.items()})

    def close(self) -> None:
        """End the engine's process; the next question starts another."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None


class Workshop:
    """All that one process needs for its tasks: a bench for each engine, and the models."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.library = library.shipped() if setup.models is None else library.of_user(Path(setup.models))
        self.benches: list[Bench] = []
        with ExitStack() as stack:
            stack.callback(self.rest)
            self.benches += (Bench(spec, setup.call_limit) for spec in setup.engines)
            stack.pop_all()

    def bench(self, name: str) -> Bench:
        """Bench of the engine of that name."""
        return next(bench for bench in self.benches if bench.name == name)

    def asked(self, cell: Cell) -> list[Bench]:
        """Benches of the engines that answer this cell."""
        return [bench for bench in self.benches if bench.supports(cell)]

    @cached_property
    def at_rest(self) -> bool:
        """Whether any engine answers anything about scenes at rest."""
        return any(self.asked(cell) for cell in cells() if cell.query not in MOVING)

    def rest(self) -> None:
        """End the engines' processes; the next question starts others."""
        for bench in self.benches:
            bench.close()


_open: list[Workshop] = []


def workshop(setup: Setup) -> Workshop:
    """Return the workshop of this process; one of another setup is closed."""
    if not (_open and _open[0].setup == setup):
        close_workshop()
        _open.append(Workshop(setup))
    return _open[0]


@atexit.register
def close_workshop() -> None:
    """End the engines of this process."""
    while _open:
        _open.pop().rest()
