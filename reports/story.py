"""A bucket in two sentences: what the engine says and what is true; how often, and whether it is known."""

from __future__ import annotations

import math

import numpy as np

from oracles import claims
from oracles.outcome import Bucket, Finding, Kind, State, Verdict
from refimpl import Ray
from reports import text
from reports.brief import FEWEST, digits, digits_to_differ, pair_in_brief, simplest

TOLD = {
    claims.OFF_SHAPE: "names a nearest point for {pair} that lies {off} off its shape",
    claims.STUCK: "gives {pair} a normal and a depth that do not separate: B moved so far along it, {still}",
    claims.OVERSHOT: "gives {pair} a normal and a depth that move too far: B moved so far along it, {still}",
    claims.BRIEF: "gives {pair} a normal that is too short, by {amount}",
    claims.LENGTHY: "gives {pair} a normal that is too long, by {amount}",
    claims.OUTSIDE: "names a contact point for {pair} that lies {off} outside one of them",
    claims.APART: "names nearest points for {pair} that are farther apart than its distance, by {amount}",
    claims.TOGETHER: "names nearest points for {pair} that are nearer than its distance, by {amount}",
    claims.MISSED: "says that {pair} do not touch; {truth}",
    claims.FALSE: "says that {pair} touch; {truth}",
    claims.RAY_MISSED: "says that {pair} do not meet; the ray hits",
    claims.RAY_FALSE: "says that {pair} meet; the ray passes at a distance of {off}",
    claims.RAY_OFF: "stops {pair} at a point that lies {off} off the shape",
    claims.RAY_LATE: "lets the ray of {pair} go on through the surface, {off} deep",
    claims.RAY_POINT: "names a point for the hit of {pair} that lies {off} away from where its time is",
    claims.SWEEP_MISSED: "lets {pair} pass through each other; {contact}",
    claims.SWEEP_FALSE: "says that {pair} meet on their way; {contact}",
    claims.EARLY: "lets {pair} meet too early; {contact}",
    claims.LATE: "lets {pair} meet too late; {contact}",
    claims.UNTOUCHED: "lets {pair} meet where they are {off} apart",
    claims.SWEEP_POINT: "names a point for the contact of {pair} that lies {off} off one of them",
    claims.SWEEP_TILTED: "gives the contact of {pair} a normal that does not separate them",
    claims.TILTED: "gives the hit of {pair} a normal that does not point outward",
}
"""What an engine does that a symptom names; all of it is proven."""

LONG = 6
"""Digits of a time."""
LONGEST = 400
"""Characters of a foreign text in a story."""


def story(bucket: Bucket) -> str:
    """Two sentences on a bucket, harmless to read."""
    return f"{fact(bucket.witness)} {_circumstances(bucket)}"


def fact(finding: Finding) -> str:
    """One sentence: what the engine says of the scene, and what is true of it."""
    return f"{text.visible(finding.engine)} {_told(finding)}."


def _told(finding: Finding) -> str:
    pair, symptom = pair_in_brief(finding.scene.a, finding.scene.b), _symptom(finding)
    match finding.verdict.kind:
        case Kind.TIMED_OUT:
            told = f"does not answer in time for {pair}{_aside(finding)}"
        case Kind.CRASHED:
            told = f"gives no answer for {pair}{_aside(finding)}: {symptom}"
        case Kind.INCONSISTENT:
            told = f"contradicts itself on {pair}: {symptom}"
        case Kind.REFERENCE_WRONG:
            told = f"was asked about {pair}, and the reference is proven wrong: {symptom}"
        case _:
            told = _wrong(finding, pair, symptom)
    return told


def _wrong(finding: Finding, pair: str, symptom: str) -> str:
    verdict, said = finding.verdict, finding.answer.get("distance")
    if finding.scene.impact is not None:
        law = f"no velocities nearer than {digits(verdict.amount)} to its answer fulfil the law, proven"
        return f"breaks a law of impacts on {pair}: {symptom}; {law}"
    if verdict.symptom == claims.NOT_A_NUMBER:
        return f"gives {pair} an answer that is not a number"
    if verdict.symptom in TOLD:
        return f"{_by_symptom(finding, pair)}, proven"
    if isinstance(said, int | float) and math.isfinite(said) and _is_of_the_pair(finding):
        return _wrong_distance(finding, pair, float(said))
    return f"is wrong on {pair}: {symptom}{_by(verdict.amount)}"


