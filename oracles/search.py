"""Hypothesis as a searcher for many different failures: the loudest may not hide the others.

Hypothesis stops generating soon after its first failure, and shrinks that. So a search goes in rounds: each ends with
one failure, and the rounds after it take failures of its kind for successes. Nothing here depends on a clock.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar
from unittest import SkipTest

import hypothesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.configuration import set_hypothesis_home_dir
from hypothesis.database import DirectoryBasedExampleDatabase
from hypothesis.strategies import SearchStrategy

from oracles.interrupts import remembered

T = TypeVar("T")

FEWEST = 5
"""A round is worth it with so many examples left."""
PATIENCE = 25
"""Steps of shrinking a failure; whoever needs it smaller has better means."""
HOME = "proxyproof-hypothesis"


class Caught(AssertionError):
    """A failure; each kind has a subclass of its own, or Hypothesis would merge them: they are raised in one place."""


class Enough(BaseException):
    """The search has had its share; no `Exception`, because Hypothesis would take that for a failure."""


class _Shrunk(BaseException):
    """The round has had its share."""


@dataclass
class Search(Generic[T]):
    """A search for examples of as many kinds of failures as there are.

    Parameters
    ----------
    attempt
        Tries an example, and answers the kind of its failure, or None. It may raise `Enough`.
    seed
        The same brings the same, but for what a database holds.
    examples
        How many are generated, in all rounds; those of shrinking are not counted.
    database
        Folder in which failures are kept, of this search alone; they are tried first.

    Attributes
    ----------
    known
        Kinds that earlier rounds have found.
    """

    attempt: Callable[[T], str | None]
    seed: int
    examples: int
    patience: int = PATIENCE
    database: Path | None = None
    known: set[str] = field(default_factory=set)
    _types: dict[str, type[Caught]] = field(default_factory=dict)
    _current: str | None = None
    _left: int = 0
    _steps: int = 0

    def run(self, strategy: SearchStrategy[T]) -> None:
        """Search; what is found is what `attempt` remembers."""
        set_hypothesis_home_dir(Path(tempfile.gettempdir()) / HOME)  # not in the caller's folder
        self._left, number = self.examples, 0
        with remembered() as pressed:
            try:
                if self.database is not None:
                    self._replay(strategy, pressed)
                while self._left >= FEWEST and self._round(strategy, number, pressed):
                    number += 1
            except Enough:
                pass

    def _replay(self, strategy: SearchStrategy[T], pressed: list[int]) -> None:
        """Try what the database holds; each kind that fails still is known from then on."""

        def again(example: T) -> None:
            _heed(pressed)
            kind = self.attempt(example)
            if kind is not None:
                self.known.add(kind)
                raise self._type(kind)

        self._let(again, strategy, (Phase.reuse,), str(self.seed), max(self._left, 1))

    def _round(self, strategy: SearchStrategy[T], number: int, pressed: list[int]) -> bool:
        """Search for a failure of a kind that is not known; whether there was one."""
        self._current, self._steps = None, 0

        def step(example: T) -> None:
            _heed(pressed)
            self._count()
            kind = self.attempt(example)
            if kind is None or kind in self.known or self._current not in (None, kind):
                return
            self._current = kind
            raise self._type(kind)

        phases = (Phase.generate, Phase.target, Phase.shrink)
        self._let(step, strategy, phases, f"{self.seed}/{number}", self._left)
        if self._current is None:
            return False
        self.known.add(self._current)
        return True

    def _count(self) -> None:
        if self._current is None:
            self._left -= 1
            if self._left < 0:
                raise _Shrunk
        else:
            self._steps += 1
            if self._steps > self.patience:
                raise _Shrunk

    def _type(self, kind: str) -> type[Caught]:
        return self._types.setdefault(kind, type(f"Caught {kind}", (Caught,), {}))

    def _let(
        self,
        step: Callable[[T], None],
        strategy: SearchStrategy[T],
        phases: tuple[Phase, ...],
        seed: str,
        examples: int,
    ) -> None:
        """Have Hypothesis call `step`; failures end it, and are no news."""
        kept = None if self.database is None else DirectoryBasedExampleDatabase(self.database)

        @settings(
            max_examples=examples,
            database=kept,
            deadline=None,
            phases=phases,
            suppress_health_check=list(HealthCheck),
            report_multiple_bugs=Phase.reuse in phases,  # or generation goes on, for up to ten seconds of the clock
            print_blob=False,
        )
        @hypothesis.seed(seed)  # below the settings: it takes the database away
        @given(example=strategy)
        def search(example: T) -> None:
            step(example)

        try:
            search()
        except (Caught, BaseExceptionGroup) as raised:
            _only_caught(raised)
        except (_Shrunk, SkipTest, hypothesis.errors.Flaky):
            pass  # nothing in the database; an answer that depends on earlier calls: what was proven is remembered


def _only_caught(found: BaseException) -> None:
    """Raise again whatever in a group is not ours."""
    if isinstance(found, BaseExceptionGroup):
        _, rest = found.split((Caught, Enough, _Shrunk, hypothesis.errors.Flaky))
        if rest is not None:
            raise rest


def _heed(pressed: list[int]) -> None:
    if pressed:
        raise KeyboardInterrupt
