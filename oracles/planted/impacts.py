"""One impulse between two rigid bodies: restitution along the normal, and Coulomb's friction across it."""

from __future__ import annotations

from typing import NamedTuple

from oracles.engine import AnswerRow, Row, answer_row
from oracles.motion import WIDTH
from oracles.planted.vectors import UNITS, ZERO, Axes, Vec, across, add, along, cross, dot, length, sub, times, unit


class Body(NamedTuple):
    """A body in motion."""

    position: Vec
    velocity: Vec
    spin: Vec
    inverse_mass: float
    inertia: Axes


class Contact(NamedTuple):
    """Where two bodies meet."""

    point: Vec
    normal: Vec
    restitution: float
    friction: float


def _body(row: Row) -> Body:
    inertia = (_vec(row, 10), _vec(row, 13), _vec(row, 16))
    return Body(_vec(row, 0), _vec(row, 3), _vec(row, 6), row[9], inertia)


def _vec(row: Row, at: int) -> Vec:
    return (row[at], row[at + 1], row[at + 2])


def multiplied(matrix: Axes, v: Vec) -> Vec:
    """Matrix, given by rows, times a vector."""
    return (dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v))


def solved(matrix: Axes, v: Vec) -> Vec:
    """The vector that a symmetric matrix turns into v, by Cramer's rule."""
    x, y, z = matrix
    volume = dot(x, cross(y, z))
    return (dot(v, cross(y, z)) / volume, dot(x, cross(v, z)) / volume, dot(x, cross(y, v)) / volume)


class Impacts:
    """Velocities after an impact."""

    def impact(self, row: Row) -> AnswerRow:
        """Answer the row of a motion."""
        numbers = row[-WIDTH:]
        a, b = _body(numbers[:19]), _body(numbers[19:38])
        contact = Contact(_vec(numbers, 38), unit(_vec(numbers, 41)), numbers[44], numbers[45])
        a, b = self.meet(a, b, contact)
        return answer_row(velocity_a=a.velocity, angular_a=a.spin, velocity_b=b.velocity, angular_b=b.spin)

    def meet(self, a: Body, b: Body, contact: Contact) -> tuple[Body, Body]:
        """Both bodies afterwards."""
        approach = sub(self.velocity_at(b, contact.point), self.velocity_at(a, contact.point))
        if not self.closes(dot(approach, contact.normal), approach):
            return a, b
        push = self.impulse(a, b, contact, approach)
        return self.pushed(a, contact.point, times(-1.0, push)), self.pushed(b, contact.point, push)

    def closes(self, speed: float, approach: Vec) -> bool:
        """Whether bodies come nearer, by their speed along the normal."""
        del approach
        return speed < 0

    def velocity_at(self, body: Body, point: Vec) -> Vec:
        """Velocity of a body's point."""
        return add(body.velocity, cross(body.spin, self.lever(body, point)))

    def lever(self, body: Body, point: Vec) -> Vec:
        """From the centre of mass to the contact."""
        return sub(point, body.position)

    def impulse(self, a: Body, b: Body, contact: Contact, approach: Vec) -> Vec:
        """Impulse on B: what stops the approach and its share that bounces, and what friction allows."""
        n = contact.normal
        give = self.give(a, b, contact.point)
        stop = times(-dot(n, approach) / dot(n, multiplied(give, n)), n)
        along_normal = times(1 + self.bounce(contact.restitution, -dot(n, approach)), stop)
        if contact.friction == 0:
            return along_normal
        rest = sub(times(-1.0, solved(give, approach)), stop)
        return along(along_normal, self.share(length(along_normal), rest, n, contact.friction), rest)

    def bounce(self, restitution: float, speed: float) -> float:
        """Share of the approach that comes back."""
        del speed
        return restitution

    def share(self, push: float, rest: Vec, n: Vec, friction: float) -> float:
        """The largest share, up to 1, of the impulse that ends all sliding with which the whole stays in the cone."""
        needed = length(across(rest, n)) - friction * dot(n, rest)
        return min(1.0, friction * push / needed) if needed > 0 else 1.0

    def give(self, a: Body, b: Body, point: Vec) -> Axes:
        """Change of the contact's relative velocity by a unit impulse along each axis: a symmetric matrix."""
        x, y, z = (add(self.yields(a, point, u), self.yields(b, point, u)) for u in UNITS)
        return (x, y, z)

    def yields(self, body: Body, point: Vec, push: Vec) -> Vec:
        """Change of the velocity of a body's point by an impulse there."""
        if body.inverse_mass == 0:
            return ZERO
        arm = self.lever(body, point)
        return along(cross(self.spun(body, arm, push), arm), body.inverse_mass, push)

    def spun(self, body: Body, arm: Vec, push: Vec) -> Vec:
        """Change of the spin by an impulse at the end of a lever."""
        return solved(body.inertia, cross(arm, push))

    def pushed(self, body: Body, point: Vec, push: Vec) -> Body:
        """The body after an impulse."""
        if self.is_fixed(body):
            return body
        spin = add(body.spin, self.spun(body, self.lever(body, point), push))
        return body._replace(velocity=along(body.velocity, body.inverse_mass, push), spin=spin)

    def is_fixed(self, body: Body) -> bool:
        """Whether a body cannot be moved."""
        return body.inverse_mass == 0
