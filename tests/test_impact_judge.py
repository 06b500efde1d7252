"""Impacts under judgement: each law by numbers known beforehand, each wrong engine found and named, no right one."""

from __future__ import annotations

import dataclasses
import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import impact_laws as laws
from oracles.batch import Batch
from oracles.campaign import run_campaign
from oracles.claims import NOT_A_NUMBER
from oracles.engine import VELOCITIES, Answers, Convention, Status, Support, Tolerance, unsupported
from oracles.impact_judge import ImpactJudge, after_of, audit_impact, broken_by, certificate_of, first_broken
from oracles.impact_reference import REFERENCE_ERROR, reference_of
from oracles.impact_regimes import IMPACT_REGIMES
from oracles.impact_stages import TARGETS
from oracles.judge import CRASHED, TIMED_OUT
from oracles.judges import Judges
from oracles.ledger import Ledger
from oracles.motion import Motion
from oracles.outcome import Kind, Severity
from oracles.planted.textbook import Textbook
from oracles.scene import IMPACT, Cell, Scene
from oracles.strategies import scenes
from refimpl import Capsule, HalfSpace, Sphere
from refimpl.linear import norm
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.wire import impact_from_json, impact_to_json
from tests.conftest import name_of
from tests.sample_impact import FLAT, answered

PAIRS = [f"{a.__name__}–{b.__name__}" for a, b in TARGETS]


class Impulses(Textbook):
    """The small engine that is right, asked about impacts only, and with no room for more than rounding."""

    name = "impulses"

    def _support(self, query: str, A: Any, B: Any) -> Support:
        return unsupported("impacts only")

    def tolerance(self, query: str, A: Any, B: Any) -> Tolerance:
        return Tolerance.uniform(0.0, 1e-12, "closed forms")


def batch_of(pair: Any, each: int = 8, seed: int = 5) -> Batch:
    (batch,) = Batch.draw_impacts(pair, seed, (1, 2), each)
    return batch


# -- the laws --------------------------------------------------------------------------------------------------

# The crate of mass 2 and inertia 3 falls at 2 on its face, with e = 1/2; its contact is 3/2 below the centre.
CASES: list[tuple[dict[str, list[float]], str, Fraction]] = [
    ({"velocity_b": [0.5, 0, -2]}, laws.MISSED, Fraction(3)),
    ({"velocity_b": [0.5, 0, 2]}, laws.FAST, Fraction(1)),
    ({"velocity_b": [0.5, 0, 0]}, laws.SLOW, Fraction(1)),
    ({"velocity_b": [0.5, 0, -3]}, laws.PULLED, Fraction(1)),
    ({"velocity_b": [0.5, 0, 1], "angular_b": [0, 0.5, 0]}, laws.ANGULAR, Fraction(3, 10)),
    ({"velocity_b": [1.5, 0, 1]}, laws.ANGULAR, Fraction(3, 5)),
    ({"velocity_b": [1.5, 0, 1], "angular_b": [0, -1, 0]}, laws.CONE, Fraction(1, 2)),
    ({"velocity_a": [0, 0, -0.25]}, laws.FIXED, Fraction(1, 4)),
    ({"angular_a": [0.125, 0, 0]}, laws.FIXED, Fraction(1, 32)),
]


@pytest.mark.parametrize(("change", "symptom", "amount"), CASES)
def test_each_broken_law_is_named_and_measured(change: dict[str, list[float]], symptom: str, amount: Fraction) -> None:
    answers, judge = answered(FLAT, **change), Judges(Impulses())
    found = judge.convict(FLAT, answers)
    assert (found.kind, found.symptom) == (Kind.WRONG, symptom)
    assert found.lower <= amount <= found.upper
    assert found.amount == pytest.approx(float(amount), rel=1e-12)
    assert symptom in found.claim
    assert isinstance(found.severity, Severity)
    assert FLAT.motion is not None
    screening = judge.screen(FLAT.cell, FLAT.a[None], FLAT.b[None], FLAT.motion[None], answers)
    assert (screening.kind[0], screening.symptom[0], screening.certain[0]) == (Kind.WRONG, symptom, True)
    assert judge.convict(FLAT, answered(FLAT)).kind is Kind.AGREES


