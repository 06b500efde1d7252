"""Regimes keep their promises: for every pair of types, from both sources of numbers, reproducibly."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import find, given, settings
from hypothesis import strategies as st

import refimpl
from oracles import solids
from oracles.batch import COMBINATIONS_EACH, Batch
from oracles.bodies import KITS, random_body, round_body
from oracles.draws import NumpyDraws
from oracles.engines import load_engine
from oracles.frames import FRAMES
from oracles.impact_regimes import IMPACT_REGIMES, impact_regimes_for
from oracles.placements import PLACEMENTS
from oracles.recipes import regimes_of
from oracles.regimes import BUILDS, COMBINATIONS, COMBINED, REGIMES, combination_name, reasons, regimes_for
from oracles.scene import TYPES, Cell, Scene, cells
from oracles.strategies import scenes
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
    Point,
    Polyhedron,
    Ray,
    Sphere,
    flat,
)
from refimpl.meshes import require_solid
from refimpl.pairs import TABLE
from tests.conftest import effort, name_of, scenes_of

ASKED = """generic aligned touching nearly_touching deep concentric parallel_edges face_on_face sliver huge tiny
size_ratio far_away turned single_precision combined models"""


def test_every_regime_that_was_asked_for_exists_and_says_why():
    assert set(ASKED.split()) <= set(REGIMES)
    assert all(len(why) > 30 for why in reasons().values())


ENGINES = [load_engine(name) for name in ("fcl", "bullet", "pybullet-defaults")]
WITH_THRESHOLDS = regimes_for(ENGINES)


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_a_shard_is_a_pure_function_of_seed_and_number(pair):
    this = named(pair, 5, 1)
    often = 1 if pair[0].header or pair[1].header else COMBINATIONS_EACH
    wanted = {(name, i) for name in WITH_THRESHOLDS for i in range(2 * often if name == COMBINED else 2)}
    assert this.keys() == wanted
    generic = {"generic": WITH_THRESHOLDS["generic"]}
    for seed, number in ((6, 1), (5, 2)):
        other = named(pair, seed, number, generic)
        assert len(other) == 2
        assert all(this[key] != bits for key, bits in other.items())
    others = {name: regime for name, regime in WITH_THRESHOLDS.items() if name not in REGIMES}
    assert named(pair, 5, 1, REGIMES) | named(pair, 5, 1, others) == this  # again, and of each regime alone


def named(pair, seed, number, regimes=WITH_THRESHOLDS):
    """Bits of every scene of a shard, by regime and number within it."""
    found = {}
    for batch in Batch.draw(pair, seed, (3, number), 2, regimes):
        assert len(batch) == len(batch.a) == len(batch.b) == len(batch.regimes)
        for i, (a, b) in enumerate(zip(*batch.rows, strict=True)):
            scene = batch.scene("distance", i)
            assert np.array_equal(scene.a.pack(), a)
            assert np.array_equal(scene.b.pack(), b)
            assert np.isfinite(a).all()
            assert np.isfinite(b).all()
            assert (": " in scene.source) == (batch.regimes[i] == COMBINED)
            first = batch.numbers[np.array(batch.regimes) == batch.regimes[i]].min()
            found[batch.regimes[i], int(batch.numbers[i] - first)] = (a.tobytes(), b.tobytes())
    return found


def sigma_over_size(pair, regime, n=200):
    a, b = scenes_of(pair, regime, n)
    sigma = refimpl.distance(a, b).distance
    return sigma / np.maximum(a.magnitude, b.magnitude), a, b


SOLID_PAIRS = [(Sphere, Box), (Capsule, Capsule), (Box, Box), (AABB, AABB), (HalfSpace, Box), (AABB, Box)]
NEW_PAIRS = [(Sphere, Ellipsoid), (HalfSpace, Cylinder), (Box, ConvexPolyhedron), (Capsule, KDOP)]


@pytest.mark.parametrize("pair", SOLID_PAIRS, ids=name_of)
def test_touching_touches_and_nearly_touching_covers_its_decades(pair):
    touching, _, _ = sigma_over_size(pair, "touching")
    assert np.all(np.abs(touching) < 1e-14)
    nearly, _, _ = sigma_over_size(pair, "nearly_touching", 2000)
    decades = {math.floor(math.log10(abs(x))) for x in nearly if x != 0}
    assert set(range(-14, -1)) <= decades
    assert (nearly > 0).any()
    assert (nearly < 0).any()


@pytest.mark.parametrize("pair", NEW_PAIRS, ids=name_of)
def test_new_types_touch_where_they_should(pair):
    ratio, _, _ = sigma_over_size(pair, "touching", 12)
    assert np.all(np.abs(ratio) < 1e-11)
    nearly, _, _ = sigma_over_size(pair, "nearly_touching", 12)
    assert np.all(np.abs(nearly) <= 1)
    assert (nearly > 0).any()
    assert (nearly < 0).any()


@pytest.mark.parametrize("pair", SOLID_PAIRS + NEW_PAIRS, ids=name_of)
def test_deep_and_concentric_overlap(pair):
    for regime in ("deep", "concentric"):
        ratio, _, _ = sigma_over_size(pair, regime, 200 if pair in SOLID_PAIRS else 20)
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


def test_where_single_precision_ends_scenes_are_far_for_their_size():
    _, a, b = sigma_over_size((Box, Box), "single_precision")
    away = np.maximum(np.abs(a.center), np.abs(b.center)).max(axis=-1)
    size = np.maximum(a.half_extents, b.half_extents).max(axis=-1)
    far = away[away > 100 * size] / size[away > 100 * size]
    assert np.mean(away > 100 * size) > 0.9
    assert np.all((far > 2.0**17) & (far < 2.0**27))


def test_turned_stacks_are_stacked_still():
    ratio, a, _ = sigma_over_size((Box, Box), "turned")
    assert np.mean(np.abs(ratio) < 1e-2) > 0.5
    axes = np.sort(np.abs(a.rotation / np.linalg.norm(a.rotation, axis=-1, keepdims=True)), axis=-1)
    assert np.mean(axes[:, 0] > 1e-2) > 0.5


# -- combinations ----------------------------------------------------------------------------------------------


def test_every_build_is_combined_with_every_placement_and_frame():
    assert len(COMBINATIONS) == len(BUILDS) * len(PLACEMENTS) * len(FRAMES) == 324
    assert next(iter(COMBINATIONS)) == "generic"
    assert {"touching · sliver · far away", "touching", "sliver", "nearly touching · huge"} <= set(COMBINATIONS)


def test_all_combinations_are_drawn_over_time():
    drawn = set()
    for number in range(1000):
        for batch in Batch.draw((Sphere, Sphere), 1, (number, 3), 1, {COMBINED: REGIMES[COMBINED]}):
            drawn |= {batch.scene("distance", i).source.partition(": ")[2] for i in range(len(batch))}
    assert drawn == set(COMBINATIONS)


@pytest.mark.parametrize("pair", TABLE, ids=name_of)
def test_combinations_are_sound_for_every_pair(pair):
    names = list(COMBINATIONS)
    first = list(TABLE).index(pair)
    for k in range(first, first + 5 * effort(), 5):
        name = names[k * 37 % len(names)]
        a, b = COMBINATIONS[name].draft(NumpyDraws(9, (k,), 3), *pair).settled()
        assert (type(a), type(b)) == pair
        assert np.isfinite(a.pack()).all(), name
        assert np.isfinite(b.pack()).all(), name
        asked = refimpl.raycast(a, b).hit if isinstance(a, Ray) else refimpl.distance(a, b).distance
        assert len(asked) == 3


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("build", BUILDS)
def test_combinations_do_what_each_of_their_parts_says(build, frame):
    def made(placement):
        name = combination_name(build, placement, frame)
        return COMBINATIONS[name].draft(NumpyDraws(4, (1,), 200), Capsule, Box).settled()

    a, b = made("touching")
    sigma = refimpl.distance(a, b).distance
    assert np.all(np.abs(sigma) <= 1e-13 * np.maximum(a.magnitude, b.magnitude))
    a, b = made("deep" if build != "size_ratio" else "concentric")
    assert np.mean(refimpl.distance(a, b).distance <= 0) > 0.4
    a, b = made("free")
    thin = b.half_extents.max(axis=-1) > 100 * b.half_extents.min(axis=-1)
    assert (np.mean(thin) > 0.5) == (build in ("sliver", "degenerate"))
    sizes = np.stack([np.maximum(a.radius, np.linalg.norm(a.q - a.p, axis=-1) / 2), b.half_extents.max(axis=-1)])
    large, small = sizes.max(axis=0), sizes.min(axis=0)
    assert (np.mean(large > 100 * small) > 0.9) == (build == "size_ratio")
    size = small if build == "size_ratio" else large
    assert (np.median(size) > 100) == (frame == "huge")
    assert (np.median(size) < 1e-2) == (frame == "tiny")
    away = np.abs(b.center).max(axis=-1)[size > 0] / size[size > 0]
    assert (np.median(away) > 500) == (frame in ("far_away", "single_precision"))
    assert frame != "single_precision" or np.median(away) > 2.0**17


# -- thresholds of engines -------------------------------------------------------------------------------------


def test_engines_that_declare_thresholds_have_regimes_about_them():
    assert set(WITH_THRESHOLDS) - set(REGIMES) == {"thresholds_of_fcl", "thresholds_of_bullet"}
    assert "margin 0.001" in reasons(WITH_THRESHOLDS)["thresholds_of_bullet"]
    assert set(regimes_of("impact", ENGINES)) - set(IMPACT_REGIMES) == {"speeds_of_pybullet-defaults"}
    assert regimes_of("distance", ENGINES) == list(WITH_THRESHOLDS)
    assert regimes_of("distance") == list(REGIMES)


@pytest.mark.parametrize(("name", "lengths"), [("thresholds_of_fcl", [1e-6]), ("thresholds_of_bullet", [1e-3, 0.02])])
def test_gaps_overlaps_and_sizes_lie_about_the_thresholds(name, lengths):
    a, b = WITH_THRESHOLDS[name](NumpyDraws(4, (1,), 1000), Box, Box)
    sigma = refimpl.distance(a, b).distance
    sizes = np.concatenate([a.half_extents.min(axis=-1), b.half_extents.min(axis=-1)])
    for length in lengths:
        for factor in (0.1, 0.99, 1.0, 1.01, 10.0):
            for values in (sigma, -sigma, sizes):
                assert np.isclose(values, factor * length, rtol=1e-7, atol=0.0).any(), (length, factor)


def test_speeds_lie_about_the_thresholds():
    make = impact_regimes_for(ENGINES)["speeds_of_pybullet-defaults"]
    _, _, motion = make(NumpyDraws(4, (1,), 500), Sphere, Box)
    closing = np.abs(motion.closing) / np.linalg.norm(motion.normal, axis=-1)
    for factor in (0.1, 0.99, 1.0, 1.01, 10.0):
        assert np.isclose(closing, 0.2 * factor, rtol=1e-9, atol=0.0).any()


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


@pytest.mark.parametrize("solid", [b for a, b in TABLE if a is Ray])
def test_rays_hit_and_miss(solid):
    hits = refimpl.raycast(*scenes_of((Ray, solid), "generic", 300)).hit
    assert 0.05 < np.mean(hits) < 0.95


@pytest.mark.parametrize("regime", WITH_THRESHOLDS)
@given(data=st.data(), number=st.integers(0, len(TABLE) - 1))
def test_hypothesis_draws_every_regime(regime, data, number):
    pair = list(TABLE)[number]
    scene = data.draw(scenes(Cell("distance", *pair), [regime], ENGINES))
    assert (type(scene.a), type(scene.b)) == pair
    assert scene.a.batch_shape == scene.b.batch_shape == ()
    again = Scene.from_json(scene.to_json())
    assert again.id == scene.id


# -- types without a fixed form ------------------------------------------------------------------------------

KINDS = [Point, Ray, Sphere, Capsule, HalfSpace, AABB, Box, KDOP, Ellipsoid, Cylinder]
KINDS += [ConvexPolyhedron, Polyhedron, Composite]


def made(kind, n=3, many=60):
    """Batches of a type from bodies of all sorts."""
    for i in range(many):
        draws = NumpyDraws(11, (i,), n)
        yield (round_body if i % 2 else random_body)(draws).make(kind)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_type_is_made_and_travels_as_rows_and_as_json(kind):
    for shapes in made(kind, many=12):
        assert type(shapes) is kind
        assert shapes.batch_shape == (3,)
        rows = shapes.pack()
        again = kind.unpack(rows)
        np.testing.assert_array_equal(again.pack(), rows)
        one = shapes[1]
        np.testing.assert_array_equal(one.pack(), rows[1])
        scene = Scene("distance", Sphere([0, 0, 0], 1), one, "here")
        if kind.__name__ in TYPES:
            back = Scene.from_json(json.loads(json.dumps(scene.to_json())))
            assert back.id == scene.id
            np.testing.assert_array_equal(back.b.pack(), one.pack())


def test_k_dops_are_the_usual_ones_and_odd_ones():
    sizes = {shapes.lower.shape[-1] for shapes in made(KDOP, n=1, many=200)}
    assert {3, 7, 9, 13} <= sizes
    assert sizes - {3, 7, 9, 13}


def test_hulls_are_given_by_planes_and_by_vertices_and_have_4_to_16():
    found = [shapes[0] for shapes in made(ConvexPolyhedron, n=1, many=200)]
    assert {hull.given for hull in found} == {"planes", "vertices"}
    counts = {hull.numbers.shape[-2] for hull in found if hull.given == "vertices"}
    assert min(counts) == 4
    assert max(counts) == 16
    assert all(hull.hull.dimension == 3 for hull in found)


def test_slivers_hold_flat_hulls():
    flat = [scenes_of((Sphere, ConvexPolyhedron), "sliver", 4, seed=seed)[1].hull.dimension < 3 for seed in range(6)]
    assert 0.05 < np.mean(flat) < 0.9


@pytest.mark.parametrize("make", solids.MESHES, ids=lambda make: make.__name__)
@pytest.mark.parametrize("width", [0.2, 0.5, 0.8])
def test_the_meshes_bound_solids(make, width):
    require_solid(*make(width))


def test_composites_have_two_to_four_parts():
    found = list(made(Composite, n=1, many=60))
    assert {len(union.parts) for union in found} == {len(kit) for kit in KITS} == {2, 3, 4}
    assert {type(part) for union in found for part in union.parts} == {kind for kit in KITS for kind in kit}


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
        ({"a": {"type": "KDOP", "numbers": []}}, "expected 1 sizes first"),
        ({"a": {"type": "KDOP", "numbers": [1e9, 1, 0, 0]}}, "expected rows of 5000000001 numbers"),
        ({"a": {"type": "KDOP", "numbers": [1, 1, 0, 0, 2, 1]}}, "must not be below KDOP.lower"),
        ({"a": {"type": "ConvexPolyhedron", "numbers": [2, 1, 0, 0]}}, "must be 0 for planes or 1 for vertices"),
        ({"a": {"type": "KDOP", "numbers": [0.0] * 1_000_001}}, "at most 1000000 numbers"),
        ({"b": None}, "not a scene"),
    ],
)
def test_scenes_from_strangers_are_checked(change, words):
    good = Scene("distance", Sphere([0, 0, 0], 1), Sphere([1, 0, 0], 1), "generic", "here").to_json()
    with pytest.raises(ValueError, match=words.replace(".", r"\.")):
        Scene.from_json(good | change)


def test_all_cells_are_there():
    found = cells()
    pairs = [*TABLE, *flat.table()]
    rays = [pair for pair in pairs if pair[0] in (Ray, flat.FlatRay)]
    assert len(rays) == 15
    assert len(found) == (len(pairs) - len(rays)) * 5 + len(rays)
    assert {(c.type_a, c.type_b) for c in found} == set(pairs)
    shapes = NumpyDraws(1, (2,), 3)
    assert shapes.choice((1.0, 2.0), 3).shape == (3, 3)
