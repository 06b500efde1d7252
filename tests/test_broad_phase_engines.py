"""Broad phases under judgement: a pair that is left out is proven missing, and a wrong engine is caught."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import jsonschema
import numpy as np
import pytest

from oracles import plan
from oracles.buckets import Buckets
from oracles.campaign import Campaign
from oracles.crowds.asking import Answer, ask
from oracles.crowds.boxes import REGIMES, BoxCrowd, Pair, crowds
from oracles.crowds.engine import BroadPhaseEngine
from oracles.crowds.failing import MISSING
from oracles.crowds.judging import CrowdCount, judged
from oracles.crowds.repro import crowd_script
from oracles.engines import load_engine
from oracles.fault import Fault, Known, unknown
from oracles.filing import Filing
from oracles.ledger import Ledger
from oracles.opening import wanted_pairs
from oracles.outcome import EntryNote, Run, State
from oracles.tasks import CrowdTask, Task
from refimpl.proof import check
from reports import broad_phase, html, ledgers, markdown
from reports.broad_phase_data import crowd_data, crowd_from
from reports.reading import NoReport, run_from_data
from reports.running import FINISHED, INCOMPLETE, exit_status
from reports.summary import report_data, report_json, schema

COUNT = 24


def axes_of(crowd: BoxCrowd, i: int, j: int) -> list[Fraction]:
    """By how much two boxes overlap along each axis, exactly."""
    c, h = ({n: [Fraction(x) for x in column[n].tolist()] for n in (i, j)} for column in (crowd.center, crowd.half))
    return [h[i][k] + h[j][k] - abs(c[i][k] - c[j][k]) for k in range(3)]


def overlap(crowd: BoxCrowd, i: int, j: int) -> Fraction:
    """The same along the axis on which they overlap least."""
    return min(axes_of(crowd, i, j))


class Exact(BroadPhaseEngine):
    """Right: closed boxes, side by side."""

    calls: ClassVar[str] = "exact"
    closed: ClassVar[bool] = True

    def pairs(self, crowd: BoxCrowd) -> Iterable[Pair]:
        named = self.meet(crowd, crowd.center - crowd.half, crowd.center + crowd.half)
        return [(i, j) for i, j in np.argwhere(named).tolist() if i < j]

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        return np.all((lower[:, None] <= upper[None]) & (lower[None] <= upper[:, None]), axis=-1)


class HalfOpen(Exact):
    """Wrong: boxes that only touch are no pair."""

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        return np.all((lower[:, None] < upper[None]) & (lower[None] < upper[:, None]), axis=-1)


class OneAxisLess(Exact):
    """Slow, not wrong: the third axis is never looked at."""

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        return super().meet(crowd, lower[:, :2], upper[:, :2])


class NextCellOnly(Exact):
    """Wrong: of a grid, only the body's own cell and the next ones above are looked at, not those below."""

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        cell = np.floor(crowd.center / (2 * crowd.half.max()))
        steps = cell[None] - cell[:, None]
        return super().meet(crowd, lower, upper) & np.all((steps >= 0) & (steps <= 1), axis=-1)


class NotUpdated(Exact):
    """Wrong: bodies that were moved are looked for where they were."""

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        return super().meet(crowd, crowd.before - crowd.half, crowd.before + crowd.half)


