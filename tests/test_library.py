"""Libraries of models: folders, PyBullet's, those made in code; scenes, lists and runs that use them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import refimpl
from oracles import library, models
from oracles.batch import Batch
from oracles.draws import NumpyDraws
from oracles.library import Library, made_here, of_folder, of_user, using
from oracles.meshfiles import ModelError
from oracles.models import COMPOSITE, HULL, SOLID, Model
from oracles.outcome import Run
from oracles.regimes import REGIMES
from oracles.scene import Cell
from oracles.strategies import scenes
from refimpl.bounds import aabb
from refimpl.pairs import TABLE
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron
from reports import cli
from reports import models as listed
from tests.conftest import name_of
from tests.sample_run import sample_run
from tests.test_meshfiles import OPEN, TETRAHEDRON


def test_a_folder_is_listed_by_family(tmp_path: Path):
    for name in ("a.obj", "arm/b.OBJ", "arm/deep/c.stl", "leg/d.urdf"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("not read yet")
    (tmp_path / "notes.txt").write_text("no model")
    found = of_folder(tmp_path)
    names = {family: [m.name for m in members] for family, members in found.families.items()}
    assert names == {"": ["a.obj"], "arm": ["arm/b.OBJ", "arm/deep/c.stl"], "leg": ["leg/d.urdf"]}


def test_a_users_folder_is_read_and_what_cannot_be_is_named(tmp_path: Path):
    (tmp_path / "good.obj").write_text(TETRAHEDRON)
    (tmp_path / "bad.obj").write_text("v 1 nan 2")
    (tmp_path / "worse.urdf").write_text("<robot/>")
    (tmp_path / "out.obj").symlink_to("/etc/passwd")
    found = of_user(tmp_path)
    assert [m.name for m in found.models] == ["good.obj"]
    assert found.unread == {
        "bad.obj": "holds no triangle",
        "out.obj": "lies outside of the folder",
        "worse.urdf": "has no collision element",
    }
    assert found.account()[0].endswith("1 model, and 3 that cannot be used")
    assert found.account()[1:] == [f"{name} {why}" for name, why in found.unread.items()]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: path / "gone", "there is no folder"),
        (lambda path: path / "file.txt", "is no folder"),
        (lambda path: path / "empty", "has no model in it: no file ends in .urdf, .obj, .stl"),
        (lambda path: path / "bad", "has no model in it that can be read; b.obj holds no triangle"),
        (lambda path: path / ("x" * 5000), "is no folder"),
    ],
)
def test_folders_of_no_use_are_refused(tmp_path: Path, make, words, capsys):
    (tmp_path / "file.txt").write_text("text")
    (tmp_path / "empty").mkdir()
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "b.obj").write_text("")
    folder = make(tmp_path)
    with pytest.raises(ModelError) as error:
        of_user(folder)
    assert words in str(error.value)
    for command in (["run", "--engine", "fcl", "--models", str(folder)], ["models", str(folder)]):
        assert cli.main(command) == cli.BAD_INPUT
        said = capsys.readouterr()
        assert said.err.count("\n") == 1
        assert said.out == ""


def test_a_folder_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for i in range(4):
        (tmp_path / f"{i}.obj").write_text(TETRAHEDRON)
    monkeypatch.setattr(library, "MOST_MODELS", 3)
    with pytest.raises(ModelError, match="more than 3 models: name a smaller folder"):
        of_folder(tmp_path)
    monkeypatch.setattr(library, "MOST_ENTRIES", 2)
    with pytest.raises(ModelError, match="more than 2 entries"):
        of_folder(tmp_path)


def test_picking_is_a_pure_function_and_finds_what_has_the_form(tmp_path: Path):
    for i in range(20):
        (tmp_path / f"{i}").mkdir()
        (tmp_path / f"{i}" / "m.obj").write_text(TETRAHEDRON if i == 13 else OPEN)
    found = of_folder(tmp_path)
    assert {found.pick(NumpyDraws(1, (i,), 5), SOLID).name for i in range(10)} == {"13/m.obj"}
    hulls = [found.pick(NumpyDraws(1, (i,), 5), HULL).name for i in range(40)]
    assert hulls == [of_folder(tmp_path).pick(NumpyDraws(1, (i,), 5), HULL).name for i in range(40)]
    assert len(set(hulls)) > 10
    assert found.lacking == set()


def test_a_form_that_no_model_has_comes_from_the_models_made_here_and_is_said(tmp_path: Path):
    (tmp_path / "open.obj").write_text(OPEN)
    found = of_folder(tmp_path)
    assert found.pick(NumpyDraws(1, (0,), 1), SOLID) in made_here().models
    assert "none of those tried is a solid: models made in code took the place" in found.account()


def test_without_pybullet_data_models_are_made_in_code(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(library, "find_spec", lambda _: None)
    assert library.shipped.__wrapped__() is made_here()


def test_pybullets_models_are_found():
    pytest.importorskip("pybullet_data")
    found = library.shipped()
    assert found.title.startswith("pybullet_data")
    by_name = {model.name: model for model in found.models}
    assert len(by_name) > 2000
    panda = by_name["franka_panda/meshes/collision/link5.obj"]
    assert [panda.size(form) for form in (HULL, SOLID)] == [152, 300]
    assert by_name["franka_panda/panda.urdf"].size(COMPOSITE) == 11
    assert "self-intersecting" in by_name["duck.obj"].defect(SOLID)
    assert by_name["duck_vhacd.obj"].size(COMPOSITE) == 5
    assert "not finite" in by_name["random_urdfs/168/168.obj"].defect(HULL)


def test_the_panda_stands_as_its_joints_say():
    pytest.importorskip("pybullet_data")
    (panda,) = (model for model in library.shipped().models if model.name == "franka_panda/panda.urdf")
    hand = refimpl.distance(panda.form(COMPOSITE), refimpl.Point([0.088, 0.0, 5.0]))
    assert 0.7 < 5.0 - float(hand.distance) < 1.3
    assert aabb(panda.form(COMPOSITE)).lower[2] > -0.01


def test_libraries_are_used_innermost_first():
    outer, inner = Library("outer", {}), Library("inner", {})
    with using(outer):
        with using(inner):
            assert library.current() is inner
        assert library.current() is outer
    assert library.current() is library.shipped()


# -- scenes ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_the_regime_places_models_for_every_pair(pair):
    n = 3 if {Polyhedron, Composite} & set(pair) else 30
    with using(made_here()):
        a, b = REGIMES["models"](NumpyDraws(3, (1,), n), *pair)
        again, _ = REGIMES["models"](NumpyDraws(3, (1,), n), *pair)
    assert (type(a), type(b)) == pair
    assert a.batch_shape == b.batch_shape == (n,)
    assert np.array_equal(a.pack(), again.pack())
    assert np.all(a.magnitude < 100)


@pytest.mark.parametrize("kinds", [(ConvexPolyhedron, ConvexPolyhedron), (refimpl.Sphere, ConvexPolyhedron)])
def test_models_touch_overlap_and_stand_apart(kinds):
    with using(made_here()):
        a, b = REGIMES["models"](NumpyDraws(3, (2,), 200), *kinds)
    sigma = refimpl.distance(a, b).distance / np.maximum(a.magnitude, b.magnitude)
    assert np.mean(np.abs(sigma) < 1e-13) > 0.2
    assert np.mean(sigma > 1e-6) > 0.1
    assert np.mean(sigma < -1e-6) > 0.1


@given(data=st.data(), number=st.integers(0, len(TABLE) - 1))
def test_hypothesis_draws_models(data, number):
    pair = list(TABLE)[number]
    with using(made_here()):
        scene = data.draw(scenes(Cell("distance", *pair), ["models"]))
    assert (type(scene.a), type(scene.b)) == pair


def test_simple_proxies_stand_around_their_model():
    with using(made_here()):
        for kind in (refimpl.Sphere, refimpl.Box, refimpl.AABB, refimpl.shapes.KDOP, refimpl.shapes.Ellipsoid):
            for i in range(10):
                around, hull = around_one(kind, i)
                outside = refimpl.distance(refimpl.Point(hull.reshape(-1, 3)), around[0]).distance
                assert np.all(outside <= 1e-12)


def around_one(kind, i):
    from oracles.placed import posed  # noqa: PLC0415

    draws = NumpyDraws(5, (i,), 1)
    stand = posed(draws, made_here().pick(draws, HULL), HULL, np.array([[1.0, 2.0, 3.0]]))
    return stand.make(kind), stand.corners


# -- lists and runs --------------------------------------------------------------------------------------------


def test_the_list_shows_sizes_defects_and_hostile_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "good.obj").write_text(TETRAHEDRON)
    (tmp_path / "open\x1b[31m.obj").write_text(OPEN)
    (tmp_path / "bad.obj").write_text("")
    assert cli.main(["models", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    assert "good.obj" + " " * (listed.NAME_WIDTH - 8 + 9) + "4" + " " * 9 + "4" + " " * 9 + "–" in shown
    assert "no solid: open: the edge from vertex" in shown
    assert "bad.obj holds no triangle" in shown
    assert shown.rstrip().endswith("2 usable as hull, 1 usable as solid, 0 usable as composite")


def test_a_run_uses_the_folder_and_its_report_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    pytest.importorskip("fcl")
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "good.obj").write_text(TETRAHEDRON)
    (tmp_path / "models" / "<img src=x>\x1b.obj").write_text("")
    used = []

    def run_campaign(*_: object, models: str, **__: object) -> Run:
        used.append(of_user(Path(models)))
        run = sample_run()
        run.models = used[0].account()
        run.ledger, run.buckets = [], []  # those of the sample are no entries of the shipped ledger
        return run

    monkeypatch.setattr("oracles.campaign.run_campaign", run_campaign)
    out = tmp_path / "report"
    command = ["run", "--engine", "fcl", "--models", str(tmp_path / "models"), "--out", str(out)]
    assert cli.main(command) == cli.FINISHED
    assert [model.name for model in used[0].models] == ["good.obj"]
    page, markdown = (out / "index.html").read_text(), (out / "report.md").read_text()
    data = json.loads((out / "report.json").read_text())
    assert data["models"][0].endswith("1 model, and 1 that cannot be used")
    assert "holds no triangle" in page
    assert "holds no triangle" in markdown
    assert not any(re.search(r"(?<!\\)<img|\x1b", text) for text in (page, markdown))
    capsys.readouterr()


def test_scenes_name_their_models():
    with using(made_here()):
        batches = Batch.draw((refimpl.Sphere, ConvexPolyhedron), 0, (0, 1), 3)
    named = [
        batch.scene("distance", i) for batch in batches for i, name in enumerate(batch.regimes) if name == "models"
    ]
    assert len(named) == 3
    names = {model.name for model in made_here().models}
    assert all(set(re.findall(r" of (\w+) and (\w+)$", scene.source)[0]) <= names for scene in named)
    assert Model("x\n'''" + "y" * 500, list).label == "..." + "y" * models.LONGEST_LABEL
    assert Model("ü\n", list).label == r"\xfc\n"
