"""Pymunk's adapter, and what Chipmunk gets wrong."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymunk")

from oracles import claims
from oracles.batch import Batch
from oracles.course import Course
from oracles.engine import COLUMNS, Answers, Engine, Status, UnsupportedCell
from oracles.engines import load_engine
from oracles.engines.pymunk_engine import PymunkEngine
from oracles.judges import Judges, finding_of
from oracles.opening import wanted_pairs
from oracles.outcome import Bucket, Kind, Run, SupportNote
from oracles.repro import script_of
from oracles.scene import (
    BOOLEAN,
    CONTACTS,
    DISTANCE,
    PAIRS,
    QUERIES,
    RAYCAST,
    SWEEP,
    Cell,
    Scene,
    cells,
    cells_of,
)
from oracles.world import PLANE, SPACE, is_flat
from refimpl import Sphere
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, Rectangle, Segment
from reports import matrix, vs
from reports.viewer.frame import FROM_ABOVE
from reports.viewer.scene import picture_of

FLAT_PAIRS = [pair for pair in PAIRS if is_flat(pair[0])]
SQUARE = Rectangle([-1.0, -1.0], [1.0, 1.0])
DIAMOND = ConvexPolygon.from_vertices([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
ROOT_HALF = math.sqrt(0.5)


def said(engine: Engine, query: str, a: Any, b: Any) -> dict[str, Any]:
    """What an engine answers of one scene."""
    return told(engine, Scene(query, a, b, "by hand"))


def told(engine: Engine, scene: Scene) -> dict[str, Any]:
    """The same of a scene that may have a motion."""
    row = engine.solver(scene.query, type(scene.a), type(scene.b))(*(numbers.tolist() for numbers in scene.rows))
    found = {name: row[columns] for name, columns in COLUMNS.items()}
    return {n: v[0] if len(v) == 1 else list(v) for n, v in found.items() if not any(math.isnan(x) for x in v)}


@pytest.fixture(scope="module")
def pymunk() -> PymunkEngine:
    engine = load_engine("pymunk")
    assert isinstance(engine, PymunkEngine)
    engine.warm()
    return engine


# -- the adapter ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("query", "a", "b", "expected"),
    [
        (DISTANCE, FlatPoint([3.0, 0.0]), SQUARE, {"distance": 2.0, "on_b": [1, 0, 0], "normal": [-1, 0, 0]}),
        (DISTANCE, FlatPoint([0.5, 0.0]), SQUARE, {"distance": -0.5, "on_b": [1, 0, 0], "normal": [-1, 0, 0]}),
        (DISTANCE, Disc([4.0, 5.0], 1.0), SQUARE, {"distance": 4.0, "on_b": [1, 1, 0], "normal": [-0.6, -0.8, 0]}),
        (DISTANCE, Disc([0.0, 3.0], 0.5), Segment([-1.0, 0.0], [1.0, 0.0], 0.25), {"distance": 2.25}),
        (CONTACTS, Disc([1.5, 0.0], 1.0), SQUARE, {"hit": 1.0, "distance": -0.5, "normal": [-1, 0, 0]}),
        (CONTACTS, DIAMOND, DIAMOND.translated([3.0, 0.5]), {"hit": 0.0}),
        (CONTACTS, SQUARE, DIAMOND.translated([1.5, 0.25]), {"hit": 1.0, "distance": -0.5, "normal": [1, 0, 0]}),
        (BOOLEAN, FlatPoint([0.5, 0.25]), DIAMOND, {"hit": 1.0}),
        (BOOLEAN, Disc([2.0, 0.0], 0.5), SQUARE, {"hit": 0.0}),
        (
            RAYCAST,
            FlatRay([-3.0, -3.0], [2.0, 2.0]),
            Disc([0.0, 0.0], 1.0),
            {"hit": 1.0, "t": 1.5 - ROOT_HALF / 2, "normal": [-ROOT_HALF, -ROOT_HALF, 0]},
        ),
        (RAYCAST, FlatRay([-3.0, 0.5], [0.5, 0.0]), SQUARE, {"hit": 1.0, "t": 4.0, "point": [-1, 0.5, 0]}),
        (RAYCAST, FlatRay([-3.0, 0.5], [-0.5, 0.0]), SQUARE, {"hit": 0.0, "t": math.inf}),
    ],
)
def test_answers_by_hand(pymunk: PymunkEngine, query: str, a: Any, b: Any, expected: dict[str, Any]) -> None:
    answer = said(pymunk, query, a, b)
    assert answer.keys() >= expected.keys()
    for name, value in expected.items():
        np.testing.assert_allclose(answer[name], value, rtol=0, atol=1e-12, err_msg=name)
    owed = pymunk.says(query, type(a), type(b))
    assert owed <= answer.keys() or answer["hit"] == 0


def test_a_sweep_by_hand(pymunk: PymunkEngine) -> None:
    """A disc of radius 1 goes right by 6 while the square goes left by 2: they close a gap of 4 in half the time."""
    course = Course.translating([6.0, 0.0, 0.0], [-2.0, 0.0, 0.0])
    scene = Scene(SWEEP, Disc([-6.0, 0.5], 1.0), SQUARE, "by hand", motion=course)
    row = pymunk.solver(SWEEP, Disc, Rectangle)(*(row.tolist() for row in scene.rows))
    np.testing.assert_allclose(np.array(row)[[0, 11, 8, 9, 12, 13]], [1, 0.5, 1, 0, -2, 0.5], rtol=0, atol=1e-12)
    upwards = Course.translating([6.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="move in the plane"):
        Scene.from_json(Scene(SWEEP, scene.a, scene.b, "by hand", motion=upwards).to_json())
    again = Scene.from_json(scene.to_json())
    assert again.id == scene.id


@pytest.mark.parametrize("pair", FLAT_PAIRS, ids=lambda pair: f"{pair[0].__name__}-{pair[1].__name__}")
def test_scripts_ask_what_the_adapter_asks(pair: Any, pymunk: PymunkEngine, capsys: pytest.CaptureFixture[str]) -> None:
    asked, drawn = 0, Batch.draw(pair, 5, (1,), 1)
    moving = (
        () if pair[0] is FlatRay else (*Batch.draw_sweeps(pair, 5, (1,), 1)[:1], *Batch.draw_impacts(pair, 5, (1,), 1))
    )
    largest = [max(drawn, key=len), *moving]
    of_cells = ((cell, batch) for cell in cells_of(pair) for batch in largest if batch.is_of(cell.query))
    for cell, batch in of_cells:
        if not pymunk.support(cell.query, *pair):
            continue
        for i in range(0, len(batch), 4):
            scene = batch.scene(cell.query, i)
            script = pymunk.repro(cell.query, *pair, *(row.tolist() for row in scene.rows))
            exec(compile(script, "script", "exec"), {})
            lines = (line.partition(" = ") for line in capsys.readouterr().out.splitlines())
            printed = {
                name: np.array(eval(value, {"inf": math.inf, "nan": math.nan})) for name, eq, value in lines if eq
            }
            answer = told(pymunk, scene)
            assert answer.keys() <= printed.keys()
            for name, value in printed.items():
                if name in answer:
                    np.testing.assert_array_equal(value, answer[name], err_msg=f"{scene} {name}")
            asked += 1
    assert asked >= 2


def test_each_engine_has_its_own_world(pymunk: PymunkEngine) -> None:
    for cell in cells():
        support = pymunk.support(cell.query, cell.type_a, cell.type_b)
        assert support or support.reason
        if not is_flat(cell.type_a):
            assert "engine of the plane" in support.reason
    answered = {cell.query for cell in cells() if pymunk.support(cell.query, cell.type_a, cell.type_b)}
    assert {DISTANCE, CONTACTS, BOOLEAN, RAYCAST} <= answered <= set(QUERIES)
    assert not pymunk.support(DISTANCE, Rectangle, ConvexPolygon)
    with pytest.raises(UnsupportedCell, match="distance of a point"):
        pymunk.solver(DISTANCE, Rectangle, ConvexPolygon)
    assert "no flat shapes" in load_engine("fcl").support(DISTANCE, FlatPoint, Disc).reason
    assert not pymunk.support(DISTANCE, FlatPoint, Sphere)
    assert set(wanted_pairs(None, [pymunk])) == set(FLAT_PAIRS) == set(PLANE.table)
    assert set(wanted_pairs(None, [load_engine("fcl")])) == set(SPACE.table)


# -- what Chipmunk gets wrong, each proven -------------------------------------------------------------------


def polygon_depth(v: np.ndarray, w: np.ndarray) -> Fraction:
    """Signed distance along the best side of two polygons' own: exact where they overlap and sides are level."""
    best = Fraction(-(10**9))
    for p, q in ((v, w), (w, v)):
        for i in range(len(p)):
            (x, y), (u, t) = p[i], p[(i + 1) % len(p)]
            nx, ny = Fraction(t) - Fraction(y), Fraction(x) - Fraction(u)
            assert nx == 0 or ny == 0
            length = abs(nx) + abs(ny)
            best = max(
                best, min((nx * (Fraction(a) - Fraction(x)) + ny * (Fraction(b) - Fraction(y))) / length for a, b in q)
            )
    return best


