"""Engines that answer sweeps in this process: the reference, and others that are wrong on purpose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from oracles.course import WIDTH as COURSE
from oracles.course import Course
from oracles.engine import (
    NATIVE,
    WIDTH,
    AnswerRow,
    Answers,
    Engine,
    Kind,
    Row,
    Solver,
    Status,
    Support,
    Tolerance,
    answer_row,
    unsupported,
)
from refimpl import Proxy, Sphere, distance, sweep
from refimpl.linear import norm
from refimpl.motions import RigidMotion
from refimpl.shapes import Box

STEPS = 10
LARGER = 1.01


class Sweeper(Engine):
    """Right in every sweep, with room for rounding only."""

    name: ClassVar[str] = "sweeper"

    def versions(self) -> dict[str, str]:
        return {"sweeper": "1"}

    def warm(self) -> None:
        pass

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        return unsupported("sweeps only")

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        return frozenset({"hit", "t", "point", "normal"})

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(1e-9, 1e-9, "Newton's method")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        def solve(row_a: Row, row_b: Row) -> AnswerRow:
            course = Course.unpack(np.array(row_a[-COURSE:]))
            return self.swept(A.unpack(np.array(row_a[:-COURSE])), B.unpack(np.array(row_b)), course)

        return solve

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        """Answer one sweep."""
        found = sweep(a, b, *course.motions)
        if not found.hit:
            return answer_row(hit=0.0, t=np.inf)
        return answer_row(hit=1.0, t=float(found.t), point=found.point.tolist(), normal=found.normal.tolist())


def changed(row: AnswerRow, **values: Any) -> AnswerRow:
    """A hit with something changed; a miss as it is."""
    if row[0] != 1.0:
        return row
    return answer_row(**({"hit": 1.0, "t": row[11], "point": row[12:15], "normal": row[8:11]} | values))


class Stepping(Sweeper):
    """Looks at ten times only, so that what is thin or fast goes through."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        for k in range(STEPS + 1):
            found = distance(*course.at(a, b, k / STEPS))
            if found.distance <= 0:
                row = {"hit": 1.0, "t": k / STEPS, "point": found.on_a.tolist(), "normal": found.normal.tolist()}
                return answer_row(**row)
        return answer_row(hit=0.0, t=np.inf)


class Bounding(Sweeper):
    """Sweeps the ball around A."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        assert isinstance(a, Box)
        return super().swept(Sphere(a.center, norm(a.half_extents)), b, course)


class Deaf(Sweeper):
    """Takes A to be at rest."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        return super().swept(a, b, Course(REST, course.b))


class InLengths(Sweeper):
    """Answers the way in place of the time."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        row = super().swept(a, b, course)
        return changed(row, t=row[11] * float(norm(course.a.linear - course.b.linear)))


class Flipped(Sweeper):
    """Its normal points from B to A."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        row = super().swept(a, b, course)
        return changed(row, normal=[-u for u in row[8:11]])


class AtStart(Sweeper):
    """Its point is where it was on B at the start."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        row = super().swept(a, b, course)
        back = (row[11] if row[0] == 1.0 else 0.0) * course.b.linear
        return changed(row, point=(np.array(row[12:15]) - back).tolist())


class Padded(Sweeper):
    """A is larger by a hundredth."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        assert isinstance(a, Sphere)
        return super().swept(Sphere(a.center, LARGER * a.radius), b, course)


class Outside(Sweeper):
    """Does not look at t = 0: what overlaps from the start never meets."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        if distance(a, b).distance < 0:
            return answer_row(hit=0.0, t=np.inf)
        return super().swept(a, b, course)


class Scaled(Sweeper):
    """Its normal is as long as the way."""

    def swept(self, a: Proxy, b: Proxy, course: Course) -> AnswerRow:
        row = super().swept(a, b, course)
        return changed(row, normal=(np.array(row[8:11]) * float(norm(course.a.linear))).tolist())


REST = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))


def answers_of(engine: Engine, query: str, kinds: tuple[Kind, Kind], rows: Sequence[Any]) -> Answers:
    """Have an engine answer a batch, row by row, here."""
    solve = engine.solver(query, *kinds)
    table = np.array([solve(a.tolist(), b.tolist()) for a, b in zip(*rows, strict=True)])
    return Answers.from_table(np.full(len(table), Status.ANSWERED, dtype=np.int8), table.reshape(-1, WIDTH), {})
