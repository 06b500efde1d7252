"""The judge of impacts: puts the laws of `oracles.impact_laws` to the velocities that an engine answers.

As in space, floats screen a batch, and a single answer is convicted in exact arithmetic. What breaks a law for the
scene's own bodies, but none for those that the engine declares to use (with its own inertia, for instance), is its
convention; what breaks laws for both is wrong, by the smaller amount.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from oracles.answers import take
from oracles.engine import VELOCITIES, Answers, Convention, Engine, Status
from oracles.impact_laws import After, Law, laws
from oracles.impact_reference import REFERENCE_ERROR, reference_of
from oracles.judge import NOT_A_NUMBER, Screening, fate_of
from oracles.motion import Motion, exact
from oracles.outcome import Kind, Severity, Verdict
from oracles.scene import Cell, Scene
from oracles.words import severity_of
from refimpl.linear import Array, Bools
from refimpl.proof.certify import round_down, round_up

LARGEST = 1e150
"""No velocity is larger; an engine that answers one has not set it."""
ROUNDING = 1e-14
"""What the laws' own rounding may come to in floats, relative to the largest velocity."""
CLAMP = 0.999
"""Part of a velocity limit from which on a body counts as limited."""


class ImpactJudge:
    """Judges an engine's answers to impacts."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    # -- bulk ------------------------------------------------------------------------------------------------

    def screen(self, cell: Cell, motion: Motion, answers: Answers) -> Screening:
        """Give every row of a batch its verdict by floats."""
        n = len(motion)
        fates = [fate_of(answers, i) for i in range(n)]
        found = Screening([k for k, _ in fates], [s for _, s in fates], np.zeros(n), np.ones(n, dtype=bool), np.zeros(n))
        for i in np.flatnonzero(_unusable(answers)):
            found.set(int(i), Kind.WRONG, NOT_A_NUMBER, math.inf, certain=True)
        rows = np.flatnonzero((answers.status == Status.ANSWERED) & ~_unusable(answers))
        if rows.size:
            self._screen(cell, rows, motion[rows], take(answers, rows), found)
        return found

    def _screen(self, cell: Cell, rows: Array, motion: Motion, answers: Answers, found: Screening) -> None:
        speed = motion.speed
        allowed, error = self._allowed(cell, speed), ROUNDING * speed
        ours = list(laws(motion, after_of(answers)))
        theirs = list(laws(self._effective(cell, motion), after_of(answers)))
        excused = self._excused(cell, motion)
        broken, worst = _first_broken(ours, allowed - error)
        found.pressure[rows] = worst / np.maximum(allowed, error)
        _, other = _first_broken(theirs, allowed - error)
        for k in np.flatnonzero(broken >= 0):
            i, law = int(rows[k]), ours[broken[k]]
            if excused[k] or other[k] <= allowed[k] - error[k]:
                found.set(i, Kind.CONVENTION, law.symptom, 0.0, certain=True)
            else:
                amount = min(float(law.amount[k]), float(other[k]))
                found.set(i, Kind.WRONG, law.symptom, amount, certain=bool(amount > allowed[k] + error[k]))

    def _allowed(self, cell: Cell, speed: Array) -> Array:
        return self.engine.tolerance(cell.query, cell.type_a, cell.type_b).value.at(speed)

    def _effective(self, cell: Cell, motion: Motion) -> Motion:
        return self.engine.effective_motion(cell.type_a, cell.type_b, motion)

    def _excused(self, cell: Cell, motion: Motion) -> Bools:
        """Impacts in which a velocity, before or after, is beyond the engine's declared limit."""
        if Convention.CLAMPED not in self.engine.conventions(cell.query, cell.type_a, cell.type_b):
            return np.zeros(len(motion), dtype=bool)
        limit = CLAMP * self.engine.velocity_limit
        known = np.stack([motion.a.velocity, motion.a.angular_velocity, motion.b.velocity, motion.b.angular_velocity])
        answers = reference_of(motion)
        right = np.stack([getattr(answers, name) for name in VELOCITIES])
        return np.asarray((np.abs(np.concatenate([known, right])).max(axis=(0, 2))) >= limit)

    # -- one answer, proven ----------------------------------------------------------------------------------

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        assert scene.motion is not None
        kind, symptom = fate_of(answers, 0)
        if kind is not Kind.AGREES:
            return self._no_answer(scene, kind, symptom, answers.errors.get(0, "no more is known"))
        if _unusable(answers)[0]:
            return self._no_answer(scene, Kind.WRONG, NOT_A_NUMBER, "a velocity is missing or beyond all bounds")
        cell, motion = scene.cell, scene.motion[None]
        allowed = Fraction(float(self._allowed(cell, motion.speed)[0]))
        ours = _worst_of(motion, answers, allowed)
        if ours is None:
            return Verdict(Kind.AGREES)
        truth = audit_impact(scene)
        if truth.kind is Kind.REFERENCE_WRONG:
            return truth
        theirs = _greatest(self._effective(cell, motion), answers)
        amount = min(ours[1], theirs)
        right_by_own = amount <= allowed or bool(self._excused(cell, motion)[0])
        return self._verdict(scene, Kind.CONVENTION if right_by_own else Kind.WRONG, ours, amount, answers)

    def _verdict(
        self, scene: Scene, kind: Kind, found: tuple[str, Fraction], amount: Fraction, answers: Answers
    ) -> Verdict:
        symptom, own = found
        said = ", ".join(f"{name} {getattr(answers, name)[0].tolist()}" for name in VELOCITIES)
        claim = (
            f"{self.engine.name} answers {said}: {symptom}. "
            f"No velocities nearer than {float(amount):.3g} to these fulfil the law."
        )
        severity = severity_of(symptom, float(amount), scene.size) if kind is Kind.WRONG else None
        bounds = round_down(own), round_up(own)
        return Verdict(kind, symptom, severity, round_down(amount), *bounds, claim, certificate_of(scene, answers))

    def _no_answer(self, scene: Scene, kind: Kind, symptom: str, text: str) -> Verdict:
        truth = audit_impact(scene)
        if truth.kind is Kind.REFERENCE_WRONG:
            return truth
        claim = f"{self.engine.name}: {symptom} ({text})."
        return Verdict(kind, symptom, Severity.LOST, 0.0, truth.lower, truth.upper, claim, truth.certificate)


