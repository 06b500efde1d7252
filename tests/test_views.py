"""Views: the same scene from where it has fewer numbers to read."""

from __future__ import annotations

import numpy as np
import pytest

from oracles.clumsiness import odd_numbers
from oracles.degeneracy import FREE, features
from oracles.scene import CONTACTS, DISTANCE, RAYCAST, Scene
from oracles.views import MOST, tidy, views
from refimpl import AABB, Box, Capsule, HalfSpace, Proxy, Ray, Sphere, distance, raycast

TURN, AWAY = [0.3, -0.2, 0.7, 0.4], [0.123456789, -4.56, 7.89]
HAIR = 1.2345e-10

SCENES = {
    "an end in a rod's axis": (
        4,
        Scene(DISTANCE, Capsule([0, 0, 0], [2, 0, 0], 0.5), Capsule([1, -HAIR, 0], [1, 1, 0], 0.5), "generic"),
    ),
    "a ball before a box": (
        1,
        Scene(DISTANCE, Sphere([0, 0, 3], 1.0), Box([0, 0, 0], [1, 0.5, 2], [0, 0, 0, 1]), "generic"),
    ),
    "a ball over a floor": (2, Scene(CONTACTS, Sphere([0, 0, 1], 1.0), HalfSpace([0, 0, 2], -HAIR), "generic")),
    "a ray at a rod": (3, Scene(RAYCAST, Ray([-2, 0, 0], [1, 0, 0]), Capsule([0, -1, 0], [0, 1, 0], 0.5), "generic")),
}


def turned(shape: Proxy) -> Proxy:
    return shape.rotated(TURN).translated(AWAY)


@pytest.mark.parametrize("name", SCENES)
def test_what_was_turned_and_moved_is_seen_in_few_numbers_again_and_is_the_same(name: str) -> None:
    most, plain = SCENES[name]
    scene = Scene(plain.query, turned(plain.a), turned(plain.b), "generic")
    assert odd_numbers(scene) > 2 * most
    found = views(scene)
    assert 0 < len(found) <= MOST
    assert odd_numbers(found[0]) <= most, found[0]
    for view in found:
        assert odd_numbers(view) < odd_numbers(scene)
        assert answer(view) == pytest.approx(answer(scene), abs=1e-14)
        assert features(view) <= features(scene) | FREE


def answer(scene: Scene) -> float:
    if isinstance(scene.a, Ray):
        return float(raycast(scene.a, scene.b).t)
    return float(distance(scene.a, scene.b).distance)


def test_what_is_aligned_with_the_axes_is_only_moved() -> None:
    scene = Scene(DISTANCE, Sphere([5.3, 6.1, 7.7], 0.3), AABB([1.3, 2.1, 3.7], [2.3, 4.1, 4.7]), "generic")
    found = views(scene)
    assert found
    assert all(np.allclose(view.b.upper - view.b.lower, [1, 2, 1]) for view in found)  # type: ignore[attr-defined]
    assert odd_numbers(found[0]) <= 4 < odd_numbers(scene)


def test_a_scene_of_few_numbers_is_seen_best_as_it_is() -> None:
    assert views(Scene(DISTANCE, Sphere([0, 0, 0], 1.0), Sphere([0, 0, 2], 1.0), "generic")) == []


def test_only_what_rounding_leaves_is_tidied_away() -> None:
    made = tidy(Capsule([1e-16, 2.0000000000000004, HAIR], [0.1 + 0.2, -1.0, 1 / 3], 0.5))
    assert made is not None
    assert made.pack().tolist() == [0.0, 2.0, HAIR, 0.3, -1.0, 1 / 3, 0.5]
