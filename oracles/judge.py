"""The judge: gives each answer of an engine its verdict.

Bulk first: every claim of every answer is screened with the reference in floats. What passes with room to spare
is right. What does not is brought before the exact checker, one answer at a time, and convicted only by a
certificate. Tolerances are the engine's own, as its adapter declares them, and are applied here and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from oracles.audit import OUTSIDE, REFUSED, audit_of
from oracles.claims import NEITHER, NOT_A_NUMBER, Claim, Proof, Questioned
from oracles.course import Course
from oracles.engine import Answers, Engine
from oracles.outcome import Kind, Severity, Verdict
from oracles.reference import UNIONS
from oracles.rules import Rules
from oracles.scene import Cell, Scene
from oracles.screening import CRASHED, RAISED, TIMED_OUT, Screening, Sides, fate_of, screen
from oracles.words import conviction, said_of, severity_of
from refimpl import Proxy
from refimpl.proof import InvalidCertificate
from refimpl.proof.certify import round_down, round_up

__all__ = ["CRASHED", "RAISED", "TIMED_OUT", "Judge", "Screening"]

Exact = Fraction | float


class Judge:
    """Judges the answers of one engine."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.rules = Rules(engine)

    def screen(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers, course: Course | None = None) -> Screening:
        """Give every row of a batch its verdict by floats."""
        return screen(self.rules, cell, a, b, answers, course)

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        kind, symptom = fate_of(answers, 0)
        if kind is not Kind.AGREES:
            return self._no_answer(scene, kind, symptom, answers.errors.get(0, "no more is known"))
        nominal = self.rules.of_scene(scene, answers)
        if nominal.unusable[0]:
            return self._no_answer(scene, Kind.WRONG, NOT_A_NUMBER, f"it answers {said_of(scene.query, answers)}")
        return self._convict_jointly(scene, nominal)

    def _convict_jointly(self, scene: Scene, nominal: Questioned) -> Verdict:
        """Try claim by claim, on the scene's shapes and on the effective ones; first those that may fail on both."""
        cell = scene.cell
        effective = self.rules.effectively(cell, nominal)
        own = self._weighed(cell, nominal, scene)
        same = effective.is_as(nominal)
        pairs = list(zip(own, own if same else self._weighed(cell, effective, scene), strict=True))
        pairs.sort(key=lambda pair: not all(doubtful for _, doubtful in pair))
        found: dict[str, Verdict] = {}
        for (ours, in_doubt), (theirs, also) in pairs:
            if "wrong" in found and not also:
                break  # of what holds on the effective shapes, one is enough to tell a convention
            verdict = self.tried(cell, ours, scene, nominal) if in_doubt else Verdict(Kind.AGREES)
            if verdict.kind is Kind.REFERENCE_WRONG:
                return verdict
            if verdict.kind is Kind.WRONG and ours.by_convention:
                found.setdefault("waived", verdict)
            elif verdict.kind is Kind.WRONG:
                found.setdefault("wrong", verdict)
                joint = verdict if same else self._both(verdict, self.tried(cell, theirs, scene, effective), scene)
                if joint.kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                    inside = joint.kind is Kind.WRONG and self.rules.excused_inside(cell, nominal)[0]
                    return replace(joint, kind=Kind.CONVENTION, severity=None) if inside else joint
                verdict = joint
            if verdict.kind is Kind.UNDECIDED:
                found.setdefault("doubtful", verdict)
        if "wrong" in found:
            return self._neither(found["wrong"], self._proven_violation(cell, effective, scene), scene)
        if "waived" in found and "doubtful" not in found:
            return replace(found["waived"], kind=Kind.CONVENTION, severity=None)
        return found.get("doubtful", Verdict(Kind.AGREES))

    def _weighed(self, cell: Cell, rows: Questioned, scene: Scene) -> list[tuple[Claim, bool]]:
        """Every claim, and whether it is in doubt."""
        return [(claim, self._doubtful(cell, claim, scene)) for claim in rows.claims()]

    def _doubtful(self, cell: Cell, claim: Claim, scene: Scene) -> bool:
        """Whether floats leave it open, or are sure, that a claim is broken."""
        if not claim.made[0]:
            return False
        below, above, error = claim.violations()
        allowed = float(self.rules.allowed(cell, claim.kind, np.array([scene.size]))[0])
        return bool(max(below[0], above[0]) >= allowed - error[0])

    def _both(self, ours: Verdict, theirs: Verdict, scene: Scene) -> Verdict:
        """One claim on the scene's shapes and on the effective ones: the kinder amount counts.

        The certificate and its interval stay those of the scene itself, which the reader has before him.
        """
        if theirs.kind is not Kind.WRONG or theirs.symptom != ours.symptom:
            return theirs if theirs.kind in (Kind.REFERENCE_WRONG, Kind.UNDECIDED) else Verdict(Kind.AGREES)
        if theirs.amount >= ours.amount:
            return ours
        kinder = f"{ours.claim} On the shapes that {self.engine.name} effectively uses, still by {theirs.amount:.3g}."
        severity = severity_of(ours.symptom, theirs.amount, scene.size)
        return replace(ours, amount=theirs.amount, severity=severity, claim=kinder)

    def _neither(self, ours: Verdict, theirs: Verdict, scene: Scene) -> Verdict:
        """No claim is violated on both: a convention, or wrong on both in different ways."""
        if theirs.kind is Kind.AGREES:
            return replace(ours, kind=Kind.CONVENTION, severity=None)
        if theirs.kind is not Kind.WRONG:
            return theirs
        amount = min(ours.amount, theirs.amount)
        also = f"On the shapes that {self.engine.name} effectively uses: {theirs.symptom}, by {theirs.amount:.3g}."
        severity = severity_of(NEITHER, amount, scene.size)
        return replace(ours, symptom=NEITHER, amount=amount, severity=severity, claim=f"{ours.claim} {also}")

    def _no_answer(self, scene: Scene, kind: Kind, symptom: str, text: str) -> Verdict:
        """Verdict on an answer that is none; what it should have been is proven all the same."""
        truth = audit_of(scene)
        if truth.kind is Kind.REFERENCE_WRONG:
            return truth
        claim = f"{self.engine.name}: {symptom} ({text})."
        return Verdict(kind, symptom, Severity.LOST, 0.0, truth.lower, truth.upper, claim, truth.certificate)

    def _proven_violation(self, cell: Cell, rows: Questioned, scene: Scene) -> Verdict:
        """Try every claim exactly; answer the gravest one that a certificate refutes."""
        doubtful: Verdict | None = None
        for claim in rows.claims():
            if claim.by_convention:
                continue
            verdict = self.tried(cell, claim, scene, rows)
            if verdict.kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                return verdict
            if verdict.kind is Kind.UNDECIDED:
                doubtful = doubtful or verdict
        return doubtful or Verdict(Kind.AGREES)

    def proven_error(self, scene: Scene, answers: Answers) -> Verdict:
        """How far off the one value in `answers` is proven to be at least; undecided where there is none.

        As in the screening, where the answer breaks a claim the effective shapes may speak for the engine.
        """
        nominal = self.rules.of_scene(scene, answers)
        if not nominal.answered[0] or nominal.unusable[0]:
            return Verdict(Kind.UNDECIDED)
        questions = [[claim for claim in nominal.claims() if claim.measures is not None and claim.made[0]]]
        if Sides.of(self.rules, scene.cell, nominal).violated.any():
            effective = self.rules.effectively(scene.cell, nominal).claims()
            meant = [c for c in effective if c.measures is not None and c.made[0] and not c.by_convention]
            questions += [meant] if meant else []
        found: list[Exact] = []
        for claims in questions:
            least: Exact = 0.0
            for claim in claims:
                known = self._interval(claim, scene)
                if isinstance(known, Verdict):
                    return known
                least = max(least, *(amount for _, amount, _ in _violations(claim, known.interval)))
            found.append(least)
        return Verdict(Kind.AGREES, amount=max(0.0, round_down(min(found))))

    def tried(self, cell: Cell, claim: Claim, scene: Scene, rows: Questioned) -> Verdict:
        """Verdict on one claim of an answer, for the shapes of `rows`."""
        if not self._doubtful(cell, claim, scene):
            return Verdict(Kind.AGREES)
        known = self._interval(claim, scene)
        if isinstance(known, Verdict):
            return known
        allowed = _exact(float(self.rules.allowed(cell, claim.kind, np.array([scene.size]))[0]))
        for word, least, most in _violations(claim, known.interval):
            if most > allowed:
                kind = Kind.WRONG if least > allowed else Kind.UNDECIDED
                return self._verdict(kind, word, least, known, rows, scene)
        return Verdict(Kind.AGREES)

    def _interval(self, claim: Claim, scene: Scene) -> Proof | Verdict:
        """What is proven of the number that a claim is about; a verdict where it is against ourselves."""
        try:
            known = claim.proof(scene)
        except InvalidCertificate as refused:
            return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=scene)
        lower, upper = known.proves
        if not known.fits:
            text = f"refimpl says {known.value!r}, but the proven interval is [{float(lower)!r}, {float(upper)!r}]"
            bounds = round_down(lower), round_up(upper)
            return Verdict(
                Kind.REFERENCE_WRONG,
                OUTSIDE,
                Severity.GROSS,
                math.inf,
                *bounds,
                text,
                known.certificate,
                known.scene,
            )
        return known

    def _verdict(self, kind: Kind, word: str, amount: Exact, known: Proof, rows: Questioned, scene: Scene) -> Verdict:
        lower, upper = round_down(known.proves[0]), round_up(known.proves[1])
        said = said_of(scene.query, rows.answers)
        claim = conviction(self.engine.name, said, word, (lower, upper), float(amount))
        severity = severity_of(word, float(amount), scene.size) if kind is Kind.WRONG else None
        return Verdict(kind, word, severity, float(amount), lower, upper, claim, known.certificate, known.scene)


