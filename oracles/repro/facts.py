"""What the script of a finding has to know: which claim of the answer is refuted, on which shapes, by which proof."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.claims import OTHER_DEPTHS, Claim, Questioned
from oracles.engine import COLUMNS, WIDTH, Answers, Convention, Engine, Status
from oracles.judge import Judge
from oracles.outcome import Kind, Verdict
from oracles.records import AnyCertificate
from oracles.reference import proven
from oracles.repro.encoding import RAYS, claims_data, kind_of, shape_data
from oracles.rules import Rules
from oracles.scene import BOOLEAN, CONTACTS, RAYCAST, SWEEP, Cell, Scene
from oracles.sweep_claims import SweptRows
from refimpl import Proxy, Ray
from refimpl.linear import norm
from refimpl.proof import Certificate, check
from refimpl.proof.certify import round_down, round_up

GIVEN = "the shapes"


@dataclass(frozen=True)
class Sides:
    """Two shapes on which answers are tried: those of the scene, or those that the engine effectively uses.

    Attributes
    ----------
    whose
        In words.
    margins
        By how much both are grown.
    truth
        Proof of their signed distance, or of the time of a hit; none where a ray is cast at grown shapes.
    claim
        Proof that refutes a claim of the recorded answer, where that is not about their signed distance.
    symptom
        What the recorded answer does wrong.
    """

    whose: str
    a: dict[str, Any]
    b: dict[str, Any]
    margins: tuple[float, float]
    truth: dict[str, Any] | None
    claim: dict[str, Any] | None = None
    symptom: str = ""


@dataclass(frozen=True)
class Refuted:
    """A claim of an answer that is broken, by its number among all of them."""

    number: int
    claim: Claim
    verdict: Verdict


@dataclass(frozen=True)
class Facts:
    """What one script says and checks.

    Attributes
    ----------
    held
        What the engine is held to, and how far off it may be: "hit", "distance", "t", "witness".
    """

    answer: Mapping[str, object]
    held: dict[str, Any]
    sides: tuple[Sides, ...]


def facts_of(engine: Engine, scene: Scene, answer: Mapping[str, object], verdict: Verdict | None) -> Facts:
    """Facts of an answer about shapes at rest, or on their way; the verdict on it, where it is known."""
    judge, answers = Judge(engine), answers_of(answer)
    cell, rules = scene.cell, judge.rules
    nominal = rules.of_scene(scene, answers)
    effective = rules.effectively(cell, nominal)
    ours = _refuted(judge, scene, nominal, verdict)
    sides = [_sides(judge, GIVEN, scene, nominal, verdict, ours)]
    if not _same(nominal, effective):
        theirs = _likewise(judge, scene, effective, ours, verdict)
        sides.append(_sides(judge, f"the shapes that {engine.name} effectively uses", scene, effective, None, theirs))
    return Facts(answer, _held(rules, cell, scene), tuple(sides))


def answers_of(answer: Mapping[str, object]) -> Answers:
    """One recorded answer, as the judge takes it."""
    table = np.full((1, WIDTH), np.nan)
    for name, value in answer.items():
        table[0, COLUMNS[name]] = value
    status = Status.ANSWERED if answer else Status.ERROR
    return Answers.from_table(np.array([status], dtype=np.int8), table, {})


def _same(one: Questioned, other: Questioned) -> bool:
    return all(
        type(x) is type(y) and np.array_equal(x.pack(), y.pack()) and np.array_equal(m, k)
        for x, y, m, k in (
            (one.a, other.a, one.margin_a, other.margin_a),
            (one.b, other.b, one.margin_b, other.margin_b),
        )
    )


def _held(rules: Rules, cell: Cell, scene: Scene) -> dict[str, Any]:
    """What the engine promises in a cell: not what its conventions take back."""
    owed = sorted(rules.engine.says(cell.query, cell.type_a, cell.type_b))
    waived, size = set(rules.conventions(cell)), np.array([scene.size])
    value, witness, hit = (float(rules.allowed(cell, kind, size)[0]) for kind in ("value", "witness", "boolean"))
    if cell.query == RAYCAST:
        assert isinstance(scene.a, Ray)
        speed = float(norm(scene.a.direction))
        return {"t": value, "speed": speed, "hit": hit, "owed": owed}
    if cell.query == SWEEP:
        return {"t": value, "witness": witness, "hit": hit, "owed": owed}
    held: dict[str, Any] = {"owed": owed} | ({"hit": hit} if cell.query in (BOOLEAN, CONTACTS) else {})
    if cell.query != BOOLEAN:
        held["witness"] = witness
        if not (cell.query == CONTACTS and waived & OTHER_DEPTHS):
            held["distance"] = value
    return held | ({"no depth": True} if Convention.NO_DEPTH in waived else {})


def _sides(
    judge: Judge, whose: str, scene: Scene, rows: Questioned, verdict: Verdict | None, refuted: Refuted | None
) -> Sides:
    """One pair of shapes, with the proofs that are needed: the finding's own, where it is about these."""
    a, b = rows.a[0], rows.b[0]
    margins = float(rows.margin_a[0]), float(rows.margin_b[0])
    own = verdict.certificate if verdict is not None and _is_about(verdict, a, b, scene) else None
    told = scene.course is None and (whose == GIVEN or kind_of(a, b) != RAYS)
    truth = proof_data(a, b, sum(margins), own) if told else None
    claim = None if refuted is None or refuted.claim.kept else _claim_data(judge, scene, refuted)
    symptom = "" if refuted is None else refuted.verdict.symptom
    return Sides(whose, shape_data(a), shape_data(b), margins, truth, claim, symptom)


