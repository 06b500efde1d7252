"""The two-phase pipeline: equal to the lecture's loop, whatever broad phase and bounding volumes it is given."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from oracles.crowds.making import Crowd, thrown
from refimpl import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Proxy,
    ShapeError,
    Sphere,
    UnsupportedOperation,
    aabb,
    certify,
    collide,
    intersect,
)
from refimpl.bodies import Body
from refimpl.broadphase import STRUCTURES, BroadPhase, BruteForce, Numbered
from refimpl.broadphase.protocol import Candidates
from refimpl.impacts import respond
from refimpl.linear import rotation_matrix
from refimpl.volumes import placed_volume
from refimpl.world import BROAD_PHASE, COLLIDER, EARLY_REJECT, RESPONSE, STAGES, World, rounds

SOUTH = [0.0, 0.0, -9.81]


@pytest.fixture(scope="module")
def crowd() -> Crowd:
    return thrown(40, seed=3)


def touching(world: World) -> set[tuple[int, int]]:
    return {(i, j) for i, j in world.detect().pairs.tolist()}


def one_by_one(crowd: Crowd) -> dict[tuple[int, int], float]:
    """The lecture's loop without any phase: every pair, alone."""
    found = {}
    for (i, a), (j, b) in combinations(enumerate(crowd.proxies), 2):
        if not (crowd.static[i] and crowd.static[j]):
            data = collide(a, b)
            if data.hit:
                found[i, j] = float(data.depth)
    return found


class LowerCellOnly(BroadPhase):
    """Wrong: a grid that enters each box in the cell of its lower corner, and in no other."""

    def _rebuild(self) -> None:
        pass

    def _near_pairs(self) -> Candidates:
        cell = np.floor(np.clip(self.lower, -1e6, 1e6))
        i, j = np.nonzero(np.all(cell[:, None] == cell[None], axis=-1))
        yield i, j

    def _near_boxes(self, lower: np.ndarray, upper: np.ndarray) -> Candidates:
        raise NotImplementedError


def test_the_pipeline_finds_what_every_pair_alone_says(crowd: Crowd) -> None:
    found = World(crowd.bodies()).detect()
    depths = dict(zip(map(tuple, found.pairs.tolist()), found.data.depth.tolist(), strict=True))
    assert depths == one_by_one(crowd)
    assert len(depths) > 15
    assert found.pairs.tolist() == sorted(found.pairs.tolist())


@pytest.mark.parametrize("name", STRUCTURES)
def test_every_broad_phase_names_the_same_pairs(name: str, crowd: Crowd) -> None:
    worlds = [World(falling(6, 9), gravity=SOUTH, broad_phase=make()) for make in (STRUCTURES[name].make, BruteForce)]
    for _ in range(2):
        for world in worlds:
            world.state.advance(0.1, world.gravity)
            world._place()
            world._moved()
        found, wanted = (world.candidates() for world in worlds)
        assert np.array_equal(found, wanted)
        assert len(found) > 4
    large = [World(crowd.bodies(), broad_phase=make()) for make in (STRUCTURES[name].make, BruteForce)]
    assert np.array_equal(large[0].candidates(), large[1].candidates())


def test_early_rejects_lose_nothing_and_save_colliders(crowd: Crowd) -> None:
    with_volumes, without = World(crowd.bodies()), World(crowd.bodies(), early_reject=False)
    assert touching(with_volumes) == touching(without)
    assert with_volumes.stages[COLLIDER].asked < 0.95 * without.stages[COLLIDER].asked
    assert without.stages[EARLY_REJECT].asked == 0


def test_a_broad_phase_that_misses_pairs_is_caught(crowd: Crowd) -> None:
    lost = set(one_by_one(crowd)) - touching(World(crowd.bodies(), broad_phase=LowerCellOnly()))
    assert lost


def test_each_stage_is_asked_what_the_one_before_left(crowd: Crowd) -> None:
    world = World(crowd.bodies(), gravity=SOUTH)
    found = world.detect()
    stages = [world.stages[name] for name in STAGES]
    static = int(crowd.static.sum())
    assert stages[0].asked == 40 * 39 // 2 - static * (static - 1) // 2
    assert [stage.left for stage in stages[:2]] == [stage.asked for stage in stages[1:3]]
    assert world.stages[COLLIDER].left == len(found.pairs)
    assert world.stages[EARLY_REJECT].rejected > 0
    assert all(stage.seconds > 0 for stage in stages[:3])
    world.state.velocity = np.random.default_rng(4).normal(size=(40, 3))
    world.respond(found)
    assert world.stages[RESPONSE].asked == len(found.pairs) > world.stages[RESPONSE].left > 0
    world.reset_counters()
    assert world.stages[BROAD_PHASE].asked == 0


