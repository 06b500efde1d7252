"""FCL and Bullet asked about sweeps: what they are asked, that right answers pass, that their scripts say the same."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from oracles import claims
from oracles.answers import take
from oracles.batch import Batch
from oracles.course import Course
from oracles.engine import Engine, Status
from oracles.engines import load_engine
from oracles.engines.fcl_sweeps import NO_SCREW, TOO_FAR
from oracles.judges import Judges
from oracles.outcome import FINDINGS, Kind
from oracles.repro.calls import call_of
from oracles.scene import SWEEP, Cell, Scene, cells
from oracles.worker import EngineWorker
from refimpl import Box, Capsule, Ellipsoid, HalfSpace, Polyhedron, Sphere
from refimpl.motions import RigidMotion
from refimpl.shapes import AABB, Composite, Point

ENGINES: dict[str, Engine] = {name: load_engine(name) for name in ("fcl", "bullet", "bullet-stepping", "bullet-ccd")}
UPRIGHT = [0.0, 0.0, 0.0, 1.0]
STILL = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))


@pytest.fixture(scope="module")
def workers() -> Iterator[dict[str, EngineWorker]]:
    started = {name: EngineWorker(name, 1.0) for name in ENGINES}
    yield started
    for worker in started.values():
        worker.close()


def scene_of(a: Any, b: Any, course: Course) -> Scene:
    return Scene(SWEEP, a, b, "example", "", course)


BALL_ON_WALL = scene_of(
    Sphere([0, 0, 0], 1), Box([6, 0, 0], [1, 2, 2], UPRIGHT), Course.translating([8, 0, 0], [0] * 3)
)
BOX_ON_BOX = scene_of(Box([0, 0, 9], [1, 1, 1], UPRIGHT), Box([0, 0, 0], [1, 1, 1], UPRIGHT), BALL_ON_WALL.course)
POINT_ON_BOX = scene_of(Point([0, 0.5, 0]), AABB([3, -2, -2], [5, 2, 2]), Course.translating([4, 0, 0], [-2, 1, 0]))
POINT_ON_PAIR = scene_of(
    Point([0, 0, 0]), Composite([Sphere([8, 0, 0], 1), Sphere([4, 0, 0], 1)]), Course.translating([8, 0, 0], [0, 0, 0])
)
BALL_ON_WALL_IN_BETWEEN = scene_of(
    Sphere([0.24, 0, 0], 1), Box([6, 0, 0], [1, 2, 2], UPRIGHT), Course.translating([8, 0, 0], [0] * 3)
)
BOX_TO_PLANE = scene_of(
    HalfSpace([0, 0, 1], 3), Box([0, 0, 1], [1, 1, 1], UPRIGHT), Course.translating([0, 0, 2], [0, 0, -2])
)
THROUGH_A_SHEET = scene_of(
    Sphere([0, 0, 0], 0.05), Box([21.1, 0, 0], [0.05, 2, 2], UPRIGHT), Course.translating([40, 0, 0], [0] * 3)
)
PAST_THE_WALL = scene_of(BALL_ON_WALL.a, BALL_ON_WALL.b, Course.translating([8, 0, 0], [0, 20, 0]))


@pytest.mark.parametrize(
    ("name", "scene", "t"),
    [
        ("fcl", BALL_ON_WALL, 0.5),
        ("fcl", BOX_ON_BOX, np.inf),
        ("fcl", POINT_ON_BOX, 0.5),
        ("bullet", POINT_ON_BOX, 0.5),
        ("fcl", POINT_ON_PAIR, 0.375),
        ("bullet", POINT_ON_PAIR, 0.375),
        ("bullet-stepping", BALL_ON_WALL, 0.5),
        ("bullet-stepping", BALL_ON_WALL_IN_BETWEEN, 0.5),
        ("bullet-stepping", BOX_ON_BOX, np.inf),
        ("bullet-stepping", BOX_TO_PLANE, 0.75),
        ("bullet-ccd", BALL_ON_WALL, 0.5),
        ("bullet-ccd", BALL_ON_WALL_IN_BETWEEN, 0.47),
        ("bullet-ccd", THROUGH_A_SHEET, 0.525),
        ("bullet-ccd", PAST_THE_WALL, np.inf),
    ],
)
def test_plain_sweeps_are_answered_and_the_script_says_the_same(
    name: str, scene: Scene, t: float, workers: dict[str, EngineWorker]
) -> None:
    answers = workers[name].ask(scene)
    assert answers.status[0] == Status.ANSWERED
    assert answers.t[0] == pytest.approx(t, abs=1e-3 / 4)  # Bullet's rays and casts end 0.001 before
    assert Judges(ENGINES[name]).convict(scene, answers).kind in (Kind.AGREES, Kind.CONVENTION)
    ran = subprocess.run(
        [sys.executable, "-c", call_of(ENGINES[name], scene)], capture_output=True, text=True, check=True
    )
    printed = dict(line.split(" = ") for line in ran.stdout.splitlines() if " = " in line)
    assert float(printed["hit"]) == answers.hit[0]
    assert float(printed["t"]) == answers.t[0]


def test_points_and_normals_of_bullet_are_in_the_world_at_that_time(workers: dict[str, EngineWorker]) -> None:
    answers = workers["bullet"].ask(POINT_ON_BOX)
    assert np.allclose(answers.point[0], [2, 0.5, 0], atol=2e-3)
    assert np.allclose(answers.normal[0], [1, 0, 0])


def test_every_other_cell_says_why_it_is_not_answered() -> None:
    reasons = {name: Counter[str]() for name in ENGINES}
    for cell in cells():
        if cell.query == SWEEP:
            for name, engine in ENGINES.items():
                support = engine.support(SWEEP, cell.type_a, cell.type_b)
                assert support or support.reason
                reasons[name][support.kind.value] += 1
    assert reasons["fcl"]["native"] + reasons["fcl"]["emulated"] == 44
    assert reasons["bullet"]["native"] + reasons["bullet"]["emulated"] == 10
    assert reasons["bullet-stepping"]["native"] + reasons["bullet-stepping"]["emulated"] == 34
    assert reasons["bullet-ccd"]["native"] + reasons["bullet-ccd"]["emulated"] == 14
    for kinds, word in (
        ((Sphere, HalfSpace), "segmentation fault"),
        ((Sphere, Polyhedron), "segmentation fault"),
        ((Sphere, Ellipsoid), "never hits"),
    ):
        assert word in ENGINES["fcl"].support(SWEEP, *kinds).reason
    assert "steps" in ENGINES["bullet"].support(SWEEP, Sphere, Box).reason
    assert "only of a ball" in ENGINES["bullet-ccd"].support(SWEEP, Capsule, Box).reason
    assert not ENGINES["bullet-stepping"].support("distance", Sphere, Box)
    assert not load_engine("pybullet-defaults").support(SWEEP, Point, Box)


@pytest.mark.parametrize(
    ("name", "motion", "reason"),
    [
        ("fcl", RigidMotion([4, 0, 0], [0, 0, 1], [6, 0, 0]), NO_SCREW),
        ("fcl", RigidMotion([0, 0, 0], [0, 0, 4], [6, 0, 0]), TOO_FAR),
        ("fcl", RigidMotion([0, 0, 0], [0, 0, 1], [5, 0, 0]), "origin"),
        ("bullet-stepping", RigidMotion([0, 0, 0], [0, 0, 1], [6, 0, 0]), "translations"),
        ("bullet-ccd", RigidMotion([0.4, 0, 0], [0, 0, 0], [0, 0, 0]), "half its radius"),
    ],
)
def test_what_an_engine_cannot_move_is_unsupported(
    name: str, motion: RigidMotion, reason: str, workers: dict[str, EngineWorker]
) -> None:
    scene = scene_of(BALL_ON_WALL.a, BALL_ON_WALL.b, Course(STILL, motion))
    answers = workers[name].ask(scene)
    assert answers.status[0] == Status.UNSUPPORTED
    assert reason in answers.errors[0]


FAIR = [
    ("fcl", (Sphere, Box)),
    ("fcl", (Capsule, Box)),
    ("bullet", (Point, Sphere)),
    ("bullet", (Point, Box)),
    ("bullet-stepping", (Capsule, Box)),
    ("bullet-ccd", (Sphere, Box)),
]


@pytest.mark.parametrize(("name", "pair"), FAIR, ids=str)
def test_engines_are_right_in_most_sweeps_and_wrong_only_with_a_certificate(
    name: str, pair: Any, workers: dict[str, EngineWorker]
) -> None:
    judges, kinds = Judges(ENGINES[name]), Counter[Kind]()
    for batch in Batch.draw_sweeps(pair, 3, (0, 1), 2):
        answers = workers[name].answer(SWEEP, *pair, *batch.rows)
        screening = judges.screen(Cell(SWEEP, *pair), batch.a, batch.b, batch.motion, answers)
        kinds.update(screening.kind)
        for i in np.flatnonzero(screening.kind == Kind.WRONG):
            verdict = judges.convict(batch.scene(SWEEP, int(i)), take(answers, [i]))
            if verdict.kind in FINDINGS:
                assert verdict.certificate is not None
                assert verdict.symptom in (claims.SWEEP_MISSED, claims.EARLY, claims.LATE, claims.SWEEP_FALSE)
    assert kinds[Kind.AGREES] > 0.75 * (kinds.total() - kinds[Kind.UNSUPPORTED])


@pytest.mark.parametrize(("name", "wrong"), [("bullet-stepping", True), ("bullet-ccd", False)])
def test_steps_tunnel_and_a_swept_sphere_does_not(name: str, wrong: bool, workers: dict[str, EngineWorker]) -> None:
    answers = workers[name].ask(THROUGH_A_SHEET)
    verdict = Judges(ENGINES[name]).convict(THROUGH_A_SHEET, answers)
    assert (answers.hit[0] == 0) == wrong
    assert verdict.kind is (Kind.WRONG if wrong else Kind.AGREES)
    assert verdict.symptom == (claims.SWEEP_MISSED if wrong else "")
    assert (verdict.certificate is not None) == wrong


def test_the_time_of_a_step_is_late_by_less_than_a_step(workers: dict[str, EngineWorker]) -> None:
    """Arrivals at many moments within a step: never before the contact, nor a sixteenth of the way after it."""
    arrivals = np.linspace(0.31, 0.45, 40)
    a = Sphere(np.column_stack([4.0 - 8.0 * arrivals, *np.zeros((2, 40))]), np.ones(40))
    b = Box(np.tile([6.0, 0, 0], (40, 1)), np.tile([1.0, 2, 2], (40, 1)), np.tile(UPRIGHT, (40, 1)))
    course = Course.translating(np.tile([8.0, 0, 0], (40, 1)), np.zeros((40, 3)))
    rows = np.concatenate([a.pack(), course.pack()], axis=1), b.pack()
    found = workers["bullet-stepping"].answer(SWEEP, Sphere, Box, *rows)
    late = found.t - arrivals
    assert late.min() > -1e-9
    assert late.max() < 1 / 16
    assert np.ptp(late) > 0.04
    swept = workers["bullet-ccd"].answer(SWEEP, Sphere, Box, *rows)
    assert np.abs(swept.t - arrivals).max() < 1e-3 / 8
