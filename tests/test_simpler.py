"""Simpler scenes: what several changes at once are made of, and how many parts are left out."""

from __future__ import annotations

import numpy as np

from oracles.around import passes
from oracles.clumsiness import odd_numbers
from oracles.degeneracy import features
from oracles.likeness import Failing
from oracles.scene import CONTACTS, DISTANCE, Scene
from oracles.simpler import simpler_proxies
from oracles.spacing import gap_of, kept_apart
from oracles.together import alike_changed, merged
from refimpl import AABB, KDOP, Capsule, Sphere

BALL, ROD = Sphere([3.1, 4.2, 5.3], 0.7), Capsule([-0.3, 0.2, 0.0], [0.3, -0.2, 0.0], 0.4)
SCENE = Scene(DISTANCE, BALL, ROD, "generic")


def with_ball(x: float, y: float, z: float, radius: float = 0.7) -> Scene:
    return Scene(DISTANCE, Sphere([x, y, z], radius), ROD, "generic")


def test_changes_of_other_numbers_are_made_at_once_and_no_number_is_changed_twice() -> None:
    others = [with_ball(0, 4.2, 5.3), with_ball(1, 4.2, 5.3), with_ball(3.1, 4.2, 0), with_ball(3.1, 1, 5.3, 2)]
    found = [scene.a.pack().tolist() for scene in merged(SCENE, others)]
    assert found == [[0, 1, 0, 2], [0, 4.2, 0, 0.7]]  # the most first; a single one was made already
    assert list(merged(SCENE, others[:2])) == []


def test_scenes_of_another_form_are_no_changes() -> None:
    slabs = KDOP(np.eye(3), [-1.0] * 3, [1.0] * 3)
    more = KDOP(np.concatenate([np.eye(3), [[1.0, 1.0, 0.0]]]), [-1.0] * 4, [1.0] * 4)
    scene = Scene(DISTANCE, BALL, slabs, "generic")
    others = [Scene(DISTANCE, Sphere([0, 4.2, 5.3], 0.7), body, "generic") for body in (more, more)]
    assert list(merged(scene, others)) == []


def test_numbers_of_one_size_are_changed_together_with_their_signs() -> None:
    rods = [scene.b.pack().tolist() for scene in alike_changed(SCENE)]
    assert [-1.0, 0.2, 0.0, 1.0, -0.2, 0.0, 0.4] in rods
    assert [-0.3, 0.0, 0.0, 0.3, 0.0, 0.0, 0.4] in rods
    assert all(abs(p) == abs(q) for rod in rods for p, q in zip(rod[:3], rod[3:6], strict=True))


def test_many_parts_are_left_out_at_once_before_one() -> None:
    directions = np.concatenate([np.eye(3), [[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1]]])
    slabs = KDOP(directions, -np.arange(1.0, 9.0), np.arange(1.0, 9.0))
    counts = [len(body.lower) for body in simpler_proxies(slabs) if isinstance(body, KDOP) and len(body.lower) < 8]
    assert sorted(counts) == counts
    assert set(counts) <= {4, 6, 7}
    assert counts.count(7) == 8


def test_either_of_both_is_moved_to_a_gap() -> None:
    for moving_a in (False, True):
        scene = kept_apart([SCENE], [1e-6], moving_a=moving_a)[0]
        assert abs(gap_of(scene) - 1e-6) < 1e-14
        assert (scene.b is ROD) == moving_a
        assert (scene.a is BALL) != moving_a


def test_a_tiny_flat_body_is_no_more_special_than_a_tiny_one_and_a_usual_one_is() -> None:
    def scene(size: float, *, flat: bool) -> Scene:
        box = AABB([0, 0, size if flat else 0], [size, size, size])
        return Scene(CONTACTS, Sphere([0, 0, 3 * size], size / 2), box, "generic")

    assert features(scene(1e-4, flat=True)) <= features(scene(1e-4, flat=False))
    assert features(scene(1.0, flat=True)) - features(scene(1.0, flat=False)) == {"thin"}


def test_candidates_have_fewer_numbers_to_read() -> None:
    candidates = [scene for some in passes(Failing(SCENE, 1e-5)) for scene in some]
    assert min(map(odd_numbers, candidates)) <= odd_numbers(SCENE) - 4
