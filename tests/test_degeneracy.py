"""What is special about a scene: told of examples, and the same however the scene is named, moved or scaled."""

from __future__ import annotations

import numpy as np
import pytest

from oracles.batch import Batch
from oracles.clumsiness import clumsiness, odd_numbers
from oracles.degeneracy import CLASSES, FREE, GENERIC, degeneracy, features, gaps_of
from oracles.impact_stages import STAGED
from oracles.motion import Motion, Moving
from oracles.plain import plain_scenes
from oracles.plain_bodies import PLAIN_BODIES
from oracles.plain_impacts import TOUCHES, restaged, simpler_motions
from oracles.scene import DISTANCE, IMPACT, RAYCAST, Cell, Scene, cells
from oracles.world import PLANE, world_of
from refimpl import (
    AABB,
    Box,
    Capsule,
    Composite,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Proxy,
    Ray,
    Sphere,
    UnsupportedOperation,
    distance,
)
from refimpl.pairs import TABLE
from refimpl.shapes import ConvexPolyhedron, Polyhedron

UNIT, TURNED = [0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0, 7.0]
ORIGIN, ONES = [0.0] * 3, [1.0] * 3


def ball(x: float, y: float = 0.0, z: float = 0.0, r: float = 1.0) -> Sphere:
    return Sphere([x, y, z], r)


EXAMPLES: list[tuple[str, Proxy, Proxy]] = [
    ("generic", ball(0), ball(2.5)),
    ("generic", ball(0), Box([1.5, 0.3, 0.2], ONES, TURNED)),
    ("touching", ball(0), ball(2)),
    ("nearly touching", ball(0), ball(2.0005)),
    ("nearly touching", ball(0), ball(2 - 1e-9)),
    ("concentric", ball(0), ball(0, r=2.0)),
    ("coaxial", ball(0, 0, 0.25, r=1.5), Capsule([0.0, 0.0, -2.0], [0.0, 0.0, 2.0], 1.0)),
    ("coaxial", Cylinder(ORIGIN, [0.0, 0.0, 1.0], 1.0), Capsule([0.0, 0.0, 3.0], [0.0, 0.0, 4.0], 0.5)),
    ("deep", ball(0), ball(0.5, r=3.0)),
    ("parallel", AABB(ORIGIN, ONES), Box([3.0, 2.5, 2.5], ONES, UNIT)),
    ("nearly parallel", AABB(ORIGIN, ONES), Box([3.0, 2.5, 2.5], ONES, [0.0, 0.0, 1e-6, 1.0])),
    ("touching", AABB(ORIGIN, ONES), Box([2.0, 0.5, 0.5], ONES, UNIT)),
    ("nearly touching", AABB(ORIGIN, ONES), Box([2.0005, 0.5, 0.5], ONES, UNIT)),
    ("huge", ball(0, r=1e5), ball(2.5e5, r=1e5)),
    ("tiny", ball(0, r=1e-5), ball(2.5e-5, r=1e-5)),
    ("very unequal", ball(0), ball(1.5, r=1e-3)),
    ("far away", ball(1e4), ball(1e4 + 2.5)),
    ("thin", ball(0), Box([1.5, 0.0, 0.0], [1.0, 1e-4, 1.0], TURNED)),
    ("generic", Point([0.1, 0.2, 0.3]), HalfSpace([1.0, 2.0, 3.0], 1.0)),
    ("generic", Ray([-3.0, 0.4, 0.0], [1.0, 0.1, 0.0]), ball(0)),
    ("from inside", Ray([0.2, 0.0, 0.0], [1.0, 0.1, 0.0]), ball(0)),
    ("from the surface", Ray([-1.0, 0.0, 0.0], [1.0, 0.1, 0.0]), ball(0)),
    ("behind", Ray([-3.0, 0.4, 0.0], [-1.0, 0.1, 0.0]), ball(0)),
    ("touching", Ray([-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]), ball(0)),
    ("nearly touching", Ray([-3.0, 1.0 - 1e-7, 0.0], [1.0, 0.0, 0.0]), ball(0)),
    ("parallel", Ray([-3.0, 0.4, 0.0], [1.0, 0.0, 0.0]), AABB([-1.0] * 3, ONES)),
    ("odd direction", Ray([-3.0, 0.4, 0.0], [1e6, 1e5, 0.0]), ball(0)),
]


@pytest.mark.parametrize(("expected", "a", "b"), EXAMPLES)
def test_examples_have_the_class_that_one_would_name(expected: str, a: Proxy, b: Proxy) -> None:
    assert degeneracy(scene_of(a, b)) == expected