def after_of(answers: Answers) -> After:
    """Velocities that were answered."""
    return After(*(getattr(answers, name) for name in VELOCITIES))


def audit_impact(scene: Scene) -> Verdict:
    """Try the reference itself on one scene: its own velocities must fulfil every law."""
    assert scene.motion is not None
    motion = scene.motion[None]
    answers = reference_of(motion)
    worst = _worst_of(motion, answers, Fraction(float(REFERENCE_ERROR * motion.speed[0])))
    certificate = certificate_of(scene, answers)
    if worst is None:
        return Verdict(Kind.AGREES, lower=0.0, upper=0.0, certificate=certificate)
    symptom, amount = worst
    bounds = round_down(amount), round_up(amount)
    text = f"refimpl's velocities break a law: {symptom}, by {float(amount):.3g}"
    return Verdict(Kind.REFERENCE_WRONG, symptom, Severity.GROSS, math.inf, *bounds, text, certificate, scene)


def _unusable(answers: Answers) -> Bools:
    """Rows in which the engine owes a velocity and gave none, or gave one that no scene can have."""
    bad = np.zeros(len(answers), dtype=bool)
    for name in VELOCITIES:
        bad |= ~(np.abs(getattr(answers, name)) < LARGEST).all(axis=-1)
    return bad & (answers.status == Status.ANSWERED)


def _first_broken(found: list[Law], allowed: Array) -> tuple[Array, Array]:
    """Number of the first law that each row breaks, or −1, and the largest violation of any."""
    broken, worst = np.full(len(allowed), -1), np.zeros(len(allowed))
    for number, law in enumerate(found):
        amount = np.where(law.applies, law.amount, 0.0)
        broken[(broken < 0) & (amount > allowed)] = number
        worst = np.maximum(worst, amount)
    return broken, worst


def _exactly(motion: Motion, answers: Answers) -> Iterator[tuple[str, Fraction]]:
    """Symptom and amount of every law that applies to one impact, in exact arithmetic."""
    after = After(*(exact(getattr(answers, name)) for name in VELOCITIES))
    for law in laws(motion.exact(), after):
        if law.applies[0]:
            yield law.symptom, Fraction(law.amount[0])


def _worst_of(motion: Motion, answers: Answers, allowed: Fraction) -> tuple[str, Fraction] | None:
    """The first law that is broken by more than is allowed."""
    return next(((symptom, amount) for symptom, amount in _exactly(motion, answers) if amount > allowed), None)


def _greatest(motion: Motion, answers: Answers) -> Fraction:
    return max((amount for _, amount in _exactly(motion, answers)), default=Fraction(0))
