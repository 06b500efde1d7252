"""Regimes keep their promises: for every pair of types, from both sources of numbers, reproducibly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import find, given, settings
from hypothesis import strategies as st

import refimpl
from oracles.batch import Batch
from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES, reasons
from oracles.scene import Cell, Scene, cells
from oracles.strategies import scenes
from refimpl import AABB, Box, Capsule, HalfSpace, Ray, Sphere
from refimpl.pairs import TABLE
from tests.conftest import name_of, scenes_of

ASKED = """generic aligned touching nearly_touching deep concentric parallel_edges face_on_face sliver huge tiny
size_ratio far_away"""


def test_every_regime_that_was_asked_for_exists_and_says_why():
    assert set(ASKED.split()) <= set(REGIMES)
    assert all(len(why) > 30 for why in reasons().values())


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_shard_is_a_pure_function_of_seed_and_number(pair):
    this, again = (Batch.draw(pair, 5, (3, 1), 4) for _ in range(2))
    other, later = Batch.draw(pair, 6, (3, 1), 4), Batch.draw(pair, 5, (3, 2), 4)
    assert np.array_equal(this.a.pack(), again.a.pack())
    assert np.array_equal(this.b.pack(), again.b.pack())
    assert not np.array_equal(this.b.pack(), other.b.pack())
    assert not np.array_equal(this.b.pack(), later.b.pack())
    assert this.regimes == [name for name in REGIMES for _ in range(4)]


def sigma_over_size(pair, regime, n=200):
    a, b = scenes_of(pair, regime, n)
    sigma = refimpl.distance(a, b).distance
    return sigma / np.maximum(a.magnitude, b.magnitude), a, b


SOLID_PAIRS = [(Sphere, Box), (Capsule, Capsule), (Box, Box), (AABB, AABB), (HalfSpace, Box), (AABB, Box)]


@pytest.mark.parametrize("pair", SOLID_PAIRS, ids=name_of)
def test_touching_touches_and_nearly_touching_covers_its_decades(pair):
    touching, _, _ = sigma_over_size(pair, "touching")
    assert np.all(np.abs(touching) < 1e-14)
    nearly, _, _ = sigma_over_size(pair, "nearly_touching", 2000)
    decades = {math.floor(math.log10(abs(x))) for x in nearly if x != 0}
    assert set(range(-14, -1)) <= decades
    assert (nearly > 0).any()
    assert (nearly < 0).any()


@pytest.mark.parametrize("pair", SOLID_PAIRS, ids=name_of)
def test_deep_and_concentric_overlap(pair):
    for regime in ("deep", "concentric"):
        ratio, _, _ = sigma_over_size(pair, regime)
        assert np.mean(ratio < -1e-3) > 0.5


def test_scales_and_places():
    for regime, low, high in (("huge", 1e2, 1e10), ("tiny", 1e-10, 1e-2)):
        _, a, _ = sigma_over_size((Box, Box), regime)
        assert np.all((a.magnitude > low) & (a.magnitude < high))
    _, a, _ = sigma_over_size((Box, Box), "far_away")
    assert np.median(np.abs(a.center)) > 1e3
    assert np.all(a.half_extents <= 1.5)
    _, a, b = sigma_over_size((Sphere, Sphere), "size_ratio")
    ratio = a.radius / b.radius
    assert np.all(np.maximum(ratio, 1 / ratio) > 50)
    _, a, _ = sigma_over_size((Box, Box), "sliver")
    thin = a.half_extents.max(axis=-1) / a.half_extents.min(axis=-1)
    assert np.mean(thin > 100) > 0.5


def test_face_on_face_faces():
    ratio, a, b = sigma_over_size((Box, Box), "face_on_face")
    assert np.all(np.abs(ratio) <= 1)
    assert np.array_equal(a.rotation, b.rotation)
    assert np.mean(np.abs(ratio) < 1e-2) > 0.5
    facing = refimpl.distance(*scenes_of((HalfSpace, HalfSpace), "face_on_face", 50)).distance
    assert np.isfinite(facing).all()


def test_parallel_edges_meet_at_tiny_angles():
    a, b = scenes_of((Capsule, Capsule), "parallel_edges", 500)
    u, v = a.q - a.p, b.q - b.p
    sine = np.linalg.norm(np.cross(u, v), axis=-1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
    assert np.mean(sine < 1e-6) > 0.3
    assert np.any((sine > 1e-10) & (sine < 1e-4))


@pytest.mark.parametrize("solid", [Sphere, Capsule, AABB, Box, HalfSpace])
def test_rays_hit_and_miss(solid):
    hits = refimpl.raycast(*scenes_of((Ray, solid), "generic", 300)).hit
    assert 0.1 < np.mean(hits) < 0.95


@pytest.mark.parametrize("regime", REGIMES)
@given(data=st.data(), number=st.integers(0, len(TABLE) - 1))
def test_hypothesis_draws_every_regime(regime, data, number):
    pair = list(TABLE)[number]
    scene = data.draw(scenes(Cell("distance", *pair), [regime]))
    assert (type(scene.a), type(scene.b)) == pair
    assert scene.a.batch_shape == scene.b.batch_shape == ()
    again = Scene.from_json(scene.to_json())
    assert again.id == scene.id


def test_hypothesis_shrinks_to_a_simple_scene():
    cell = Cell("distance", Sphere, Sphere)
    least = find(
        scenes(cell), lambda s: refimpl.distance(s.a, s.b).distance < -0.1, settings=settings(max_examples=200)
    )
    digits = sum(len(f"{x:g}") for x in [*least.a.pack(), *least.b.pack()])
    assert digits <= 24, least


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"query": "smell"}, "unknown query 'smell'"),
        ({"a": {"type": "Cone", "numbers": []}}, "unknown type 'Cone'"),
        ({"a": {"type": "Sphere", "numbers": [1]}}, "a Sphere has 4 numbers"),
        ({"a": {"type": "Sphere", "numbers": [0, 0, 0, -1]}}, "Sphere.radius must be greater than 0"),
        ({"b": None}, "not a scene"),
    ],
)
def test_scenes_from_strangers_are_checked(change, words):
    good = Scene("distance", Sphere([0, 0, 0], 1), Sphere([1, 0, 0], 1), "generic", "here").to_json()
    with pytest.raises(ValueError, match=words.replace(".", r"\.")):
        Scene.from_json(good | change)


def test_all_cells_are_there():
    found = cells()
    assert len(found) == 20 * 3 + 5
    assert len({(c.type_a, c.type_b) for c in found}) == 25
    shapes = NumpyDraws(1, (2,), 3)
    assert shapes.choice((1.0, 2.0), 3).shape == (3, 3)