def _violations(claim: Claim, interval: tuple[Exact, Exact]) -> Iterator[tuple[str, Exact, Exact]]:
    """By how much each side of one claim is violated, at least and at most."""
    margin, rounding = Fraction(float(claim.margin[0])), Fraction(float(claim.rounding[0]))
    any_depth = interval[1] < 0 and (isinstance(claim.x, UNIONS) or isinstance(claim.y, UNIONS))
    for word, bound, sign in ((claim.below, claim.low[0], -1), (claim.above, claim.high[0], 1)):
        both = (_excess(float(bound), end, margin, sign) for end in interval)
        least, most = sorted(min(excess, _exact(float(claim.cap[0]))) for excess in both)
        least, most = least - rounding, most + rounding
        yield word, least, least if any_depth else most


def _exact(value: float) -> Exact:
    return value if math.isinf(value) else Fraction(value)


def _excess(bound: float, sigma: Exact, margin: Fraction, sign: int) -> Exact:
    """By how much σ − margin lies above (sign +1) or below (sign −1) the bound; infinities included."""
    if math.isinf(bound) or isinstance(sigma, float):
        difference = float(sigma) - float(margin) - bound
        return -math.inf if math.isnan(difference) else sign * difference
    return sign * (sigma - margin - Fraction(bound))
