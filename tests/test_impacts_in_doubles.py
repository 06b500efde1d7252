"""Impacts in doubles: nearest to the exact result, in batches as alone, in any units; and what is refused."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import astuple, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from refimpl import Box, HalfSpace, ShapeError, Sphere
from refimpl.impacts import (
    RigidBody,
    approach,
    evaluating,
    impact_of_bodies,
    impact_of_particles,
    impact_on_line,
    inertia_tensor,
    join_bodies,
    merge_particles,
    rigid,
    split,
)
from refimpl.impacts.definite import is_definite
from refimpl.impacts.numbers import root_above
from refimpl.impacts.reading import fractions
from refimpl.impacts.twofold import Twofold
from tests.conftest import effort
from tests.impact_accuracy import FORMULAS, lines, measure, particles
from tests.impact_scenes import Scene, wide_scenes

RNG = np.random.default_rng(8)
ROWS = 40


def numbers_of(answer: Any) -> list[Any]:
    """All arrays of an answer."""
    found = []
    for value in vars(answer).values():
        bodies = isinstance(value, RigidBody)
        found += [value.position, value.velocity, value.angular_velocity] if bodies else [np.asarray(value)]
    return found


# ---- accuracy ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FORMULAS)
def test_errors_are_those_of_one_rounding(name: str) -> None:
    """Asked are 4 ulp of the largest velocity, and 1e-13 relative for bodies; it is the nearest double, nearly."""
    worst = measure(name, 4 * effort(), seed=3)
    assert worst.ulp <= 0.51
    assert worst.relative <= 1.2e-16


def test_a_plain_solve_is_not_that_good(monkeypatch: pytest.MonkeyPatch) -> None:
    """The measure sees what doubles alone lose to the condition of the inertia."""

    class Plain:
        def __init__(self, matrix: Any) -> None:
            self.matrix = np.moveaxis(matrix.high, -1, 0)

        def solve(self, v: Any) -> Any:
            columns = np.moveaxis(v.high, -1, 0)
            found = np.linalg.solve(self.matrix, columns if columns.ndim == 3 else columns[..., None])
            return Twofold(np.moveaxis(found if columns.ndim == 3 else found[..., 0], 0, -1))

    exactly = rigid.factors
    monkeypatch.setattr(rigid, "factors", lambda m: Plain(m) if isinstance(m, Twofold) else exactly(m))
    assert measure("bodies", 60, seed=3).relative > 1e-13


@pytest.mark.parametrize("seed", range(3))
def test_twofold_operations(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = (drawn(rng) for _ in range(2))
    u, v = exact(x), exact(y)
    bound = Fraction(1, 2**100)
    for found, true, terms in (
        (x + y, u + v, np.abs(u) + np.abs(v)),
        (x - y, u - v, np.abs(u) + np.abs(v)),
        (x * y, u * v, np.abs(u * v)),
        (x / y, u / v, np.abs(u / v)),
        (1 - x, 1 - u, 1 + np.abs(u)),
        (2 / x, 2 / u, np.abs(2 / u)),
        (x * x.high, u * fractions(x.high), np.abs(u * fractions(x.high))),
    ):
        assert np.all(np.abs(exact(found) - true) <= bound * terms)
        assert np.all(found.high + found.lows == found.high), "the high part is the nearest double"
    root = exact((x * x).root())
    assert np.all(np.abs(root - np.abs(u)) <= bound * np.abs(u))
    assert np.array_equal(x < y, u < v)
    assert np.array_equal(x >= y, u >= v)
    assert np.all(x == x)  # noqa: PLR0124  element by element
    assert not np.any(Twofold(x.high, x.lows + np.abs(x.lows) + 1e-40) == x)


def drawn(rng: np.random.Generator) -> Twofold:
    high = rng.normal(size=50) * 10 ** rng.uniform(-9, 9, 50)
    return Twofold(high, np.spacing(high) * rng.uniform(-0.5, 0.5, 50))


def exact(x: Twofold) -> Any:
    return fractions(x.high) + fractions(x.lows)


def test_roots_of_fractions_round_up() -> None:
    squares = fractions(np.array([0.0, 4.0, 2.0, 1e-300, 3e300]))
    squares = np.append(squares, Fraction(9, 49))
    for square, root in zip(squares, root_above(squares), strict=True):
        assert root * root >= square
        assert (root * (1 - Fraction(1, 2**99))) ** 2 <= square
    assert root_above(squares)[1] == 2
    assert root_above(squares)[-1] == Fraction(3, 7)


# ---- batches, order, units ---------------------------------------------------------------------------------------


def alone(formula: Any, given: Any, i: int) -> Any:
    return formula(*(v[i] for v in given))


@pytest.mark.parametrize(
    ("formula", "given"),
    [
        (impact_on_line, lines(RNG, ROWS)),
        (impact_of_particles, particles(RNG, ROWS)),
        (merge_particles, particles(RNG, ROWS)[:4]),
        (lambda *given: impact_of_particles(*given, friction=0.4), particles(RNG, ROWS)),
    ],
)
def test_a_row_is_the_impact_alone(formula: Any, given: Any) -> None:
    whole = formula(*given)
    for i in range(ROWS):
        assert all(
            np.array_equal(x[i], y) for x, y in zip(astuple(whole), astuple(alone(formula, given, i)), strict=True)
        )


def test_rows_may_differ_in_their_friction() -> None:
    given = particles(RNG, 3)
    damping, friction = np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.5, 0.0])
    whole = impact_of_particles(*given, damping=damping, friction=friction)
    for i in range(3):
        one = impact_of_particles(*(v[i] for v in given), damping=damping[i], friction=friction[i])
        assert np.array_equal(one.velocity_b, whole.velocity_b[i])


@pytest.mark.parametrize("condition", [1e6, 1e15])
def test_a_row_is_the_impact_of_bodies_alone(condition: float) -> None:
    """Also where some rows are left to fractions."""
    scene = wide_scenes(np.random.default_rng(4), ROWS, condition=condition)
    whole, joined = impact_of_bodies(*scene.question), join_bodies(scene.a, scene.b)
    smooth = impact_of_bodies(*scene.without_friction().question)
    for i in range(ROWS):
        one = impact_of_bodies(*scene[i].question)
        assert all(np.array_equal(x[i], y) for x, y in zip(numbers_of(whole), numbers_of(one), strict=True))
        both = join_bodies(scene.a[i], scene.b[i])
        assert all(np.array_equal(x[i], y) for x, y in zip(numbers_of(joined), numbers_of(both), strict=True))
        if scene.friction[i] == 0:
            assert all(np.array_equal(x[i], y[i]) for x, y in zip(numbers_of(whole), numbers_of(smooth), strict=True))


def test_batches_longer_than_a_chunk_and_of_any_shape() -> None:
    scene = wide_scenes(np.random.default_rng(5), 5000)
    whole = impact_of_bodies(*scene.question)
    part = impact_of_bodies(*scene[2000:2100].question)
    assert np.array_equal(whole.b.velocity[2000:2100], part.b.velocity)
    body, wall = scene.a[:6], RigidBody.immovable()
    grid = impact_of_bodies(wall, body, np.zeros((4, 1, 3)), [0, 0, 1], np.linspace(0, 1, 4)[:, None])
    assert grid.impulse.shape == (4, 6, 3)
    assert grid.a.batch_shape == (4, 6)
    assert grid.b[2, 3].velocity.shape == (3,)
    none = impact_of_bodies(wall, body[:0], [0, 0, 0], [0, 0, 1], 1)
    assert none.b.velocity.shape == (0, 3)
    assert impact_on_line(np.zeros((0, 2)), 1, 1, 1, 1).impulse.shape == (0, 2)


def test_both_orders_agree_to_the_bit() -> None:
    scene = wide_scenes(np.random.default_rng(6), 300)
    a, b, point, normal, e, mu = scene.question
    straight, turned = impact_of_bodies(*scene.question), impact_of_bodies(b, a, point, -normal, e, mu)
    assert np.array_equal(straight.a.velocity, turned.b.velocity)
    assert np.array_equal(straight.b.angular_velocity, turned.a.angular_velocity)
    assert np.array_equal(straight.impulse, -turned.impulse)
    one, other = join_bodies(a, b), join_bodies(b, a)
    assert np.array_equal(one.a.velocity, other.b.velocity)
    assert np.array_equal(one.b.angular_velocity, other.a.angular_velocity)
    va, vb, wa, wb, shares = lines(np.random.default_rng(7), 300)
    assert np.array_equal(
        impact_on_line(va, vb, wa, wb, shares).velocity_a, impact_on_line(vb, va, wb, wa, shares).velocity_b
    )


@pytest.mark.parametrize(("length", "time", "mass"), [(200, -100, 50), (-150, 150, -200), (0, -300, 0), (40, 0, 300)])
def test_units_do_not_matter(length: int, time: int, mass: int) -> None:
    """Powers of two change no digit, although squares of these numbers overflow or vanish."""
    scene = wide_scenes(np.random.default_rng(9), 60)

    def other(body: RigidBody) -> RigidBody:
        return RigidBody(
            np.ldexp(body.position, length),
            np.ldexp(body.velocity, length - time),
            np.ldexp(body.angular_velocity, -time),
            np.ldexp(body.inverse_mass, -mass),
            np.ldexp(body.inertia, mass + 2 * length),
        )

    far = replace(scene, a=other(scene.a), b=other(scene.b), point=np.ldexp(scene.point, length))
    near, there = impact_of_bodies(*scene.question), impact_of_bodies(*far.question)
    assert np.array_equal(there.b.velocity, np.ldexp(near.b.velocity, length - time))
    assert np.array_equal(there.a.angular_velocity, np.ldexp(near.a.angular_velocity, -time))
    assert np.array_equal(there.impulse, np.ldexp(near.impulse, mass + length - time))
    assert np.array_equal(there.sticks, near.sticks)


def test_extreme_numbers_are_left_to_fractions() -> None:
    """Where twice the precision would not do: a ratio beyond all exponents, nearly singular tensors, doubtful signs."""
    thin = inertia_tensor([1, 1, 1e-30], [0, 0, 0, 1])
    nearly = np.array([[1.0, 1 - 2**-52, 0], [1 - 2**-52, 1.0, 0], [0, 0, 1]])
    for inertia in (thin, nearly):
        a = RigidBody([0, 0, 0], [0.1, 0.2, 1], [0, 0, 0], 1, inertia)
        b = RigidBody([1, 1, 1], [0, 0, -1], [0.1, 0.2, 0.3], 1e-290, inertia)
        scene = Scene(a, b, np.array([0.3, 0.1, 0.5]), np.array([0.1, 0.2, 1]), np.array(0.5), np.array(0.2))
        found, true = impact_of_bodies(*scene.question), impact_of_bodies(*scene.exact().question)
        for x, y in zip(numbers_of(found)[:6], numbers_of(true)[:6], strict=True):
            assert np.array_equal(x, y.astype(float))


def test_numbers_at_the_end_of_the_exponents() -> None:
    """What a body of 1e308 times the mass receives is a double as good as any other."""
    given = np.zeros(20), np.linspace(-1, -2, 20), 1e-308 * np.linspace(1, 9, 20), np.full(20, 1.1), np.full(20, 0.7)
    found, true = impact_on_line(*given), impact_on_line(*map(fractions, given))
    assert np.array_equal(found.velocity_a, true.velocity_a.astype(float))
    assert np.array_equal(found.impulse, true.impulse.astype(float))


def test_fractions_are_only_for_what_needs_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """They take a thousand times longer."""
    scene = wide_scenes(np.random.default_rng(0), 1000)
    monkeypatch.setattr(evaluating, "_in_fractions", None)
    impact_of_bodies(*scene.question)
    join_bodies(scene.a, scene.b)
    impact_of_particles(*particles(RNG, 1000), friction=0.3)
    impact_on_line(*lines(RNG, 1000))
    with pytest.raises(TypeError):
        impact_on_line(0, 1, 1e-308, 1, 1)


def test_the_sign_of_an_approach_is_exact() -> None:
    """0.1 · 3 − 0.3 is not 0 in doubles; the true value is."""
    a = RigidBody.immovable()
    b = RigidBody([0, 0, 0], [3, -1, 0], [0, 0, 0], 1, np.eye(3))
    third = 3 * Fraction(0.1)
    exact_normal = [Fraction(0.1), third, 0]
    assert approach(a, b, [0, 0, 0], exact_normal) == 0
    assert approach(a, b, [0, 0, 0], [0.1, float(third), 0]) == float(third - Fraction(float(third)))
    grazing = impact_of_bodies(a, b, [0, 0, -1], [1, 3, 0], 1, 1)
    assert not grazing.sticks
    assert np.array_equal(grazing.b.velocity, b.velocity)


def test_what_only_grazes_does_not_rub(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body that turns about the normal slides along it exactly; rounding the sign of that would jam it."""
    rng = np.random.default_rng(0)
    scene = wide_scenes(rng, 100, ratio=4.0)
    mass = np.where(scene.b.inverse_mass > 0, scene.b.inverse_mass, 1)
    tensors = inertia_tensor(np.array([1.0, 30, 900]), rng.normal(size=(100, 4)))
    top = RigidBody(scene.b.position, [0, 0, 0], scene.normal, mass, tensors)
    question = RigidBody.immovable(), top, scene.point, scene.normal, 0.5, 3.0
    assert not approach(*question[:4]).any()
    assert not impact_of_bodies(*question).b.velocity.any()
    monkeypatch.setattr(rigid, "known", lambda difference, *_: difference)
    assert np.abs(impact_of_bodies(*question).b.velocity).max() > 1, "twice the precision alone is not enough"