class OnlyInCrowds(Exact):
    """Wrong: a pair is lost whenever three further bodies are there that begin to the left of it."""

    def meet(self, crowd: BoxCrowd, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        x = crowd.center[:, 0]
        first = np.minimum(x[:, None], x[None])
        return super().meet(crowd, lower, upper) & (np.sum(x < first[..., None], axis=-1) < 3)


@pytest.fixture(scope="module")
def made() -> list[BoxCrowd]:
    return crowds(0, COUNT)


def of_moved(fault: Fault) -> str:
    """What a ledger says that has an entry on bodies that were moved."""
    return "not-followed" * (fault.special == "moved" and fault.symptom == MISSING)


def verdicts(
    solver: BroadPhaseEngine, made: Sequence[BoxCrowd], known: Known = unknown, name: str = "planted"
) -> dict[str, CrowdCount]:
    def asker(some: Sequence[BoxCrowd]) -> list[Answer]:
        return [Answer(frozenset((min(p), max(p)) for p in solver.pairs(crowd))) for crowd in some]

    return {count.regime: count for count in judged(name, solver, made, asker(made), asker, known)}


def test_crowds_are_what_their_regimes_say(made: list[BoxCrowd]) -> None:
    assert len(made) == 2 * len(REGIMES)
    assert {len(crowd) for crowd in made} == {COUNT, 8 * COUNT}
    for crowd in made:
        assert crowd.moved == crowd.regime.endswith("moved")
        assert len(np.unique(crowd.center, axis=0)) == len(crowd)
        assert np.all(crowd.half > 0)
        assert np.all(crowd.half[crowd.balls] == crowd.half[crowd.balls][:, :1])
    again = crowds(0, COUNT)
    assert all(
        np.array_equal(a.center, b.center) and np.array_equal(a.before, b.before)
        for a, b in zip(made, again, strict=True)
    )
    assert not np.array_equal(crowds(1, COUNT)[0].center, made[0].center)


def test_an_exact_broad_phase_is_found_right(made: list[BoxCrowd]) -> None:
    found = verdicts(Exact(), made)
    assert not any(count.wrong or count.extra or count.false_alarms or count.witnesses for count in found.values())
    assert all(count.pairs for regime, count in found.items() if not regime.startswith("flat"))
    assert found["stacked"].pairs > 50  # touching exactly, where nothing is rounded


def test_depths_are_those_of_rational_numbers(made: list[BoxCrowd]) -> None:
    for crowd in made:
        depths, slack = crowd.depths(), crowd.slack()
        for i, j in ((0, 1), (2, 9), (5, 17)):
            assert abs(Fraction(float(depths[i, j])) - overlap(crowd, i, j)) <= Fraction(float(slack[i, j])) / 4


@pytest.mark.parametrize(
    ("solver", "regime"),
    [(HalfOpen(), "stacked"), (NextCellOnly(), "thrown"), (NotUpdated(), "thrown, moved"), (OnlyInCrowds(), "thrown")],
    ids=lambda value: type(value).__name__,
)
def test_a_broad_phase_that_misses_pairs_is_caught(solver: BroadPhaseEngine, regime: str, made: list[BoxCrowd]) -> None:
    count = verdicts(solver, [crowd for crowd in made if crowd.regime == regime])[regime]
    assert count.missing
    assert count.wrong
    (witness,) = count.witnesses
    assert witness.pair is not None
    assert witness.certificate is not None
    i, j = witness.pair
    assert len(witness.crowd) == (5 if isinstance(solver, OnlyInCrowds) else 2)
    assert witness.pair not in {(min(p), max(p)) for p in solver.pairs(witness.crowd)}
    proven = -check(witness.certificate, witness.crowd.box(i), witness.crowd.box(j))[1]
    assert overlap(witness.crowd, i, j) >= proven >= witness.depth >= 0
    assert max(len(repr(x)) for x in witness.crowd.center.ravel().tolist()) < 8 or isinstance(solver, NextCellOnly)


def test_one_axis_less_is_slow_and_not_wrong(made: list[BoxCrowd]) -> None:
    found = verdicts(OneAxisLess(), made)
    assert not any(count.wrong for count in found.values())
    assert found["thrown"].false_alarms == found["thrown"].extra > 10
    assert found["thrown"].widest > 0.5


def test_the_nearest_pair_is_held_against_all_others(made: list[BoxCrowd]) -> None:
    class Nearest(Exact):
        finds_nearest: ClassVar[bool] = True

    crowd = made[0].some(np.arange(12))
    thin = crowd.thinned()
    gaps = {
        (i, j): sum(max(Fraction(0), -gap) ** 2 for gap in axes_of(thin, i, j)) for i in range(12) for j in range(i)
    }
    order = sorted(gaps, key=lambda pair: gaps[pair])
    assert 0 < gaps[order[0]] < gaps[order[1]]
    exact = frozenset((min(p), max(p)) for p in Exact().pairs(crowd))
    for pair, wrong in ((order[0], False), (order[1], True), (None, True)):
        (count,) = judged(
            "planted", Nearest(), [crowd], [Answer(exact, nearest=pair)], lambda some: [Answer()] * len(some)
        )
        assert (count.wrong, count.missing) == (wrong, 0)


def test_a_declared_margin_makes_extra_pairs_no_false_alarms(made: list[BoxCrowd]) -> None:
    class Wide(OneAxisLess):
        margin: ClassVar[float] = 100.0

    count = verdicts(Wide(), made)["thrown"]
    assert count.extra > 10
    assert count.false_alarms == 0


def test_what_the_ledger_explains_is_counted_apart(made: list[BoxCrowd]) -> None:
    count = verdicts(NotUpdated(), made, of_moved)["thrown, moved"]
    assert count.missing == 0
    assert count.known == count.explained["not-followed"] > 3
    assert not count.wrong
    assert [witness.entry for witness in count.witnesses] == ["not-followed"]


def test_lost_crowds_are_wrong_and_say_why(made: list[BoxCrowd]) -> None:
    answers = [Answer(lost="the engine's process was ended by SIGSEGV")] * len(made)
    found = judged("planted", Exact(), made, answers, lambda some: answers[: len(some)])
    assert all(count.lost == 1 and count.wrong and "SIGSEGV" in count.errors[0] for count in found)


# -- real engines, in processes of their own --------------------------------------------------------------------

PLANTED = """
import os, time
from oracles.crowds.engine import BroadPhaseEngine
from oracles.crowds.failing import MISSING
from tests.reference_engine import Reference

class Moody(BroadPhaseEngine):
    calls = "none"
    def pairs(self, crowd):
        print("noise that is no answer")
        if crowd.regime == "crash":
            os.abort()
        if crowd.regime == "raise":
            raise RuntimeError("not today")
        if crowd.regime == "nobody":
            return [(0, 99)]
        if crowd.regime == "fine":
            return [(1, 0), (0, 1), (1, 1)]
        return [(i, j) for i in range(len(crowd)) for j in range(i)]

class Engine(Reference):
    def broad_phase(self):
        return Moody()
"""


def test_an_engine_that_crashes_loses_one_crowd_only(made: list[BoxCrowd], tmp_path: Path) -> None:
    path = tmp_path / "moody.py"
    path.write_text(PLANTED, encoding="utf-8")
    small = made[0].some(np.arange(3))
    asked = [dataclasses.replace(small, regime=name) for name in ("fine", "raise", "crash", "nobody", "fine")]
    fine, raised, crashed, nobody, last = ask(f"{path}:Engine", asked)
    assert fine == last == Answer(frozenset({(0, 1)}))
    assert raised.lost == "RuntimeError: not today"
    assert "SIGABRT" in crashed.lost
    assert nobody.lost == "a pair of bodies that are none"


@pytest.mark.parametrize("name", ["fcl", "bullet"])
def test_shipped_engines_miss_nothing_that_they_promise(name: str, made: list[BoxCrowd]) -> None:
    pytest.importorskip({"fcl": "fcl", "bullet": "pybullet"}[name])
    solver = load_engine(name).broad_phase()
    assert solver is not None
    answers = ask(name, made)
    known = Ledger.load().name_of
    found = {c.regime: c for c in judged(name, solver, made, answers, lambda some: [Answer()] * len(some), known)}
    assert not any(count.wrong for count in found.values())
    assert sum(count.pairs for count in found.values()) > 300
    if name == "fcl":
        assert all(count.nearest == 1 for count in found.values())
        assert not any(count.extra for count in found.values())
        assert found["stacked"].pairs > 50
    else:  # see oracles.engines.bullet_boxes
        assert set(found["huge, moved"].explained) == {"large-bodies-are-not-followed"}
        assert not any(count.known for regime, count in found.items() if regime != "huge, moved")
        assert not any(count.false_alarms for regime, count in found.items() if regime != "huge, moved")


def test_a_campaign_over_all_pairs_asks_broad_phases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Task] = []
    for name, instead in (("_do", lambda _, tasks, until: asked.extend(tasks)), ("certify", None), ("boil_down", None)):
        monkeypatch.setattr(Campaign, name, instead or (lambda _: None))
    monkeypatch.setattr(plan, "replays", lambda *_: iter(()))
    shop = SimpleNamespace(asked=lambda _: [SimpleNamespace(name="planted")])
    filing = SimpleNamespace(buckets=SimpleNamespace(ledger=Ledger()))
    for pairs, wanted in ((None, [CrowdTask("planted"), CrowdTask("limited")]), (["Sphere–Box"], [])):
        asked.clear()
        Campaign(shop, bare_run(), wanted_pairs(pairs), 1, None, filing, None, 1).go()
        assert asked[: len(wanted)] == wanted, "with the ledger's witnesses of crowds, they come first"
        assert len(asked) > len(wanted)
        assert not any(isinstance(task, CrowdTask) for task in asked[len(wanted) :])


