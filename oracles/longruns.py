"""Many impacts in a row: a ball in a box, and Newton's cradle of five, by the reference and by PyBullet.

Nothing is lost at an impact of restitution 1 without friction, so energy and momentum tell what a simulation adds.
The reference goes from impact to impact; PyBullet in steps, by default and without its damping.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.engines.bullet_world import import_bullet
from refimpl.impacts import RigidBody, impact_of_bodies
from refimpl.linear import Array

HALF, RADIUS, MASS = 1.0, 0.125, 1.0
"""Half the box's edge, and the ball's radius and mass."""
START = (3.0, -2.0, 1.0)
"""Velocity of the ball, from the middle of the box."""
MOST_STEPS = 20_000
SETTLED = 240
"""Steps after which the balls of a cradle are looked at."""
NO_DAMPING = {"linearDamping": 0.0, "angularDamping": 0.0}


@dataclass(frozen=True)
class Series:
    """What became of a ball in a box.

    Attributes
    ----------
    energy : (n,)
        After each bounce, as a share of the energy at the start; fewer where the ball came to rest, and then at the
        end as well.
    """

    name: str
    energy: Array


@dataclass(frozen=True)
class Cradle:
    """Velocities of the five balls of a cradle along its line, the first of which came in at 1, (5,)."""

    name: str
    velocities: Array

    @property
    def momentum(self) -> float:
        """Momentum, as a share of that at the start."""
        return float(self.velocities.sum())

    @property
    def energy(self) -> float:
        """Energy, as a share of that at the start."""
        return float((self.velocities**2).sum())


# -- the reference -----------------------------------------------------------------------------------------------


def ball_in_box(bounces: int) -> Series:
    """Fly to the wall that is reached first, and bounce, as often as is asked."""
    position, velocity = np.zeros(3), np.array(START)
    wall, inertia = RigidBody.immovable(), 0.4 * MASS * RADIUS**2 * np.eye(3)
    energies = []
    for _ in range(bounces):
        away = np.where(velocity > 0, HALF - RADIUS - position, position + HALF - RADIUS)
        times = np.where(velocity != 0, away / np.where(velocity != 0, np.abs(velocity), 1.0), np.inf)
        axis = int(np.argmin(times))
        normal = np.where(np.arange(3) == axis, np.sign(velocity), 0.0)
        position = position + times[axis] * velocity
        ball = RigidBody(position, velocity, np.zeros(3), np.array(1 / MASS), inertia)
        velocity = impact_of_bodies(ball, wall, position + RADIUS * normal, normal, 1.0).a.velocity
        energies.append(float(velocity @ velocity))
    return Series("refimpl", np.array(energies) / float(np.dot(START, START)))


def cradle() -> Cradle:
    """Five balls that touch, one after the other, until none comes nearer to the next."""
    velocities = [1.0, 0.0, 0.0, 0.0, 0.0]
    normal, inertia = np.array([1.0, 0.0, 0.0]), 0.4 * MASS * RADIUS**2 * np.eye(3)

    def ball(i: int) -> RigidBody:
        return RigidBody(2 * RADIUS * i * normal, velocities[i] * normal, np.zeros(3), np.array(1 / MASS), inertia)

    while meeting := [i for i in range(4) if velocities[i] > velocities[i + 1]]:
        i = meeting[0]
        found = impact_of_bodies(ball(i), ball(i + 1), (2 * i + 1) * RADIUS * normal, normal, 1.0)
        velocities[i], velocities[i + 1] = float(found.a.velocity[0]), float(found.b.velocity[0])
    return Cradle("refimpl", np.array(velocities))


# -- PyBullet ----------------------------------------------------------------------------------------------------


def ball_in_box_of_bullet(bounces: int, *, damped: bool) -> Series:
    """Let PyBullet go on in steps until the ball has turned as often as is asked, or comes to rest."""
    with _Client() as world:
        for axis in range(3):
            for sign in (-1.0, 1.0):
                normal = [sign * float(i == axis) for i in range(3)]
                plane = world.bullet.createCollisionShape(world.bullet.GEOM_PLANE, planeNormal=normal, **world.client)
                world.body(plane, 0.0, [-HALF * u for u in normal], damped=True)
        ball = world.body(world.ball(), MASS, [0.0, 0.0, 0.0], damped=damped)
        world.bullet.resetBaseVelocity(ball, START, [0.0, 0.0, 0.0], **world.client)
        energies = list(_turns(world, ball, bounces))
    return Series(_name(damped), np.array(energies) / float(np.dot(START, START)))


def _turns(world: _Client, ball: int, bounces: int) -> Iterator[float]:
    """Energy after every step in which coordinates of the velocity change sign, for each that does; and at the end."""
    before, found = np.array(START), 0
    for _ in range(MOST_STEPS):
        world.bullet.stepSimulation(**world.client)
        velocity = np.array(world.bullet.getBaseVelocity(ball, **world.client)[0])
        for _ in range(int(np.count_nonzero(velocity * before < 0))):
            found += 1
            yield float(velocity @ velocity)
            if found == bounces:
                return
        before = velocity
    yield float(before @ before)


def cradle_of_bullet(*, damped: bool) -> Cradle:
    """Let PyBullet go on for a second."""
    with _Client() as world:
        shape = world.ball()
        balls = [world.body(shape, MASS, [2 * RADIUS * i, 0.0, 0.0], damped=damped) for i in range(5)]
        world.bullet.resetBaseVelocity(balls[0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], **world.client)
        for _ in range(SETTLED):
            world.bullet.stepSimulation(**world.client)
        velocities = [world.bullet.getBaseVelocity(ball, **world.client)[0][0] for ball in balls]
    return Cradle(_name(damped), np.array(velocities))


def _name(damped: bool) -> str:
    return "PyBullet by default" if damped else "PyBullet without damping"


class _Client:
    """A physics client, and what all these scenes are made of."""

    def __enter__(self) -> _Client:
        self.bullet = import_bullet()
        self.client: dict[str, Any] = {"physicsClientId": self.bullet.connect(self.bullet.DIRECT)}
        return self

    def __exit__(self, *_: object) -> None:
        self.bullet.disconnect(**self.client)

    def ball(self) -> int:
        return int(self.bullet.createCollisionShape(self.bullet.GEOM_SPHERE, radius=RADIUS, **self.client))

    def body(self, shape: int, mass: float, position: list[float], *, damped: bool) -> int:
        """Make a body of restitution 1 without friction."""
        body = int(self.bullet.createMultiBody(mass, shape, -1, position, **self.client))
        extra = {} if damped else NO_DAMPING
        self.bullet.changeDynamics(body, -1, restitution=1.0, lateralFriction=0.0, **extra, **self.client)
        return body