def corners(r: Rectangle) -> np.ndarray:
    (x, y), (u, v) = r.lower, r.upper
    return np.array([[x, y], [u, y], [u, v], [x, v]])


FAULTS: dict[str, tuple[str, Any, Any, str]] = {
    "a gap along the line of a side": (
        BOOLEAN,
        Rectangle([2.75, -2.5], [3.25, 0.5]),
        Rectangle([-0.5, 0.5], [2.5, 2.5]),
        claims.FALSE,
    ),
    "bars across each other": (
        CONTACTS,
        Rectangle([-0.5, 0.5], [2.5, 1.5]),
        Rectangle([0.75, -1.0], [1.25, 3.0]),
        claims.LONG,
    ),
    "a ray from inside": (RAYCAST, FlatRay([0.0, 0.0], [1.0, 0.0]), SQUARE, claims.RAY_POINT),
    "nearer than 1e-5 to a centre": (DISTANCE, FlatPoint([5e-6, 0.0]), Disc([0.0, 0.0], 1e-6), claims.OVERSHOT),
    "on a side": (DISTANCE, FlatPoint([1.0, 0.0]), SQUARE, claims.NOT_A_NUMBER),
}


@pytest.mark.parametrize("name", FAULTS)
def test_known_faults_are_proven_and_shown(name: str, pymunk: PymunkEngine) -> None:
    query, a, b, symptom = FAULTS[name]
    scene = Scene(query, a, b, "by hand")
    row = np.array([pymunk.solver(query, type(a), type(b))(a.pack().tolist(), b.pack().tolist())])
    bad = symptom == claims.NOT_A_NUMBER
    status = np.array([Status.ERROR if bad else Status.ANSWERED], dtype=np.int8)
    answers = Answers.from_table(status, row, {0: "answered on_b = nan"} if bad else {})
    verdict = Judges(pymunk).convict(scene, answers)
    assert (verdict.kind, verdict.symptom) == (Kind.WRONG, symptom), verdict
    if isinstance(a, Rectangle):
        exact = polygon_depth(corners(a), corners(b))
        assert Fraction(verdict.lower) <= exact <= Fraction(verdict.upper)
    finding = finding_of("pymunk", scene, answers, verdict)
    picture = picture_of(Bucket("pymunk", query, scene.cell.pair, symptom, "", None, finding))
    assert picture.view is FROM_ABOVE
    assert picture.a
    assert picture.b
    text = script_of(pymunk, finding)
    assert "import pymunk" in text
    assert "refimpl" not in text
    module: dict[str, Any] = {"__name__": "script", "__file__": "script.py"}
    exec(compile(text, "script", "exec"), module)
    for side in module.get("SIDES", ()):
        lower, upper = module["proven"](side["truth"])
        if verdict.proof_scene is None or verdict.proof_scene.id == scene.id:
            assert verdict.lower <= upper
            assert lower <= verdict.upper
        broken = {**side["truth"], "interval": [1e3, 1e3]}
        with pytest.raises(module["Refused"]):
            module["proven"](broken)


