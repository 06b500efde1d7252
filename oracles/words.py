"""The judge's sentences, and how grave a symptom is."""

from __future__ import annotations

import math

from oracles import claims
from oracles.engine import Answers
from oracles.outcome import Severity
from oracles.scene import BOOLEAN, CONTACTS, RAYCAST, SWEEP

_OF_THE_RAY = "the ray's signed distance from the shape is proven to be {}"
_AFTER_THE_MOVE = "once B is moved along its normal by its depth or gap, the signed distance is proven to be {}, not 0"
_FIRST = "the first time at which the two touch is proven to be {}"
_OF_THE_WITNESSES = "its two witnesses are proven to be apart by its distance plus {}"

TRUTHS = {
    claims.STUCK: _AFTER_THE_MOVE,
    claims.OVERSHOT: _AFTER_THE_MOVE,
    claims.OFF_SHAPE: "its witness is proven to lie {} away from its shape",
    claims.RAY_POINT: "the point it names is proven to lie {} away from the point at its time",
    claims.BRIEF: "its normal's length is proven to be 1 plus {}",
    claims.LENGTHY: "its normal's length is proven to be 1 plus {}",
    claims.OUTSIDE: "its contact point is proven to lie {} away from one of the shapes",
    claims.APART: _OF_THE_WITNESSES,
    claims.TOGETHER: _OF_THE_WITNESSES,
    claims.RAY_MISSED: _OF_THE_RAY,
    claims.RAY_FALSE: _OF_THE_RAY,
    claims.RAY_OFF: "the point at that time is proven to lie {} away from the shape",
    claims.RAY_LATE: "the way to that point is proven to cross the shape, with a signed distance of {}",
    claims.SWEEP_MISSED: _FIRST,
    claims.SWEEP_FALSE: _FIRST,
    claims.EARLY: f"{_FIRST}; that error of the time counts as the way, or the gap, that is left",
    claims.LATE: f"{_FIRST}; that error of the time counts as the way since then, or the depth",
    claims.UNTOUCHED: "where the two are at that time, their signed distance is proven to be {}",
    claims.SWEEP_POINT: "its point is proven to lie {} away from one of the shapes, where that is then",
    claims.SWEEP_TILTED: "the space beyond its point and normal is proven to overlap a shape, "
    "with a signed distance of {}",
    claims.TILTED: "the space in front of its normal is proven to overlap the shape, with a signed distance of {}",
}
"""What a certificate proves, symptom by symptom, where it is not the signed distance of the pair itself."""


AT_ITS_TIME = "where the two are at that time, their signed distance is proven to be {}"
BEFORE_ITS_TIME = "where the two are at a time before that, their signed distance is proven to be {}"
TRUTHS_OF_SWEEPS = {
    claims.SWEEP_FALSE: AT_ITS_TIME,
    claims.EARLY: AT_ITS_TIME,
    claims.LATE: BEFORE_ITS_TIME,
    claims.SWEEP_MISSED: "where the two are at a time from 0 to 1, their signed distance is proven to be {}",
}
"""The same where a sweep is refuted by the shapes as they are at one time."""


def said_of(query: str, answers: Answers) -> str:
    """What the engine said of one scene, in full precision."""
    if query == BOOLEAN:
        return "overlap" if answers.hit[0] == 1 else "no overlap" if answers.hit[0] == 0 else "neither yes nor no"
    if query in (RAYCAST, SWEEP):
        return f"a hit at t = {float(answers.t[0])!r}" if answers.hit[0] == 1 else "no hit"
    if query == CONTACTS and answers.hit[0] == 0:
        return "no contact"
    return f"a signed distance of {float(answers.distance[0])!r}"


def conviction(engine: str, said: str, symptom: str, bounds: tuple[float, float], amount: float) -> str:
    """One sentence: what the engine said, and what is true."""
    lower, upper = bounds
    value = f"{lower!r}" if lower == upper else f"between {lower!r} and {upper!r}"
    truth = TRUTHS.get(symptom, "the signed distance is proven to be {}").format(value)
    return f"{engine} answers {said}: {symptom}; {truth}. It is wrong by at least {amount:.3g}."


def severity_of(symptom: str, amount: float, size: float) -> Severity:
    """How wrong: a wrong boolean is the worst, then by the amount against the scene's size."""
    if symptom in claims.WRONG_BOOLEANS:
        return Severity.BOOLEAN
    ratio = amount / size if size > 0 else math.inf
    if ratio > 0.1:
        return Severity.GROSS
    return Severity.LARGE if ratio > 1e-3 else Severity.SMALL


EDGE = 1e-3
"""Errors that are a power of ten but for rounding are taken for it: many are, of scenes of size 1."""


def decade_of(amount: float, size: float) -> int | None:
    """Decade of an error relative to the scene's size, at most 0; None where it has no amount."""
    if not (0 < amount < math.inf and size > 0) or math.isinf(amount / size):
        return None
    return min(0, math.floor(math.log10(amount / size) + EDGE))
