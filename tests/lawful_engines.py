"""Engines whose answers are off by a known law, or take a known time; none of it is wrong enough for a finding."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import numpy as np

from oracles.aspect import aspect_of
from oracles.engine import Kind, Row, Solver, Tolerance
from oracles.scene import BOOLEAN, CONTACTS
from refimpl import AABB, Point, Proxy
from tests.wrong_engines import Honest

OF_SIZE, OF_GAP, OF_ASPECT, ALWAYS = 1e-6, 1e-3, 1e-12, 1e-4
BUSY_FOR = 1e-3


class Lawful(Honest):
    """Off by a known law in each cell: of the scene's size, its gap or aspect ratio, or by the same always."""

    name: ClassVar[str] = "lawful"

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(1.0, 1e3, "nothing is wrong enough")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        right = super().solver(query, A, B)
        if query == BOOLEAN:
            return right

        def solve(row_a: Row, row_b: Row) -> Any:
            answer = list(right(row_a, row_b))
            answer[1] += law(query, A.unpack(np.array(row_a)), B.unpack(np.array(row_b)), answer[1])
            return tuple(answer)

        return solve


def law(query: str, a: Proxy, b: Proxy, gap: float) -> float:
    size = float(max(a.magnitude, b.magnitude))
    if query == CONTACTS:
        return -OF_GAP * abs(gap)
    if isinstance(b, AABB):
        return OF_ASPECT * min(float(aspect_of(b)), 1e6) * size
    return ALWAYS if isinstance(a, Point) else OF_SIZE * size


class Busy(Honest):
    """Needs a millisecond of the processor for every answer."""

    name: ClassVar[str] = "busy"

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        right = super().solver(query, A, B)

        def solve(row_a: Row, row_b: Row) -> Any:
            end = time.process_time() + BUSY_FOR
            while time.process_time() < end:
                pass
            return right(row_a, row_b)

        return solve