def test_what_a_task_finds_is_in_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "moody.py"
    path.write_text(PLANTED, encoding="utf-8")
    monkeypatch.setattr("oracles.tasks.crowds", lambda seed, count: crowds(seed, 6)[:3])
    bench = SimpleNamespace(engine=load_engine(f"{path}:Engine"), spec=f"{path}:Engine", name="moody")
    task = CrowdTask("moody")
    outcome = task.do(SimpleNamespace(bench=lambda name: bench, setup=SimpleNamespace(seed=0)))
    assert outcome.digest
    filing = Filing(bare_run(), Buckets(Ledger()))
    filing.file(task, outcome)
    assert filing.run.crowds == outcome.crowds
    assert [count.regime for count in outcome.crowds] == [crowd.regime for crowd in crowds(0, 6)[:3]]
    assert sum(count.extra for count in outcome.crowds) > 10 > sum(count.missing for count in outcome.crowds) == 0
    assert not task.recorded
    bench.engine = load_engine("pybullet-defaults")
    assert task.do(SimpleNamespace(bench=lambda name: bench)).crowds == []


def two_balls(radius: float) -> BoxCrowd:
    """Two balls that overlap by a radius, of which the engine has both from other places."""
    center, half = np.array([[0.0, 0, 0], [radius, 0, 0]]), np.full((2, 3), radius)
    before = center + np.array([[0.0, 10 * radius, 0], [0, -10 * radius, 0]])
    return BoxCrowd("own", np.ones(2, dtype=bool), center, half, before)


