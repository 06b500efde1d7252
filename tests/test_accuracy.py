"""Errors by rank: engines with planted laws of error must give exactly these, in memory, from a record and resumed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pytest

from oracles.accuracy import ABSOLUTE, ASPECT, GAP, RELATIVE, SCALE, Errors, Extreme, Point, Spread, keep_worst
from oracles.answers import reference_answers, reference_for, take
from oracles.aspect import aspect_of
from oracles.buckets import Buckets
from oracles.campaign import run_campaign
from oracles.draws import NumpyDraws
from oracles.engine import COLUMNS, WIDTH, Answers, Status
from oracles.filing import Filing
from oracles.impact_regimes import IMPACT_REGIMES
from oracles.judges import Judges
from oracles.ledger import Ledger
from oracles.looks import look
from oracles.measuring import Measured
from oracles.outcome import Kind as Verdict
from oracles.outcome import Run
from oracles.regimes import REGIMES
from oracles.rules import Rules
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, Cell, Scene
from oracles.screening import screen
from oracles.store import FOLDER
from oracles.worker import EngineWorker
from refimpl import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Proxy,
    Ray,
    Sphere,
)
from refimpl import Point as PointProxy
from tests.lawful_engines import ALWAYS, BUSY_FOR, OF_ASPECT, OF_GAP, OF_SIZE, Busy, Lawful
from tests.test_judge import Exact, Grown, NoDepth
from tests.wrong_engines import spec

PAIRS = ["Sphere–Sphere", "Point–Sphere", "Sphere–AABB"]
REFERENCE = 2e-14
"""What the reference may err by, and what rounding the planted sums costs, relative to the scene's size."""


def campaign(**options: Any) -> Run:
    return run_campaign([spec(Lawful)], budget=60, seed=5, passes=1, pairs=PAIRS, ledger=Ledger(), **options)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("record")


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    found = campaign(folder=folder)
    assert found.problems == []
    assert found.buckets == []
    return found


def errors(run: Run, query: str, pair: str, regime: str = "") -> Errors:
    (row,) = [row for row in run.accuracy.errors if (row.query, row.pair, row.regime) == (query, pair, regime)]
    return row


def spread(errors: Spread | None) -> list[float]:
    assert errors is not None
    return [errors.median, errors.p99, errors.worst]


def curve(folder: Path, pair: str, query: str, axis: str) -> list[Point]:
    """Points of one pair alone."""
    files = list((folder / FOLDER).glob(f"bulk-*-{pair.replace('–', '-')}.*.parquet"))
    with Measured(files, []) as measured:
        return [point for point in measured.points() if (point.query, point.axis) == (query, axis)]


# -- planted laws --------------------------------------------------------------------------------------------


def test_an_error_of_a_millionth_of_the_size_is_told_as_that_in_every_regime(run: Run) -> None:
    for regime in ("", *REGIMES):
        row = errors(run, DISTANCE, "Sphere–Sphere", regime)
        np.testing.assert_allclose(spread(row.relative), OF_SIZE, rtol=2 * REFERENCE / OF_SIZE)
        assert (row.answers, row.lost) == (row.valued, 0)
    assert errors(run, DISTANCE, "Sphere–Sphere").answers == sum(
        errors(run, DISTANCE, "Sphere–Sphere", regime).answers for regime in REGIMES
    )


def test_an_error_that_is_always_the_same_is_told_as_that(run: Run) -> None:
    row = errors(run, DISTANCE, "Point–Sphere")
    assert row.absolute is not None
    assert row.absolute.median == pytest.approx(ALWAYS, rel=1e-9)
    assert row.absolute.p99 == pytest.approx(ALWAYS, rel=1e-6)


def test_only_hits_have_a_depth_and_no_boolean_has_an_error(run: Run) -> None:
    for pair in PAIRS:
        row = errors(run, CONTACTS, pair)
        assert 0 < row.valued < row.answers
        row = errors(run, BOOLEAN, pair)
        assert (row.valued, row.absolute, row.relative) == (0, None, None)
        assert row.answers == run.total(query=BOOLEAN, pair=pair, kinds=(Verdict.AGREES,), engine="lawful")