def test_momentum_and_energy_in_doubles() -> None:
    body = RigidBody([1, 2, 3], [1, 0, 0], [0, 2, 0], 0.5, np.diag([1.0, 2.0, 3.0]))
    assert np.array_equal(body.momentum(), [2, 0, 0])
    assert body.kinetic_energy() == 1 + 4
    assert np.array_equal(body.angular_momentum(), [0, 4 + 6, -4])
    assert np.array_equal(body.angular_momentum([1, 2, 3]), [0, 4, 0])
    assert np.array_equal(body.velocity_at([1, 2, 4]), [3, 0, 0])


# ---- bodies from proxies -----------------------------------------------------------------------------------------


def test_bodies_of_proxies() -> None:
    ball = RigidBody.of(Sphere([1, 2, 3], 2), mass=5, velocity=[1, 0, 0])
    assert np.array_equal(ball.position, [1, 2, 3])
    assert ball.inverse_mass == 0.2
    assert np.allclose(ball.inertia, 8 * np.eye(3), rtol=1e-15)
    box = RigidBody.of(Box([0, 0, 0], [1, 2, 3], [0.1, 0.2, 0.3, 0.9]), density=np.array([1.0, 2.0]))
    assert box.batch_shape == (2,)
    assert np.allclose(box.inverse_mass, [1 / 48, 1 / 96], rtol=1e-15)
    floor = RigidBody.of(HalfSpace([0, 0, 1], 0), mass=np.inf)
    assert floor.inverse_mass == 0
    mixed = RigidBody.of(Sphere([0, 0, 0], 1), mass=[1.0, np.inf])
    assert np.array_equal(mixed.inverse_mass, [1, 0])
    with pytest.raises(TypeError, match="HalfSpace"):
        RigidBody.of(HalfSpace([0, 0, 1], 0), mass=1)
    for wrong in ({}, {"mass": 1, "density": 1}, {"mass": 0}, {"density": -1}, {"density": np.inf}):
        with pytest.raises(ShapeError, match=r"mass|density"):
            RigidBody.of(Sphere([0, 0, 0], 1), **wrong)