def test_static_bodies_do_not_meet_and_do_not_move(crowd: Crowd) -> None:
    world = World(crowd.bodies(), gravity=SOUTH)
    before = world.state.center[crowd.static].copy()
    for _ in range(3):
        pairs = world.step(0.01).pairs
        assert len(pairs)
        assert not np.any(np.all(crowd.static[pairs], axis=1))
    assert np.array_equal(world.state.center[crowd.static], before)
    assert not np.array_equal(world.state.center[~crowd.static], np.zeros(3))


def test_a_static_body_with_a_velocity_pushes_what_it_meets() -> None:
    wall = Body(Box([0, 0, 0], [0.5, 2, 2], [0, 0, 0, 1]), velocity=[1.0, 0, 0])
    ball = Body(Sphere([0, 0, 0], 0.5), position=[3.0, 0, 0], mass=1.0)
    world = World([wall, ball], restitution=1.0)
    hits = [len(world.step(0.25).pairs) for _ in range(12)]
    assert sum(hits) == 1
    assert world.state.velocity.tolist() == [[1.0, 0, 0], [2.0, 0, 0]]
    assert world.state.center[0].tolist() == [3.0, 0, 0]


# -- response ------------------------------------------------------------------------------------------------


def falling(count: int, seed: int) -> list[Body]:
    """Balls and boxes in a heap, some of them on two others, about to fall on a ground."""
    rng = np.random.default_rng(seed)
    bodies = [Body(HalfSpace([0, 0, 1], 0))]
    for number in range(count):
        shape = Sphere([0.1, 0, 0], 0.5) if number % 2 else Box([0, 0, 0], [0.5, 0.4, 0.3], [0, 0, 0, 1])
        turn, place = rng.normal(size=4), rng.uniform([-1, -1, 0.3], [1, 1, 1.5])
        bodies.append(Body(shape, None, place, turn, rng.normal(size=3), rng.normal(size=3), mass=1.0 + number))
    return bodies


def slide(world: World, pairs: list[tuple[int, int]]) -> None:
    """The lecture's loop to the letter, pair by pair, on the bodies of a world."""
    state = world.state
    for i, j in pairs:
        a, b = (world.bodies[k].collider.transformed(state.rotation[k], state.position[k]) for k in (i, j))
        data = collide(a, b, state.inverse_mass[i], state.inverse_mass[j])
        if data.hit:
            one, other = (state.rigid(np.array([k]))[0] for k in (i, j))
            after = respond(data, one, other, world.restitution, world.friction)
            for k, body in ((i, after.a), (j, after.b)):
                if state.movable[k]:
                    state.center[k], state.velocity[k] = body.position, body.velocity
                    state.spin[k] = body.angular_velocity


def test_answering_in_rounds_is_the_lectures_loop() -> None:
    world, looped = (World(falling(14, 5), restitution=0.4, friction=0.3) for _ in range(2))
    found = world.detect()
    assert len(rounds(found.pairs, world.state.movable)) > 2
    slide(looped, [(int(i), int(j)) for i, j in found.pairs])
    world.respond(found)
    for name in ("center", "velocity", "spin"):
        assert np.allclose(getattr(world.state, name), getattr(looped.state, name), rtol=0, atol=1e-12), name
    assert not np.allclose(world.state.velocity, World(falling(14, 5)).state.velocity)


def test_responses_keep_momentum_and_gain_no_energy() -> None:
    world = World(falling(12, 6)[1:], restitution=1.0)
    ids = np.arange(12)

    def totals() -> tuple[np.ndarray, np.ndarray, float]:
        bodies = world.state.rigid(ids)
        return bodies.momentum().sum(axis=0), bodies.angular_momentum().sum(axis=0), bodies.kinetic_energy().sum()

    momentum, _, energy = totals()
    found = world.detect()
    world.respond(found)
    after, _, left = totals()
    assert len(found.pairs) > 5
    assert np.allclose(after, momentum, atol=1e-12)
    assert left == pytest.approx(energy, rel=1e-12)  # e = 1, without friction


def test_what_falls_comes_to_rest_on_the_ground() -> None:
    ball = Body(Sphere([0, 0, 0], 0.5), position=[0, 0, 0.7], velocity=[1.0, 0, 0], mass=2.0)
    world = World([Body(HalfSpace([0, 0, 1], 0)), ball], restitution=0.0, gravity=SOUTH)
    for _ in range(60):
        world.step(1 / 60)
    assert world.state.center[1] == pytest.approx([1.0, 0.0, 0.5], abs=3e-3)
    assert world.stages[RESPONSE].left > 10