def test_energy_and_idle_friction_are_laws_of_their_own() -> None:
    """Between two balls, with spins set so that momenta are kept and the restitution is right."""
    pair = Sphere([0, 0, 0], 1), Sphere([2, 0, 0], 1)
    batch = batch_of((Sphere, Sphere), 1)
    i = batch.regimes.index("rubbing")
    scene = batch.scene(IMPACT, i)
    assert scene.motion is not None
    assert isinstance(scene.a, type(pair[0]))
    smooth = dataclasses.replace(scene, motion=dataclasses.replace(scene.motion, friction=np.array(0.0)))
    without = {name: getattr(answered(smooth), name)[0] for name in VELOCITIES}
    assert Judges(Impulses()).convict(scene, answered(scene, **without)).symptom == laws.SLIPPERY
    assert Judges(Impulses()).convict(smooth, answered(smooth, **without)).kind is Kind.AGREES
    rough = dataclasses.replace(scene, motion=dataclasses.replace(scene.motion, friction=np.array(1e6)))
    doubled = {}
    for name in VELOCITIES:  # twice the friction reverses the sliding, three times it makes it grow
        sticks, slides = getattr(answered(rough), name)[0], without[name]
        doubled[name] = slides + 3.0 * (sticks - slides)
    assert Judges(Impulses()).convict(rough, answered(rough, **doubled)).symptom == laws.ENERGY


@given(data=st.data())
@pytest.mark.parametrize("pair", TARGETS, ids=name_of)
def test_no_law_is_said_to_be_broken_by_more_than_the_answer_is_wrong(pair: Any, data: st.DataObject) -> None:
    """Velocities that are δ away from right ones break no law by more than δ: the amount is a proven lower bound."""
    scene = data.draw(scenes(Cell(IMPACT, *pair)))
    motion = scene.motion
    assert motion is not None
    delta = data.draw(st.sampled_from([1.0, 1e-3, 1e3])) * max(float(motion.speed), 1e-9)
    right, changes = answered(scene), {}
    for side, body in (("a", motion.a), ("b", motion.b)):
        lever = float(np.abs(motion.point - body.position).sum())
        for name, reach in ((f"velocity_{side}", 1.0), (f"angular_{side}", lever)):
            share = np.array(data.draw(st.tuples(*[st.sampled_from([0.0, 1.0, -1.0, 0.5])] * 3)))
            changes[name] = getattr(right, name)[0] + share * delta / reach
    wrong = after_of(answered(scene, **changes))
    for law in laws.laws(motion[None], wrong):
        if law.applies[0] and law.symptom != laws.MISSED:
            assert law.amount[0] <= delta * (1 + 1e-9) + 1e-12 * motion.speed, law.symptom


@pytest.mark.parametrize("pair", TARGETS, ids=name_of)
def test_floats_and_fractions_say_the_same(pair: Any) -> None:
    batch = batch_of(pair, 2)
    assert batch.motion is not None
    right = reference_of(batch.motion)
    rng = np.random.default_rng(1)
    speed = batch.motion.speed
    noisy = {
        name: getattr(right, name) + 0.1 * speed[:, None] * rng.normal(size=(len(batch), 3)) for name in VELOCITIES
    }
    floats = list(laws.laws(batch.motion, laws.After(**noisy)))
    for i in range(len(batch)):
        single = batch.motion[i : i + 1].exact()
        after = laws.After(**{name: _exact(values[i : i + 1]) for name, values in noisy.items()})
        for law, other in zip(floats, laws.laws(single, after), strict=True):
            assert law.applies[i] == other.applies[0]
            if law.applies[i]:
                assert abs(law.amount[i] - float(other.amount[0])) <= 1e-12 * speed[i], law.symptom


def _exact(values: Any) -> Any:
    return np.array([Fraction(x) for x in np.ravel(values).tolist()], dtype=object).reshape(np.shape(values))


# -- the reference and its certificates ------------------------------------------------------------------------


@pytest.mark.parametrize("pair", TARGETS, ids=name_of)
def test_the_reference_fulfils_every_law_in_every_regime(pair: Any) -> None:
    batch = batch_of(pair, 40)
    assert batch.motion is not None
    right, speed = after_of(reference_of(batch.motion)), batch.motion.speed
    for law in laws.laws(batch.motion, right):
        excess = np.where(law.applies, law.amount, 0.0) / speed
        assert excess.max() < 2e-15, (law.symptom, batch.regimes[int(np.argmax(excess))])
    assert REFERENCE_ERROR > 10 * 2e-15
    for i in range(0, len(batch), 40):
        assert audit_impact(batch.scene(IMPACT, i)).kind is Kind.AGREES


def test_the_audit_finds_a_reference_that_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    tipped = answered(FLAT, angular_b=[0.0, 1e-9, 0.0])
    monkeypatch.setattr("oracles.impact_judge.reference_of", lambda motion: tipped)
    found = audit_impact(FLAT)
    assert (found.kind, found.symptom) == (Kind.REFERENCE_WRONG, laws.ANGULAR)
    assert Judges(Impulses()).convict(FLAT, answered(FLAT, velocity_b=[0, 0, 0])).kind is Kind.REFERENCE_WRONG


