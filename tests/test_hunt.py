"""The hunter: finds what is rare, finds one bug beside another, remembers, stops, and brings the same again."""

from __future__ import annotations

import contextlib
import math
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import strategies as st

from oracles import claims
from oracles.bench import Setup
from oracles.engine import VELOCITIES, AnswerRow, Answers, Engine, Kind, Row, Solver, answer_row
from oracles.hunt import hunting
from oracles.motion import WIDTH, Motion
from oracles.outcome import Outcome
from oracles.scene import CONTACTS, DISTANCE, IMPACT, Cell, Scene
from oracles.search import Enough, Search
from oracles.steering import BOOLEAN, NORMAL, VALUE, WITNESS, height, strain
from oracles.tasks import HuntTask
from oracles.worker import EngineWorker
from refimpl.shapes import Box, Point, Sphere
from tests.reference_engine import Desk, Reference
from tests.wrong_engines import Answer, Honest

BALLS = Cell(DISTANCE, Sphere, Sphere)
Spoil = Callable[[Row, Row, Answer], None]


class Planted(Honest):
    """Spoils answers in ways of its own."""

    spoils: ClassVar[tuple[Spoil, ...]] = ()

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        solve = super().solver(query, A, B)

        def spoiled(a: Row, b: Row) -> AnswerRow:
            row = list(solve(a, b))
            answer = {"distance": row[1], "on_a": row[2:5], "on_b": row[5:8], "normal": row[8:11]}
            for spoil in self.spoils:
                spoil(a, b, answer)
            return answer_row(hit=row[0], **answer)

        return spoiled


def planted(*spoils: Spoil) -> Planted:
    made = type("Made", (Planted,), {"spoils": spoils})
    return made()  # type: ignore[no-any-return]


def hunted(engine: Engine, cell: Cell = BALLS, *, seed: int = 1, **options: Any) -> Outcome:
    bench: Any = Desk(engine)
    return hunting(bench, cell, seed=seed, **options)


def symptoms(found: Outcome) -> set[str]:
    return {finding.verdict.symptom for finding in found.findings}


def tried(found: Outcome) -> int:
    return found.hunters["hypothesis"]


# -- more than one bug ---------------------------------------------------------------------------------------


def _loud(a: Row, b: Row, answer: Answer) -> None:
    answer["distance"] += 1.0


def _flipped_when_b_is_larger(a: Row, b: Row, answer: Answer) -> None:
    if b[3] > 1.3 * a[3]:
        answer["normal"] = [-u for u in answer["normal"]]


def _witness_off_when_level(a: Row, b: Row, answer: Answer) -> None:
    if abs(a[2] - b[2]) < 0.05:
        answer["on_a"] = [u + 1e-3 for u in answer["on_a"]]


def _slightly_off_when_small(a: Row, b: Row, answer: Answer) -> None:
    if a[3] < 1e-3:
        answer["distance"] *= 1.0 + 1e-7


def _off_beyond(a: Row, b: Row, answer: Answer) -> None:
    if a[0] > b[0]:
        answer["distance"] += 1.0


def test_a_loud_bug_does_not_hide_a_quiet_one() -> None:
    both = planted(_off_beyond, _witness_off_when_level)
    found = symptoms(hunted(both, examples=100))
    assert {claims.LONG, claims.OFF_SHAPE} <= found


def test_three_bugs_are_found_in_one_run() -> None:
    engine = planted(_off_beyond, _flipped_when_b_is_larger, _witness_off_when_level)
    found = symptoms(hunted(engine, examples=100))
    assert {claims.LONG, claims.OFF_SHAPE} <= found
    assert found & {claims.STUCK, claims.OVERSHOT}


def test_two_errors_of_one_symptom_but_of_other_sizes_are_two() -> None:
    engine = planted(_slightly_off_when_small, _off_when_large)
    found = hunted(engine, examples=100).findings
    decades = {math.floor(math.log10(catch.verdict.amount / catch.scene.size)) for catch in found}
    assert len(decades) > 1


def _off_when_large(a: Row, b: Row, answer: Answer) -> None:
    if a[3] > 1:
        answer["distance"] += 0.1 * a[3]


def _numbers(kinds: Callable[[int], str | None]) -> tuple[list[int], Callable[[int], str | None]]:
    tried: list[int] = []

    def attempt(x: int) -> str | None:
        tried.append(x)
        return kinds(x)

    return tried, attempt


