"""Static detection by stepping: what it sees, what tunnels, and that it is never before the first contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

import refimpl
from refimpl import AABB, Box, Point, RigidMotion, Sphere, Translation, UnsupportedOperation
from refimpl.sweeps import stepped

WALL = AABB([-0.05, -1, -1], [0.05, 1, 1])
BALL = Sphere([-1, 0, 0], 0.1)
THROUGH = Translation([2, 0, 0])


def test_a_fast_ball_tunnels_through_a_wall_and_a_slower_one_does_not() -> None:
    # the ball overlaps the wall from t = 0.425 to 0.575: no step of 1/3 falls in between, and one of 1/2 does
    assert not stepped(BALL, WALL, THROUGH, steps=3).hit
    assert stepped(BALL, WALL, THROUGH, steps=3).t == math.inf
    assert stepped(BALL, WALL, THROUGH, steps=2).t == 0.5
    assert stepped(BALL, WALL, THROUGH, steps=100).t == 0.43
    assert refimpl.sweep(BALL, WALL, THROUGH).t == pytest.approx(0.425, abs=1e-15)


def test_the_first_and_the_last_place_are_looked_at() -> None:
    assert stepped(BALL, WALL, Translation([0.9, 0, 0]), steps=1).t == 1
    assert stepped(BALL, WALL, Translation([0.8, 0, 0]), steps=1).t == math.inf
    assert stepped(Point([0, 0, 0]), WALL, THROUGH, steps=1).t == 0


def test_both_move_and_only_their_relative_way_counts() -> None:
    half = Translation([1, 0, 0]), Translation([-1, 0, 0])
    for steps in (2, 3, 16, 64):
        assert stepped(BALL, WALL, *half, steps=steps) == stepped(BALL, WALL, THROUGH, steps=steps)


def test_a_turning_box_is_seen_when_it_has_turned() -> None:
    bar = Box([0, 0, 0], [1, 0.01, 0.01], [0, 0, 0, 1])
    ball = Sphere([0, 0.5, 0], 0.05)
    quarter = RigidMotion([0, 0, 0], [0, 0, math.pi / 2], [0, 0, 0])
    assert stepped(bar, ball, quarter, steps=1).t == 1
    assert stepped(bar, ball, RigidMotion([0, 0, 0], [0, 0, math.pi], [0, 0, 0]), steps=1).t == math.inf  # past it
    assert stepped(bar, ball, RigidMotion([0, 0, 0], [0, 0, math.pi], [0, 0, 0]), steps=2).t == 0.5


def test_one_row_of_a_batch_is_the_pair_alone_and_never_early() -> None:
    rng = np.random.default_rng(1)
    balls = Sphere(rng.uniform(-2, -1, (12, 3)), rng.uniform(0.05, 0.3, 12))
    ways = Translation(rng.uniform(1, 4, (12, 3)))
    found, first = stepped(balls, WALL, ways, steps=6), refimpl.sweep(balls, WALL, ways)
    alone = [stepped(balls[i], WALL, ways[i], steps=6).t for i in range(12)]
    assert found.t.tolist() == alone
    assert np.all(found.t >= first.t - 1e-12)
    assert np.all(found.hit == np.isfinite(found.t))
    assert 0 < np.sum(found.hit) < np.sum(first.hit)  # some tunnel


def test_what_cannot_be_stepped_is_refused() -> None:
    with pytest.raises(ValueError, match="steps: at least 1, got 0"):
        stepped(BALL, WALL, steps=0)
    with pytest.raises(UnsupportedOperation, match="AABB"):
        stepped(WALL, BALL, RigidMotion([0, 0, 0], [0, 0, 1], [0, 0, 0]), steps=1)
    with pytest.raises(TypeError, match="a motion is"):
        stepped(WALL, BALL, [1, 0, 0], steps=1)  # type: ignore[arg-type]
