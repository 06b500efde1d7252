"""Both answers in the fewest words, as they stand in a corner of the picture."""

from __future__ import annotations

import math
from collections.abc import Mapping

from oracles.outcome import Finding, Kind
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST
from reports import text

DIGITS = (4, 7, 10)
"""Significant digits that are tried until the two answers differ; where none do, something else is wrong."""

LOST = (Kind.CRASHED, Kind.TIMED_OUT)


def said(finding: Finding) -> list[tuple[str, str]]:
    """Layer and words of both answers; with as many digits as tell the two apart."""
    query, verdict = finding.scene.query, finding.verdict
    name = text.visible(finding.engine, limit=40)
    symptom = text.visible(verdict.symptom, limit=80)
    if query == IMPACT:
        return [("engine", f"{name}: {symptom}")]
    truth = _truth(finding)
    for digits in DIGITS:
        engine, true = (_words(query, answer, digits) for answer in (finding.answer, finding.reference))
        if engine != true:
            break
    else:
        true = _words(query, finding.reference, DIGITS[0])
        engine = f"{true}, {symptom}" if symptom else true
    if verdict.kind in LOST:
        engine = symptom or verdict.kind.value
    return [("engine", f"{name}: {engine}"), ("truth", f"true: {truth or true}")]


def _truth(finding: Finding) -> str:
    """What is proven of a boolean's scene: more than yes or no."""
    verdict, proof_scene = finding.verdict, finding.verdict.proof_scene
    about = proof_scene is None or proof_scene.id == finding.scene.id
    if finding.scene.query != BOOLEAN or not about or not math.isfinite(verdict.lower):
        return ""
    return _words(DISTANCE, {"distance": float(verdict.lower)}, 4)


def _words(query: str, answer: object, digits: int) -> str:
    """One answer; of whatever is no answer, that there is none."""
    if not isinstance(answer, Mapping):
        return "no answer"
    hit, distance, time = (_number(answer.get(name)) for name in ("hit", "distance", "t"))
    if query == RAYCAST:
        miss = hit == 0 or time == math.inf
        return "no hit" if miss else "no answer" if time is None else f"hit at t = {time:.{digits}g}"
    if distance is not None and (query != BOOLEAN or hit is None):
        return _distance(distance, digits)
    contact = "no contact" if query == CONTACTS else "no overlap"
    return "no answer" if hit is None else "overlap" if hit else contact


def _distance(distance: float, digits: int) -> str:
    if distance == -math.inf:
        return "overlap without end"
    return f"distance {distance:.{digits}g}" if distance >= 0 else f"overlap, depth {-distance:.{digits}g}"


def _number(value: object) -> float | None:
    try:
        return float(value) if isinstance(value, bool | int | float) else None
    except OverflowError:
        return None