def test_inertia_tensor_turns_the_moments() -> None:
    moments, q = fractions([1, 2, 3]), fractions([1, 2, 3, 4])
    tensor = inertia_tensor(moments, q)
    assert all(isinstance(x, Fraction) for x in tensor.ravel())
    assert np.trace(tensor) == 6
    assert np.array_equal(tensor, tensor.T)
    from refimpl.linear import rotation_matrix  # noqa: PLC0415

    matrix = rotation_matrix(np.array([1.0, 2, 3, 4]))
    assert np.allclose(tensor.astype(float), matrix @ np.diag([1, 2, 3]) @ matrix.T, rtol=0, atol=1e-15)
    assert np.array_equal(inertia_tensor([1, 2, 3], [0, 0, 0, 7]), np.diag([1.0, 2, 3]))


ROUNDED_TO_DEFINITE = [
    [2.1161224489795916, 4.328571428571428, 7.442857142857143],
    [4.328571428571428, 10.0, 10.0],
    [7.442857142857143, 10.0, 50.0],
]
"""Its last pivot is negative, and comes out as 1e-14 in doubles."""


def test_definite_is_decided_exactly() -> None:
    ulp = 2**-52
    tensors = np.array(
        [
            [[1, 1, 0], [1, 1 + ulp, 0], [0, 0, 1]],
            [[1, 1, 0], [1, 1, 0], [0, 0, 1]],
            [[1 + ulp, 1, 0], [1, 1 - ulp, 0], [0, 0, 1]],
            [[1, 0, 0], [0, 1, 0], [0, 0, -1]],
            [[1e-300, 0, 0], [0, 1e300, 0], [0, 0, 1]],
            [[0, 0, 0], [0, 1, 0], [0, 0, 1]],
            ROUNDED_TO_DEFINITE,
        ]
    )
    assert is_definite(tensors).tolist() == [True, False, False, False, True, False, False]
    assert is_definite(fractions(tensors)).tolist() == [True, False, False, False, True, False, False]


