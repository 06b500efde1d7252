"""Both answers in the fewest words, as they stand in a corner of the picture."""

from __future__ import annotations

import math
from collections.abc import Mapping

from oracles.outcome import Finding, Kind
from oracles.scene import BOOLEAN, CONTACTS, IMPACT, RAYCAST
from reports import text

LOST = (Kind.CRASHED, Kind.TIMED_OUT)


def said(finding: Finding) -> list[tuple[str, str]]:
    """Layer and words of both answers; with as many digits as tell the two apart."""
    query = finding.scene.query
    if query == IMPACT:
        return []
    answers = (finding.answer, finding.reference)
    short, long = ([_words(query, answer, digits) for answer in answers] for digits in (4, 17))
    engine, truth = short if short[0] != short[1] else long
    if finding.verdict.kind in LOST:
        engine = text.visible(finding.verdict.symptom, limit=40) or finding.verdict.kind.value
    name = text.visible(finding.engine, limit=40)
    return [(layer, words) for layer, words in (("engine", f"{name}: {engine}"), ("truth", f"true: {truth}")) if words]


def _words(query: str, answer: object, digits: int) -> str:
    """One answer; of whatever is no answer, that there is none."""
    if not isinstance(answer, Mapping):
        return "no answer"
    hit, distance, time = (_number(answer.get(name)) for name in ("hit", "distance", "t"))
    if query == RAYCAST:
        if hit == 0 or time == math.inf:
            return "no hit"
        return "no answer" if time is None else f"hit at t = {time:.{digits}g}"
    if distance is not None and (query != BOOLEAN or hit is None):
        return f"distance {distance:.{digits}g}" if distance >= 0 else f"overlap, depth {-distance:.{digits}g}"
    if hit is None:
        return "no answer"
    return "overlap" if hit else "no contact" if query == CONTACTS else "no overlap"


def _number(value: object) -> float | None:
    try:
        return float(value) if isinstance(value, bool | int | float) else None
    except OverflowError:
        return None
