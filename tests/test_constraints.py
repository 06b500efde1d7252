"""Particles with distance constraints come to what the rigid formula says, and keep what they must keep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from refimpl import HalfSpace
from refimpl.fields import ShapeError
from refimpl.impacts.constraints import Contact, ParticleBody, impact_between, impact_with_plane, solve, step

CUBE = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5], indexing="ij"), axis=-1).reshape(8, 3)
TETRAHEDRON = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 2
UP = np.array([0.0, 0.0, 1.0])


def corner(body: ParticleBody, i: int = 0) -> np.ndarray[Any, Any]:
    return np.eye(len(body.inverse_masses))[i]


def thrown(points: Any, seed: int = 0, **moved: Any) -> ParticleBody:
    """A body of uneven masses whose corner 0 falls."""
    rng = np.random.default_rng(seed)
    masses = rng.uniform(0.5, 2.0, len(points)) / len(points)
    return ParticleBody.braced(np.asarray(points) + rng.normal(size=3), masses, [0.3, 0.1, -1.0], [0.2, -0.4, 0.5])


def rigid_answer(body: ParticleBody, i: int, normal: Any, e: float) -> tuple[Any, Any]:
    """Velocity and angular velocity after a frictionless impact of corner i with a plane, by the lecture's formula."""
    arm, mass = body.positions[i] - body.center, float(np.sum(body.masses))
    speed = normal @ body.velocities[i]
    turn = np.linalg.solve(body.inertia, np.cross(arm, normal))
    impulse = -(1 + e) * speed / (1 / mass + normal @ np.cross(turn, arm))
    return body.velocity + impulse / mass * normal, body.angular_velocity + impulse * turn


def test_a_braced_body_moves_as_it_was_told() -> None:
    body = thrown(CUBE)
    np.testing.assert_allclose(body.velocity, [0.3, 0.1, -1.0], atol=1e-14)
    np.testing.assert_allclose(body.angular_velocity, [0.2, -0.4, 0.5], atol=1e-13)
    assert body.strain == 0
    energy = np.sum(body.masses) * body.velocity @ body.velocity / 2
    energy += body.angular_velocity @ body.inertia @ body.angular_velocity / 2
    assert body.kinetic_energy == pytest.approx(energy, rel=1e-13)


@pytest.mark.parametrize("points", [CUBE, TETRAHEDRON], ids=["cube", "tetrahedron"])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("normal", [UP, np.array([2.0, -1.0, 5.0])])
def test_many_iterations_come_to_the_rigid_formula(points: Any, e: float, normal: Any) -> None:
    body = thrown(points)
    unit = normal / np.linalg.norm(normal)
    velocity, angular = rigid_answer(body, 0, unit, e)
    errors = []
    for time_step in (1e-4, 1e-6):
        after = impact_with_plane(body, corner(body), normal, e, time_step, 150)
        errors.append(np.linalg.norm(after.angular_velocity - angular) + np.linalg.norm(after.velocity - velocity))
        assert unit @ after.velocities[0] == pytest.approx(-e * (unit @ body.velocities[0]), abs=1e-8)
    assert errors[0] < 1e-3
    assert errors[1] < 0.02 * errors[0] + 1e-9  # what is left is the bend of the step, in proportion to it


