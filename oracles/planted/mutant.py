"""How an engine is made wrong: one step of the textbook engine is replaced, and only in the cell that it names."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, TypeVar

from oracles.engine import Kind, Solver
from oracles.judge import CRASHED, TIMED_OUT
from oracles.planted.textbook import Textbook
from oracles.scene import Cell


class Planted(Textbook):
    """Wrong in one cell; in all others the textbook engine itself answers."""

    query: ClassVar[str]
    pair: ClassVar[str]
    remembers: ClassVar[bool] = False
    """Whether an answer depends on what was asked before: then it need not be wrong again."""

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Return the wrong function in its cell, and the right one in all others."""
        wrong = query == self.query and Cell(query, A, B).pair == self.pair
        return super().solver(query, A, B) if wrong else Textbook().solver(query, A, B)


@dataclass(frozen=True)
class Mutant:
    """A wrong engine, and what a hunter has to say of it.

    Attributes
    ----------
    name
        Of the class, in small letters with hyphens.
    what
        What was changed, in a sentence.
    query, pair
        The cell in which the findings have to be, all of them.
    symptoms
        The judge's words that name the fault, the most frequent one first.
    """

    name: str
    engine: type[Planted]
    what: str
    query: str
    pair: str
    symptoms: tuple[str, ...]

    @property
    def comes_back(self) -> bool:
        """Whether the process that asks survives the answer."""
        return not {CRASHED, TIMED_OUT} & set(self.symptoms)

    @property
    def spec(self) -> str:
        """Name for `load_engine`."""
        return f"{self.engine.__module__}:{self.engine.__qualname__}"


MUTANTS: dict[str, Mutant] = {}
"""Every wrong engine by its name, once its module has been imported."""

Class = TypeVar("Class", bound=type[Planted])


def wrong(query: str, pair: str, *symptoms: str) -> Callable[[Class], Class]:
    """Register an engine that is wrong in this cell, by these symptoms; its docstring says what was changed."""

    def register(engine: Class) -> Class:
        name = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "-", engine.__name__).lower()
        engine.name, engine.query, engine.pair = name, query, pair
        what = (engine.__doc__ or "").strip().splitlines()[0]
        assert name not in MUTANTS, name
        MUTANTS[name] = Mutant(name, engine, what, query, pair, symptoms)
        return engine

    return register
