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
from typing import Any

import numpy as np

from oracles.audit import OUTSIDE, REFUSED, allows, audit
from oracles.claims import NEITHER, NOT_A_NUMBER, Claim, Questioned
from oracles.engine import Answers, Bound, Convention, Effective, Engine, Status
from oracles.outcome import Kind, Severity, Verdict
from oracles.reference import UNIONS, error_of, proven
from oracles.scene import Cell, Scene
from oracles.words import conviction, said_of, severity_of
from refimpl import Point, Proxy, distance
from refimpl.linear import Array, Bools
from refimpl.proof import Certificate, InvalidCertificate
from refimpl.proof.certify import round_down, round_up

Exact = Fraction | float

TINY = np.finfo(float).tiny
INSIDE_CONVENTIONS = {Convention.NO_HIT_FROM_INSIDE, Convention.TWO_SIDED_PLANE}
TIMED_OUT, CRASHED, RAISED = "no answer in time", "process lost", "error raised"

_LOST = {
    Status.ANSWERED: (Kind.AGREES, ""),
    Status.ERROR: (Kind.CRASHED, RAISED),
    Status.CRASHED: (Kind.CRASHED, CRASHED),
    Status.TIMED_OUT: (Kind.TIMED_OUT, TIMED_OUT),
    Status.SKIPPED: (Kind.SKIPPED, ""),
    Status.UNSUPPORTED: (Kind.UNSUPPORTED, ""),
}


def fate_of(answers: Answers, i: int) -> tuple[Kind, str]:
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

    def set(self, row: int, kind: Kind, symptom: str, amount: float, *, certain: bool) -> None:
        """Give one row its verdict."""
        self.kind[row], self.symptom[row], self.amount[row], self.certain[row] = kind, symptom, amount, certain


@dataclass(frozen=True)
class _Side:
    """One side of a claim over a batch: by how much it is violated, whether at all, and whether beyond doubt."""

    symptom: str
    excess: Array
    violated: Bools
    certain: Bools
    by_convention: bool

    def take(self, rows: Any) -> _Side:
        """Pick rows."""
        return replace(self, excess=self.excess[rows], violated=self.violated[rows], certain=self.certain[rows])