def test_each_round_has_an_exception_type_of_its_own_for_each_kind() -> None:
    """All are raised in one place: types alone keep Hypothesis from taking them for one."""
    _, attempt = _numbers(lambda x: "even" if x % 2 == 0 else "odd" if x > 100 else None)
    found = Search(attempt, 1, 60)
    found.run(st.integers(0, 1000))
    assert found.known == {"even", "odd"}
    assert len({*found._types.values()}) == 2


def test_what_is_rare_is_found_beside_what_is_common() -> None:
    def kind(x: int) -> str | None:
        return "rare" if 500 <= x < 520 else "common" if x % 3 else None

    _, attempt = _numbers(kind)
    found = Search(attempt, 3, 400)
    found.run(st.integers(0, 1000))
    assert found.known == {"rare", "common"}


# -- steering --------------------------------------------------------------------------------------------------


def test_heights_have_a_slope_everywhere_and_order_as_pressures_do() -> None:
    values = [-1e12, -1.0, 0.0, 1e-8, 1e-3, 0.9, 1.0, 1e5]
    heights = [height(v) for v in values]
    assert heights == sorted(heights)
    assert height(0.0) == height(1e-10)
    assert height(10.0) == pytest.approx(1.0)
    assert math.isfinite(height(1e308))


def _of(engine: Engine, scene: Scene) -> dict[str, float]:
    rows = tuple(row[None] for row in scene.rows)
    return dict(strain(engine, scene, Desk(engine).answer(scene.cell, rows)).pressures)


def test_pressures_name_each_claim_of_an_answer() -> None:
    scene = Scene(DISTANCE, Sphere([0, 0, 0], 1.0), Sphere([3, 0, 0], 1.0), "here")
    right = _of(Honest(), scene)
    assert max(right.values()) < 1
    off = _of(planted(_loud), scene)
    assert off[claims.LONG] == pytest.approx(1 / 3e-12, rel=1e-6)
    assert off[claims.SHORT] < 0
    assert off[claims.OFF_SHAPE] < 1


class Stale(Reference):
    """Tells the velocities before the impact."""

    def answer(self, query: str, A: Kind, B: Kind, rows_a: Any, rows_b: Any) -> Answers:
        motion = Motion.unpack(np.asarray(rows_a)[:, -WIDTH:])
        answers = super().answer(query, A, B, rows_a, rows_b)
        a, b = motion.bodies
        before = a.velocity, a.angular_velocity, b.velocity, b.angular_velocity
        return replace(answers, **dict(zip(VELOCITIES, before, strict=True)))


def test_pressures_of_impacts_name_laws() -> None:
    from oracles.batch import Batch  # noqa: PLC0415

    (batch,) = Batch.draw_impacts((Sphere, Sphere), 1, (0,), 1)
    scene = batch.scene(IMPACT, 0)
    assert max(_of(Reference(), scene).values()) < 1
    assert max(_of(Stale(), scene).values()) > 1


def test_what_is_known_is_not_climbed(monkeypatch: pytest.MonkeyPatch) -> None:
    told: dict[str, float] = {}
    monkeypatch.setattr("oracles.steering.target", lambda score, label: told.update({label: score}))
    scene = Scene(DISTANCE, Sphere([0, 0, 0], 1.0), Sphere([3, 0, 0], 1.0), "here")
    engine = planted(_loud)
    answers = Desk(engine).answer(scene.cell, tuple(row[None] for row in scene.rows))
    strain(engine, scene, answers).steer(set())
    assert set(told) == {VALUE, NORMAL, WITNESS}
    assert BOOLEAN not in told
    loud = told[VALUE]
    told.clear()
    strain(engine, scene, answers).steer({claims.LONG})
    assert told[VALUE] < 0 < loud


# -- memory ----------------------------------------------------------------------------------------------------


def test_a_second_run_finds_old_failures_at_once(tmp_path: Path) -> None:
    engine = planted(_off_beyond, _witness_off_when_level)
    first = hunted(engine, examples=100, database=tmp_path)
    assert {claims.LONG, claims.OFF_SHAPE} <= symptoms(first)
    again = hunted(engine, seed=99, examples=1, database=tmp_path)
    assert {claims.LONG, claims.OFF_SHAPE} <= symptoms(again)
    assert tried(again) < 60
    assert symptoms(hunted(Honest(), examples=1, database=tmp_path)) == set()