def test_certificates_prove_the_amount_and_are_about_their_scene() -> None:
    answers = answered(FLAT, velocity_b=[0.5, 0, 2])
    certificate = certificate_of(FLAT, answers)
    again = impact_from_json(json.loads(json.dumps(impact_to_json(certificate))))
    assert broken_by(again, FLAT, laws.FAST) == 1
    assert broken_by(again, FLAT, laws.CONE) <= 0
    assert FLAT.motion is not None
    other = dataclasses.replace(FLAT, motion=dataclasses.replace(FLAT.motion, restitution=np.array(0.25)))
    with pytest.raises(InvalidCertificate, match="another impact"):
        broken_by(certificate, other, laws.FAST)
    false = dataclasses.replace(certificate, residuals=dataclasses.replace(certificate.residuals, pressure=1.0))
    with pytest.raises(InvalidCertificate, match="pressure"):
        broken_by(false, FLAT, laws.FAST)


def test_nothing_is_broken_by_what_the_engine_is_allowed() -> None:
    answers = answered(FLAT, velocity_b=[0.5, 0, 1 + 2e-12])
    assert FLAT.motion is not None
    assert first_broken(FLAT.motion[None], answers, Fraction(1, 10**12)) is not None
    assert first_broken(FLAT.motion[None], answers, Fraction(3, 10**12)) is None


# -- verdicts --------------------------------------------------------------------------------------------------


class Rounded(Impulses):
    """Declares that it takes every body for a ball of the same mass."""

    def effective_motion(self, A: Any, B: Any, motion: Motion, rows: Any) -> Motion:
        balls = (0.4 / np.where(motion.b.inverse_mass > 0, motion.b.inverse_mass, 1.0))[:, None, None] * np.eye(3)
        return dataclasses.replace(motion, b=dataclasses.replace(motion.b, inertia=balls))


class Limited(Impulses):
    velocity_limit = 0.9

    def conventions(self, query: str, A: Any, B: Any) -> dict[Convention, str]:
        return {Convention.CLAMPED: "by design"}


def test_an_inertia_of_its_own_is_a_convention() -> None:
    batch = batch_of((Sphere, Capsule), 1)
    scene = batch.scene(IMPACT, batch.regimes.index("edge_or_corner"))
    assert scene.motion is not None
    own = Rounded().effective_motion(Sphere, Capsule, scene.motion[None], ())
    answers = reference_of(own)
    assert Judges(Impulses()).convict(scene, answers).kind is Kind.WRONG
    assert Judges(Rounded()).convict(scene, answers).kind is Kind.CONVENTION
    screening = Judges(Rounded()).screen(scene.cell, scene.a[None], scene.b[None], scene.motion[None], answers)
    assert list(screening.kind) == [Kind.CONVENTION]
    assert Judges(Rounded()).convict(scene, answered(scene, velocity_b=[0, 0, 9])).kind is Kind.WRONG


def test_a_declared_limit_excuses_what_exceeds_it() -> None:
    wrong = answered(FLAT, velocity_b=[0.5, 0, 0.9])
    assert Judges(Impulses()).convict(FLAT, wrong).kind is Kind.WRONG
    assert Judges(Limited()).convict(FLAT, wrong).kind is Kind.CONVENTION
    slow = dataclasses.replace(FLAT.motion, b=dataclasses.replace(FLAT.motion.b, velocity=np.array([0.0, 0, -0.5])))  # type: ignore[type-var, union-attr]
    scene = dataclasses.replace(FLAT, motion=slow)
    assert Judges(Limited()).convict(scene, answered(scene, velocity_b=[0, 0, 0.3])).kind is Kind.WRONG


@pytest.mark.parametrize("value", [np.nan, np.inf, 1.7976931348623157e308])
def test_numbers_that_no_impact_has_are_no_answers(value: float) -> None:
    answers = answered(FLAT, angular_b=[0, value, 0])
    found = Judges(Impulses()).convict(FLAT, answers)
    assert (found.kind, found.symptom) == (Kind.WRONG, NOT_A_NUMBER)
    screening = Judges(Impulses()).screen(FLAT.cell, FLAT.a[None], FLAT.b[None], FLAT.motion[None], answers)  # type: ignore[index]
    assert list(screening.symptom) == [NOT_A_NUMBER]


@pytest.mark.parametrize(("status", "symptom"), [(Status.CRASHED, CRASHED), (Status.TIMED_OUT, TIMED_OUT)])
def test_a_lost_answer_keeps_its_text_and_the_truth(status: Status, symptom: str) -> None:
    right = answered(FLAT)
    lost = dataclasses.replace(right, status=np.array([status], dtype=np.int8), errors={0: "the last words"})
    found = Judges(Impulses()).convict(FLAT, lost)
    assert (found.symptom, found.severity) == (symptom, Severity.LOST)
    assert "the last words" in found.claim
    assert found.certificate is not None


