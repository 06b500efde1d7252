"""Hypothesis fuzzes every supported cell of FCL and PyBullet: each answer is right, or a known fault with a reason.

``pytest tests/test_fuzz_engines.py --hypothesis-profile=thorough`` hunts a hundred times longer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import pytest
from hypothesis import given, note, target

from oracles.engine import Engine
from oracles.engines import load_engine
from oracles.judge import Judge
from oracles.known import KnownFaults
from oracles.outcome import FINDINGS, Kind
from oracles.scene import Cell, Scene, cells
from oracles.strategies import scenes
from oracles.worker import EngineWorker

ENGINES: dict[str, Engine] = {name: load_engine(name) for name in ("fcl", "bullet")}
KNOWN = KnownFaults.shipped()
SUPPORTED = [(name, c) for name, e in ENGINES.items() for c in cells() if e.support(c.query, c.type_a, c.type_b)]


@pytest.fixture(scope="module")
def workers() -> Iterator[dict[str, EngineWorker]]:
    running = {name: EngineWorker(name, call_limit=1.0) for name in ENGINES}
    yield running
    for worker in running.values():
        worker.close()


def cell_name(cell: object) -> str:
    return f"{cell.query}-{cell.pair}" if isinstance(cell, Cell) else str(cell)


@pytest.mark.parametrize(("name", "cell"), SUPPORTED, ids=cell_name)
def test_each_answer_is_right_or_a_known_fault(name: str, cell: Cell, workers: dict[str, EngineWorker]) -> None:
    judge, worker, compared = Judge(ENGINES[name]), workers[name], Counter[Kind]()

    @given(scene=scenes(cell))
    def fuzz(scene: Scene) -> None:
        rows = scene.a[None].pack(), scene.b[None].pack()
        answers = worker.answer(cell.query, cell.type_a, cell.type_b, *rows)
        screening = judge.screen(cell, scene.a[None], scene.b[None], answers)
        target(float(min(screening.pressure[0], 1e300)))
        kind = screening.kind[0]
        verdict = judge.convict(scene, answers) if kind in FINDINGS else None
        compared[verdict.kind if verdict else kind] += 1
        if verdict is not None and verdict.kind in FINDINGS:
            note(f"{scene!r}")
            assert KNOWN.reason(name, scene, verdict), f"{verdict.claim}\n{scene.to_json()}"

    fuzz()
    assert sum(compared.values()) >= 10
    assert not compared[Kind.REFERENCE_WRONG]


def test_all_cells_are_asked_or_said_to_be_unsupported() -> None:
    for name, engine in ENGINES.items():
        for cell in cells():
            support = engine.support(cell.query, cell.type_a, cell.type_b)
            assert bool(support) == ((name, cell) in SUPPORTED)
            assert support or support.reason
    assert len(SUPPORTED) > 80
