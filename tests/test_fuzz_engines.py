"""Hypothesis fuzzes every supported cell of FCL and PyBullet: each answer is right, or a known fault with a reason.

``pytest tests/test_fuzz_engines.py --hypothesis-profile=thorough`` hunts a hundred times longer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import pytest
from hypothesis import Phase, given, note, settings, target

from oracles.engine import Engine
from oracles.engines import load_engine
from oracles.judge import Judge
from oracles.ledger import Ledger
from oracles.outcome import FINDINGS, Kind
from oracles.reference import is_quick
from oracles.scene import MOVING, Cell, Scene, cells
from oracles.strategies import scenes
from oracles.worker import EngineWorker
from refimpl import Proxy
from refimpl.pairs import TABLE
from tests.conftest import name_of

ENGINES: dict[str, Engine] = {name: load_engine(name) for name in ("fcl", "bullet")}
JUDGES = {name: Judge(engine) for name, engine in ENGINES.items()}
KNOWN = Ledger.load()
AT_REST = [c for c in cells() if c.query not in MOVING]
"""Impacts and sweeps have scenes of their own: see test_impact_engines, test_sweep_engines."""
SUPPORTED = [(name, c) for name, e in ENGINES.items() for c in AT_REST if e.support(c.query, c.type_a, c.type_b)]
Pair = tuple[type[Proxy], type[Proxy]]


@pytest.fixture(scope="module")
def workers() -> Iterator[dict[str, EngineWorker]]:
    running = {name: EngineWorker(name, call_limit=0.3) for name in ENGINES}
    yield running
    for worker in running.values():
        worker.close()


def examples(pair: Pair) -> int:
    """Pairs that need a search or pieces cost a hundred times more each."""
    many = settings.default.max_examples if settings.default else 20
    return max(8, many // 2 - 2) if is_quick(*pair) else max(5, many // 4)


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_each_answer_is_right_or_a_known_fault(pair: Pair, workers: dict[str, EngineWorker]) -> None:
    """One scene is put before both engines in every query that they support, so that the reference is asked once.

    What fails is not shrunk here, which would take minutes: the campaign's hunters do that.
    """
    asked = [(name, cell) for name, cell in SUPPORTED if (cell.type_a, cell.type_b) == pair]
    compared: Counter[tuple[str, Cell]] = Counter()

    @settings(max_examples=examples(pair), phases=(Phase.generate, Phase.target))
    @given(scene=scenes(Cell("distance", *pair)))
    def fuzz(scene: Scene) -> None:
        pressure = 0.0
        for name, cell in asked:
            kind, error = answered(name, Scene(cell.query, scene.a, scene.b, scene.regime, scene.source), workers)
            compared[name, cell] += kind is not Kind.UNSUPPORTED
            pressure = max(pressure, error)
        target(min(pressure, 1e300))

    fuzz()
    assert all(compared[key] >= 4 for key in asked), compared


def answered(name: str, scene: Scene, workers: dict[str, EngineWorker]) -> tuple[Kind, float]:
    """Verdict on an engine's answer, which must be right or known, and its error relative to the tolerance."""
    cell, judge = scene.cell, JUDGES[name]
    a, b = scene.a[None], scene.b[None]
    answers = workers[name].answer(cell.query, cell.type_a, cell.type_b, a.pack(), b.pack())
    screening = judge.screen(cell, a, b, answers)
    kind, pressure = screening.kind[0], float(screening.pressure[0])
    if kind in FINDINGS:
        verdict = judge.convict(scene, answers)
        kind = verdict.kind
        assert kind is not Kind.REFERENCE_WRONG, f"{verdict.claim}\n{scene.to_json()}"
        if kind in FINDINGS:
            note(f"{name} {scene!r}")
            assert KNOWN.match(name, scene, verdict), f"{verdict.claim}\n{scene.to_json()}"
    return kind, pressure


def test_all_cells_are_asked_or_said_to_be_unsupported() -> None:
    for name, engine in ENGINES.items():
        for cell in AT_REST:
            support = engine.support(cell.query, cell.type_a, cell.type_b)
            assert bool(support) == ((name, cell) in SUPPORTED)
            assert support or support.reason
    assert len(SUPPORTED) > 280
