"""Outcomes as JSON, to the bit: what a run records so that another can go on.

What is read back is not trusted: numbers and texts are limited, and a finding counts as proven only when its
certificate proves again what it is said to prove.
"""

from __future__ import annotations

import math
from collections import Counter
from fractions import Fraction
from typing import Any

from oracles.accuracy import ABSOLUTE, RELATIVE, CellKey, Extreme, ExtremeKey
from oracles.impact_judge import broken_by
from oracles.outcome import Finding, Kind, Outcome, Related, Severity, Verdict
from oracles.scene import Scene
from refimpl.proof import Certificate, InvalidCertificate, SweepCertificate, check, check_sweep, from_json
from refimpl.proof.claims import Bound
from refimpl.proof.impacts import ImpactCertificate
from refimpl.proof.wire import certificate_to_json, impact_from_json, sweep_certificate_from_json

AnyCertificate = Certificate | ImpactCertificate | SweepCertificate

LONGEST_TEXT = 2_000
"""Characters of any text that is read back."""
NUMBERS = ("amount", "lower", "upper")
MOST = 1 << 62
"""No count is larger."""


def outcome_to_json(outcome: Outcome) -> dict[str, Any]:
    """Everything but the sheets, which are recorded as rows, and what is proven of extremes."""
    return {
        "digest": outcome.digest,
        "counts": [[*key[:4], key[4].value, n] for key, n in outcome.counts.items()],
        "counted": [[*key, *value] for key, value in outcome.counted.items()],
        "relations": [[*key[:3], key[3].value, n] for key, n in outcome.relations.items()],
        "hunters": dict(outcome.hunters),
        "timing": outcome.timing,
        "problems": outcome.problems,
        "incidents": dict(outcome.incidents),
        "lacking": sorted(outcome.lacking),
        "extremes": [[*key, extreme.error, extreme.scene.to_json()] for key, extreme in outcome.extremes.items()],
        "efforts": [[*cell, *effort] for cell, effort in outcome.efforts.items()],
        "findings": [finding_to_json(finding) for finding in outcome.findings],
    }


def outcome_from_json(data: Any) -> Outcome:
    """Read what `outcome_to_json` gave.

    Raises
    ------
    ValueError
        For anything else, and for findings whose certificates do not prove them.
    """
    try:
        return Outcome(
            counts=Counter({(*_texts(key[:4]), Kind(key[4])): _count(key[5]) for key in data["counts"]}),  # type: ignore[misc]
            findings=[finding_from_json(entry) for entry in data["findings"]],
            counted={_counted_key(entry): (_count(entry[6]), float(entry[7])) for entry in data["counted"]},
            relations=Counter(
                {(*_texts(key[:3]), Kind(key[3])): _count(key[4]) for key in data["relations"]}  # type: ignore[misc]
            ),
            hunters=Counter({_text(name): _count(n) for name, n in data["hunters"].items()}),
            timing={_text(name): float(spent) for name, spent in data["timing"].items()},
            problems=[_text(line) for line in data["problems"]],
            incidents=Counter({_text(line): _count(n) for line, n in data["incidents"].items()}),
            lacking=set(_texts(data["lacking"])),
            extremes={_extreme_key(entry): _extreme(entry) for entry in data["extremes"]},
            efforts={_cell_key(entry): (_count(entry[3]), _length(entry[4])) for entry in data["efforts"]},
            digest=_text(data["digest"]),
        )
    except (LookupError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f"not an outcome: {error!r}") from None


def _counted_key(entry: Any) -> tuple[str, str, str, str, int | None, str]:
    engine, query, pair, symptom, regime = _texts([*entry[:4], entry[5]])
    decade = None if entry[4] is None else int(entry[4])
    return engine, query, pair, symptom, decade, regime


def _cell_key(entry: Any) -> CellKey:
    engine, query, pair = _texts(entry[:3])
    return engine, query, pair


def _extreme_key(entry: Any) -> ExtremeKey:
    if entry[3] not in (ABSOLUTE, RELATIVE):
        raise ValueError(f"not a measure: {entry[3]!r:.50}")
    return *_cell_key(entry), entry[3]


def _extreme(entry: Any) -> Extreme:
    return Extreme(Scene.from_json(entry[5]), _length(entry[4]))


def _length(value: Any) -> float:
    number = float(value)
    if not number >= 0:
        raise ValueError(f"not a length or time: {value!r:.50}")
    return number


def _text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise ValueError(f"not a text of at most {LONGEST_TEXT} characters")
    return value