def test_errors_against_scale_gap_and_aspect_have_the_slopes_of_their_laws(run: Run, folder: Path) -> None:
    del run
    scale = curve(folder, "Sphere–Sphere", DISTANCE, SCALE)
    assert max(p.x for p in scale) > 1e12 * min(p.x for p in scale)
    for point in scale:
        np.testing.assert_allclose(point.errors.median, OF_SIZE * point.x, rtol=1e-7)
    for point in curve(folder, "Sphere–AABB", DISTANCE, ASPECT):
        if 1e2 < point.x < 1e6:
            np.testing.assert_allclose(point.errors.median, OF_ASPECT * point.x, rtol=REFERENCE / OF_ASPECT)
    gaps = [point for point in curve(folder, "Sphere–Sphere", CONTACTS, GAP) if point.x > 1e-8]
    assert len(gaps) > 6
    for point in gaps:
        np.testing.assert_allclose(point.errors.median, OF_GAP * point.x, rtol=1e-6, atol=2 * REFERENCE)
    flat = curve(folder, "Point–Sphere", DISTANCE, ASPECT)
    assert [point.x for point in flat] == [1.0]
    assert curve(folder, "Sphere–AABB", DISTANCE, ASPECT)[-1].x == math.inf


def test_ranks_are_those_of_numpy_on_the_same_rows(run: Run, folder: Path) -> None:
    rows = duckdb.sql(f"SELECT query, pair, regime, error, size FROM '{folder / FOLDER}/bulk-*.parquet'").fetchall()
    checked = 0
    for row in run.accuracy.errors:
        wanted = {"query": row.query, "pair": row.pair, "regime": row.regime}
        fits = [i for i, value in enumerate(wanted.values()) if value]
        values = list(wanted.values())
        mine = [r for r in rows if r[3] is not None and all(r[i] == values[i] for i in fits)]
        assert len(mine) == row.valued
        if mine:
            error = np.array([r[3] for r in mine])
            for told, known in ((row.absolute, error), (row.relative, error / np.array([r[4] for r in mine]))):
                ranks = np.quantile(known, [0.5, 0.99, 1.0], method="inverted_cdf")
                assert spread(told) == ranks.tolist()
                checked += 1
    assert checked > 100


def test_the_worst_of_each_cell_is_proven(run: Run) -> None:
    for pair in PAIRS:
        row = errors(run, DISTANCE, pair)
        for known, proven in ((row.absolute, row.proven_absolute), (row.relative, row.proven_relative)):
            assert known is not None
            assert proven is not None
            assert known.worst * (1 - 1e-12) <= proven <= known.worst * 1.001
    assert errors(run, DISTANCE, "Sphere–Sphere").proven_relative == pytest.approx(OF_SIZE, rel=1e-6)
    assert errors(run, DISTANCE, "Sphere–Sphere", "tiny").proven_relative is None
    assert errors(run, BOOLEAN, "Sphere–Sphere").proven_absolute is None


def test_the_regime_of_the_worst_error_is_named(run: Run) -> None:
    for pair in PAIRS:
        whole = errors(run, DISTANCE, pair)
        assert whole.relative is not None
        part = errors(run, DISTANCE, pair, whole.worst_in).relative
        assert part is not None
        assert part.worst == whole.relative.worst
    assert errors(run, BOOLEAN, "Sphere–Sphere").worst_in == ""


def test_the_same_comes_without_a_record_and_from_one_that_is_gone_on_with(run: Run, folder: Path) -> None:
    alone, resumed = campaign(), campaign(folder=folder, resume=True)
    assert resumed.recalled > 0
    for other in (alone, resumed):
        assert other.digest == run.digest
        assert other.accuracy.errors == run.accuracy.errors
        assert other.accuracy.points == run.accuracy.points
    asked = [(speed.query, speed.pair, speed.answers) for speed in run.accuracy.speeds]
    assert asked == [(speed.query, speed.pair, speed.answers) for speed in alone.accuracy.speeds]
    assert resumed.accuracy.speeds == run.accuracy.speeds


def test_a_run_of_which_nothing_is_known_has_no_errors() -> None:
    with Measured([], []) as measured:
        assert (measured.errors({}), measured.points()) == ((), ())


def test_a_record_that_is_lost_costs_a_run_its_errors_and_nothing_else(tmp_path: Path) -> None:
    filing = Filing(Run(0, 1.0, ""), Buckets(Ledger()))
    filing.sums.spend({("one", DISTANCE, "Sphere–Sphere"): (10, 0.5)})
    (tmp_path / "damaged.parquet").write_bytes(b"PAR1 nothing PAR1")
    for name in ("damaged.parquet", "none.parquet"):
        filing.measure([tmp_path / name])
        assert filing.run.problems.pop().startswith("the accuracy is not known: ")
        assert filing.run.accuracy.errors == ()
        assert [speed.answers for speed in filing.run.accuracy.speeds] == [10]


