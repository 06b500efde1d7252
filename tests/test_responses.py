"""From collision data to positions and velocities after the impact."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from refimpl import Box, CollisionData, HalfSpace, ShapeError, Sphere, collide, distance, intersect
from refimpl.impacts import Response, RigidBody, approach, respond
from refimpl.proxy import Proxy
from refimpl.shapes import Composite

FLOOR = HalfSpace([0, 0, 1], 0)
GROUND = RigidBody.of(FLOOR, mass=np.inf)
RNG = np.random.default_rng(12)


def bounce(p: Proxy, q: Proxy, a: RigidBody, b: RigidBody, e: Any, mu: Any = 0) -> tuple[CollisionData, Response]:
    found = collide(p, q, a.inverse_mass, b.inverse_mass)
    return found, respond(found, a, b, e, mu)


def test_a_ball_bounces_off_the_floor() -> None:
    ball = Sphere([0.3, 0.2, 0.9], 1)
    body = RigidBody.of(ball, mass=2, velocity=[1, 0, -4])
    _, after = bounce(FLOOR, ball, GROUND, body, 0.5)
    assert after.met
    assert np.array_equal(after.b.velocity, [1, 0, 2])
    assert np.array_equal(after.b.angular_velocity, [0, 0, 0])
    assert np.allclose(after.b.position, [0.3, 0.2, 1], rtol=0, atol=1e-15)
    assert np.allclose(after.point, [0.3, 0.2, 0], rtol=0, atol=1e-15)
    assert np.array_equal(after.impulse, [0, 0, 12])
    assert np.array_equal(after.a.position, [0, 0, 0])


def test_a_ball_that_grips_the_floor_rolls() -> None:
    """A solid ball of inertia 2/5 m r² keeps 5/7 of its speed, and turns so that the lowest point rests."""
    ball = Sphere([0, 0, 1], 1)
    body = RigidBody.of(ball, mass=1, velocity=[7, 0, -4])
    _, after = bounce(FLOOR, ball, GROUND, body, 0, 1)
    assert np.allclose(after.b.velocity, [5, 0, 0], rtol=0, atol=1e-14)
    assert np.allclose(after.b.angular_velocity, [0, 5, 0], rtol=0, atol=1e-14)
    assert np.allclose(after.b.velocity_at([0, 0, 0]), 0, atol=1e-14)
    _, slides = bounce(FLOOR, ball, GROUND, body, 0, 0.125)
    assert np.allclose(slides.b.velocity, [6.5, 0, 0], rtol=0, atol=1e-14)


def test_a_corner_of_a_box_on_the_floor() -> None:
    """The struck corner leaves with e times its speed; without friction the centre goes straight up."""
    box = Box([0, 0, 1.6], [1, 1, 1], [0.3, 0.2, 0.1, 0.9])
    body = RigidBody.of(box, density=1, velocity=[0, 0, -3], angular_velocity=[0.2, -0.1, 0.4])
    found, after = bounce(FLOOR, box, GROUND, body, 0.75)
    assert after.met
    corner = after.point
    moved = box.translated(after.b.position - body.position)
    assert abs(distance(FLOOR, moved).distance) < 1e-15
    assert np.allclose(after.b.position - body.position, [0, 0, found.depth], atol=1e-15)
    before = body.moved([0, 0, found.depth]).velocity_at(corner)
    assert np.isclose(after.b.velocity_at(corner)[2], -0.75 * before[2], rtol=1e-14)
    assert np.array_equal(after.b.velocity[:2], [0, 0])
    assert np.any(after.b.angular_velocity != body.angular_velocity)


def test_two_boxes() -> None:
    """Both are moved apart by their inverse masses, and momentum and angular momentum are kept."""
    p, q = Box([0, 0, 0], [1, 1, 1], [0, 0, 0, 1]), Box([0.4, 0.3, 1.9], [0.5, 0.5, 1], [0.1, 0, 0, 1])
    a = RigidBody.of(p, mass=3, velocity=[0, 0, 1])
    b = RigidBody.of(q, mass=1, velocity=[0, 0.5, -2], angular_velocity=[0, 0.3, 0])
    found, after = bounce(p, q, a, b, 0.5, 0.2)
    assert after.met
    assert np.allclose(after.a.position, a.position + found.shift_a)
    assert np.isclose(np.linalg.norm(found.shift_b), 3 * np.linalg.norm(found.shift_a))
    free = p.translated(found.shift_a), q.translated(found.shift_b)
    assert abs(distance(*free).distance) < 1e-14
    assert np.allclose(after.a.momentum() + after.b.momentum(), a.momentum() + b.momentum(), atol=1e-14)
    there = a.moved(found.shift_a), b.moved(found.shift_b)
    before, now = (sum(body.angular_momentum() for body in both) for both in (there, (after.a, after.b)))
    assert np.allclose(before, now, rtol=0, atol=1e-13)
    assert approach(after.a, after.b, after.point, found.normal) > 0


def test_bodies_that_separate_or_miss_are_left_alone() -> None:
    balls = Sphere([[0, 0, 0.9], [0, 0, 0.9], [0, 0, 0.9], [0, 0, 1.1]], 1)
    speeds = np.array([[1, 0, 2.0], [1, 0, 0], [1, 0, -2], [-1, -1, -2]])
    body = RigidBody.of(balls, mass=1, velocity=speeds)
    _, after = bounce(FLOOR, balls, GROUND, body, 1, 1)
    assert after.met.tolist() == [False, False, True, False]
    assert np.array_equal(after.b.velocity[[0, 1, 3]], speeds[[0, 1, 3]])
    assert np.array_equal(after.impulse[[0, 1, 3]], np.zeros((3, 3)))
    assert np.allclose(after.b.position[:, 2], [1, 1, 1, 1.1])
    assert np.array_equal(after.b.position[3], body.position[3])
    assert np.isnan(after.point[3]).all()


def test_responses_of_a_batch_are_those_alone_and_of_any_pair_symmetric() -> None:
    n = 30
    p = Box(RNG.normal(size=(n, 3)) * 0.5, RNG.uniform(0.5, 1, (n, 3)), RNG.normal(size=(n, 4)))
    q = Box(RNG.normal(size=(n, 3)) * 0.5, RNG.uniform(0.5, 1, (n, 3)), RNG.normal(size=(n, 4)))
    a, b = (
        RigidBody.of(shape, density=1.5, velocity=RNG.normal(size=(n, 3)), angular_velocity=RNG.normal(size=(n, 3)))
        for shape in (p, q)
    )
    _, after = bounce(p, q, a, b, 0.4, 0.3)
    assert 0 < after.met.sum() < n
    assert intersect(p, q).sum() > n / 2
    for i in range(n):
        _, one = bounce(p[i], q[i], a[i], b[i], 0.4, 0.3)
        assert np.array_equal(one.b.angular_velocity, after.b.angular_velocity[i])
        assert np.array_equal(one.a.position, after.a.position[i])
        assert np.array_equal(one.impulse, after.impulse[i])
    _, turned = bounce(q, p, b, a, 0.4, 0.3)
    assert np.array_equal(turned.met, after.met)
    assert np.allclose(turned.a.velocity, after.b.velocity, rtol=0, atol=1e-12)


def test_a_union_bounces_too() -> None:
    dumbbell = Composite([Sphere([-2, 0, 0.9], 1), Sphere([2, 0, 1.4], 1)])
    body = RigidBody.of(dumbbell, density=1, velocity=[0, 0, -1])
    _, after = bounce(FLOOR, dumbbell, GROUND, body, 1)
    assert after.met
    assert after.b.angular_velocity[1] > 0, "the left ball is thrown up: it turns about +y"


def test_fractions_stay_fractions() -> None:
    ball = Sphere([0, 0, 0.5], 1)
    zero = [Fraction(0)] * 3
    body = RigidBody(
        [0, 0, Fraction(1, 2)], [Fraction(1), 0, -4], zero, Fraction(1), Fraction(2, 5) * np.eye(3, dtype=int)
    )
    wall = RigidBody.immovable()
    after = respond(collide(FLOOR, ball, 0, 1), wall, body, Fraction(1, 3))
    assert after.b.velocity.tolist() == [1, 0, Fraction(4, 3)]
    assert after.b.position.tolist() == [0, 0, 1]


def test_what_cannot_be_answered_is_refused() -> None:
    with np.errstate(all="ignore"):
        found = collide(FLOOR, HalfSpace([0, 1, 1], 0))
    with pytest.raises(ShapeError, match=r"found\.shift_a: must be finite: the overlap has no end"):
        respond(found, GROUND, RigidBody([0, 0, 0], [0, 0, 0], [0, 0, 0], 1, np.eye(3)), 1)
    met = collide(FLOOR, Sphere([0, 0, 0.5], 1), 0, 1)
    ball = RigidBody.of(Sphere([0, 0, 0.5], 1), mass=1)
    with pytest.raises(ShapeError, match="restitution: must be from 0 to 1, got 2"):
        respond(met, GROUND, ball, 2)
    with pytest.raises(ShapeError, match="friction: must be at least 0, got -1"):
        respond(met, GROUND, ball, 1, -1)
    with pytest.raises(ShapeError, match="batch shapes do not broadcast"):
        respond(
            met[None],
            GROUND,
            RigidBody(np.zeros((2, 3)), [0, 0, 0], [0, 0, 0], np.ones((3, 1)), np.eye(3)),
            [1, 1, 1, 1],
        )