def test_the_attacks_of_a_campaign_have_a_folder_for_each_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What one attack has kept another one with another seed tries first, in its own cell only."""
    engine, kept = planted(_off_beyond, _witness_off_when_level), tmp_path / "kept"
    monkeypatch.setattr(type(engine), "name", "../../made")

    def attack(cell: Cell, seed: int, examples: int) -> Outcome:
        setup = Setup((), seed=seed, examples=examples, database=str(kept))
        shop: Any = SimpleNamespace(setup=setup, bench=lambda name: Desk(engine))
        return HuntTask(engine.name, cell, 0).do(shop)

    attack(BALLS, 1, 100)
    assert {claims.LONG, claims.OFF_SHAPE} <= symptoms(attack(BALLS, 99, 1))
    assert symptoms(attack(Cell(DISTANCE, Point, Sphere), 99, 1)) == set()
    assert list(tmp_path.iterdir()) == [kept]
    assert [len(folder.name) for folder in kept.iterdir()] == [12], "where nothing fails there is nothing to keep"


def test_without_a_database_the_seed_says_it_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    engine = planted(_off_beyond, _witness_off_when_level)
    first, second = (hunted(engine, seed=7, examples=100) for _ in range(2))
    assert [c.scene.id for c in first.findings] == [c.scene.id for c in second.findings]
    assert (first.counts, first.digest) == (second.counts, second.digest)
    assert list(tmp_path.iterdir()) == []


# -- stopping --------------------------------------------------------------------------------------------------


def test_ctrl_c_that_a_callback_swallowed_ends_the_search_all_the_same() -> None:
    tried = []

    def attempt(x: int) -> str | None:
        tried.append(x)
        if len(tried) == 5:
            with contextlib.suppress(
                KeyboardInterrupt
            ):  # as in a callback of the garbage collector, where exceptions are lost
                signal.raise_signal(signal.SIGINT)
        return None

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        Search(attempt, 1, 1000).run(st.integers())
    assert len(tried) == 5
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("at", [1, 3])
def test_ctrl_c_ends_a_search_that_shrinks(at: int) -> None:
    tried = []

    def attempt(x: int) -> str | None:
        tried.append(x)
        if x > 10:
            attempt.found += 1  # type: ignore[attr-defined]
            if attempt.found == at:  # type: ignore[attr-defined]
                signal.raise_signal(signal.SIGINT)
            return "large"
        return None

    attempt.found = 0  # type: ignore[attr-defined]
    with pytest.raises(KeyboardInterrupt):
        Search(attempt, 1, 1000).run(st.integers(0, 10**9))
    assert len(tried) < 200


def test_enough_is_enough() -> None:
    tried = []

    def attempt(x: int) -> str | None:
        tried.append(x)
        if len(tried) >= 7:
            raise Enough
        return "odd" if x % 2 else None

    Search(attempt, 1, 1000).run(st.integers())
    assert len(tried) == 7


def test_errors_of_the_harness_itself_are_no_findings() -> None:
    def attempt(x: int) -> str | None:
        raise ZeroDivisionError("a mistake of ours")

    with pytest.raises(ZeroDivisionError):
        Search(attempt, 1, 10).run(st.integers())


def test_examples_and_steps_are_counted() -> None:
    tried, attempt = _numbers(lambda x: "large" if x > 1000 else None)
    Search(attempt, 1, 50, patience=10).run(st.integers(0, 10**9))
    assert 50 <= len(tried) <= 50 + 12


def test_an_answer_that_depends_on_earlier_calls_is_remembered() -> None:
    calls = iter(range(10**6))

    def attempt(x: int) -> str | None:
        return "now and then" if next(calls) % 7 == 6 else None

    found = Search(attempt, 1, 100)
    found.run(st.integers())
    assert found.known == {"now and then"}


@pytest.mark.parametrize("cell", [Cell(DISTANCE, Point, Sphere), Cell(CONTACTS, Sphere, Sphere)])
def test_a_right_engine_is_let_be(cell: Cell) -> None:
    found = hunted(Honest(), cell, examples=60)
    assert found.findings == []
    assert tried(found) >= 55


def test_steering_knows_the_conventions_of_an_engine() -> None:
    """On the shapes that Bullet effectively uses, a rounded edge is no error to be climbed."""
    pytest.importorskip("pybullet")
    from oracles.engines import load_engine  # noqa: PLC0415

    engine = load_engine("bullet")
    scene = Scene(
        DISTANCE, Sphere([2.0, 2.0, 2.0], 0.5), Box([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]), "here"
    )
    with EngineWorker("bullet", 0.5) as worker:
        rows = (row[None] for row in scene.rows)
        answers = worker.answer(scene.query, scene.cell.type_a, scene.cell.type_b, *rows)
    assert abs(answers.distance[0] - (math.sqrt(3) - 0.5)) > 1e-4
    found = strain(engine, scene, answers)
    assert found.worst < 1
    assert not found.calm
