"""Models: what each can be used as, and what keeps it from the rest."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import refimpl
from oracles import models
from oracles.library import made_here, of_folder
from oracles.meshfiles import ModelError
from oracles.models import COMPOSITE, FORMS, HULL, SOLID, Model
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron
from tests.test_meshfiles import OPEN, TETRAHEDRON, TWO


def model_of(folder: Path, text: str, name: str = "m.obj") -> Model:
    (folder / name).write_text(text)
    (model,) = of_folder(folder).models
    return model


def test_a_closed_mesh_of_two_objects_has_all_forms(tmp_path: Path):
    model = model_of(tmp_path, TWO)
    assert [type(model.form(form)) for form in FORMS] == [ConvexPolyhedron, Polyhedron, Composite]
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
        (TWO.replace("v 5", "v 0.2").replace("v 6", "v 1.2"), SOLID, "self-intersecting"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n", HULL, "is flat"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", HULL, "is flat"),
        (TETRAHEDRON, COMPOSITE, "is one piece"),
        (TWO.replace("v 5 0 1", "v 6 1 0"), COMPOSITE, "is flat"),
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


def test_concave_edges_are_counted_and_too_many_refused(monkeypatch: pytest.MonkeyPatch):
    by_name = {model.name: model for model in made_here().models}
    assert models.concave_edges(by_name["bracket"].form(SOLID)) == 1
    assert models.concave_edges(by_name["gear"].form(SOLID)) == 12 + 24
    monkeypatch.setattr(models, "MOST_CONCAVE", 35)
    fresh = Model("gear", by_name["gear"].read)
    assert fresh.defect(SOLID) == "splits into too many convex pieces: 36 concave edges, at most 35"


def enclosed_volume(solid: Polyhedron) -> float:
    a, b, c = np.moveaxis(solid.vertices[solid.triangles], 1, 0)
    return float(np.sum(np.cross(a, b) * c) / 6)


def test_limits_stand_in_the_defect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(models, "MOST_FACES", 3)
    monkeypatch.setattr(models, "MOST_VERTICES", 3)
    monkeypatch.setattr(models, "MOST_PARTS", 1)
    model = model_of(tmp_path, TWO)
    assert model.defect(SOLID) == "is too large: 8 faces, at most 3"
    assert model.defect(HULL) == "is too large: 6 vertices on its hull, at most 3"
    assert model.defect(COMPOSITE) == "is too large: 2 parts, at most 1"