class Judge:
    """Judges the answers of one engine."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    # -- bulk ------------------------------------------------------------------------------------------------

    def screen(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers) -> Screening:
        """Give every row of a batch its verdict by floats."""
        n = len(a)
        lost = [fate_of(answers, i) for i in range(n)]
        found = Screening([k for k, _ in lost], [s for _, s in lost], np.zeros(n), np.ones(n, dtype=bool), np.zeros(n))
        nominal = self._questioned(cell, a, b, answers, effective=False)
        for i in np.flatnonzero(nominal.unusable):
            found.set(int(i), Kind.WRONG, NOT_A_NUMBER, math.inf, certain=True)
        sides = self._sides(cell, nominal, found.pressure)
        usable = ~nominal.unusable
        wrong = np.flatnonzero(np.any([side.violated for side in sides], axis=0) & usable)
        if wrong.size:
            self._judge_jointly(cell, nominal, sides, wrong, found)
        return found

    def _sides(self, cell: Cell, rows: Questioned, pressure: Array | None = None) -> list[_Side]:
        """Both sides of every claim, the gravest claim first."""
        size, sides = rows.size, []
        for claim in rows.claims():
            below, above, error = claim.violations()
            allowed = self._tolerance(cell, claim.kind, size)
            for excess, word in ((below, claim.below), (above, claim.above)):
                doubt = excess > allowed - error
                sides.append(_Side(word, excess, doubt, excess > allowed + error, claim.by_convention))
                if pressure is not None:
                    np.maximum(pressure, excess / np.maximum(allowed, error + TINY), out=pressure)
        return sides

    def _judge_jointly(self, cell: Cell, nominal: Questioned, sides: list[_Side], wrong: Any, found: Screening) -> None:
        """Give the rows with a violated claim their verdict: on the scene's shapes and on the effective ones.

        A claim counts when it is violated on both, by the smaller amount; right on the effective shapes is a
        convention; wrong on both, but in different ways, is a symptom of its own.
        """
        part = nominal.take(wrong)
        effective = self._questioned(cell, part.a, part.b, part.answers, effective=True)
        as_given = effective.a is part.a and effective.b is part.b
        theirs = [side.take(wrong) for side in sides] if as_given else self._sides(cell, effective)
        excused = self._inside_excused(cell, part)
        for k, i in enumerate(wrong):
            ours = [s for s in sides if s.violated[i] and not s.by_convention]
            both = [(s, t) for s, t in zip(sides, theirs, strict=True) if s.violated[i] and t.violated[k]]
            both = [(s, t) for s, t in both if not s.by_convention]
            other = [t for t in theirs if t.violated[k] and not t.by_convention]
            if excused[k] or not ours or not other:
                symptom = ours[0].symptom if ours else next(s.symptom for s in sides if s.violated[i])
                found.set(i, Kind.CONVENTION, symptom, 0.0, certain=True)
            elif both:
                s, t = both[0]
                amount = min(float(s.excess[i]), float(t.excess[k]))
                found.set(i, Kind.WRONG, s.symptom, amount, certain=bool(s.certain[i] and t.certain[k]))
            else:
                amount = min(float(ours[0].excess[i]), float(other[0].excess[k]))
                certain = bool(ours[0].certain[i] and other[0].certain[k])
                found.set(i, Kind.WRONG, NEITHER, amount, certain=certain)

    def _inside_excused(self, cell: Cell, rows: Questioned) -> Bools:
        """Rays that start inside, where the engine's convention differs: a miss, or a hit on the way out."""
        if not INSIDE_CONVENTIONS & set(self._conventions(cell)):
            return np.zeros(len(rows.a), dtype=bool)
        allowed = self._tolerance(cell, "value", rows.size)
        inside = distance(Point(rows.a.pack()[:, :3]), rows.b).distance <= allowed
        point = rows.hit_point()
        surface = np.abs(distance(point, rows.b).distance) <= allowed + error_of(point, rows.b) * rows.size
        return np.asarray(inside & ((rows.answers.hit == 0) | surface))

    def _questioned(self, cell: Cell, a: Proxy, b: Proxy, answers: Answers, *, effective: bool) -> Questioned:
        margins = np.zeros(len(a)), np.zeros(len(a))
        if effective:
            rows = a.pack(), b.pack()
            used = self.engine.effective(cell.query, cell.type_a, rows[0], cell.type_b, rows[1])
            margins = used[0].margin, used[1].margin
            a, b = (_effective(shape, given, row) for shape, given, row in zip(used, (a, b), rows, strict=True))
        waived = frozenset(self._conventions(cell))
        return Questioned(cell.query, a, b, *margins, answers, answers.status == Status.ANSWERED, waived)

    def _conventions(self, cell: Cell) -> Mapping[Convention, str]:
        return self.engine.conventions(cell.query, cell.type_a, cell.type_b)

    def _tolerance(self, cell: Cell, kind: str, size: Array) -> Array:
        tolerance = self.engine.tolerance(cell.query, cell.type_a, cell.type_b)
        bound: Bound = getattr(tolerance, kind)
        return bound.at(size)

    # -- one answer, proven ----------------------------------------------------------------------------------

    def convict(self, scene: Scene, answers: Answers) -> Verdict:
        """Verdict on the one answer in `answers`, with its proof."""
        kind, symptom = fate_of(answers, 0)
        if kind is not Kind.AGREES:
            return self._no_answer(scene, kind, symptom, answers.errors.get(0, "no more is known"))
        cell = scene.cell
        nominal = self._questioned(cell, scene.a[None], scene.b[None], answers, effective=False)
        if nominal.unusable[0]:
            return self._no_answer(scene, Kind.WRONG, NOT_A_NUMBER, f"it answers {said_of(scene.query, answers)}")
        return self._convict_jointly(scene, nominal)

    def _convict_jointly(self, scene: Scene, nominal: Questioned) -> Verdict:
        """Try claim by claim, on the scene's shapes and on the effective ones; first those that may fail on both."""
        cell = scene.cell
        effective = self._questioned(cell, nominal.a, nominal.b, nominal.answers, effective=True)
        pairs = list(zip(nominal.claims(), effective.claims(), strict=True))
        pairs.sort(key=lambda pair: not all(self._doubtful(cell, claim, scene) for claim in pair))
        found: dict[str, Verdict] = {}
        for ours, theirs in pairs:
            if "wrong" in found and not self._doubtful(cell, theirs, scene):
                break  # of what holds on the effective shapes, one is enough to tell a convention
            verdict = self._try(cell, ours, scene, nominal)
            if verdict.kind is Kind.REFERENCE_WRONG:
                return verdict
            if verdict.kind is Kind.WRONG and ours.by_convention:
                found.setdefault("waived", verdict)
            elif verdict.kind is Kind.WRONG:
                found.setdefault("wrong", verdict)
                joint = self._both(verdict, self._try(cell, theirs, scene, effective), scene)
                if joint.kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                    inside = joint.kind is Kind.WRONG and self._inside_excused(cell, nominal)[0]
                    return replace(joint, kind=Kind.CONVENTION, severity=None) if inside else joint
                verdict = joint
            if verdict.kind is Kind.UNDECIDED:
                found.setdefault("doubtful", verdict)
        if "wrong" in found:
            return self._neither(found["wrong"], self._proven_violation(cell, effective, scene), scene)
        if "waived" in found and "doubtful" not in found:
            return replace(found["waived"], kind=Kind.CONVENTION, severity=None)
        return found.get("doubtful", Verdict(Kind.AGREES))

    def _doubtful(self, cell: Cell, claim: Claim, scene: Scene) -> bool:
        """Whether floats leave it open, or are sure, that a claim is broken."""
        if not claim.made[0]:
            return False
        below, above, error = claim.violations()
        allowed = float(self._tolerance(cell, claim.kind, np.array([scene.size]))[0])
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
        truth = audit(scene.a, scene.b)
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
            verdict = self._try(cell, claim, scene, rows)
            if verdict.kind in (Kind.WRONG, Kind.REFERENCE_WRONG):
                return verdict
            if verdict.kind is Kind.UNDECIDED:
                doubtful = doubtful or verdict
        return doubtful or Verdict(Kind.AGREES)

    def _try(self, cell: Cell, claim: Claim, scene: Scene, rows: Questioned) -> Verdict:
        if not self._doubtful(cell, claim, scene):
            return Verdict(Kind.AGREES)
        x, y = claim.x[0], claim.y[0]
        proof_scene = Scene(scene.query, x, y, scene.regime, scene.source)
        allowed = _exact(float(self._tolerance(cell, claim.kind, np.array([scene.size]))[0]))
        try:
            certificate, interval = proven(x, y)
        except InvalidCertificate as refused:
            return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=proof_scene)
        lower, upper = interval
        sigma = float(distance(x, y).distance)
        if not allows(lower, upper, sigma, error_of(x, y) * max(proof_scene.size, abs(sigma))):
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
            if upper < 0 and (isinstance(x, UNIONS) or isinstance(y, UNIONS)):
                most = least  # any depth of the interval is right
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


def _effective(used: Effective, given: Proxy, rows: Array) -> Proxy:
    """The shapes that an engine uses: the very ones given, with what is derived of them, where they are the same."""
    same = used.kind is type(given) and used.rows is rows and not used.margin.any()
    return given if same else used.kind.unpack(used.rows)


def _exact(value: float) -> Exact:
    return value if math.isinf(value) else Fraction(value)


def _excess(bound: float, sigma: Exact, margin: Fraction, sign: int) -> Exact:
    """By how much σ − margin lies above (sign +1) or below (sign −1) the bound; infinities included."""
    if math.isinf(bound) or isinstance(sigma, float):
        difference = float(sigma) - float(margin) - bound
        return -math.inf if math.isnan(difference) else sign * difference
    return sign * (sigma - margin - Fraction(bound))