# -- engines, the whole way ------------------------------------------------------------------------------------


def test_a_right_engine_gives_no_finding_and_every_regime_is_compared() -> None:
    run = run_campaign([f"{__name__}:Impulses"], budget=1e-9, seed=3, ledger=Ledger(), pairs=PAIRS)
    assert [(bucket.key, bucket.witness.verdict.claim) for bucket in run.buckets] == []
    assert run.problems == []
    for pair in PAIRS:
        for regime in IMPACT_REGIMES:
            assert run.total(query=IMPACT, pair=pair, regime=regime, kinds=(Kind.AGREES,)) > 0
    assert run.total(engine="refimpl", query=IMPACT, kinds=(Kind.AGREES,)) >= len(PAIRS)
    assert set(IMPACT_REGIMES) <= set(run.regimes)


# -- scenes ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", TARGETS, ids=name_of)
def test_scenes_touch_where_they_say_and_approach(pair: Any) -> None:
    from refimpl import Point, distance  # noqa: PLC0415

    batch, other = batch_of(pair, 20), batch_of(pair, 20)
    motion = batch.motion
    assert motion is not None
    np.testing.assert_array_equal(motion.pack(), other.motion.pack())  # type: ignore[union-attr]
    found = distance(batch.a, batch.b)
    size = np.maximum(batch.a.magnitude, batch.b.magnitude)
    assert (np.abs(found.distance) / size).max() < 1e-14
    length, free = norm(motion.normal), np.array([name == "any_normal" for name in batch.regimes])
    np.testing.assert_allclose(length[~free], 1.0, atol=1e-15)
    assert (length[free] > 2.0).any()
    np.testing.assert_allclose(found.normal, motion.normal / length[:, None], atol=1e-7)
    for shape in (batch.a, batch.b):
        assert (np.abs(distance(Point(motion.point), shape).distance) / size).max() < 1e-14
    part = np.array([name == "parting" for name in batch.regimes])
    assert (motion.closing[part] >= 0).all()
    graze = np.array([name == "grazing" for name in batch.regimes])
    meets = motion.closing[~part & ~graze] < 0
    assert meets.mean() > 0.9  # round numbers may slide past each other
    assert (motion.closing[~part] <= 1e-15).all()


def test_what_is_immovable_is_so_in_its_regime() -> None:
    for pair in TARGETS:
        batch = batch_of(pair, 20)
        assert batch.motion is not None
        fixed = (batch.motion.a.inverse_mass == 0) | (batch.motion.b.inverse_mass == 0)
        rows = np.array([name == "one_immovable" for name in batch.regimes])
        assert fixed[rows].all()
        assert fixed.all() == (HalfSpace in pair)


def test_the_hash_knows_the_motion() -> None:
    assert FLAT.motion is not None
    other = dataclasses.replace(FLAT, motion=dataclasses.replace(FLAT.motion, friction=np.array(1.0)))
    assert other.id != FLAT.id
    assert FLAT.size == 2.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"restitution": 1.5}, "restitution must be from 0 to 1"),
        ({"friction": -1.0}, "friction must be from 0"),
        ({"normal": [0.0, 0.0, 0.0]}, "normal must not be 0"),
        ({"point": [0.0, 0.0]}, "point must be finite numbers of shape"),
        ({"point": [0.0, 0.0, float("nan")]}, "point must be finite"),
        ({"a": {}}, "not a motion"),
        ({"a": None}, "not a motion"),
    ],
)
def test_motions_from_strangers_are_checked(change: dict[str, Any], words: str) -> None:
    data = FLAT.to_json()
    with pytest.raises(ValueError, match=words):
        Scene.from_json(data | {"motion": data["motion"] | change})
    with pytest.raises(ValueError, match="not a scene"):
        Scene.from_json({name: value for name, value in data.items() if name != "motion"})


def test_names_of_regimes_are_their_own() -> None:
    from oracles.regimes import REGIMES  # noqa: PLC0415

    assert not set(REGIMES) & set(IMPACT_REGIMES)


def test_tolerances_decide() -> None:
    class Loose(Impulses):
        def tolerance(self, query: str, A: Any, B: Any) -> Tolerance:
            return Tolerance.uniform(0.0, 0.6, "for this test")

    answers: Answers = answered(FLAT, velocity_b=[0.5, 0, 2])
    assert ImpactJudge(Impulses()).convict(FLAT, answers).kind is Kind.WRONG
    assert ImpactJudge(Loose()).convict(FLAT, answers).kind is Kind.AGREES
