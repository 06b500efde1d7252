"""The judge: gives each answer of an engine its verdict.

Bulk first: every claim of every answer is screened with the reference in floats. What passes with room to spare
is right. What does not is brought before the exact checker, one answer at a time, and convicted only by a
certificate. Tolerances are the engine's own, as its adapter declares them, and are applied here and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from oracles.answers import reference_answers, take
from oracles.claims import NOT_A_NUMBER, REFERENCE_ERROR, Claim, Questioned
from oracles.engine import Answers, Bound, Convention, Engine, Status
from oracles.outcome import Kind, Severity, Verdict
from oracles.scene import DISTANCE, RAYCAST, Cell, Scene
from oracles.words import conviction, said_of, severity_of
from refimpl import Point, Proxy, Ray, distance, raycast
from refimpl.linear import Array, Bools
from refimpl.proof import Certificate, InvalidCertificate, certify, check
from refimpl.proof.certify import round_down, round_up

Exact = Fraction | float

TINY = np.finfo(float).tiny
REFUSED, OUTSIDE = "certificate refused", "reference outside its proof"
INSIDE_CONVENTIONS = {Convention.NO_HIT_FROM_INSIDE, Convention.TWO_SIDED_PLANE}
TIMED_OUT, CRASHED, RAISED = "no answer in time", "process lost", "error raised"

_LOST = {
    Status.ANSWERED: (Kind.AGREES, ""),
    Status.ERROR: (Kind.CRASHED, RAISED),
    Status.CRASHED: (Kind.CRASHED, CRASHED),
    Status.TIMED_OUT: (Kind.TIMED_OUT, TIMED_OUT),
    Status.SKIPPED: (Kind.SKIPPED, ""),
}


def _lost(answers: Answers, i: int) -> tuple[Kind, str]:
    """Verdict on a scene without an answer; `Kind.AGREES` where there is one to be judged."""
    kind, symptom = _LOST[Status(int(answers.status[i]))]
    if symptom == RAISED and answers.errors.get(i, "").startswith("answered "):
        return Kind.WRONG, NOT_A_NUMBER
    return kind, symptom


@dataclass(frozen=True)
class Screening:
    """What the floats say of one batch.

    Attributes
    ----------
    kind : (n,) of `Kind`
        AGREES, CONVENTION, the statuses, or WRONG for a suspect, which is yet to be proven.
    symptom : (n,) of str
    amount : (n,)
        Estimated violation, for sorting and counting; a proof comes from `Judge.convict`.
    certain : (n,) bool
        Whether the violation exceeds what the reference itself may err by.
    pressure : (n,)
        Largest error of any claim relative to the tolerance for it: what steers the adversarial hunter.
    """

    kind: list[Kind]
    symptom: list[str]
    amount: Array
    certain: Bools
    pressure: Array


@dataclass(frozen=True)
class _Violations:
    """Symptom ("" for none), amount, whether it is beyond doubt, and the pressure, of each row."""

    symptom: Array
    amount: Array
    certain: Bools
    pressure: Array


class Judge:
    """Judges the answers of one engine."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    # -- bulk ------------------------------------------------------------------------------------------------

    def screen(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers) -> Screening:
        """Give every row of a batch its verdict by floats."""
        n = len(a)
        answered = answers.status == Status.ANSWERED
        lost = [_lost(answers, i) for i in range(n)]
        kinds, symptoms = [kind for kind, _ in lost], [symptom for _, symptom in lost]
        amount, certain = np.zeros(n), np.ones(n, dtype=bool)
        nominal = self._questioned(cell, a, b, answers, effective=False)
        found = self._violations(cell, nominal, self._scene_size(a, b))
        excused = self._excused(cell, nominal, found.symptom)
        for i in np.flatnonzero(answered & (found.symptom != "")):
            symptoms[i], amount[i], certain[i] = found.symptom[i], found.amount[i], found.certain[i]
            kinds[i] = Kind.CONVENTION if excused[i] else Kind.WRONG
        bad = nominal.not_a_number()
        for i in np.flatnonzero(bad):
            kinds[i], symptoms[i], amount[i], certain[i] = Kind.WRONG, NOT_A_NUMBER, math.inf, True
        return Screening(kinds, symptoms, amount, certain, found.pressure)

    def _questioned(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers, *, effective: bool) -> Questioned:
        margins = np.zeros(len(a)), np.zeros(len(a))
        if effective:
            used = self.engine.effective(cell.query, cell.type_a, a.pack(), cell.type_b, b.pack())
            a, b = (shape.kind.unpack(shape.rows) for shape in used)
            margins = used[0].margin, used[1].margin
        least = Convention.DEPTH_OF_ITS_NORMAL not in self._conventions(cell)
        return Questioned(cell.query, a, b, *margins, answers, answers.status == Status.ANSWERED, least)

    def _conventions(self, cell: Cell) -> Mapping[Convention, str]:
        return self.engine.conventions(cell.query, cell.type_a, cell.type_b)

    @staticmethod
    def _scene_size(a: Proxy, b: Proxy) -> Array:
        return np.maximum(a.magnitude, b.magnitude)

    def _tolerance(self, cell: Cell, kind: str, size: Array) -> Array:
        tolerance = self.engine.tolerance(cell.query, cell.type_a, cell.type_b)
        bound: Bound = getattr(tolerance, kind)
        return bound.at(size)

    def _violations(self, cell: Cell, rows: Questioned, size: Array) -> _Violations:
        """The gravest violated claim of each row."""
        n = len(size)
        found = _Violations(np.full(n, "", dtype=object), np.zeros(n), np.zeros(n, dtype=bool), np.zeros(n))
        for claim in rows.claims():
            below, above, error = claim.violations()
            allowed = self._tolerance(cell, claim.kind, size)
            for excess, word in ((below, claim.below), (above, claim.above)):
                new = (excess > allowed - error) & (found.symptom == "")
                found.symptom[new], found.amount[new] = word, excess[new]
                found.certain[new] = (excess > allowed + error)[new]
                np.maximum(found.pressure, excess / np.maximum(allowed, error + TINY), out=found.pressure)
        return found

    def _excused(self, cell: Cell, nominal: Questioned, first: Array) -> Bools:
        """Rows that are right on the shape that the engine effectively uses, or by its documented convention."""
        excused = np.zeros(len(first), dtype=bool)
        wrong = np.flatnonzero(first != "")
        if not wrong.size:
            return excused
        a, b, answers = nominal.a[wrong], nominal.b[wrong], take(nominal.answers, wrong)
        effective = self._questioned(cell, a, b, answers, effective=True)
        excused[wrong] = self._violations(cell, effective, self._scene_size(a, b)).symptom == ""
        if INSIDE_CONVENTIONS & set(self._conventions(cell)):
            inside = distance(Point(a.pack()[:, :3]), b).distance
            excused[wrong] |= inside <= self._tolerance(cell, "value", self._scene_size(a, b))
        return excused

    # -- one answer, proven ----------------------------------------------------------------------------------

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        kind, symptom = _lost(answers, 0)
        if kind is not Kind.AGREES:
            return self._no_answer(scene, kind, symptom, answers.errors.get(0, "no more is known"))
        cell = scene.cell
        a, b = scene.a[None], scene.b[None]
        nominal = self._questioned(cell, a, b, answers, effective=False)
        if nominal.not_a_number()[0]:
            return self._no_answer(scene, Kind.WRONG, NOT_A_NUMBER, f"it answers {said_of(scene.query, answers)}")
        found = self._proven_violation(cell, nominal, scene)
        if found.kind is not Kind.WRONG:
            return found
        first = np.array([found.symptom], dtype=object)
        if self._excused(cell, nominal, first)[0]:
            return replace(found, kind=Kind.CONVENTION, severity=None)
        return self._at_most_effective(cell, a, b, answers, scene, found)

    def _no_answer(self, scene: Scene, kind: Kind, symptom: str, text: str) -> Verdict:
        """Verdict on an answer that is none; what it should have been is proven all the same."""
        truth = audit(scene.a, scene.b)
        if truth.kind is Kind.REFERENCE_WRONG:
            return truth
        claim = f"{self.engine.name}: {symptom} ({text})."
        return Verdict(kind, symptom, Severity.LOST, 0.0, truth.lower, truth.upper, claim, truth.certificate)

    def _at_most_effective(
        self, cell: Cell, a: Proxy, b: Proxy, answers: Answers, scene: Scene, found: Verdict
    ) -> Verdict:
        """Lessen the amount to what is also proven on the effective shapes: the kinder of the two counts.

        The certificate and its interval stay those of the scene itself, which the reader has before him.
        """
        effective = self._questioned(cell, a, b, answers, effective=True)
        same = np.array_equal(effective.a.pack(), a.pack()) and np.array_equal(effective.b.pack(), b.pack())
        if same and not (effective.margin_a[0] or effective.margin_b[0]):
            return found
        other = self._proven_violation(cell, effective, scene)
        if other.kind is Kind.AGREES:
            return replace(found, kind=Kind.CONVENTION, severity=None)
        if other.kind is not Kind.WRONG:
            return other
        if other.amount >= found.amount:
            return found
        kinder = f"{found.claim} On the shapes that {self.engine.name} effectively uses, still by {other.amount:.3g}."
        severity = severity_of(found.symptom, other.amount, scene.size)
        return replace(found, amount=other.amount, severity=severity, claim=kinder)

    def _proven_violation(self, cell: Cell, rows: Questioned, scene: Scene) -> Verdict:
        """Try every claim exactly; answer the gravest one that a certificate refutes."""
        doubtful: Verdict | None = None
        for claim in rows.claims():
            if not claim.made[0]:
                continue
            verdict = self._try(cell, claim, scene, rows)
            if verdict.kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                return verdict
            if verdict.kind is Kind.UNDECIDED:
                doubtful = doubtful or verdict
        return doubtful or Verdict(Kind.AGREES)

    def _try(self, cell: Cell, claim: Claim, scene: Scene, rows: Questioned) -> Verdict:
        x, y = claim.x[0], claim.y[0]
        proof_scene = Scene(scene.query, x, y, scene.regime, scene.source)
        below, above, error = claim.violations()
        allowed = _exact(float(self._tolerance(cell, claim.kind, np.array([scene.size]))[0]))
        if max(below[0], above[0]) < float(allowed) - error[0]:
            return Verdict(Kind.AGREES)
        try:
            certificate = certify(x, y)
            interval = check(certificate, x, y)
        except InvalidCertificate as refused:
            return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=proof_scene)
        lower, upper = interval
        sigma = float(distance(x, y).distance)
        if not allows(lower, upper, sigma, proof_scene.size):
            text = f"refimpl says {sigma!r}, but the proven interval is [{float(lower)!r}, {float(upper)!r}]"
            bounds = round_down(lower), round_up(upper)
            return Verdict(
                Kind.REFERENCE_WRONG,
                OUTSIDE,
                Severity.GROSS,
                math.inf,
                *bounds,
                text,
                certificate,
                proof_scene,
            )
        margin, rounding = Fraction(float(claim.margin[0])), Fraction(float(claim.rounding[0]))
        for word, bound, sign in ((claim.below, claim.low[0], -1), (claim.above, claim.high[0], 1)):
            both = (_excess(float(bound), end, margin, sign) for end in interval)
            least, most = sorted(min(excess, _exact(float(claim.cap[0]))) for excess in both)
            least, most = least - rounding, most + rounding
            if most > allowed:
                kind = Kind.WRONG if least > allowed else Kind.UNDECIDED
                return self._verdict(kind, word, least, interval, certificate, proof_scene, rows, scene)
        return Verdict(Kind.AGREES)

    def _verdict(
        self,
        kind: Kind,
        word: str,
        amount: Fraction | float,
        interval: tuple[Fraction | float, Fraction | float],
        certificate: Certificate,
        proof_scene: Scene,
        rows: Questioned,
        scene: Scene,
    ) -> Verdict:
        lower, upper = round_down(interval[0]), round_up(interval[1])
        said = said_of(scene.query, rows.answers)
        claim = conviction(self.engine.name, said, word, (lower, upper), float(amount))
        severity = severity_of(word, float(amount), scene.size) if kind is Kind.WRONG else None
        return Verdict(kind, word, severity, float(amount), lower, upper, claim, certificate, proof_scene)


