"""The reference as an engine that is judged like any other: it answers every cell, batches at once."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from oracles.answers import reference_answers
from oracles.engine import (
    COLUMNS,
    NATIVE,
    VELOCITIES,
    WIDTH,
    AnswerRow,
    Answers,
    Engine,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
)
from oracles.impact_reference import reference_of
from oracles.judges import Judges
from oracles.motion import WIDTH as MOTION
from oracles.motion import Motion
from oracles.reference import SEARCH_ERROR
from oracles.scene import BOOLEAN, IMPACT, RAYCAST, Cell, Scene


class Reference(Engine):
    """`refimpl`, with the error of its searches."""

    name: ClassVar[str] = "reference"

    def versions(self) -> dict[str, str]:
        return {}

    def warm(self) -> None:
        pass

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        return NATIVE

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        if query == IMPACT:
            return frozenset(VELOCITIES)
        if query == RAYCAST:
            return frozenset({"hit", "t", "normal", "point"})
        return frozenset({"hit"} if query == BOOLEAN else {"hit", "distance", "on_a", "on_b", "normal"})

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(0.0, 4 * SEARCH_ERROR, "what the audit allows")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        def solve(a: Row, b: Row) -> AnswerRow:
            found = self.answer(query, A, B, np.array([a]), np.array([b]))
            return np.concatenate([np.atleast_1d(getattr(found, name)[0]) for name in COLUMNS]).tolist()  # type: ignore[no-any-return]

        return solve

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        """Answer a batch."""
        if query == IMPACT:
            return reference_of(Motion.unpack(np.asarray(rows_a)[:, -MOTION:]))
        return reference_answers(query, A.unpack(np.asarray(rows_a)), B.unpack(np.asarray(rows_b)))


class FlatReference(Reference):
    """The same in the plane."""

    name: ClassVar[str] = "flat-reference"
    flat: ClassVar[bool] = True


class Desk:
    """A bench whose engine answers in this process: the reference batch by batch, others row by row."""

    def __init__(self, engine: Engine, judges: Any = None) -> None:
        self.engine, self.judges = engine, judges or Judges(engine)

    @property
    def name(self) -> str:
        return self.engine.name

    def renew(self) -> None:
        """An engine of this process remembers nothing."""

    def ask(self, scene: Scene) -> Answers:
        first, second = scene.rows
        return self.answer(scene.cell, (first[None], second[None]))

    def answer(
        self, cell: Cell, rows: tuple[Any, Any], groups: object = None, give_up_after: int | None = None
    ) -> Answers:
        of_cell = cell.query, cell.type_a, cell.type_b
        if isinstance(self.engine, Reference):
            return self.engine.answer(*of_cell, *rows)
        solve, table = self.engine.solver(*of_cell), np.full((len(rows[0]), WIDTH), np.nan)
        for i, (a, b) in enumerate(zip(*(np.asarray(side).tolist() for side in rows), strict=True)):
            table[i] = solve(a, b)
        return Answers.from_table(np.zeros(len(table), dtype=np.int8), table, {})