def test_pairs_of_a_round_share_no_movable_body_and_keep_their_order() -> None:
    rng = np.random.default_rng(0)
    movable = rng.uniform(size=20) < 0.7
    pairs = np.unique(np.sort(rng.integers(0, 20, (60, 2)), axis=1), axis=0)
    pairs = pairs[(pairs[:, 0] < pairs[:, 1]) & movable[pairs].any(axis=1)]
    turn = np.full(len(pairs), -1)
    for number, rows in enumerate(rounds(pairs, movable)):
        moving = pairs[rows].ravel()[movable[pairs[rows].ravel()]]
        assert len(set(moving.tolist())) == len(moving)
        turn[rows] = number
    assert np.all(turn >= 0)
    for first, second in combinations(range(len(pairs)), 2):
        if any(movable[k] for k in set(pairs[first]) & set(pairs[second])):
            assert turn[first] < turn[second]


# -- motion --------------------------------------------------------------------------------------------------


def test_a_free_body_turns_about_its_centre_of_mass() -> None:
    off = Body(
        Sphere([1.0, 0, 0], 0.5), position=[0, 0, 2.0], velocity=[0, 1.0, 0], angular_velocity=[0, 0, 0.5], mass=3.0
    )
    world = World([off])
    for _ in range(100):
        world.step(0.01)
    assert world.state.center[0] == pytest.approx([1.0, 1.0, 2.0], abs=1e-12)
    turned = rotation_matrix(world.state.rotation[0]) @ [1.0, 0, 0]
    assert turned == pytest.approx([np.cos(0.5), np.sin(0.5), 0.0], abs=1e-12)
    assert world.colliders[0].center == pytest.approx([1.0, 1.0, 2.0], abs=1e-12)


def test_an_aabb_moves_but_does_not_turn() -> None:
    world = World([Body(AABB([0, 0, 0], [1, 1, 1]), velocity=[1.0, 0, 0], mass=1.0)])
    world.step(0.5)
    assert world.colliders[0].lower.tolist() == [0.5, 0, 0]
    spinning = World([Body(AABB([0, 0, 0], [1, 1, 1]), angular_velocity=[0, 0, 1.0], mass=1.0)])
    with pytest.raises(UnsupportedOperation, match="use Box"):
        spinning.step(0.5)


# -- bounding volumes ----------------------------------------------------------------------------------------


