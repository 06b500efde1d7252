"""The reference itself under judgement: its answer must lie in its own proven interval."""

from __future__ import annotations

import math

import numpy as np

from oracles.answers import reference_answers
from oracles.claims import Questioned
from oracles.course import Course
from oracles.outcome import Kind, Severity, Verdict
from oracles.reference import SEARCH_ERROR, allows, error_of, proven
from oracles.scene import DISTANCE, RAYCAST, Scene
from oracles.sweep_claims import SweptRows
from oracles.sweep_reference import error_of_time, proven_sweep, stands, sweep_answers
from oracles.world import world_of
from refimpl import Proxy, Ray, distance, raycast
from refimpl.proof import InvalidCertificate
from refimpl.proof.certify import round_down, round_up

REFUSED, OUTSIDE = "certificate refused", "reference outside its proof"


def audit_of(scene: Scene) -> Verdict:
    """Try the reference itself on a scene at rest, or on a sweep."""
    return audit(scene.a, scene.b) if scene.course is None else _audit_sweep(scene, scene.course)


def _audit_sweep(scene: Scene, course: Course) -> Verdict:
    """The reference's time must lie in its own proven interval, and its point and normal must fit the shapes then."""
    try:
        certificate, (lower, upper) = proven_sweep(scene.a, scene.b, course)
    except InvalidCertificate as refused:
        return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=scene)
    a, b, moving, zero = scene.a[None], scene.b[None], course[None], np.zeros(1)
    answers, error = world_of(b).cut(sweep_answers(a, b, moving)), float(error_of_time(course))
    value = float(answers.t[0])
    rows = SweptRows(scene.query, a, b, zero, zero, answers, np.ones(1, dtype=bool), course=moving)
    known_to = error * float(course.way(scene.a, scene.b)) + error_of(scene.a, scene.b) * scene.size
    broken = "" if stands(value, (lower, upper), scene.a, scene.b, course) else OUTSIDE
    broken = broken or _broken(rows, known_to)
    bounds = round_down(lower), round_up(upper)
    if not broken:
        return Verdict(Kind.AGREES, lower=bounds[0], upper=bounds[1], certificate=certificate)
    text = f"refimpl says {value!r}, proven is [{float(lower)!r}, {float(upper)!r}]: {broken}"
    return Verdict(Kind.REFERENCE_WRONG, broken, Severity.GROSS, math.inf, *bounds, text, certificate, scene)


def audit(a: Proxy, b: Proxy) -> Verdict:
    """Try the reference itself on one scene: its answer must lie in its own proven interval.

    Its normal and witnesses, and the time of a ray's hit, are tried by the claims that they make in space, as an
    engine's would be: near grazing, rounding moves the time by much more than the point from the surface.
    """
    query = RAYCAST if isinstance(a, Ray) else DISTANCE
    scene = Scene(query, a, b, "audit")
    try:
        certificate, (lower, upper) = proven(a, b)
    except InvalidCertificate as refused:
        return Verdict(Kind.REFERENCE_WRONG, REFUSED, Severity.GROSS, claim=str(refused), proof_scene=scene)
    if isinstance(a, Ray):
        value = float(raycast(a, b).t)
        fits = True
    else:
        value = float(distance(a, b).distance)
        fits = allows(lower, upper, value, error_of(a, b) * max(scene.size, abs(value)))
    broken = "" if fits else OUTSIDE
    broken = broken or _broken_claim(scene)
    if not broken:
        return Verdict(Kind.AGREES, lower=round_down(lower), upper=round_up(upper), certificate=certificate)
    text = f"refimpl says {value!r}, proven is [{float(lower)!r}, {float(upper)!r}]: {broken}"
    bounds = round_down(lower), round_up(upper)
    return Verdict(Kind.REFERENCE_WRONG, broken, Severity.GROSS, math.inf, *bounds, text, certificate, scene)


def _broken_claim(scene: Scene) -> str:
    """Symptom of a claim that the reference's normal, witnesses or hit point break; empty when all hold."""
    a, b = scene.a[None], scene.b[None]
    answers = world_of(b).cut(reference_answers(scene.query, a, b))
    rows = Questioned(scene.query, a, b, np.zeros(1), np.zeros(1), answers, np.ones(1, dtype=bool), ways_out=True)
    known_to = SEARCH_ERROR if rows.of_union and answers.distance[0] < 0 else error_of(a, b)  # ways out are searched
    return _broken(rows, known_to * scene.size)


def _broken(rows: Questioned, known_to: float) -> str:
    """Symptom of a claim that is broken by more than the reference may err by; empty when all hold."""
    for claim in rows.claims():
        below, above, error = claim.violations()
        allowed = 4 * max(float(error[0]), known_to)
        for excess, symptom in ((below, claim.below), (above, claim.above)):
            if excess[0] > allowed:
                return symptom
    return ""