def scene_of(a: Proxy, b: Proxy, query: str = DISTANCE) -> Scene:
    return Scene(RAYCAST if isinstance(a, Ray) else query, a, b, "example")


def test_two_bodies_that_face_each_other_are_told_from_two_that_do_not() -> None:
    facing = scene_of(AABB(ORIGIN, ONES), Box([2.0005, 0.5, 0.5], ONES, UNIT))
    aside = scene_of(AABB(ORIGIN, ONES), AABB([1.0003, 1.0004, 0.0], [2.0, 2.0, 1.0]))
    assert "face on face" in features(facing)
    assert "face on face" not in features(aside)


MOVING = {
    "position": np.zeros(3),
    "angular_velocity": np.zeros(3),
    "inverse_mass": np.asarray(1.0),
    "inertia": np.eye(3),
}


def impact(va: list[float], vb: list[float], inverse: float = 1.0) -> Scene:
    a = Moving(velocity=np.array(va), **MOVING)
    b = Moving(velocity=np.array(vb), **{**MOVING, "position": np.array([2.0, 0.0, 0.0]), "inverse_mass": inverse})  # type: ignore[arg-type]
    point, normal = np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    return Scene(IMPACT, ball(0), ball(2), "example", "", Motion(a, b, point, normal, np.asarray(0.5), np.asarray(0.0)))


@pytest.mark.parametrize(
    ("expected", "scene"),
    [
        ("head on", impact([1.0, 0.0, 0.0], [0.0, 0.0, 0.0])),
        ("generic", impact([1.0, 0.5, 0.0], [0.0, 0.0, 0.0])),
        ("parting", impact([-1.0, 0.5, 0.0], [0.0, 0.0, 0.0])),
        ("grazing", impact([1e-5, 1.0, 0.0], [0.0, 0.0, 0.0])),
        ("fast", impact([100.0, 50.0, 0.0], [0.0, 0.0, 0.0])),
        ("slow", impact([1e-3, 1e-3, 0.0], [0.0, 0.0, 0.0])),
        ("immovable", impact([1.0, 0.5, 0.0], [0.0, 0.0, 0.0], np.asarray(0.0))),  # type: ignore[arg-type]
        ("unequal masses", impact([1.0, 0.5, 0.0], [0.0, 0.0, 0.0], np.asarray(1e-3))),  # type: ignore[arg-type]
    ],
)
def test_impacts_are_classed_by_their_motion(expected: str, scene: Scene) -> None:
    assert degeneracy(scene) == expected


def drawn(pair: tuple[type[Proxy], type[Proxy]], each: int = 1) -> list[Scene]:
    query = RAYCAST if pair[0] is Ray else DISTANCE
    return [batch.scene(query, i) for batch in Batch.draw(pair, 4, (0, 2), each) for i in range(len(batch))]


QUICK_PAIRS = [pair for pair in TABLE if not any(kind.header for kind in pair)]