def _wrong_distance(finding: Finding, pair: str, said: float) -> str:
    count = digits_to_differ(said, simplest(finding.verdict.lower, finding.verdict.upper))
    where = _along(finding) if said > 0 else ""
    return f"says {_distance(said, count)} for {pair}{where}; {_truth(finding, said)}, proven"


def _by_symptom(finding: Finding, pair: str) -> str:
    verdict = finding.verdict
    apart = verdict.lower if verdict.lower > 0 else verdict.upper
    still = f"they still overlap by {digits(-apart)}" if apart < 0 else f"they are {digits(apart)} apart"
    return TOLD[verdict.symptom].format(
        pair=pair,
        off=digits(abs(apart)),
        still=still,
        amount=digits(verdict.amount),
        truth=_truth(finding),
        contact=_contact(verdict),
    )


def _contact(verdict: Verdict) -> str:
    """When the two first touch, where the interval is one of the time."""
    if verdict.lower == math.inf:
        return "they do not touch"
    if verdict.upper == math.inf:
        return f"they do not touch before t = {digits(verdict.lower)}"
    return f"they first touch at t = {digits(simplest(verdict.lower, verdict.upper), LONG)}"


def _is_of_the_pair(finding: Finding) -> bool:
    """Whether the verdict's interval is that of the signed distance of the scene's own two shapes."""
    verdict = finding.verdict
    bounded = not (math.isnan(verdict.lower) or math.isnan(verdict.upper))
    own = verdict.proof_scene is None or verdict.proof_scene.id == finding.scene.id
    return bounded and own and not isinstance(finding.scene.a, Ray) and finding.scene.motion is None


def _distance(value: float, count: int) -> str:
    if value == 0:
        return "a distance of 0"
    return f"a gap of {digits(value, count)}" if value > 0 else f"a depth of {digits(-value, count)}"


def _truth(finding: Finding, said: float = math.nan) -> str:
    """What the interval proves of the pair, as against what was said."""
    lower, upper = finding.verdict.lower, finding.verdict.upper
    if lower <= 0 <= upper:
        width = max(-lower, upper)
        return f"they touch, to within {digits(width)}" if width else "they touch"
    best = simplest(lower, upper)
    if math.isinf(best):
        return "they overlap without end"
    count = digits_to_differ(said, best) if math.isfinite(said) else FEWEST
    near, far = sorted((abs(lower), abs(upper)))
    value = digits(near, count)
    if value != digits(far, count):
        value = f"between {value} and {digits(far, count)}"
    if said * best > 0:
        return f"it is {value}"
    return f"they are {value} apart" if best > 0 else f"they overlap by {value}"


def _along(finding: Finding) -> str:
    """How far apart the two are along an axis, where they are."""
    normal, lower = finding.reference.get("normal"), finding.verdict.lower
    if not (lower > 0 and isinstance(normal, list | tuple | np.ndarray)):
        return ""
    numbers = [abs(float(x)) for x in normal]
    if sorted(numbers) != [0.0, 0.0, 1.0] or digits(lower) != digits(finding.verdict.upper):
        return ""
    return f" {digits(lower)} apart along {'xyz'[numbers.index(1.0)]}"


def _aside(finding: Finding) -> str:
    """What is true of the two, beside an answer that never came."""
    return f", which {_truth(finding).removeprefix('they ')}" if _is_of_the_pair(finding) else ""


def _symptom(finding: Finding) -> str:
    return text.visible(finding.verdict.symptom or "no answer", limit=LONGEST)


def _by(amount: float) -> str:
    return f", by at least {digits(amount)}, proven" if 0 < amount < math.inf else ""


def _circumstances(bucket: Bucket) -> str:
    """How often it was seen, and what the ledger makes of it."""
    often = f"Seen {text.plural(bucket.count, 'time')} in this run"
    if bucket.state is State.NEW:
        return f"{often}; no entry of the ledger explains it: it is new."
    known = f"known as {text.visible(bucket.entry or '')}"
    return f"{often}; {known}{', which has changed' if bucket.state is State.CHANGED else ''}."
