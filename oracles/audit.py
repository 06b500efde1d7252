"""The reference itself under judgement: its answer must lie in its own proven interval."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from oracles.answers import reference_answers
from oracles.claims import REFERENCE_ERROR, Questioned
from oracles.outcome import Kind, Severity, Verdict
from oracles.scene import DISTANCE, RAYCAST, Scene
from refimpl import Proxy, Ray, distance, raycast
from refimpl.proof import InvalidCertificate, certify, check
from refimpl.proof.certify import round_down, round_up
from refimpl.proof.checker import Bound

REFUSED, OUTSIDE = "certificate refused", "reference outside its proof"


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


def allows(lower: Bound, upper: Bound, value: float, size: float) -> bool:
    """Whether `value` lies in the proven interval, but for the rounding that the reference is allowed."""
    if math.isinf(value):
        return value == lower == upper or (value < 0 and lower == value)
    slack = Fraction(REFERENCE_ERROR * max(size, abs(value)))
    return lower - slack <= Fraction(value) <= upper + slack