def test_few_iterations_do_not() -> None:
    body = thrown(CUBE)
    _, angular = rigid_answer(body, 0, UP, 0.5)
    errors = [
        np.linalg.norm(impact_with_plane(body, corner(body), UP, 0.5, 1e-6, n).angular_velocity - angular)
        for n in (1, 4, 16, 64)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.1
    assert errors[-1] < 1e-4


def test_repairs_keep_momentum_and_angular_momentum() -> None:
    a, b = thrown(CUBE, 1), thrown(TETRAHEDRON, 2)
    b = ParticleBody.braced(b.positions, b.masses, [0.0, 0.2, 1.5], [1.0, 0.0, -0.3])
    # one common line of action: the touching corners are brought to one place
    b = ParticleBody.braced(b.positions - b.positions[1] + a.positions[5], b.masses, [0.0, 0.2, -1.5], [1.0, 0.0, -0.3])
    after = impact_between(a, b, corner(a, 5), corner(b, 1), UP, 0.7, 1e-6, 200)
    origin = np.zeros(3)
    np.testing.assert_allclose(sum(x.momentum for x in after), a.momentum + b.momentum, atol=1e-9)
    np.testing.assert_allclose(
        sum(x.angular_momentum(origin) for x in after),
        a.angular_momentum(origin) + b.angular_momentum(origin),
        atol=1e-5,
    )
    before_gap = UP @ (b.velocities[1] - a.velocities[5])
    assert before_gap < 0
    assert UP @ (after[1].velocities[1] - after[0].velocities[5]) == pytest.approx(-0.7 * before_gap, abs=1e-8)
    energy = sum(x.kinetic_energy for x in after)
    assert energy < a.kinetic_energy + b.kinetic_energy


def test_a_body_that_leaves_is_left_alone() -> None:
    body = thrown(CUBE)
    after = impact_with_plane(body, corner(body), -UP, 0.5, 1e-6, 50)
    np.testing.assert_allclose(after.angular_velocity, body.angular_velocity, atol=1e-5)
    np.testing.assert_allclose(after.velocity, body.velocity, atol=1e-9)


def test_batches_of_motions_are_the_motions_one_by_one() -> None:
    rng = np.random.default_rng(5)
    velocities, spins = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    many = ParticleBody.braced(CUBE, np.ones(8), velocities, spins)
    together = impact_with_plane(many, corner(many), UP, 0.3, 1e-3, 20)
    for i in range(4):
        one = ParticleBody.braced(CUBE, np.ones(8), velocities[i], spins[i])
        after = impact_with_plane(one, corner(one), UP, 0.3, 1e-3, 20)
        assert np.array_equal(after.positions, together.positions[i])


def test_a_cube_that_falls_comes_to_rest_on_the_floor() -> None:
    floor = HalfSpace([0.0, 0.0, 2.0], -1.0)  # z <= 0.5
    body = ParticleBody.braced(CUBE + np.array([0.0, 0.0, 1.2]), np.ones(8), angular_velocity=[0.3, 0.2, 0.0])
    for _ in range(150):
        body = step(body, 0.02, 10, acceleration=[0.0, 0.0, -9.81], planes=[floor])
    assert np.min(body.positions[:, 2]) >= 0.5 - 1e-9
    assert body.center[2] == pytest.approx(1.0, abs=0.02)
    assert body.kinetic_energy < 1e-2
    assert body.strain < 1e-2


def test_pinned_particles_stay() -> None:
    rope = ParticleBody(
        [[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], np.zeros((3, 3)), [0.0, 1.0, 1.0], [[0, 1], [1, 2]], [1.0, 1.0]
    )
    for _ in range(50):
        rope = step(rope, 0.01, 30, acceleration=[0.0, 0.0, -9.81])
    assert np.array_equal(rope.positions[0], [0.0, 0.0, 0.0])
    assert rope.positions[2, 2] < -0.5
    assert rope.strain < 1e-2
    with pytest.raises(ValueError, match="pinned"):
        _ = rope.momentum


def test_contacts_are_inequalities_unless_they_hold() -> None:
    body = ParticleBody.braced([[0.0, 0, 1], [1, 0, 1]], [1.0, 1.0])
    free, held = (Contact(UP, np.array([0]), np.ones(1), 0.5, holds) for holds in (False, True))
    assert np.array_equal(solve(body, body.positions, [free], 3), body.positions)
    assert solve(body, body.positions, [held], 50)[0, 2] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.zeros((2, 2))}, "positions has shape"),
        ({"positions": [[np.nan, 0, 0], [1, 0, 0]]}, "positions must be finite"),
        ({"inverse_masses": [1.0, -1.0]}, "inverse_masses must be finite and ≥ 0"),
        ({"inverse_masses": [1.0]}, "inverse_masses has shape"),
        ({"links": [[0, 2]]}, r"links: \[0, 2\]"),
        ({"links": [[1, 1]]}, r"links: \[1, 1\]"),
        ({"lengths": [0.0]}, "lengths must be positive"),
    ],
)
def test_bad_bodies(change: dict[str, Any], message: str) -> None:
    good: dict[str, Any] = {
        "positions": [[0.0, 0, 0], [1, 0, 0]],
        "velocities": np.zeros((2, 3)),
        "inverse_masses": [1.0, 1.0],
        "links": [[0, 1]],
        "lengths": [1.0],
    }
    ParticleBody(**good)
    with pytest.raises(ShapeError, match=message):
        ParticleBody(**{**good, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"restitution": 1.5}, "restitution"),
        ({"normal": [0.0, 0.0, 0.0]}, "normal"),
        ({"weights": [1.0, 1.0]}, "weights"),
        ({"time_step": 0.0}, "time_step"),
        ({"iterations": -1}, "iterations"),
    ],
)
def test_bad_impacts(change: dict[str, Any], message: str) -> None:
    body = ParticleBody.braced([[0.0, 0, 0], [1, 0, 0]], [1.0, 1.0], [0.0, 0.0, -1.0])
    good: dict[str, Any] = {
        "weights": [1.0, 0.0],
        "normal": UP,
        "restitution": 0.5,
        "time_step": 1e-3,
        "iterations": 5,
    }
    impact_with_plane(body, **good)
    with pytest.raises(ValueError, match=message):
        impact_with_plane(body, **{**good, **change})