def test_the_worse_of_two_is_kept_and_the_first_of_equals() -> None:
    small, large = (Scene(DISTANCE, Sphere([0, 0, 0], r), Sphere([0, 0, r], r), "generic") for r in (1.0, 100.0))
    known: dict[tuple[str, str, str, str], Extreme] = {}
    for measure in (ABSOLUTE, RELATIVE):
        key = ("e", DISTANCE, "Sphere–Sphere", measure)
        keep_worst(known, [(key, Extreme(small, 1.0)), (key, Extreme(large, 1.5)), (key, Extreme(large, 1.5))])
    assert [known["e", DISTANCE, "Sphere–Sphere", m].scene for m in (ABSOLUTE, RELATIVE)] == [large, small]
    nowhere = Scene(DISTANCE, PointProxy([0, 0, 0]), AABB([0, 0, 0], [0, 0, 0]), "degenerate")
    assert [Extreme(nowhere, error).amount(RELATIVE) for error in (0.0, 1.0)] == [0.0, math.inf]


# -- what is proven of single answers ------------------------------------------------------------------------


def off(scene: Scene, column: str, by: float) -> Answers:
    """The reference's answer, off in one column."""
    right = reference_for(scene)
    table = np.full((1, WIDTH), np.nan)
    for name, place in COLUMNS.items():
        table[:, place] = np.reshape(getattr(right, name), (1, -1))
    table[:, COLUMNS[column]] += by
    return Answers.from_table(right.status, table, {})


