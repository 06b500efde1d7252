"""The law of impacts, solved in exact numbers one impact at a time.

Part of what has to be believed; needs nothing but the standard library.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from refimpl.proof.vectors import Exact, cross, dot, minus, root

Interval: TypeAlias = tuple[Fraction, Fraction]
Rows: TypeAlias = Sequence[Exact]
Velocities: TypeAlias = tuple[Exact, Exact, Exact, Exact]  # v_a, ω_a, v_b, ω_b


class Body(NamedTuple):
    """A body: where the impact's point is, seen from its centre of mass, its velocities and inverse mass."""

    arm: Exact
    velocity: Exact
    spin: Exact
    w: Fraction
    inertia: Rows


class Question(NamedTuple):
    """An impact: the bodies, the normal from A to B, restitution and friction."""

    a: Body
    b: Body
    n: Exact
    e: Fraction
    mu: Fraction


def relative(question: Question, velocities: Velocities) -> list[Fraction]:
    """Velocity of B minus that of A at the point."""
    va, spin_a, vb, spin_b = velocities
    at_a = [x + y for x, y in zip(va, cross(spin_a, question.a.arm), strict=True)]
    at_b = [x + y for x, y in zip(vb, cross(spin_b, question.b.arm), strict=True)]
    return minus(at_b, at_a)


def solution(question: Question) -> tuple[Velocities, Velocities]:
    """Enclose the velocities after the impact, by the law of Chatterjee and Ruina (1998)."""
    a, b, n, e, mu = question
    before: Velocities = (a.velocity, a.spin, b.velocity, b.spin)
    u = relative(question, before)
    if dot(n, u) >= 0 or not a.w + b.w:
        return before, before
    give = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(_giving(a), _giving(b), strict=True)]
    share = -dot(n, u) / dot(n, times(give, n))
    stop = [share * x for x in n]
    axis = [(1 + e) * x for x in stop]
    toward = minus([-x for x in times(_inverse(give), u)], stop)
    ends = [
        _after(question, [p + kappa * q for p, q in zip(axis, toward, strict=True)])
        for kappa in _share_in_cone(n, axis, toward, mu)
    ]
    return _each(min, *ends), _each(max, *ends)


def _each(pick: Callable[[Fraction, Fraction], Fraction], u: Velocities, v: Velocities) -> Velocities:
    """Pick one of the two, for each coordinate."""
    va, spin_a, vb, spin_b = ([pick(x, y) for x, y in zip(*pair, strict=True)] for pair in zip(u, v, strict=True))
    return va, spin_a, vb, spin_b


def _share_in_cone(n: Exact, axis: Exact, toward: Exact, mu: Fraction) -> Interval:
    """Enclose the largest κ from 0 to 1 with axis + κ toward in the friction cone: |n × κ t| ≤ μ n·(axis + κ t)."""
    aside = cross(n, toward)
    low, high = root(dot(aside, aside))
    normal, gain = mu * dot(n, axis), mu * dot(n, toward)
    if normal + gain >= 0 and dot(aside, aside) <= (normal + gain) ** 2:
        return Fraction(1), Fraction(1)
    # here root − gain > normal ≥ 0; an enclosure of the root so wide that its low end hides that is cut off at κ = 1
    upper = normal / (low - gain) if low - gain > normal else Fraction(1)
    return normal / (high - gain), upper


def _after(question: Question, impulse: Exact) -> Velocities:
    a, b = question.a, question.b
    back = [-p for p in impulse]
    return *_pushed(a, back), *_pushed(b, impulse)


def _pushed(body: Body, impulse: Exact) -> tuple[Exact, Exact]:
    velocity = [x + body.w * p for x, p in zip(body.velocity, impulse, strict=True)]
    return velocity, [x + y for x, y in zip(body.spin, _turn(body, impulse), strict=True)]


def _turn(body: Body, impulse: Exact) -> list[Fraction]:
    """Change of angular velocity by an impulse at the point."""
    return times(_inverse(body.inertia), cross(body.arm, impulse)) if body.w else [Fraction(0)] * 3


def _giving(body: Body) -> list[list[Fraction]]:
    """Matrix from an impulse at the point to the change of velocity there; symmetric, so that rows are columns."""
    rows = []
    for axis in range(3):
        unit = [Fraction(int(axis == i)) for i in range(3)]
        rows.append([body.w * x + y for x, y in zip(unit, cross(_turn(body, unit), body.arm), strict=True)])
    return rows


def times(matrix: Rows, v: Exact) -> list[Fraction]:
    """Matrix times vector."""
    return [dot(row, v) for row in matrix]


def determinant(m: Rows) -> Fraction:
    """Determinant of a 3 × 3 matrix."""
    value: Fraction = dot(m[0], cross(m[1], m[2]))
    return value


def _inverse(m: Rows) -> list[list[Fraction]]:
    """Of a symmetric matrix, by Cramer's rule."""
    volume = determinant(m)
    return [[x / volume for x in cross(m[i - 2], m[i - 1])] for i in range(3)]
