"""The laws of an impact as statements about an answer: by how much each is broken.

An answer is never compared with ours. The impulse is read off the velocities, P = m Δv, and the laws are put to it:
momentum, angular momentum of each body about the point of contact, restitution, Coulomb's cone, energy. Each
violation is given as a velocity: the least change of the answer's velocities (of any of their coordinates, of a spin
at the distance of the contact) that could fulfil the law. Only + − × ÷ and comparisons occur, so the same lines
screen batches of floats and convict with Fractions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from oracles.motion import Motion, Moving
from refimpl.linear import Array, Bools, apply, cross, dot, scale

MISSED = "impact missed: no velocity changes"
DISTURBED = "velocities of bodies that part are changed"
FIXED = "immovable body is moved"
PULLED = "the bodies pull at each other"
MOMENTUM = "momentum is not kept"
ANGULAR = "angular momentum about the contact is not kept"
FAST, SLOW = "bounces faster than its restitution", "bounces slower than its restitution"
SLIPPERY = "sliding is not stopped although friction could"
CONE = "impulse outside the friction cone"
ENERGY = "energy is gained"


@dataclass(frozen=True)
class After:
    """Velocities after an impact, (n, 3) each."""

    velocity_a: Array
    angular_a: Array
    velocity_b: Array
    angular_b: Array


@dataclass(frozen=True)
class Law:
    """One law over a batch: for every row where it `applies`, by how much it is broken; at most 0 where it holds."""

    symptom: str
    amount: Array
    applies: Bools


def laws(motion: Motion, after: After) -> Iterator[Law]:
    """Every law of a batch of impacts, the one that tells most first."""
    met = _Met(motion, after)
    yield from met.without_impulse()
    yield from met.of_impulse()
    yield from met.of_friction()


@dataclass(frozen=True)
class _Change:
    """What became of one body: changes of its velocities, and the lever of the contact."""

    body: Moving
    after: Array
    spin_after: Array
    point: Array

    @cached_property
    def lever(self) -> Array:
        return np.asarray(self.point - self.body.position)

    @cached_property
    def reach(self) -> Array:
        """Distance of the contact from the centre, as the sum of its coordinates, which needs no root."""
        return _total(self.lever)

    @cached_property
    def dv(self) -> Array:
        return np.asarray(self.after - self.body.velocity)

    @cached_property
    def dw(self) -> Array:
        return np.asarray(self.spin_after - self.body.angular_velocity)

    @property
    def movable(self) -> Bools:
        return np.asarray(self.body.inverse_mass > 0, dtype=bool)

    @property
    def moved(self) -> Array:
        """Largest change of any velocity."""
        return np.maximum(_most(self.dv), _most(self.dw) * self.reach)

    @property
    def contact_after(self) -> Array:
        """Velocity of the point of contact afterwards; that of an immovable body is the one it had."""
        moves = self.movable[..., None]
        velocity, spin = np.where(moves, self.dv, 0 * self.dv), np.where(moves, self.dw, 0 * self.dw)
        return np.asarray(self.body.velocity + velocity + cross(self.body.angular_velocity + spin, self.lever))

    def against(self, direction: Array) -> Array:
        """By how much the contact's velocity along a direction grows, at most, when all velocities change by 1."""
        turned = _ratio(_total(cross(self.lever, direction)), self.reach)
        return np.where(self.movable, _total(direction) + turned, 0 * turned)

    def angular(self) -> Array:
        """Breach of I Δω = r × m Δv, multiplied by the inverse mass."""
        body = self.body
        inertia = body.inertia * body.inverse_mass[..., None, None]
        breach = abs(apply(inertia, self.dw) - cross(self.lever, self.dv))
        weight = scale(_ratio(1, self.reach), abs(inertia).sum(-1)) + self.reach[..., None] - abs(self.lever)
        return _most(_ratio(breach, weight))

    def energy(self) -> tuple[Array, Array]:
        """Energy gained, and by how much, at most, it falls when all velocities change by 1."""
        body, mass = self.body, _ratio(1, self.body.inverse_mass)
        angular = apply(body.inertia, self.spin_after)
        moving = mass * (dot(self.after, self.after) - dot(body.velocity, body.velocity))
        turning = dot(self.spin_after, angular) - dot(body.angular_velocity, apply(body.inertia, body.angular_velocity))
        slope = mass * _total(self.after) + _ratio(_total(angular), self.reach)
        none = 0 * slope
        return np.where(self.movable, (moving + turning) / 2, none), np.where(self.movable, slope, none)