SCENES = {
    "balls": Scene(DISTANCE, Sphere([0, 0, 0], 1), Sphere([3, 0.5, 0], 1), "generic"),
    "ellipsoids": Scene(
        DISTANCE, Ellipsoid([0, 0, 0], [1, 2, 3], [0, 0, 0.1, 1]), Ellipsoid([5, 1, 0], [1, 1, 2], [0.2, 0, 0, 1]), "g"
    ),
    "overlap": Scene(CONTACTS, Box([0, 0, 0], [1, 2, 1], [0, 0, 0.2, 1]), Capsule([0, 1, 0], [1, 2, 2], 0.5), "deep"),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_proven_of_an_answer_is_its_error(name: str) -> None:
    scene, judges = SCENES[name], Judges(Exact())
    for by in (0.25, -0.25, 1e-6):
        verdict = judges.proven_error(scene, off(scene, "distance", by))
        assert verdict.kind is Verdict.AGREES
        assert verdict.amount == pytest.approx(abs(by), abs=1e-8)
        assert verdict.amount <= abs(by) + 1e-14
    assert judges.proven_error(scene, reference_for(scene)).amount < 1e-13


@pytest.mark.parametrize("engine", [Exact(), Exact(absolute=0.1), Grown()], ids=["exact", "lax", "grown"])
@pytest.mark.parametrize("kinds", [(Sphere, Box), (Capsule, Capsule), (Ray, Box)], ids=lambda x: x[0].__name__)
def test_what_is_proven_is_what_the_screening_was_certain_of(engine: Exact, kinds: tuple[type[Proxy], ...]) -> None:
    a, b = REGIMES["generic"](NumpyDraws(4, (1,), 12), *kinds)
    query = RAYCAST if isinstance(a, Ray) else DISTANCE
    right = reference_answers(query, a, b)
    table = np.full((len(a), WIDTH), np.nan)
    by = np.tile([0.0, 1e-3, -1e-3, 0.05, -0.05, 0.3], 2)
    for name, values in (("hit", right.hit), ("distance", right.distance - by), ("t", right.t + by)):
        table[:, COLUMNS[name]] = values[:, None]
    answers, judges = Answers.from_table(right.status, table, {}), Judges(engine)
    screening = judges.screen(Cell(query, *kinds), a, b, None, answers)
    seen = 0
    for i in np.flatnonzero(~np.isnan(screening.error)):
        verdict = judges.proven_error(Scene(query, a[i], b[i], "generic"), take(answers, [i]))
        assert verdict.amount == pytest.approx(screening.error[i], abs=1e-9)
        seen += verdict.amount > 1e-4
    assert seen > 2


def test_what_is_proven_of_a_ray_is_how_far_its_hit_is_from_the_surface() -> None:
    scene = Scene(RAYCAST, Ray([-3, 0, 0], [2, 0, 0]), Sphere([0, 0, 0], 1), "generic")
    judges = Judges(Exact())
    for by in (0.125, -0.125):
        assert judges.proven_error(scene, off(scene, "t", by)).amount == pytest.approx(0.25, abs=1e-12)
    assert judges.proven_error(scene, reference_for(scene)).amount < 1e-14


def test_what_is_proven_of_an_impact_is_the_gravest_violation_of_a_law() -> None:
    a, b, motion = next(iter(IMPACT_REGIMES.values()))(NumpyDraws(1, (1,), 1), Sphere, HalfSpace)
    scene = Scene(IMPACT, a[0], b[0], "generic", motion=motion[0])
    judges = Judges(Exact())
    assert judges.proven_error(scene, reference_for(scene)).amount < 1e-12
    assert judges.proven_error(scene, off(scene, "velocity_a", 0.5)).amount > 0.1


def test_of_what_is_no_answer_nothing_is_proven() -> None:
    scene = SCENES["balls"]
    lost = Answers.from_table(np.array([Status.CRASHED], dtype=np.int8), np.full((1, WIDTH), np.nan), {})
    assert Judges(Exact()).proven_error(scene, lost).kind is Verdict.UNDECIDED


def test_an_overlap_without_a_depth_has_no_error_and_a_false_one_has() -> None:
    a, b = Sphere(np.zeros((3, 3)), np.ones(3)), Sphere([[1.0, 0, 0], [3.0, 0, 0], [1.5, 0, 0]], np.ones(3))
    table = np.full((3, WIDTH), np.nan)
    table[:, COLUMNS["distance"]] = [[-np.inf], [-np.inf], [-0.5]]
    answers = Answers.from_table(np.zeros(3, dtype=np.int8), table, {})
    found = screen(Rules(NoDepth()), Cell(DISTANCE, Sphere, Sphere), a, b, answers)
    assert np.isnan(found.error[0])
    np.testing.assert_allclose(found.error[1:], [1.0, 0.0], atol=1e-13)
    assert screen(Rules(Exact()), Cell(DISTANCE, Sphere, Sphere), a, b, answers).error[0] == math.inf


# -- aspect ratios -------------------------------------------------------------------------------------------

BOXES = np.array([[1.0, 2.0, 8.0], [1.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
OF_BOXES = [8.0, 1.0, math.inf, 1.0]


@pytest.mark.parametrize(
    ("shape", "aspects"),
    [
        (Sphere(np.zeros((2, 3)), [1, 5]), [1, 1]),
        (HalfSpace([[0, 0, 2.0]], [1]), [1]),
        (Capsule([[0, 0, 0], [0, 0, 0]], [[0, 0, 6], [1, 0, 0]], [1.0, 0.0]), [4.0, math.inf]),
        (Cylinder([[0, 0, 0], [0, 0, 0]], [[0, 0, 6], [0, 0, 1]], [1.0, 2.0]), [3.0, 4.0]),
        (AABB(-BOXES, BOXES), OF_BOXES),
        (Box(np.ones((4, 3)), BOXES, np.tile([0, 0.3, 0, 1], (4, 1))), OF_BOXES),
        (Ellipsoid(np.zeros((1, 3)), [[1, 5, 2]], [[0, 0, 0, 1]]), [5.0]),
        (KDOP([np.eye(3) * 2] * 4, -BOXES, BOXES), OF_BOXES),
        (ConvexPolyhedron.from_vertices(CUBE * BOXES[:3, None], np.ones((3, 3)), np.ones((3, 4))), OF_BOXES[:3]),
        (Composite([Sphere([[0, 0, 0]], [1]), Box([[1, 0, 0]], [[1, 2, 8]], [[0, 0, 0, 1]])]), [8.0]),
    ],
    ids=lambda x: type(x).__name__,
)
def test_aspect_ratios(shape: Proxy, aspects: list[float]) -> None:
    assert aspect_of(shape).tolist() == aspects


@pytest.mark.parametrize("kind", [Capsule, Box, Cylinder, Ellipsoid, AABB])
def test_aspect_ratios_are_those_that_the_eye_sees(kind: type[Proxy]) -> None:
    for regime in ("generic", "sliver"):
        _, shapes = REGIMES[regime](NumpyDraws(3, (1,), 12), Sphere, kind)
        seen = [look(shapes[i]) for i in range(len(shapes))]
        np.testing.assert_allclose(aspect_of(shapes), [s.size / s.thin for s in seen], rtol=1e-6)


# -- times ---------------------------------------------------------------------------------------------------


def test_the_time_of_an_answer_is_the_processor_s_and_only_that_of_the_engine() -> None:
    (batch,) = (np.tile(row, (40, 1)) for row in ([1.0, 0, 0, 1],))
    with EngineWorker(spec(Busy)) as worker:
        worker.answer(DISTANCE, Sphere, Sphere, batch, batch + 2.0)
        asked, seconds = worker.effort
        assert asked == 40
        assert 40 * BUSY_FOR <= seconds < 40 * BUSY_FOR * 2
        assert worker.answer(DISTANCE, Sphere, Sphere, batch[:1], batch[:1]).status.tolist() == [Status.ANSWERED]
        assert worker.effort[0] == 1