def audit(a: Proxy, b: Proxy) -> Verdict:
    """Try the reference itself on one scene: its answer must lie in its own proven interval.

    The time of a ray's hit is tried by the claims that it makes in space, as an engine's would be: near grazing,
    rounding moves the time by much more than the point from the surface.
    """
    query = RAYCAST if isinstance(a, Ray) else DISTANCE
    scene = Scene(query, a, b, "audit")
    try:
        certificate = certify(a, b)
        lower, upper = check(certificate, a, b)
    except InvalidCertificate as refused:
        return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=scene)
    if isinstance(a, Ray):
        value = float(raycast(a, b).t)
        fits = _ray_claims_hold(scene)
    else:
        value = float(distance(a, b).distance)
        fits = allows(lower, upper, value, scene.size)
    if fits:
        return Verdict(Kind.AGREES, lower=round_down(lower), upper=round_up(upper), certificate=certificate)
    text = f"refimpl says {value!r}, but the proven interval is [{float(lower)!r}, {float(upper)!r}]"
    bounds = round_down(lower), round_up(upper)
    return Verdict(Kind.REFERENCE_WRONG, OUTSIDE, Severity.GROSS, math.inf, *bounds, text, certificate, scene)


def _ray_claims_hold(scene: Scene) -> bool:
    a, b = scene.a[None], scene.b[None]
    rows = Questioned(RAYCAST, a, b, np.zeros(1), np.zeros(1), reference_answers(RAYCAST, a, b), np.ones(1, dtype=bool))
    for claim in rows.claims():
        below, above, error = claim.violations()
        if max(below[0], above[0]) > 4 * error[0]:
            return False
    return True


def allows(lower: Exact, upper: Exact, value: float, size: float) -> bool:
    """Whether `value` lies in the proven interval, but for the rounding that the reference is allowed."""
    if math.isinf(value):
        return value == lower == upper or (value < 0 and lower == value)
    slack = Fraction(REFERENCE_ERROR * max(size, abs(value)))
    return lower - slack <= Fraction(value) <= upper + slack


def _exact(value: float) -> Exact:
    return value if math.isinf(value) else Fraction(value)


def _excess(bound: float, sigma: Exact, margin: Fraction, sign: int) -> Exact:
    """By how much σ − margin lies above (sign +1) or below (sign −1) the bound; infinities included."""
    if math.isinf(bound) or isinstance(sigma, float):
        difference = float(sigma) - float(margin) - bound
        return -math.inf if math.isnan(difference) else sign * difference
    return sign * (sigma - margin - Fraction(bound))
