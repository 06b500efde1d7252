"""The laws of an impact, put to velocities in exact numbers.

The impulse is read off the velocities. Each breach is given as a velocity: no velocities that are nearer than this to
those answered (in any coordinate, of a spin at the distance of the contact) can fulfil the law.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from oracles.repro.pieces.exact import Vector, along, cross, dot, minus, number, times, vector


def total(v: Vector) -> Any:
    """Sum of the absolute coordinates: at least the length, at most its double."""
    return abs(v[0]) + abs(v[1]) + abs(v[2])


def most(v: Vector) -> Any:
    """Largest absolute coordinate."""
    return max(abs(v[0]), abs(v[1]), abs(v[2]))


def ratio(above: Any, below: Any) -> Any:
    """Quotient; 0 where the divisor is 0."""
    return above / below if below else 0 * above


class Change:
    """What became of one body."""

    def __init__(self, body: Any, velocity: Any, spin: Any, point: Vector) -> None:
        self.before, self.spin_before = vector(body["velocity"]), vector(body["angular_velocity"])
        self.after, self.spin = vector(velocity), vector(spin)
        self.w, self.inertia = number(body["inverse_mass"]), [vector(row) for row in body["inertia"]]
        self.lever = minus(point, vector(body["position"]))
        self.dv, self.dw = minus(self.after, self.before), minus(self.spin, self.spin_before)

    @property
    def moved(self) -> Any:
        """Largest change of any velocity."""
        return max(most(self.dv), most(self.dw) * total(self.lever))

    def at_contact(self, velocity: Vector, spin: Vector) -> list[Any]:
        """Velocity of the point of contact; an immovable body keeps its own."""
        if not self.w:
            velocity, spin = self.before, self.spin_before
        return along(velocity, 1, cross(spin, self.lever))

    def against(self, direction: Vector) -> Any:
        """By how much the contact's velocity along a direction grows, at most, when all velocities change by 1."""
        if not self.w:
            return 0 * self.w
        return total(direction) + ratio(total(cross(self.lever, direction)), total(self.lever))

    def angular(self) -> Any:
        """Breach of I Δω = r × m Δv."""
        reach, found = total(self.lever), [0 * self.w]
        turned = cross(self.lever, self.dv)
        for row, lever, turn in zip(self.inertia, self.lever, turned, strict=True) if self.w else ():
            weight = ratio(1, reach) * self.w * total(row) + reach - abs(lever)
            found.append(ratio(abs(self.w * dot(row, self.dw) - turn), weight))
        return max(found)

    def energy(self) -> tuple[Any, Any]:
        """Energy gained, and by how much, at most, it falls when all velocities change by 1."""
        if not self.w:
            return 0 * self.w, 0 * self.w
        momentum, old = ([dot(row, spin) for row in self.inertia] for spin in (self.spin, self.spin_before))
        moving = (dot(self.after, self.after) - dot(self.before, self.before)) / self.w
        turning = dot(self.spin, momentum) - dot(self.spin_before, old)
        return (moving + turning) / 2, total(self.after) / self.w + ratio(total(momentum), total(self.lever))

    def pushed(self, impulse: Vector) -> list[Any]:
        """Change of the contact's velocity by an impulse there."""
        x, y, z = self.inertia
        turn, volume = cross(self.lever, impulse), dot(x, cross(y, z))
        found = times(self.w, impulse)
        if self.w and volume:
            spin = [dot(turn, cross(y, z)), dot(x, cross(turn, z)), dot(x, cross(y, turn))]
            found = along(found, 1 / volume, cross(spin, self.lever))
        return found


def breaches(motion: Any, answer: Any) -> Iterator[tuple[str, Any]]:
    """Every law of an impact that applies, and by how much velocities break it."""
    point, n = vector(motion["point"]), vector(motion["normal"])
    e, mu = number(motion["restitution"]), number(motion["friction"])
    a = Change(motion["a"], answer["velocity_a"], answer["angular_a"], point)
    b = Change(motion["b"], answer["velocity_b"], answer["angular_b"], point)
    before = [along(c.before, 1, cross(c.spin_before, c.lever)) for c in (a, b)]
    closing = dot(minus(before[1], before[0]), n)
    if closing >= 0 or not (a.w or b.w):
        yield "velocities of bodies that part are changed", max(a.moved, b.moved)
        return
    give = a.against(n) + b.against(n)
    if not (a.moved or b.moved):
        yield "impact missed: no velocity changes", ratio(-(1 + e) * closing, give)
    if not (a.w and b.w):
        yield "immovable body is moved", max(c.moved for c in (a, b) if not c.w)
    impulse = b.dv if b.w >= a.w else times(-1, a.dv)  # by the mass of the lighter body
    yield "the bodies pull at each other", ratio(-dot(impulse, n), total(n))
    if a.w and b.w:
        yield "momentum is not kept", most(along(times(b.w, a.dv), a.w, b.dv)) / (a.w + b.w)
    yield "angular momentum about the contact is not kept", max(a.angular(), b.angular())
    apart = minus(b.at_contact(b.after, b.spin), a.at_contact(a.after, a.spin))
    leaving = dot(apart, n) + e * closing
    yield "bounces faster than its restitution", ratio(leaving, give)
    yield "bounces slower than its restitution", ratio(-leaving, give)
    yield from breaches_of_friction(a, b, n, e, mu, impulse, apart, closing)


def breaches_of_friction(
    a: Change, b: Change, n: Vector, e: Any, mu: Any, impulse: Vector, apart: Vector, closing: Any
) -> Iterator[tuple[str, Any]]:
    """The impulse lies in the cone, gains no energy, and leaves no sliding that it could have stopped."""
    square = dot(n, n)
    aside = along(impulse, -dot(impulse, n) / square, n)
    bound = mu * max(dot(impulse, n), 0)
    room = ratio(bound * bound / square - dot(aside, aside), total(aside) + bound / most(n))
    yield "impulse outside the friction cone", -room / (2 * (1 + mu))
    if all(c.w or not (any(c.before) or any(c.spin_before)) for c in (a, b)):
        (gain_a, slope_a), (gain_b, slope_b) = a.energy(), b.energy()
        yield "energy is gained", ratio(gain_a + gain_b, slope_a + slope_b)
    if mu:
        left = along(apart, -dot(apart, n) / square, n)
        bounce = along(a.pushed(n), 1, b.pushed(n))
        share = ratio(-closing, dot(bounce, n)) * e
        caused = times(share, bounce)
        other = minus(left, along(caused, -dot(caused, n) / square, n))
        sliding = min(most(left), most(other)) / 8
        yield "sliding is not stopped although friction could", min(max(room, 0) / (2 * (1 + mu)), sliding)