# ---- what is refused ---------------------------------------------------------------------------------------------

BALL = {"position": [0, 0, 0], "velocity": [0, 0, 0], "angular_velocity": [0, 0, 0], "inverse_mass": 1}
ROUND = RigidBody(**BALL, inertia=np.eye(3))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inverse_mass": -1}, r"RigidBody.inverse_mass: must be at least 0, got -1"),
        ({"inverse_mass": np.nan}, r"RigidBody.inverse_mass: must be finite"),
        ({"position": [0, 0, np.inf]}, r"RigidBody.position: must be finite"),
        ({"velocity": [0, 0]}, r"RigidBody.velocity: expected 3 numbers, got an array of shape \(2,\)"),
        ({"angular_velocity": "fast"}, r"RigidBody.angular_velocity: expected real numbers"),
        ({"inertia": None}, r"RigidBody.inertia: needed"),
        ({"inertia": np.eye(2)}, r"RigidBody.inertia: expected 3 × 3 numbers"),
        ({"inertia": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]}, r"RigidBody.inertia: must be symmetric.*0\.1"),
        ({"inertia": np.diag([1, 1, 0])}, r"RigidBody.inertia: must be positive definite"),
        ({"inertia": np.diag([1, -1, 1])}, r"RigidBody.inertia: must be positive definite"),
        ({"inertia": [np.eye(3), np.ones((3, 3))]}, r"RigidBody.inertia: must be positive definite, got \[\[1"),
        ({"velocity": np.zeros((2, 3)), "position": np.zeros((3, 3))}, r"RigidBody.position \(3,\)"),
    ],
)
def test_bad_bodies(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        RigidBody(**{**BALL, "inertia": np.eye(3), **change})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: impact_on_line(1, 0, -1, 1, 1), "inverse_mass_a: must be at least 0, got -1"),
        (lambda: impact_on_line(1, 0, 1, [1, -2], 1), "inverse_mass_b: must be at least 0, got -2"),
        (lambda: impact_on_line(1, np.nan, 1, 1, 1), "velocity_b: must be finite, got nan"),
        (lambda: impact_on_line(1, 0, 1, 1, 1.5), "restitution: must be from 0 to 1, got 1.5"),
        (lambda: impact_on_line(1, 0, 1, 1, Fraction(-1, 2)), "restitution: must be from 0 to 1, got -1/2"),
        (lambda: impact_on_line([1, 2], [1, 2, 3], 1, 1, 1), "batch shapes do not broadcast"),
        (lambda: split([1, 2, 3], [0, 0, 0]), "normal: must not be zero"),
        (lambda: impact_of_particles([0] * 3, [1] * 3, 1, 1, [1, 0, 0], 1, friction=-0.1), "friction: must be at"),
        (lambda: impact_of_particles([0] * 3, [1] * 3, 1, 1, [1, 0, 0], 1, damping=2), "damping: must be from 0"),
        (
            lambda: impact_of_particles([0] * 3, [1] * 3, 1, 1, [1, 0, 0], 1, damping=1, friction=1),
            "damping and friction",
        ),
        (lambda: impact_of_bodies(ROUND, ROUND, [0, 0, 0], [0, 0, 0], 1), "normal: must not be zero"),
        (lambda: impact_of_bodies(ROUND, ROUND, [0, 0, 0], [0, 0, 1], -0.1), "restitution: must be from 0 to 1"),
        (lambda: impact_of_bodies(ROUND, ROUND, [0, 0, 0], [0, 0, 1], 1, -1), "friction: must be at least 0"),
        (lambda: impact_of_bodies(ROUND, ROUND, [0, np.inf, 0], [0, 0, 1], 1), "point: must be finite"),
        (lambda: RigidBody.immovable().momentum(), "RigidBody.inverse_mass: must not be 0"),
        (lambda: RigidBody.immovable().kinetic_energy(), "RigidBody.inverse_mass: must not be 0"),
        (lambda: inertia_tensor([1, 2, 3], [0, 0, 0, 0]), "rotation: must not be zero"),
        (lambda: inertia_tensor([1, 2, -3], [0, 0, 0, 1]), "moments: must be at least 0"),
    ],
)
def test_bad_input(call: Any, message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        call()


def test_what_is_read() -> None:
    """Whole numbers and doubles of any kind; with one fraction among them, all are fractions."""
    given = np.array([np.float32(0.5), np.int64(2), 3, 4.5, Fraction(1, 3)], dtype=object)
    after = impact_on_line(given, 0, 1, 1, 0)
    assert after.velocity_b.tolist() == [Fraction(1, 4), 1, Fraction(3, 2), Fraction(9, 4), Fraction(1, 6)]
    assert all(isinstance(x, Fraction) for x in after.velocity_b)
    assert impact_on_line(np.float32(0.5), 0, 1, 1, 0).velocity_b == 0.25
    assert impact_on_line(0.1, Fraction(0), 1, 1, 0).velocity_b == Fraction(0.1) / 2
    for wrong in (True, "1", None, 1j, [1, None], [Fraction(1), float("inf")], [Fraction(1), True]):
        with pytest.raises(ShapeError, match="velocity_a"):
            impact_on_line(wrong, 0, 1, 1, 0)


def test_bodies_cannot_be_changed() -> None:
    given = np.zeros(3)
    body = RigidBody(given, [0, 0, 0], [0, 0, 0], 0)
    given[0] = 1
    assert body.position[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        body.velocity[0] = 1


def test_the_reference_alone_imports_neither_impacts_nor_proofs_and_an_engine_no_hypothesis() -> None:
    """Each process of an engine has to import them: what it does not need costs every campaign."""
    script = (
        "import sys, refimpl; assert not {'refimpl.impacts', 'refimpl.proof'} & set(sys.modules); "
        "import oracles.isolation.guard; assert not {'refimpl.proof', 'hypothesis', 'scipy'} & set(sys.modules); "
        "from refimpl import certify, impacts, sweeps; assert refimpl.proof.certify is certify and sweeps.Touch"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
