"""The judge of impacts: puts the laws of `oracles.impact_laws` to the velocities that an engine answers.

As in space, floats screen a batch, and a single answer is convicted in exact arithmetic. What breaks a law for the
scene's own bodies, but none for those that the engine declares to use (with its own inertia, for instance), is its
convention; what breaks laws for both is wrong, by the smaller amount. Laws of friction differ where sliding and bounce
are coupled: what keeps all laws, but is not the reference's answer, is the convention of an engine that declares so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oracles.answers import take
from oracles.claims import LARGEST, NOT_A_NUMBER
from oracles.engine import COLUMNS, VELOCITIES, WIDTH, Answers, Convention, Engine, Status
from oracles.impact_laws import After, Law, laws
from oracles.impact_reference import REFERENCE_ERROR, reference_of
from oracles.motion import BODY, CONTACT, Motion, exact
from oracles.outcome import Kind, Severity, Verdict
from oracles.scene import Cell, Scene
from oracles.screening import TINY, Screening, fate_of
from oracles.words import severity_of
from refimpl import Proxy
from refimpl.linear import Array, Bools
from refimpl.proof.certify import round_down, round_up
from refimpl.proof.impacts import Impact, ImpactCertificate, MovingBody, Outcome, certify_impact, check_impact
from refimpl.proof.rational import InvalidCertificate

ROUNDING = 1e-14
"""What the laws' own rounding may come to in floats, relative to the largest velocity."""
ANOTHER_FRICTION = "another law of friction"
CLAMP = 0.999
"""Part of a velocity limit from which on a body counts as limited."""


@dataclass(frozen=True)
class _Part:
    """Rows of one cell that are to be judged."""

    cell: Cell
    a: Proxy
    b: Proxy
    motion: Motion
    answers: Answers


class ImpactJudge:
    """Judges an engine's answers to impacts."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    # -- bulk ------------------------------------------------------------------------------------------------

    def screen(self, cell: Cell, a: Proxy, b: Proxy, motion: Motion, answers: Answers) -> Screening:
        """Give every row of a batch its verdict by floats."""
        found = Screening.of_fates(answers)
        unusable = _unusable(answers)
        if unusable.any():
            found.set(unusable, Kind.WRONG, NOT_A_NUMBER, math.inf, certain=True)
        rows = np.flatnonzero((answers.status == Status.ANSWERED) & ~unusable)
        if rows.size:
            part = _Part(cell, a[rows], b[rows], motion[rows], take(answers, rows))
            self._screen(part, rows, found)
        return found

    def _screen(self, part: _Part, rows: NDArray[np.int_], found: Screening) -> None:
        speed, after = part.motion.speed, after_of(part.answers)
        allowed, error = self._allowed(part), ROUNDING * speed
        ours, theirs = list(laws(part.motion, after)), list(laws(self._effective(part), after))
        excused = self._excused(part)
        broken, worst = _first_broken(ours, allowed - error)
        found.pressure[rows] = worst / np.maximum(allowed, error + TINY)
        _, other = _first_broken(theirs, allowed - error)
        found.error[rows] = np.maximum(np.minimum(worst, other) - error, 0.0)
        for k in np.flatnonzero(broken >= 0):
            i, law = int(rows[k]), ours[broken[k]]
            if excused[k] or other[k] <= allowed[k] - error[k]:
                found.set(i, Kind.CONVENTION, law.symptom, 0.0, certain=True)
            else:
                amount = min(float(law.amount[k]), float(other[k]))
                found.set(i, Kind.WRONG, law.symptom, amount, certain=bool(amount > allowed[k] + error[k]))
        for k in np.flatnonzero((broken < 0) & self._slides_otherwise(part, allowed + error)):
            found.set(int(rows[k]), Kind.CONVENTION, ANOTHER_FRICTION, 0.0, certain=True)

    def _slides_otherwise(self, part: _Part, allowed: Array) -> Bools:
        """Impacts with friction after which the velocities are others than by the reference's law."""
        if not self._declares(Convention.OTHER_FRICTION, part.cell):
            return np.zeros(len(part.motion), dtype=bool)
        right = reference_of(part.motion)
        away = [np.abs(getattr(part.answers, v) - getattr(right, v)).max(axis=1) for v in ("velocity_a", "velocity_b")]
        return np.asarray((part.motion.friction > 0) & (np.maximum(*away) > allowed))

    def _declares(self, convention: Convention, cell: Cell) -> bool:
        return convention in self.engine.conventions(cell.query, cell.type_a, cell.type_b)

    def _allowed(self, part: _Part) -> Array:
        cell = part.cell
        return self.engine.tolerance(cell.query, cell.type_a, cell.type_b).value.at(part.motion.speed)

    def _effective(self, part: _Part) -> Motion:
        rows = part.a.pack(), part.b.pack()
        return self.engine.effective_motion(part.cell.type_a, part.cell.type_b, part.motion, rows)

    def _excused(self, part: _Part) -> Bools:
        """Impacts in which a velocity, before or after, is beyond the engine's declared limit."""
        cell, motion = part.cell, part.motion
        if not self._declares(Convention.CLAMPED, cell):
            return np.zeros(len(motion), dtype=bool)
        limit = CLAMP * self.engine.velocity_limit
        known = np.stack([motion.a.velocity, motion.a.angular_velocity, motion.b.velocity, motion.b.angular_velocity])
        answers = reference_of(motion)
        right = np.stack([getattr(answers, name) for name in VELOCITIES])
        return np.asarray((np.abs(np.concatenate([known, right])).max(axis=(0, 2))) >= limit)

    # -- one answer, proven ----------------------------------------------------------------------------------

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        assert scene.impact is not None
        kind, symptom = fate_of(answers, 0)
        if kind is not Kind.AGREES:
            return self._no_answer(scene, kind, symptom, answers.errors.get(0, "no more is known"))
        if _unusable(answers)[0]:
            return self._no_answer(scene, Kind.WRONG, NOT_A_NUMBER, "a velocity is missing or beyond all bounds")
        part = _Part(scene.cell, scene.a[None], scene.b[None], scene.impact[None], answers)
        allowed = Fraction(float(self._allowed(part)[0]))
        ours = first_broken(part.motion, answers, allowed)
        if ours is None:
            otherwise = self._slides_otherwise(part, np.asarray([float(allowed) + ROUNDING * part.motion.speed[0]]))
            return Verdict(Kind.CONVENTION, ANOTHER_FRICTION) if otherwise[0] else Verdict(Kind.AGREES)
        truth = audit_impact(scene)
        if truth.kind is Kind.REFERENCE_WRONG:
            return truth
        ours = _broken_by_both(part.motion, self._effective(part), answers, allowed) or ours
        amount = min(ours[1], _greatest(self._effective(part), answers))
        right_by_own = amount <= allowed or bool(self._excused(part)[0])
        return self._verdict(scene, Kind.CONVENTION if right_by_own else Kind.WRONG, ours, amount, answers)

    def proven_error(self, scene: Scene, answers: Answers) -> Verdict:
        """The largest violation of a law by the one answer: by the scene's bodies, or those of the engine if smaller.

        Undecided where there is no answer.
        """
        assert scene.impact is not None
        if answers.status[0] != Status.ANSWERED or _unusable(answers)[0]:
            return Verdict(Kind.UNDECIDED)
        part = _Part(scene.cell, scene.a[None], scene.b[None], scene.impact[None], answers)
        effective = self._effective(part)
        amount = min(_greatest(motion, answers) for motion in (part.motion, effective))
        return Verdict(Kind.AGREES, amount=max(0.0, round_down(amount)))

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
    assert scene.impact is not None
    motion = scene.impact[None]
    answers = reference_of(motion)
    worst = first_broken(motion, answers, Fraction(float(REFERENCE_ERROR * motion.speed[0])))
    certificate = certificate_of(scene, answers)
    if worst is None:
        return Verdict(Kind.AGREES, lower=0.0, upper=0.0, certificate=certificate)
    symptom, amount = worst
    bounds = round_down(amount), round_up(amount)
    text = f"refimpl's velocities break a law: {symptom}, by {float(amount):.3g}"
    return Verdict(Kind.REFERENCE_WRONG, symptom, Severity.GROSS, math.inf, *bounds, text, certificate, scene)