# -- the report ----------------------------------------------------------------------------------------------


def test_the_plane_has_a_table_of_its_own() -> None:
    space, plane = vs.matrix(), vs.matrix(in_plane=True)
    assert plane.columns == ("Disc", "Segment", "Rectangle", "ConvexPolygon")
    assert sum(bool(mark) for row in plane.cells for mark in row) == len(FLAT_PAIRS) == 18
    assert not set(plane.columns) & set(space.columns)
    lines = vs.as_text().splitlines()
    assert any(line.split() == ["VS", *plane.columns] for line in lines)


def test_the_matrix_shows_each_world_with_its_engines(pymunk: PymunkEngine) -> None:
    run = Run(0, 1.0, "2026-01-01T00:00:00")
    run.engines = ["fcl", "pymunk"]
    for cell in (Cell(DISTANCE, Disc, Rectangle), Cell(DISTANCE, Sphere, Sphere)):
        for name, engine in (("fcl", load_engine("fcl")), ("pymunk", pymunk)):
            note = engine.support(cell.query, cell.type_a, cell.type_b)
            run.support[name, cell.query, cell.pair] = SupportNote(note.kind.value, note.reason)
            if note:
                run.counts[name, cell.query, cell.pair, "generic", Kind.AGREES] += 7
    overviews = {table.caption.partition(":")[0]: table for table in matrix.overviews(run)}
    assert [column.title for column in overviews["pymunk"].columns][1:] == [
        "Disc",
        "Segment",
        "Rectangle",
        "ConvexPolygon",
    ]
    assert "Sphere" in [column.title for column in overviews["fcl"].columns]
    tables = {tuple(row[0].text for row in table.rows): table for table in matrix.matrices(run, {})}
    assert tables.keys() == {("Sphere–Sphere",), ("Disc–Rectangle",)}
    assert {column.group for column in tables["Disc–Rectangle",].columns[1:]} == {"pymunk"}
    assert {column.group for column in tables["Sphere–Sphere",].columns[1:]} == {"fcl"}
