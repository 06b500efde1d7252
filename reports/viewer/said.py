"""Both answers in the fewest words, as they stand in a corner of the picture."""

from __future__ import annotations

import math
from collections.abc import Mapping

from oracles.outcome import Finding, Kind
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, IMPACT, RAYCAST, SWEEP
from reports import text

DIGITS = (4, 7, 10)
"""Significant digits that are tried until the two answers differ; where none do, something else is wrong."""

NARROW = 1e-3
"""Width of a proven interval, relative to its ends, below which it is given by one number."""

LOST = (Kind.CRASHED, Kind.TIMED_OUT)


def said(finding: Finding) -> list[tuple[str, str]]:
    """Layer and words of both answers, with as many digits as tell the two apart; of related scenes those of either."""
    query, verdict = finding.scene.query, finding.verdict
    name = text.visible(finding.engine, limit=40)
    symptom = text.visible(verdict.symptom, limit=80)
    if query == IMPACT:
        return [("engine", f"{name}: {symptom}")]
    asked, truth = _truth(finding)
    for digits in DIGITS:
        engine, true = _words(query, finding.answer, digits), _words(asked, truth, digits)
        if engine != true:
            break
    else:
        true = _words(asked, truth, DIGITS[0])
        engine = f"{true}, {symptom}" if symptom else true
    if verdict.kind in LOST:
        engine = symptom or verdict.kind.value
    elif finding.related:
        both = (query, finding.answer), (finding.related.scene.query, finding.related.answer)
        engine = ", then ".join(_words(asked_for, answer, DIGITS[0]) for asked_for, answer in both)
    return [("engine", f"{name}: {engine}"), ("truth", f"true: {true}")]


def _truth(finding: Finding) -> tuple[str, object]:
    """Query and answer that are true: the proven distance, where it is known, and else what the reference says."""
    scene, verdict = finding.scene, finding.verdict
    lower, upper = float(verdict.lower), float(verdict.upper)
    about = verdict.proof_scene is None or verdict.proof_scene.id == scene.id
    if scene.query in (RAYCAST, SWEEP) or not about or not math.isclose(lower, upper, rel_tol=NARROW):
        return scene.query, finding.reference
    return DISTANCE, {"distance": lower}


def _words(query: str, answer: object, digits: int) -> str:
    """One answer; of whatever is no answer, that there is none."""
    if not isinstance(answer, Mapping):
        return "no answer"
    hit, distance, time = (_number(answer.get(name)) for name in ("hit", "distance", "t"))
    if any(value is not None and math.isnan(value) for value in (hit, distance, time)):
        return "not a number"
    if query in (RAYCAST, SWEEP):
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
