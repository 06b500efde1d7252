"""The model library: what files hold, what a model can be used as, and scenes made of models."""

from __future__ import annotations

import math
import pickle
import struct
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import refimpl
from oracles import library, meshfiles, models
from oracles.draws import NumpyDraws
from oracles.library import Library, made_here, of_folder, of_user, using
from oracles.meshfiles import ModelError, read_mesh
from oracles.models import COMPOSITE, FORMS, HULL, SOLID, Model
from oracles.regimes import REGIMES
from oracles.scene import Cell
from oracles.strategies import scenes
from refimpl.pairs import TABLE
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron
from reports import cli
from reports import models as listed
from tests.conftest import name_of

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
OPEN = TETRAHEDRON.replace("f 2 3 4\n", "")
TWO = (
    TETRAHEDRON.replace("v", "o one\nv", 1)
    + "o two\n"
    + "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n"
)


def stl(*triangles: list[list[float]], said: int | None = None) -> bytes:
    """Binary STL; `said` is how many triangles its header claims."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0) for t in triangles)
    return b"\0" * 80 + struct.pack("<I", len(triangles) if said is None else said) + rows


# -- files ---------------------------------------------------------------------------------------------------


def test_equal_corners_become_one_vertex(tmp_path: Path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 1]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    (tmp_path / "t.STL").write_bytes(stl(*(corners[f].tolist() for f in faces)))
    (mesh,) = read_mesh(tmp_path / "t.STL")
    assert mesh.vertices.shape == (4, 3)
    assert mesh.triangles.shape == (4, 3)
    (tmp_path / "t.obj").write_text(TETRAHEDRON.replace("f", "# a comment, and a vertex of no face\nv 9 9 9\nf", 1))
    (other,) = read_mesh(tmp_path / "t.obj")
    assert np.array_equal(mesh.vertices, other.vertices)


def test_quads_relative_indices_and_objects(tmp_path: Path):
    (tmp_path / "q.obj").write_bytes("# grün\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n".encode("latin-1"))
    (mesh,) = read_mesh(tmp_path / "q.obj")
    assert mesh.triangles.shape == (2, 3)
    (tmp_path / "two.obj").write_text(TWO)
    one, two = read_mesh(tmp_path / "two.obj")
    assert len(one.vertices) == len(two.vertices) == 4


def test_what_a_file_refers_to_is_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "m.obj").write_text("mtllib ../secret.mtl\nusemtl x\n" + TETRAHEDRON)
    (tmp_path.parent / "secret.mtl").write_text("newmtl x\nmap_Kd /etc/passwd\n")
    opened = []
    monkeypatch.setattr("builtins.open", lambda *a, **_: opened.append(a))
    assert len(read_mesh(tmp_path / "m.obj")[0].triangles) == 4
    assert opened == []


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.obj", b"", "holds no triangle"),
        ("a.obj", b"v 1 2 3\n", "holds no triangle"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v nan 0 0").encode(), "not finite"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v 1e999 0 0").encode(), "not finite"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v 1e300 0 0").encode(), "a coordinate of 1e+300, at most 1e+09"),
        ("a.obj", TETRAHEDRON.replace("f 2 3 4", "f 2 3 99").encode(), "is broken"),
        ("a.obj", TETRAHEDRON.replace("f 2 3 4", "f 2 3 -99").encode(), "is broken"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v one 0 0").encode(), "is broken"),
        ("a.obj", pickle.dumps({"vertices": [1, 2, 3]}), "holds no triangle"),
        ("a.obj", b"\xff\xfe\x00\x01" * 1000, ""),
        ("a.obj", b"o x\n" * 5000 + TETRAHEDRON.encode(), "is too large: 5000 objects, at most 1000"),
        ("a.stl", b"", ""),
        ("a.stl", stl(), "holds no triangle"),
        ("a.stl", stl([[0, 0, 0], [1, 0, 0], [0, 1, 0]], said=2**32 - 1), ""),
        ("a.stl", stl([[0, 0, math.nan], [1, 0, 0], [0, 1, 0]]), "not finite"),
        ("a.stl", stl([[0, 0, 1e38], [1, 0, 0], [0, 1, 0]]), "a coordinate of 1e+38"),
        ("a.stl", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0\n", ""),
        ("a.dae", b"<COLLADA/>", "is of no format that is read: .dae; convert it to OBJ or STL"),
        ("a.zip", b"PK\3\4", "is of no format that is read"),
    ],
)
def test_broken_meshes_are_refused_with_the_reason(tmp_path: Path, name: str, data: bytes, words: str):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ModelError) as error:
        read_mesh(tmp_path / name)
    assert words in str(error.value)
    assert len(str(error.value)) < 400


def test_large_files_are_refused_before_they_are_parsed(tmp_path: Path):
    path = tmp_path / "large.obj"
    with path.open("wb") as file:
        file.truncate(2**40)  # a terabyte, sparse
    began = time.monotonic()
    with pytest.raises(ModelError, match="more than 8 MiB"):
        read_mesh(path)
    faces = meshfiles.MOST_FACES + 1
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * faces)
    with pytest.raises(ModelError, match=f"is too large: {faces} faces"):
        read_mesh(path)
    for many in ("f" + " 1 2 3" * 10**6, "f 1 2 3 \\\n 4 " * 300_000, "usemtl a\nf 1 2 3\n" * 400_000):
        path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + many)
        with pytest.raises(ModelError, match="is too large: as long as 50000 faces"):
            read_mesh(path)
    assert time.monotonic() - began < 10


# -- forms ---------------------------------------------------------------------------------------------------


def model_of(folder: Path, text: str, name: str = "m.obj") -> Model:
    (folder / name).write_text(text)
    (model,) = of_folder(folder).models
    return model


def test_a_closed_mesh_has_all_forms(tmp_path: Path):
    model = model_of(tmp_path, TETRAHEDRON)
    assert [type(model.form(form)) for form in FORMS] == [ConvexPolyhedron, Polyhedron, Composite]
    assert [model.size(form) for form in FORMS] == [4, 4, 1]
    assert not any(model.defect(form) for form in FORMS)


def test_objects_become_the_parts_of_a_composite(tmp_path: Path):
    model = model_of(tmp_path, TWO)
    assert [model.size(form) for form in FORMS] == [6, 8, 2]
    between = refimpl.distance(model.form(COMPOSITE), refimpl.Point([3.0, 0, 0])).distance
    assert between == 2
    assert refimpl.distance(model.form(HULL), refimpl.Point([3.0, 0, 0])).distance <= 0


@pytest.mark.parametrize(
    ("text", "form", "words"),
    [
        (OPEN, SOLID, "open: the edge from vertex"),
        (TETRAHEDRON.replace("f 1 3 2", "f 1 2 3"), SOLID, "flipped"),
        (TETRAHEDRON + "f 2 3 4\n", SOLID, "not a surface"),
        (TETRAHEDRON + TETRAHEDRON.replace("v 0 0 0", "v 0.1 0.1 0.1"), SOLID, ""),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n", HULL, "is flat"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", HULL, "is flat"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", COMPOSITE, "part 0 is flat"),
        ("v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", HULL, "is flat"),
        (TETRAHEDRON.replace("v 0 0 1", "v 0 0 1e-12"), HULL, "next to no volume"),
    ],
)
def test_defects_are_named(tmp_path: Path, text: str, form: str, words: str):
    model = model_of(tmp_path, text)
    with pytest.raises(ModelError) as error:
        model.form(form)
    assert words in str(error.value)
    assert model.defect(form) == str(error.value)


def test_models_made_in_code_have_their_shapes():
    by_name = {model.name: model for model in made_here().models}
    assert all(any(not m.defect(form) for m in by_name.values()) for form in FORMS)
    gear = by_name["gear"].form(SOLID)
    tooth = math.sin(math.pi / 12) / 2
    area = 24 * tooth * (0.05 * 0.04 - 0.01**2)
    assert np.isclose(enclosed_volume(gear), area * 0.012, rtol=1e-12)
    assert np.isclose(enclosed_volume(by_name["bracket"].form(SOLID)), (60 * 2 + 38 * 2) * 30e-9, rtol=1e-12)
    assert by_name["pebble"].size(HULL) == 40
    waist = refimpl.distance(by_name["dumbbell"].form(COMPOSITE), refimpl.Point([0, 0, 0.02])).distance
    assert np.isclose(waist, 0.008)
    assert by_name["table"].size(COMPOSITE) == 5


def enclosed_volume(solid: Polyhedron) -> float:
    a, b, c = np.moveaxis(solid.vertices[solid.triangles], 1, 0)
    return float(np.sum(np.cross(a, b) * c) / 6)


# -- libraries -----------------------------------------------------------------------------------------------


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
    assert "none of them is a solid: models made in code took the place" in found.account()


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
    assert [panda.size(form) for form in FORMS] == [152, 300, 1]
    assert by_name["franka_panda/panda.urdf"].size(COMPOSITE) == 11
    assert "self-intersecting" in by_name["duck.obj"].defect(SOLID)
    assert by_name["duck_vhacd.obj"].size(COMPOSITE) == 5
    assert "not finite" in by_name["random_urdfs/168/168.obj"].defect(HULL)


def test_the_panda_stands_as_its_joints_say():
    pytest.importorskip("pybullet_data")
    (panda,) = (model for model in library.shipped().models if model.name == "franka_panda/panda.urdf")
    hand = refimpl.distance(panda.form(COMPOSITE), refimpl.Point([0.088, 0.0, 5.0]))
    assert 0.7 < 5.0 - float(hand.distance) < 1.3
    assert panda.form(COMPOSITE).aabb.lower[2] > -0.01


# -- scenes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_the_regime_places_models_for_every_pair(pair):
    with using(made_here()):
        a, b = REGIMES["models"](NumpyDraws(3, (1,), 30), *pair)
        again, _ = REGIMES["models"](NumpyDraws(3, (1,), 30), *pair)
    assert (type(a), type(b)) == pair
    assert a.batch_shape == b.batch_shape == (30,)
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


# -- the list ------------------------------------------------------------------------------------------------


def test_the_list_shows_sizes_defects_and_hostile_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "good.obj").write_text(TETRAHEDRON)
    (tmp_path / "open\x1b[31m.obj").write_text(OPEN)
    (tmp_path / "bad.obj").write_text("")
    assert cli.main(["models", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    assert "good.obj" + " " * (listed.NAME_WIDTH - 8 + 9) + "4" + " " * 9 + "4" + " " * 9 + "1" in shown
    assert "no solid: open: the edge from vertex" in shown
    assert "bad.obj holds no triangle" in shown
    assert shown.rstrip().endswith("2 usable as hull, 1 usable as solid, 2 usable as composite")


def test_limits_stand_in_the_defect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(models, "MOST_FACES", 3)
    monkeypatch.setattr(models, "MOST_VERTICES", 3)
    monkeypatch.setattr(models, "MOST_PARTS", 0)
    model = model_of(tmp_path, TETRAHEDRON)
    assert model.defect(SOLID) == "is too large: 4 faces, at most 3"
    assert model.defect(HULL) == "is too large: 4 vertices on its hull, at most 3"
    assert model.defect(COMPOSITE) == "is too large: 1 parts, at most 0"


def test_libraries_are_used_innermost_first():
    outer, inner = Library("outer", {}), Library("inner", {})
    with using(outer):
        with using(inner):
            assert library.current() is inner
        assert library.current() is outer
    assert library.current() is library.shipped()
