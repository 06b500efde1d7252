"""Certificates of impacts: what they prove, and that a false one is refused."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from refimpl.impacts import RigidBody, approach, impact_of_bodies
from refimpl.impacts.laws import certify
from refimpl.proof.impacts import (
    Impact,
    ImpactCertificate,
    MovingBody,
    Outcome,
    Residuals,
    certify_impact,
    check_impact,
)
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.wire import impact_from_json, impact_to_json
from tests.impact_scenes import Scene, scenes, wide_scenes
from tests.wrong_impact_formulas import EXAMPLE, KANE, full_stick

F = Fraction


def certificate(scene: Scene, after_a: RigidBody | None = None, after_b: RigidBody | None = None) -> ImpactCertificate:
    """Of the reference's answer, or another."""
    if after_a is None:
        after = impact_of_bodies(*scene.question)
        after_a, after_b = after.a, after.b
    assert after_b is not None
    found = certify(*scene.question, after_a=after_a, after_b=after_b)
    assert isinstance(found, ImpactCertificate)
    return found


@given(scenes())
def test_the_checker_solves_the_same_law(scene: Scene) -> None:
    """By Cramer's rule, where the formulas eliminate: two programs for one law."""
    if approach(scene.a, scene.b, scene.point, scene.normal) >= 0:
        return
    proven = check_impact(certificate(scene))
    for low, high in proven.errors:
        assert low == 0
        assert high < F(1, 2**90)
    if not scene.friction or impact_of_bodies(*scene.question).sticks:
        assert proven.lower == proven.upper
        assert set(proven.errors) == {(0, 0)}


def test_of_parting_bodies_and_of_immovable_ones_nothing_changes() -> None:
    parting = replace(EXAMPLE, normal=-EXAMPLE.normal)
    proven = check_impact(certificate(parting, parting.a, parting.b))
    assert set(proven.errors) == {(0, 0)}
    assert proven.residuals.restitution == 0
    fixed = replace(EXAMPLE, b=RigidBody.immovable(EXAMPLE.b.position, EXAMPLE.b.velocity), a=KANE.a)
    proven = check_impact(certificate(fixed, fixed.a, fixed.b))
    assert proven.upper == proven.lower == certificate(fixed, fixed.a, fixed.b).outcome
    moved = fixed.b.with_velocities(2 * fixed.b.velocity, fixed.b.angular_velocity)
    assert any(check_impact(certificate(fixed, fixed.a, moved)).residuals.linear_b)


def test_an_answer_in_doubles_has_a_proven_error() -> None:
    scene = wide_scenes(np.random.default_rng(2), 40)
    after = impact_of_bodies(*scene.question)
    speeds = approach(scene.a, scene.b, scene.point, scene.normal)
    for i in np.flatnonzero(speeds < 0):
        proven = check_impact(certificate(scene[i], after.a[i], after.b[i]))
        for (low, high), field in zip(proven.errors, fields(Outcome), strict=True):
            kind, name = field.name.rsplit("_", 1)
            own = [getattr(getattr(owner[i], name), kind) for owner in (scene, BothAfter(after))]
            assert low <= high <= F(np.abs(own).max()) / 2**52


class BothAfter:
    """An outcome that is indexed as a scene is."""

    def __init__(self, after: Any) -> None:
        self.after = after

    def __getitem__(self, i: Any) -> Any:
        return type("Row", (), {"a": self.after.a[i], "b": self.after.b[i]})


def test_a_wrong_answer_has_a_large_proven_error() -> None:
    """Kane's paradox: the usual law keeps all that it promises, gains energy, and is not this law's answer."""
    proven = check_impact(certificate(KANE, *full_stick(KANE)))
    assert proven.residuals.energy > 0
    assert min(low for low, _ in proven.errors[2:]) > F(1, 10)
    assert proven.errors[0] == (0, 0)


SMALL = F(1, 10**30)


@pytest.mark.parametrize("name", [f.name for f in fields(Residuals)])
def test_a_tampered_residual_is_refused(name: str) -> None:
    for scene in (EXAMPLE, KANE):
        true = certificate(scene)
        value = getattr(true.residuals, name)
        false = (value[0], value[1] + SMALL, value[2]) if isinstance(value, tuple) else value + SMALL
        with pytest.raises(InvalidCertificate, match=name):
            check_impact(replace(true, residuals=replace(true.residuals, **{name: false})))


@pytest.mark.parametrize("name", [f.name for f in fields(Outcome)])
def test_a_tampered_outcome_is_refused(name: str) -> None:
    true = certificate(EXAMPLE)
    x, y, z = getattr(true.outcome, name)
    with pytest.raises(InvalidCertificate, match="the residual is not what is stated"):
        check_impact(replace(true, outcome=replace(true.outcome, **{name: (x, y, z + SMALL)})))