@pytest.mark.parametrize("pair", TABLE, ids=lambda pair: f"{pair[0].__name__}-{pair[1].__name__}")
def test_every_scene_has_a_class_and_it_is_the_first_of_its_features(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    for scene in drawn(pair)[:: 1 if pair in QUICK_PAIRS else 4]:
        found = features(scene)
        assert found <= set(CLASSES)
        assert degeneracy(scene) == next((name for name in CLASSES if name in found), GENERIC)
        assert degeneracy(scene) == degeneracy(Scene.from_json(scene.to_json()))


@pytest.mark.parametrize("pair", QUICK_PAIRS, ids=lambda pair: f"{pair[0].__name__}-{pair[1].__name__}")
def test_classes_stay_when_proxies_are_swapped_scaled_by_two_or_turned_by_a_quarter(
    pair: tuple[type[Proxy], type[Proxy]],
) -> None:
    for scene in drawn(pair):
        found = features(scene)
        if not isinstance(scene.a, Ray):
            assert features(Scene(DISTANCE, scene.b, scene.a, "")) == found
        size = {"huge", "tiny", "very unequal", "far away", "odd direction"}  # those two go by the unit of length
        doubled = Scene(scene.query, scene.a.scaled(2.0), scene.b.scaled(2.0), "")
        assert features(doubled) - size == found - size
        try:
            turned = [shape.rotated([0.0, 0.0, 1.0, 1.0]) for shape in (scene.a, scene.b)]
        except UnsupportedOperation:
            continue
        assert degeneracy(Scene(scene.query, *turned, "")) == degeneracy(scene)


def test_every_regime_of_extremes_has_its_class() -> None:
    classes: dict[str, set[str]] = {}
    for scene in drawn((Sphere, Box), 6):
        classes.setdefault(scene.regime, set()).add(degeneracy(scene))
    assert classes["touching"] == {"touching"}
    assert classes["huge"] == {"huge"}
    assert classes["tiny"] == {"tiny"}
    assert "concentric" in classes["concentric"]
    assert classes["nearly_touching"] & {"nearly touching", "touching"}


# -- clumsiness ----------------------------------------------------------------------------------------------


def test_clumsiness_counts_numbers_that_have_to_be_read() -> None:
    plain, odd = scene_of(ball(0), ball(2)), scene_of(ball(0.1234), ball(2.5))
    assert odd_numbers(plain) == 0
    assert odd_numbers(odd) == 2
    assert clumsiness(plain) < clumsiness(scene_of(ball(0), ball(-2))) < clumsiness(odd)
    hull = ConvexPolyhedron.from_vertices(np.vstack([np.zeros(3), np.eye(3)]))
    assert odd_numbers(scene_of(ball(2), hull)) == 0, "how many vertices there are is no number to read"
    mesh = Polyhedron(np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert odd_numbers(scene_of(ball(2), mesh)) == 0, "nor is which of them a face joins"
    assert odd_numbers(scene_of(ball(2), Composite([Ellipsoid(ORIGIN, ONES), hull]))) == 0


# -- plain scenes ----------------------------------------------------------------------------------------------


def test_plain_scenes_are_plain_the_same_every_time_and_there_are_some_of_every_cell() -> None:
    for cell in cells():
        if cell.query == IMPACT and (cell.type_a, cell.type_b) not in STAGED:
            assert plain_scenes(cell, "generic") == ()
        elif cell.query in (DISTANCE, RAYCAST, IMPACT):
            scenes = plain_scenes(cell, "generic" if cell.query != IMPACT else "spinning")
            few = sum(odd_numbers(scene) <= 3 for scene in scenes)
            assert few >= 8, (cell, few)
    again = plain_scenes.__wrapped__(Cell(DISTANCE, Sphere, Box), "touching")
    assert [s.id for s in again] == [s.id for s in plain_scenes(Cell(DISTANCE, Sphere, Box), "touching")]


def test_plain_bodies_have_no_number_that_has_to_be_read() -> None:
    for kind, bodies in PLAIN_BODIES.items():
        assert all(isinstance(body, kind) for body in bodies)
    odd = [odd_numbers(scene_of(ball(0), body)) for bodies in PLAIN_BODIES.values() for body in bodies]
    assert max(odd) <= 6
    assert sorted(odd)[len(odd) // 2] == 0


@pytest.mark.parametrize("pair", TOUCHES, ids=lambda pair: f"{pair[0].__name__}-{pair[1].__name__}")
def test_plain_impacts_touch_where_they_say(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    cell = Cell(IMPACT, *pair)
    motions = [scene for scene in plain_scenes(cell, "spinning") if scene.source == "plain"]
    first = next(scene for scene in motions if scene.motion is not None and scene.motion.closing < 0)
    assert first.motion is not None
    around = [*motions, *restaged(first)]
    around += [Scene(IMPACT, first.a, first.b, "", "", motion) for motion in simpler_motions(first.motion)]
    for scene in around:
        motion = scene.motion
        assert motion is not None
        assert abs(distance(scene.a, scene.b).distance) <= 1e-12
        world, normal = world_of(scene.b), motion.normal / np.linalg.norm(motion.normal)
        assert not (world is PLANE and motion.leaves_the_plane)
        for shape in (scene.a, scene.b):
            assert abs(distance(world.point(world.vectors(motion.point)), shape).distance) <= 1e-12
        apart = distance(scene.a, scene.b.translated(1e-3 * world.vectors(normal))).distance
        assert apart == pytest.approx(1e-3, rel=1e-6), "the normal is that of the contact"


def test_free_features_are_features() -> None:
    assert set(CLASSES) > FREE


@pytest.mark.parametrize("pair", [(Capsule, Box), (Ray, Capsule), (Point, Sphere)], ids=lambda p: p[1].__name__)
def test_features_are_the_same_where_the_gaps_of_a_whole_batch_are_known(pair: tuple[type[Proxy], type[Proxy]]) -> None:
    (batch,) = Batch.draw(pair, 3, (0, 2), 1)
    query = RAYCAST if pair[0] is Ray else DISTANCE
    for i, gaps in enumerate(gaps_of(batch.a, batch.b)):
        scene = batch.scene(query, i)
        assert features(scene, gaps) == features(scene)
