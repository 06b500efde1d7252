"""Certificates of impacts: how far given velocities are from the laws of an impact, in exact numbers.

Part of what has to be believed: standard library only. A certificate holds two bodies before an impact, their
velocities after it as somebody gave them, and the residuals of the laws. `check_impact` computes the residuals again,
refuses a certificate that states others, and encloses the error of the velocities, as the laws leave only one answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Any, TypeAlias

from refimpl.proof.impact_law import Body, Interval, Question, Rows, Velocities, determinant, relative, solution, times
from refimpl.proof.rational import InvalidCertificate, items, rational
from refimpl.proof.rational import vector as read_vector
from refimpl.proof.vectors import Exact, Number, Vector, cross, dot, minus

Matrix: TypeAlias = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class MovingBody:
    """A rigid body: see `refimpl.impacts.RigidBody`. Of an immovable body (inverse mass 0) the inertia is ignored."""

    position: Vector
    velocity: Vector
    angular_velocity: Vector
    inverse_mass: Number
    inertia: Matrix | None = None


@dataclass(frozen=True)
class Impact:
    """An impact at a point, with a normal from A to B of any length: see `refimpl.impacts.impact_of_bodies`."""

    a: MovingBody
    b: MovingBody
    point: Vector
    normal: Vector
    restitution: Number
    friction: Number = 0


@dataclass(frozen=True)
class Outcome:
    """Velocities after an impact."""

    velocity_a: Vector
    angular_velocity_a: Vector
    velocity_b: Vector
    angular_velocity_b: Vector


@dataclass(frozen=True)
class Residuals:
    """What is left over of each law: 0 where it holds, but for the last three.

    With Δ for after − before, w for inverse mass, r for the point seen from a centre of mass, u for the velocity of B
    minus that of A at the point, and P = (Δv_b − Δv_a) / (w_a + w_b), the impulse of which the velocities speak:

    Attributes
    ----------
    linear_a, linear_b
        Δv_a + w_a P and Δv_b − w_b P: momentum is kept, and immovable bodies go on as before.
    angular_a, angular_b
        I Δω minus the moment of P (A: −P) about the centre of mass: the impulse acted at the point, and angular
        momentum about any point is kept. Of an immovable body: Δω.
    restitution
        n·u′ + e n·u; of bodies that ought to keep their velocities, as they do not approach or are both immovable:
        n·u′ − n·u.
    pressure
        n·P, not negative where the bodies push each other.
    cone
        μ² (n·P)² − |n × P|², not negative inside the friction cone.
    energy
        Gain of kinetic energy; what an immovable body gives or takes by its motion is not counted.
    """

    linear_a: Vector
    linear_b: Vector
    angular_a: Vector
    angular_b: Vector
    restitution: Number
    pressure: Number
    cone: Number
    energy: Number


@dataclass(frozen=True)
class ImpactCertificate:
    """An impact, the velocities that somebody gave for it, and how far they are from each law."""

    impact: Impact
    outcome: Outcome
    residuals: Residuals


@dataclass(frozen=True)
class ProvenImpact:
    """What follows from a certificate.

    Attributes
    ----------
    residuals
        As stated, and found true.
    lower, upper
        Enclose the velocities that the laws leave: equal but where bodies slip, which takes a root.
    errors
        Enclose, for each of the four velocities, how far its worst coordinate is from the law.
    """

    residuals: Residuals
    lower: Outcome
    upper: Outcome
    errors: tuple[Interval, Interval, Interval, Interval]


def certify_impact(impact: Impact, outcome: Outcome) -> ImpactCertificate:
    """Make a certificate: compute the residuals.

    Raises
    ------
    InvalidCertificate
        Where the numbers mean no impact: the text names the field.
    """
    return ImpactCertificate(impact, outcome, _residuals(_read(impact), _read_outcome(outcome)))


def check_impact(certificate: ImpactCertificate) -> ProvenImpact:
    """Verify a certificate.

    Raises
    ------
    InvalidCertificate
        If it is malformed, or a residual is not what it states.
    """
    for part, kind in (("impact", Impact), ("outcome", Outcome), ("residuals", Residuals)):
        if type(getattr(certificate, part, None)) is not kind:
            raise InvalidCertificate(f"{part}: expected {kind.__name__}")
    question, outcome = _read(certificate.impact), _read_outcome(certificate.outcome)
    found = _residuals(question, outcome)
    for field in fields(Residuals):
        true, stated = getattr(found, field.name), getattr(certificate.residuals, field.name)
        same = tuple(read_vector(stated, field.name)) if isinstance(true, tuple) else rational(stated, field.name)
        if same != true:
            raise InvalidCertificate(f"{field.name}: the residual is not what is stated")
    lower, upper = solution(question)
    errors = [_error(*ends) for ends in zip(lower, upper, outcome, strict=True)]
    return ProvenImpact(found, _outcome(lower), _outcome(upper), (errors[0], errors[1], errors[2], errors[3]))


# ---- reading -----------------------------------------------------------------------------------------------------


def _read(impact: Impact) -> Question:
    if type(impact) is not Impact:
        raise InvalidCertificate("impact: expected Impact")
    point = read_vector(impact.point, "point")
    n = read_vector(impact.normal, "normal")
    e, mu = rational(impact.restitution, "restitution"), rational(impact.friction, "friction")
    if not any(n):
        raise InvalidCertificate("normal: must not be zero")
    if not 0 <= e <= 1:
        raise InvalidCertificate("restitution: must be from 0 to 1")
    if mu < 0:
        raise InvalidCertificate("friction: must be at least 0")
    return Question(_read_body(impact.a, point, "a"), _read_body(impact.b, point, "b"), n, e, mu)


def _read_body(body: MovingBody, point: Exact, name: str) -> Body:
    if type(body) is not MovingBody:
        raise InvalidCertificate(f"{name}: expected MovingBody")
    w = rational(body.inverse_mass, f"{name}.inverse_mass")
    if w < 0:
        raise InvalidCertificate(f"{name}.inverse_mass: must be at least 0")
    inertia: Rows = []
    if w:
        inertia = [read_vector(row, f"{name}.inertia") for row in items(body.inertia, f"{name}.inertia", 3)]
        if any(inertia[i][j] != inertia[j][i] for i in range(3) for j in range(i)):
            raise InvalidCertificate(f"{name}.inertia: must be symmetric")
        (xx, xy, _), (_, yy, _), _ = inertia
        if not (xx > 0 and xx * yy > xy * xy and determinant(inertia) > 0):
            raise InvalidCertificate(f"{name}.inertia: must be positive definite")
    position, velocity, spin = (
        read_vector(getattr(body, field), f"{name}.{field}") for field in ("position", "velocity", "angular_velocity")
    )
    return Body(minus(point, position), velocity, spin, w, inertia)


def _read_outcome(outcome: Outcome) -> Velocities:
    if type(outcome) is not Outcome:
        raise InvalidCertificate("outcome: expected Outcome")
    va, spin_a, vb, spin_b = (read_vector(getattr(outcome, f.name), f.name) for f in fields(Outcome))
    return va, spin_a, vb, spin_b


# ---- the laws ----------------------------------------------------------------------------------------------------


def _residuals(question: Question, outcome: Velocities) -> Residuals:
    a, b, n, e, mu = question
    va, spin_a, vb, spin_b = outcome
    before = relative(question, (a.velocity, a.spin, b.velocity, b.spin))
    after = relative(question, outcome)
    change_a, change_b = minus(va, a.velocity), minus(vb, b.velocity)
    total = a.w + b.w
    impulse = [x / total if total else x * 0 for x in minus(change_b, change_a)]
    opposite = [-x for x in impulse]
    approach = dot(n, before)
    aside = cross(n, impulse)
    return Residuals(
        _tuple([x + a.w * p for x, p in zip(change_a, impulse, strict=True)]),
        _tuple([x - b.w * p for x, p in zip(change_b, impulse, strict=True)]),
        _turning(a, minus(spin_a, a.spin), opposite),
        _turning(b, minus(spin_b, b.spin), impulse),
        dot(n, after) + (e * approach if approach < 0 < total else -approach),
        dot(n, impulse),
        mu * mu * dot(n, impulse) ** 2 - dot(aside, aside),
        _gain(a, va, spin_a, opposite) + _gain(b, vb, spin_b, impulse),
    )


def _turning(body: Body, change: Exact, impulse: Exact) -> Vector:
    if not body.w:
        return _tuple(change)
    return _tuple(minus(times(body.inertia, change), cross(body.arm, impulse)))


def _gain(body: Body, velocity: Exact, spin: Exact, impulse: Exact) -> Fraction:
    """Gain of kinetic energy; of an immovable body, the work that is done on it."""
    work: Fraction
    if not body.w:
        moving = [x + y for x, y in zip(body.velocity, cross(body.spin, body.arm), strict=True)]
        work = dot(impulse, moving)
        return work
    work = (dot(velocity, velocity) - dot(body.velocity, body.velocity)) / (2 * body.w)
    turning: Fraction = dot(spin, times(body.inertia, spin)) - dot(body.spin, times(body.inertia, body.spin))
    return work + turning / 2


def _error(lower: Exact, upper: Exact, given: Exact) -> Interval:
    least = max(max(low - x, x - high, Fraction(0)) for low, high, x in zip(lower, upper, given, strict=True))
    most = max(max(high - x, x - low) for low, high, x in zip(lower, upper, given, strict=True))
    return least, most


def _tuple(v: Sequence[Any]) -> Vector:
    x, y, z = v
    return x, y, z


def _outcome(velocities: Velocities) -> Outcome:
    return Outcome(*(_tuple(v) for v in velocities))
