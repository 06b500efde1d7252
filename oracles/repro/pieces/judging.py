"""The verdict on an answer, by what has been proven."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from oracles.repro.pieces.checking import read
from oracles.repro.pieces.exact import length, minus, number, vector

Error = tuple[str, Any, float]
"""What is wrong, by how much at least, and how much the engine is allowed."""


def of_value(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of a hit and of a distance, by what is proven of the signed distance."""
    lower, upper = (bound - number(side["truth"]["margin"]) for bound in side["truth"]["exact"])
    hit, distance = answer.get("hit"), answer.get("distance")
    if "hit" in held and hit is not None:
        yield ("false contact", lower, held["hit"]) if hit else ("missed contact", -upper, held["hit"])
    if "distance" in held and hit != 0:
        if distance is None:
            yield "not a number", math.inf, 0.0
        elif distance == -math.inf and held.get("no depth"):
            yield "distance too small", lower, held["distance"]
        else:
            yield "distance too small", lower - distance_of(distance), held["distance"]
            yield "distance too large", distance_of(distance) - upper, held["distance"]


def distance_of(value: float) -> Any:
    """A distance as it is answered, exactly."""
    return number(value) if math.isfinite(value) else value


def of_time(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of a ray's hit, in lengths, by what is proven of the time when it first hits."""
    if side["truth"] is None:
        return
    lower, upper = side["truth"]["exact"]
    hit, t, speed = answer.get("hit"), answer.get("t", math.inf), held["speed"]
    if hit is None or (hit and not 0 <= t < math.inf):
        yield "not a number", math.inf, 0.0
    elif hit:
        yield "ray hits a shape that it misses", math.inf if lower == math.inf else 0, held["t"]
        yield "ray hit off the shape", (lower - number(t)) * number(speed) if lower < math.inf else 0, held["t"]
        yield "ray hit behind the surface", (number(t) - upper) * number(speed), held["t"]
    else:
        yield "ray misses a hit", math.inf if upper < math.inf else 0, held["t"]


def of_claim(_: Any, side: Any, __: Any) -> Iterator[Error]:
    """Error of a claim low ≤ σ(x, y) − margin ≤ high, which the recorded answer makes."""
    proof = side["claim"]
    lower, upper = proof["exact"]
    low, high = proof["low"], proof["high"]
    under = number(low) - (upper - number(proof["margin"])) if math.isfinite(low) else -math.inf
    over = lower - number(proof["margin"]) - number(high) if math.isfinite(high) else -math.inf
    excess = min(max(under, over), distance_of(proof["cap"]))
    yield proof["symptom"], excess - number(proof["rounding"]), proof["allowed"]


def of_numbers(answer: Any, _: Any, held: Any) -> Iterator[Error]:
    """Errors of what is no number, or one that no scene can have, or is not there though there is a hit."""
    if answer.get("distance") == -math.inf:  # has neither witnesses nor a normal
        return
    owed = held["owed"] if answer.get("hit") != 0 else ["hit"]
    for name, value in {**dict.fromkeys(owed, math.nan), **answer}.items():
        endless = name in ("t", "distance") and math.isinf(value)
        inside = name == "normal" and answer.get("t") == 0
        numbers = value if isinstance(value, list) else [value]
        if not endless and not inside and not all(abs(x) < 1e150 for x in numbers):
            yield "not a number", math.inf, 0.0


def of_seconds(answer: Any, _: Any, held: Any) -> Iterator[Error]:
    """Error of an answer that comes late."""
    yield "no answer in time", number(answer.get("seconds", 0.0)) - number(held["seconds"]), 0.0


def of_points(answer: Any, side: Any, held: Any) -> Iterator[Error]:
    """Errors of witnesses, contact point and normal, as far as they can be told without a search."""
    distance, allowed = answer.get("distance"), held["witness"]
    if distance is None or not math.isfinite(distance):
        return
    shapes = [(side["truth"][name], margin) for name, margin in zip("xy", side["margins"], strict=True)]
    for name, shape, margin in (("on_a", *shapes[0]), ("on_b", *shapes[1])):
        if name in answer and shape["type"] not in ("Composite", "Polyhedron"):
            yield "witness off its shape", read(shape).outside(vector(answer[name])) - number(margin), allowed
    if "on_a" in answer and "on_b" in answer:
        low, high = length(minus(vector(answer["on_a"]), vector(answer["on_b"])))
        yield "witnesses farther apart than the distance", low - abs(number(distance)), allowed
        yield "witnesses nearer than the distance", abs(number(distance)) - high, allowed
    for shape, margin in shapes if "point" in answer else ():
        if shape["type"] not in ("Composite", "Polyhedron"):
            beyond = read(shape).outside(vector(answer["point"])) - number(margin) - max(0, -number(distance))
            yield "contact point farther from a shape than the depth", beyond, allowed
    if "normal" in answer:
        low, high = length(vector(answer["normal"]))
        yield "normal shorter than 1", 1 - high, 1e-6
        yield "normal longer than 1", low - 1, 1e-6


TRIALS: dict[str, Any] = {
    "numbers": of_numbers,
    "seconds": of_seconds,
    "claim": of_claim,
    "value": of_value,
    "time": of_time,
    "points": of_points,
}