def certificate_of(scene: Scene, answers: Answers) -> ImpactCertificate:
    """Residuals of the laws for the one answer, as the exact checker finds them."""
    assert scene.impact is not None
    bodies = [MovingBody(**{name: _plain(getattr(body, name)) for name in BODY}) for body in scene.impact.bodies]
    contact = {name: _plain(getattr(scene.impact, name)) for name in CONTACT}
    outcome = Outcome(*(_plain(getattr(answers, name)[0]) for name in VELOCITIES))
    return certify_impact(Impact(bodies[0], bodies[1], **contact), outcome)


def broken_by(certificate: ImpactCertificate, scene: Scene, symptom: str) -> Fraction:
    """By how much a law is broken by the velocities of a certificate, which must be true and about the scene.

    Raises
    ------
    InvalidCertificate
        When it states false residuals, or is about another impact.
    """
    check_impact(certificate)
    outcome = certificate.outcome
    values = (outcome.velocity_a, outcome.angular_velocity_a, outcome.velocity_b, outcome.angular_velocity_b)
    table = np.full((1, WIDTH), np.nan)
    for name, value in zip(VELOCITIES, values, strict=True):
        table[0, COLUMNS[name]] = value
    answers = Answers.from_table(np.zeros(1, dtype=np.int8), table, {})
    if scene.impact is None or certificate_of(scene, answers) != certificate:
        raise InvalidCertificate("the certificate is about another impact")
    return max((amount for law, amount in _exactly(scene.impact[None], answers) if law == symptom), default=Fraction(0))


def _plain(values: Array) -> Any:
    """Numbers in tuples."""
    found = np.asarray(values).tolist()
    return tuple(map(_plain, found)) if isinstance(found, list) else found


def _unusable(answers: Answers) -> Bools:
    """Rows in which the engine owes a velocity and gave none, or gave one that no scene can have."""
    bad = np.zeros(len(answers), dtype=bool)
    for name in VELOCITIES:
        bad |= ~(np.abs(getattr(answers, name)) < LARGEST).all(axis=-1)
    return np.asarray(bad & (answers.status == Status.ANSWERED))


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


def first_broken(motion: Motion, answers: Answers, allowed: Fraction) -> tuple[str, Fraction] | None:
    """The first law that is broken by more than is allowed."""
    return next(((symptom, amount) for symptom, amount in _exactly(motion, answers) if amount > allowed), None)


def _broken_by_both(
    motion: Motion, effective: Motion, answers: Answers, allowed: Fraction
) -> tuple[str, Fraction] | None:
    """The first law that is broken by the scene's bodies and also by those with which the engine calculates."""
    own = {symptom for symptom, amount in _exactly(effective, answers) if amount > allowed}
    broken = ((symptom, amount) for symptom, amount in _exactly(motion, answers) if amount > allowed)
    return next(((symptom, amount) for symptom, amount in broken if symptom in own), None)


def _greatest(motion: Motion, answers: Answers) -> Fraction:
    return max((amount for _, amount in _exactly(motion, answers)), default=Fraction(0))