class _Met:
    """A batch of impacts with its answers."""

    def __init__(self, motion: Motion, after: After) -> None:
        self.motion = motion
        self.a = _Change(motion.a, after.velocity_a, after.angular_a, motion.point)
        self.b = _Change(motion.b, after.velocity_b, after.angular_b, motion.point)
        self.closing = motion.closing
        movable = self.a.movable | self.b.movable
        self.meets = np.asarray(self.closing < 0, dtype=bool) & movable

    def without_impulse(self) -> Iterator[Law]:
        """Bodies that part keep their velocities, and so does an immovable one."""
        a, b, e = self.a, self.b, self.motion.restitution
        both = np.maximum(a.moved, b.moved)
        expected = -(1 + e) * self.closing  # what an answer that changes nothing lacks
        yield Law(MISSED, self._along_normal(expected), self.meets & np.asarray(both == 0, dtype=bool))
        yield Law(DISTURBED, both, ~self.meets)
        fixed = [np.where(side.movable, 0 * side.moved, side.moved) for side in (a, b)]
        yield Law(FIXED, np.maximum(*fixed), self.meets & ~(a.movable & b.movable))

    def of_impulse(self) -> Iterator[Law]:
        """The impulses on both bodies are opposite, act at the contact, push, and reverse the approach by e."""
        a, b, motion = self.a, self.b, self.motion
        hit = self.meets
        push = self._push
        yield Law(PULLED, _ratio(-push, _total(motion.normal)), hit)
        together = scale(motion.b.inverse_mass, a.dv) + scale(motion.a.inverse_mass, b.dv)
        weight = motion.a.inverse_mass + motion.b.inverse_mass
        yield Law(MOMENTUM, _ratio(_most(together), weight), hit & a.movable & b.movable)
        turned = [np.where(side.movable, side.angular(), 0 * side.reach) for side in (a, b)]
        yield Law(ANGULAR, np.maximum(*turned), hit)
        leaving = dot(self._apart, motion.normal) + motion.restitution * self.closing
        yield Law(FAST, self._along_normal(leaving), hit)
        yield Law(SLOW, self._along_normal(-leaving), hit)

    def of_friction(self) -> Iterator[Law]:
        """The impulse lies in the cone, gains no energy, and leaves no sliding that it could have stopped."""
        motion, hit = self.motion, self.meets
        room = self._room
        reach = 2 * (1 + motion.friction)
        yield Law(CONE, -room / reach, hit)
        (gain_a, slope_a), (gain_b, slope_b) = self.a.energy(), self.b.energy()
        at_rest = (self.a.movable | _still(motion.a)) & (self.b.movable | _still(motion.b))
        yield Law(ENERGY, _ratio(gain_a + gain_b, slope_a + slope_b), hit & at_rest)
        idle = np.minimum(np.maximum(room, 0 * room) / reach, self._sliding)
        yield Law(SLIPPERY, idle, hit & np.asarray(motion.friction > 0, dtype=bool))

    @property
    def _apart(self) -> Array:
        return np.asarray(self.b.contact_after - self.a.contact_after)

    def _along_normal(self, excess: Array) -> Array:
        """An excess of relative velocity times the normal, as a change of velocities."""
        normal = self.motion.normal
        return _ratio(excess, self.a.against(normal) + self.b.against(normal))

    @property
    def _impulse(self) -> Array:
        """Impulse on B by the mass of the lighter body, whose velocities tell it best."""
        lighter = (self.motion.b.inverse_mass >= self.motion.a.inverse_mass)[..., None]
        return np.where(lighter, self.b.dv, -self.a.dv)

    @property
    def _push(self) -> Array:
        """Its part along the normal, times the normal's length."""
        return dot(self._impulse, self.motion.normal)

    def _tangential(self, vector: Array) -> Array:
        normal = self.motion.normal
        return np.asarray(vector - scale(_ratio(dot(vector, normal), dot(normal, normal)), normal))

    @property
    def _room(self) -> Array:
        """From the impulse to the border of the cone: positive inside; at most the true way, without a root."""
        motion, along = self.motion, self._tangential(self._impulse)
        push = np.maximum(self._push, 0 * self._push)
        bound = motion.friction * push
        squares = _ratio(bound * bound, dot(motion.normal, motion.normal)) - dot(along, along)
        return _ratio(squares, _total(along) + _ratio(bound, _most(motion.normal)))

    @property
    def _sliding(self) -> Array:
        """Sliding that is left: after the bounce, or (Chatterjee and Ruina) but for what the bounce itself causes."""
        motion = self.motion
        left = self._tangential(self._apart)
        reaction = [scale(c.body.inverse_mass, motion.normal) + _spun(c, motion.normal) for c in (self.b, self.a)]
        bounce = reaction[0] + reaction[1]  # change of the relative velocity by an impulse of the normal
        share = _ratio(-self.closing, dot(bounce, motion.normal)) * motion.restitution
        other = left - self._tangential(scale(share, bounce))
        least = np.minimum(_most(left), _most(other))
        return least / 8  # two centres and two spins may change, and the projection may double a coordinate


def _spun(change: _Change, impulse: Array) -> Array:
    """Velocity of the contact by the spin that an impulse there causes: (I⁻¹ (r × P)) × r, by Cramer's rule."""
    inertia, turn = change.body.inertia, cross(change.lever, impulse)
    x, y, z = (inertia[..., i] for i in range(3))
    volume = dot(x, cross(y, z))
    usable = change.movable & np.asarray(volume != 0, dtype=bool)
    parts = (dot(turn, cross(y, z)), dot(x, cross(turn, z)), dot(x, cross(y, turn)))
    spin = np.stack([_ratio(part, volume) for part in parts], axis=-1)
    return np.where(usable[..., None], cross(spin, change.lever), 0 * spin)


def _still(body: Moving) -> Bools:
    return np.asarray((_total(body.velocity) == 0) & (_total(body.angular_velocity) == 0), dtype=bool)


def _total(vector: Array) -> Array:
    """Sum of the absolute coordinates: at least the length, at most its double."""
    return np.asarray(abs(vector).sum(-1))


def _most(vector: Array) -> Array:
    return np.asarray(abs(vector).max(-1))


def _ratio(part: Any, whole: Any) -> Array:
    """Quotient, and 0 where the divisor is 0."""
    nothing = np.asarray(whole == 0, dtype=bool)
    safe = np.where(nothing, 1, whole)
    return np.asarray(np.where(nothing, 0 * safe, part / safe))