@pytest.mark.parametrize(
    ("name", "radius", "missing"), [("fcl", 1.0, False), ("bullet", 1.0, False), ("bullet", 1e6, True)]
)
def test_a_script_asks_the_engine_alone(name: str, radius: float, missing: bool) -> None:
    solver = load_engine(name).broad_phase()
    assert solver is not None
    script = crowd_script(solver, name, two_balls(radius), (0, 1))
    ran = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=False)
    assert ran.returncode == int(missing), ran.stderr
    assert ("named: []" in ran.stdout) == missing
    assert f"overlap by {radius!r} along" in ran.stdout


# -- the report --------------------------------------------------------------------------------------------------


def bare_run() -> Run:
    return Run(seed=0, budget=1.0, started="2026-03-04T05:06:07Z", engines=["planted", "limited"])


@pytest.fixture(scope="module")
def run(made: list[BoxCrowd]) -> Run:
    found = bare_run()
    some = [crowd for crowd in made if crowd.regime in ("thrown", "thrown, moved", "stacked")]
    found.crowds = [*verdicts(NotUpdated(), some).values()]
    found.crowds += [*verdicts(NotUpdated(), some, of_moved, "limited").values()]
    found.ledger = [EntryNote("limited", "not-followed", "Nothing that moves.", State.EXPECTED, "", 9, 0, ())]
    return found


def test_reports_show_matrix_counts_and_witness(run: Run) -> None:
    texts = markdown.render(run), html.render(run)
    missing = next(count for count in run.crowds if count.missing)
    for page in texts:
        assert "Broad phase" in page
        assert f"✗ {missing.missing} of {missing.pairs} missing" in page
        assert "wrong by a known fault" in page
        assert "not-followed: Nothing that moves." in page.replace("\\", "")
        assert "moved there from" in page
    assert broad_phase.shown(bare_run()) == ()
    assert 'id="broad-phase"' not in html.render(bare_run())


def test_scripts_of_missing_pairs_stand_in_the_folder(made: list[BoxCrowd]) -> None:
    class Told(NotUpdated):
        script: ClassVar[str] = "import math\n\ndef pairs(bodies):\n    return []\n"

    found = bare_run()
    some = [crowd for crowd in made if crowd.regime == "thrown, moved"]
    found.crowds = [*verdicts(Told(), some).values()]
    ((path, script),) = broad_phase.scripts(found).items()
    assert path == "repro/broad-phase-planted-thrown-moved.py"
    assert path in markdown.render(found)
    with pytest.raises(SystemExit) as ended:
        exec(compile(script, path, "exec"), {})
    assert ended.value.code == 1


def test_a_missing_pair_makes_the_run_fail(run: Run) -> None:
    fine = bare_run()
    assert exit_status(fine) == FINISHED
    fine.crowds = [count for count in run.crowds if not count.wrong]
    assert any(count.known for count in fine.crowds)
    ledger = Ledger(own=(Path("own.toml"),))
    assert exit_status(fine, settled=ledgers.settle(fine, ledger, update=False)) == FINISHED
    fine.crowds = run.crowds
    assert exit_status(fine, settled=ledgers.settle(fine, ledger, update=False)) == INCOMPLETE


def test_the_report_as_data_fits_its_schema_and_reads_back(run: Run) -> None:
    data = json.loads(report_json(run))
    jsonschema.validate(data, json.loads(schema()))
    back = run_from_data(data)
    assert [crowd_data(count) for count in back.crowds] == [crowd_data(count) for count in run.crowds]
    old = {name: value for name, value in data.items() if name != "crowds"}
    assert run_from_data(old).crowds == []


@pytest.mark.parametrize("damage", ["depth", "pair", "half", "number"])
def test_a_witness_that_does_not_prove_its_pair_is_refused(run: Run, damage: str) -> None:
    data = json.loads(json.dumps(report_data(run)))
    one = next(item for item in data["crowds"] if item["witnesses"])
    (witness,) = one["witnesses"]
    if damage == "depth":
        witness["depth"] *= 1.01
    elif damage == "pair":
        witness["pair"] = [0, 7]
    elif damage == "half":
        witness["crowd"]["half"] = [[0.01] * 3] * len(witness["crowd"]["half"])
    else:
        one["missing"] = "many"
    with pytest.raises((ValueError, LookupError, TypeError)):
        crowd_from(one)
    with pytest.raises(NoReport, match="damaged"):
        run_from_data(data)