def _texts(values: Any) -> list[str]:
    return [_text(value) for value in values]


def _count(value: Any) -> int:
    if type(value) is not int or not 0 <= value <= MOST:
        raise ValueError(f"not a count: {value!r:.50}")
    return value


# -- findings ------------------------------------------------------------------------------------------------


def finding_to_json(finding: Finding) -> dict[str, Any]:
    """Return a finding as plain data, with its certificate."""
    verdict = finding.verdict
    return {
        "engine": finding.engine,
        "scene": finding.scene.to_json(),
        "answer": finding.answer,
        "reference": finding.reference,
        "text": finding.text,
        "repeats": finding.repeats,
        "related": None if finding.related is None else _related_to_json(finding.related),
        **{
            name: getattr(verdict, name)
            for name in ("kind", "symptom", "severity", "amount", "lower", "upper", "claim")
        },
        "certificate": None if verdict.certificate is None else certificate_to_json(verdict.certificate),
        "proof_scene": None if verdict.proof_scene is None else verdict.proof_scene.to_json(),
    }


def finding_from_json(data: Any) -> Finding:
    """Read what `finding_to_json` gave, and have its certificate checked.

    Raises
    ------
    ValueError
        For anything else, or when the certificate does not prove the interval.
    """
    scene = Scene.from_json(data["scene"])
    proof_scene = None if data["proof_scene"] is None else Scene.from_json(data["proof_scene"])
    about = proof_scene or scene
    certificate = None if data["certificate"] is None else certificate_from_json(data["certificate"], about)
    verdict = Verdict(
        Kind(data["kind"]),
        _text(data["symptom"]),
        None if data["severity"] is None else Severity(data["severity"]),
        **{name: float(data[name]) for name in NUMBERS},
        claim=_text(data["claim"]),
        certificate=certificate,
        proof_scene=proof_scene,
    )
    gap = unproven(verdict, scene)
    if gap:
        raise ValueError(gap)
    answer, reference = _answer(data["answer"]), _answer(data["reference"])
    related = None if data.get("related") is None else _related_from_json(data["related"])
    text, repeats = _text(data["text"]), bool(data.get("repeats", True))
    return Finding(_text(data["engine"]), scene, answer, reference, verdict, text, repeats, related)


def _related_to_json(related: Related) -> dict[str, Any]:
    return {"relation": related.relation, "scene": related.scene.to_json(), "answer": related.answer}


def _related_from_json(data: Any) -> Related:
    return Related(_text(data["relation"]), Scene.from_json(data["scene"]), _answer(data["answer"]))


def _answer(data: Any) -> dict[str, object]:
    """Numbers and vectors by name."""
    return {
        _text(name): [float(x) for x in value[:3]] if isinstance(value, list) else float(value)
        for name, value in data.items()
    }


def certificate_from_json(data: Any, scene: Scene) -> AnyCertificate:
    """Read the certificate of a scene, of the kind that its query has."""
    if scene.course is not None:
        return sweep_certificate_from_json(data)
    return from_json(data) if scene.impact is None else impact_from_json(data)


def unproven(verdict: Verdict, scene: Scene) -> str:
    """What a verdict's certificate fails to prove, in a sentence; empty when it proves the interval."""
    certificate, shown = verdict.certificate, verdict.proof_scene or scene
    if certificate is None:
        needed = verdict.kind is Kind.WRONG and math.isfinite(verdict.amount)
        return "no certificate proves it wrong" if needed else ""
    try:
        low, high = proven_interval(certificate, shown, verdict.symptom)
    except ValueError as error:
        return f"the certificate is refused: {error}"
    if low < math.nextafter(verdict.lower, -math.inf) or high > math.nextafter(verdict.upper, math.inf):
        return f"the certificate proves only {float(low)!r} to {float(high)!r}"
    return ""


def proven_interval(certificate: AnyCertificate, scene: Scene, symptom: str) -> tuple[Bound, Bound]:
    """What a certificate proves: an interval of the signed distance or of a time; how far velocities are from a law."""
    if isinstance(certificate, ImpactCertificate):
        amount: Fraction = broken_by(certificate, scene, symptom)
        return amount, amount
    if isinstance(certificate, SweepCertificate):
        if scene.course is None:
            raise InvalidCertificate("the certificate of a sweep is about a scene at rest")
        return check_sweep(certificate, scene.a, scene.b, *scene.course.motions)
    return check(certificate, scene.a, scene.b)