def volumes_of(half: list[float]) -> list[Proxy]:
    """Every type of volume, each as tight around a box as the type allows along some direction."""
    x, y, z = half
    corners = np.array([[i * x, j * y, k * z] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    still = [0, 0, 0, 1]
    return [
        Sphere([0, 0, 0], np.sqrt(x * x + y * y + z * z)),
        Capsule([0, 0, -z], [0, 0, z], np.hypot(x, y)),
        AABB([-x, -y, -z], half),
        Box([0, 0, 0], half, still),
        KDOP.around(corners, 18),
        Ellipsoid([0, 0, 0], np.sqrt(3) * np.array(half), still),
        Cylinder([0, 0, -z], [0, 0, z], np.hypot(x, y)),
    ]


HALF = [0.3, 0.5, 0.7]
TIGHT = [(volume, type(volume).__name__) for volume in volumes_of(HALF)]


@pytest.fixture(scope="module")
def touching_boxes() -> list[tuple[Proxy, np.ndarray, np.ndarray]]:
    """Turned boxes far from the origin, with a ball each that touches a corner from outside, proven."""
    rng, found = np.random.default_rng(7), []
    while len(found) < 4:
        turn, place = rng.normal(size=4), 1e3 * rng.normal(size=3)
        box = Box([0, 0, 0], HALF, [0, 0, 0, 1]).transformed(turn, place)
        corner = place + rotation_matrix(turn) @ HALF
        ball = Sphere(corner + 2.0**-20 * (corner - place), 2.0**-20 * (1 + 2**-18) * np.linalg.norm(corner - place))
        if certify(box, ball).upper <= 0:
            found.append((ball, turn, place))
    return found


@pytest.mark.parametrize("volume", [v for v, _ in TIGHT], ids=[name for _, name in TIGHT])
def test_placed_volumes_contain_what_their_colliders_touch(
    volume: Proxy, touching_boxes: list[tuple[Proxy, np.ndarray, np.ndarray]]
) -> None:
    for ball, turn, place in touching_boxes:
        world = World([Body(Box([0, 0, 0], HALF, [0, 0, 0, 1]), volume, place, turn), Body(ball, ball, mass=1.0)])
        assert world.volumes_meet(np.array([[0, 1]])).all()
        assert certify(world.volumes[0], world.colliders[0]).upper < 0


def test_without_growing_placed_volumes_lose_touching_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the growth is for: a volume that is its own collider, rounded otherwise, can be beyond a touching ball."""
    monkeypatch.setattr("refimpl.volumes.SLACK", 0.0)
    rng = np.random.default_rng(8)
    lost = 0
    for _ in range(50):
        turn, place = rng.normal(size=4), 1e3 * rng.normal(size=3)
        own = Box([0.1, 0.2, 0.3], HALF, [0, 0, 0, 1])
        box, around = own.transformed(turn, place), KDOP([[1, 0, 0], [0, 1, 0], [0, 0, 1]], *_slabs(own))
        kdop = placed_volume(around[None], turn[None], place[None], *(corner[None] for corner in _corners(box)))[0]
        tip = box.center + rotation_matrix(box.rotation) @ HALF
        lost += not intersect(kdop, Sphere(tip, 2.0**-52))
    assert lost > 5


def _slabs(box: Box) -> tuple[np.ndarray, np.ndarray]:
    return box.center - box.half_extents, box.center + box.half_extents


def _corners(box: Proxy) -> tuple[np.ndarray, np.ndarray]:
    around = aabb(box)
    return around.lower, around.upper


def test_a_volume_that_does_not_contain_its_collider_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"Body\.volume: the Sphere does not contain the Box, which reaches 0\.11"):
        Body(Box([0, 0, 0], [1, 1, 1], [0, 0, 0, 1]), Sphere([0, 0, 0], 1.62))
    with pytest.raises(ShapeError, match="does not contain the HalfSpace"):
        Body(HalfSpace([0, 0, 1], 0), Sphere([0, 0, 0], 5))
    with pytest.raises(UnsupportedOperation, match="no bounding volume: take one of Sphere"):
        Body(Sphere([0, 0, 0], 1), HalfSpace([0, 0, 1], -1))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("collider", Sphere(np.zeros((2, 3)), 1)),
        ("mass", 0.0),
        ("mass", float("nan")),
        ("position", [0, 0]),
        ("rotation", [0, 0, 0, 0]),
        ("velocity", [0, np.nan, 0]),
    ],
)
def test_bad_bodies_are_refused_by_name(field: str, value: object) -> None:
    with pytest.raises(ShapeError, match=rf"Body\.{field}"):
        Body(**{"collider": Sphere([0, 0, 0], 1), field: value})  # type: ignore[arg-type]


def test_mixed_proxies_come_back_as_they_were(crowd: Crowd) -> None:
    mixed = Numbered.by_form(crowd.proxies)
    assert len(mixed) == len(crowd)
    assert len(mixed.batches) < 10
    for number, proxy in enumerate(crowd.proxies):
        assert np.array_equal(mixed[number].pack(), proxy.pack())
    pairs = np.array([[i, j] for i, j in combinations(range(40), 2)])
    seen = np.zeros(len(pairs), dtype=int)
    for which, a, b in mixed.by_types(pairs):
        seen[which] += 1
        for row in (0, -1):
            i, j = pairs[which[row]]
            assert np.array_equal(a[row].pack(), crowd.proxies[i].pack())
            assert np.array_equal(b[row].pack(), crowd.proxies[j].pack())
    assert np.all(seen == 1)


def test_an_empty_world_steps() -> None:
    world = World([], broad_phase=BruteForce())
    assert len(world.step(1.0).pairs) == 0


@pytest.mark.parametrize(
    ("bodies", "options", "why"),
    [
        ([Sphere([0, 0, 0], 1)], {}, r"bodies\[0\]: expected a Body, got Sphere: Body\(proxy\) makes one"),
        ([], {"restitution": 2}, "restitution: must be from 0 to 1"),
        ([], {"friction": -1}, "friction: must be at least 0"),
        ([], {"gravity": [0, 0, np.nan]}, "gravity: must be finite"),
        ([], {"gravity": 9.81}, "gravity: expected"),
    ],
)
def test_a_world_of_nonsense_is_refused(bodies: Any, options: dict[str, Any], why: str) -> None:
    with pytest.raises(ShapeError, match=why):
        World(bodies, **options)


@pytest.mark.parametrize("dt", [-1.0, np.nan])
def test_time_does_not_run_backwards(dt: float) -> None:
    world = World(falling(3, 5))
    with pytest.raises(ShapeError, match="dt: must be"):
        world.step(dt)