def _claim_data(judge: Judge, scene: Scene, refuted: Refuted) -> dict[str, Any]:
    """Proof that a claim of the answer is broken."""
    claim, found = refuted.claim, refuted.verdict
    data = proof_data(claim.x[0], claim.y[0], float(claim.margin[0]), found.certificate)
    numbers = {name: float(getattr(claim, name)[0]) for name in ("low", "high", "cap", "rounding")}
    allowed = float(judge.rules.allowed(scene.cell, claim.kind, np.array([scene.size]))[0])
    return data | numbers | {"symptom": found.symptom, "allowed": allowed}


def _is_about(verdict: Verdict, a: Proxy, b: Proxy, scene: Scene) -> bool:
    """Whether a verdict's certificate is about two shapes themselves."""
    shown = verdict.proof_scene or scene
    pairs = ((shown.a, a), (shown.b, b))
    return all(type(x) is type(y) and np.array_equal(x.pack(), y.pack()) for x, y in pairs)


def _refuted(judge: Judge, scene: Scene, rows: Questioned, verdict: Verdict | None) -> Refuted | None:
    """The claim of the answer that the verdict is about, or the first that is refuted."""
    claims = _claims(rows)
    if verdict is None:
        return next(_all_refuted(judge, scene, rows, claims), None)
    about = [(n, claim) for n, claim in claims if _is_about(verdict, claim.x[0], claim.y[0], scene)]
    found = sorted(_all_refuted(judge, scene, rows, about), key=lambda one: _unlike(one.verdict.symptom, verdict))
    return found[0] if found else next(_all_refuted(judge, scene, rows, claims), None)


def _unlike(symptom: str, verdict: Verdict) -> int:
    """How little a symptom is that of a verdict, which may have another name for it and mention it only."""
    return 0 if symptom == verdict.symptom else 1 if f": {symptom};" in verdict.claim else 2


def _likewise(
    judge: Judge, scene: Scene, rows: Questioned, ours: Refuted | None, verdict: Verdict | None
) -> Refuted | None:
    """The same claim on other shapes, if it is broken there in the same way; else the first that is."""
    claims = _claims(rows)
    if ours is not None and verdict is not None and verdict.symptom == ours.verdict.symptom:
        same = [(n, claim) for n, claim in claims if n == ours.number]
        for one in _all_refuted(judge, scene, rows, same):
            if one.verdict.symptom == ours.verdict.symptom:
                return one
    return next(_all_refuted(judge, scene, rows, claims), None)


def _claims(rows: Questioned) -> list[tuple[int, Claim]]:
    """Claims that an answer makes, by their numbers."""
    if not rows.answered[0] or rows.unusable[0]:
        return []
    made = rows.claims_at_rest() if isinstance(rows, SweptRows) else rows.claims()
    return [(number, claim) for number, claim in enumerate(made) if not claim.by_convention]


def _all_refuted(judge: Judge, scene: Scene, rows: Questioned, claims: list[tuple[int, Claim]]) -> Iterator[Refuted]:
    for number, claim in claims:
        verdict = judge.tried(scene.cell, claim, scene, rows)
        if verdict.kind is Kind.WRONG:
            yield Refuted(number, claim, verdict)


def proof_data(x: Proxy, y: Proxy, margin: float, certificate: AnyCertificate | None = None) -> dict[str, Any]:
    """Proof of the signed distance of two shapes, as scripts carry it: by a certificate, where there is one."""
    if isinstance(certificate, Certificate):
        lower, upper = check(certificate, x, y)
    else:
        certificate, (lower, upper) = proven(x, y)
    kind, claims = kind_of(x, y), claims_data(certificate, x, y)
    about = {"x": shape_data(x), "y": shape_data(y), "margin": margin}
    return {"kind": kind, **about, "interval": [round_down(lower), round_up(upper)], "claims": claims}