@pytest.mark.parametrize("side", ["a", "b"])
@pytest.mark.parametrize("name", [f.name for f in fields(MovingBody)])
def test_a_tampered_body_is_refused(side: str, name: str) -> None:
    """Of bodies that turn and slide, every number matters."""
    true = certificate(EXAMPLE)
    body = getattr(true.impact, side)
    value = getattr(body, name)
    if name == "inertia":
        false: Any = ((value[0][0] + SMALL, *value[0][1:]), value[1], (*value[2][:2], value[2][2] + SMALL))
        false = (false[0], (false[1][0], false[1][1] + SMALL, false[1][2]), false[2])
    else:
        false = value + SMALL if name == "inverse_mass" else tuple(x + SMALL * (i + 1) for i, x in enumerate(value))
    with pytest.raises(InvalidCertificate, match="the residual is not what is stated"):
        check_impact(replace(true, impact=replace(true.impact, **{side: replace(body, **{name: false})})))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"restitution": F(3, 2)}, "restitution"),
        ({"restitution": float("nan")}, "restitution"),
        ({"friction": -1}, "friction"),
        ({"normal": (0, 0, 0)}, "normal"),
        ({"normal": (1, 0)}, "normal"),
        ({"point": (0, 0, float("inf"))}, "point"),
        ({"a": None}, "a: expected MovingBody"),
        ({"b": replace(certificate(EXAMPLE).impact.b, inverse_mass=-1)}, "b.inverse_mass"),
        ({"b": replace(certificate(EXAMPLE).impact.b, inertia=None)}, "b.inertia"),
        ({"b": replace(certificate(EXAMPLE).impact.b, inertia=((1, 1, 0), (0, 1, 0), (0, 0, 1)))}, "symmetric"),
        ({"b": replace(certificate(EXAMPLE).impact.b, inertia=((1, 1, 0), (1, 1, 0), (0, 0, 1)))}, "definite"),
        ({"b": replace(certificate(EXAMPLE).impact.b, velocity=("1", 0, 0))}, "b.velocity"),
    ],
)
def test_what_is_no_impact_is_refused(change: dict[str, Any], message: str) -> None:
    true = certificate(EXAMPLE)
    with pytest.raises(InvalidCertificate, match=message):
        check_impact(replace(true, impact=replace(true.impact, **change)))
    with pytest.raises(InvalidCertificate, match=message):
        certify_impact(replace(true.impact, **change), true.outcome)


def test_what_is_no_certificate_is_refused() -> None:
    true = certificate(EXAMPLE)
    for change in ({"outcome": None}, {"residuals": {}}, {"impact": true.outcome}):
        with pytest.raises(InvalidCertificate, match=next(iter(change))):
            check_impact(replace(true, **change))
    with pytest.raises(InvalidCertificate, match="impact"):
        check_impact(None)  # type: ignore[arg-type]


@pytest.mark.parametrize("scene", [EXAMPLE, KANE, wide_scenes(np.random.default_rng(1), 1)[0]])
def test_certificates_go_through_json(scene: Scene) -> None:
    true = certificate(scene)
    read = impact_from_json(json.loads(json.dumps(impact_to_json(true))))
    assert read == true
    check_impact(read)


def test_malformed_json_is_refused() -> None:
    good = impact_to_json(certificate(KANE))
    for path, value in [
        (("kind",), "near"),
        (("impact", "kind"), "outcome"),
        (("impact", "a", "velocity"), [1, 2]),
        (("impact", "restitution"), "half"),
        (("impact", "b", "mass"), 1),
        (("outcome", "velocity_a"), None),
        (("residuals",), []),
    ]:
        data = json.loads(json.dumps(good))
        inner = data
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value
        with pytest.raises(InvalidCertificate):
            impact_from_json(data)


def test_batches_of_certificates() -> None:
    scene = wide_scenes(np.random.default_rng(3), 6)
    after = impact_of_bodies(*scene.question)
    rows = certify(*scene.question, after_a=after.a, after_b=after.b)
    assert isinstance(rows, list)
    assert rows == [certificate(scene[i], after.a[i], after.b[i]) for i in range(6)]


def test_immovable_bodies_need_no_inertia() -> None:
    wall = MovingBody((0, 0, 0), (0, 0, 0), (0, 0, 0), 0)
    ball = MovingBody((0, 0, 1), (1, 0, -2), (0, 0, 0), F(1, 2), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    after = Outcome((0, 0, 0), (0, 0, 0), (1, 0, 2), (0, 0, 0))
    proven = check_impact(certify_impact(Impact(wall, ball, (0, 0, 0), (0, 0, 1), 1), after))
    assert set(proven.errors) == {(0, 0)}
    assert proven.residuals.energy == 0
    assert proven.residuals.pressure == 8
