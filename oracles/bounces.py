"""How a ball bounces off a plane in PyBullet by default, against the formula: by restitution, speed and moment.

A simulation in steps meets the plane somewhere within a step, and what is left of the way then decides, with Bullet's
default settings, how much of the restitution is applied.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.engines.bullet_world import import_bullet
from refimpl.linear import Array

RESTITUTIONS = (0.0, 0.25, 0.5, 0.75, 1.0)
SPEEDS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 90.0, 300.0)
MOMENTS = 16
"""Moments within a step at which the ball is to meet the plane, evenly spaced, from its beginning."""
STEP, RADIUS = 1 / 240, 0.5
MOST_STEPS = 12


@dataclass(frozen=True)
class Bounces:
    """Speeds after a bounce, as shares of those before; the formula's share is the restitution.

    Attributes
    ----------
    restitutions : (r,)
    speeds : (s,)
    shares : (r, s, m)
        For each moment within a step; negative where the ball goes on into the plane.
    """

    restitutions: tuple[float, ...]
    speeds: tuple[float, ...]
    shares: Array


def measured(
    restitutions: tuple[float, ...] = RESTITUTIONS, speeds: tuple[float, ...] = SPEEDS, moments: int = MOMENTS
) -> Bounces:
    """Let a ball of mass 1 and radius 0.5 meet a plane, without gravity, and read its first speed away from it.

    Raises
    ------
    EngineUnavailable
        When PyBullet is not installed.
    """
    bullet = import_bullet()
    client = bullet.connect(bullet.DIRECT)
    try:
        found = [
            [[_share(bullet, client, e, v, i / moments) for i in range(moments)] for v in speeds] for e in restitutions
        ]
    finally:
        bullet.disconnect(client)
    return Bounces(restitutions, speeds, np.array(found))


def _share(bullet: Any, client: int, restitution: float, speed: float, moment: float) -> float:
    """Speed away from the plane, after the first step in which the ball does not come nearer, or after the last."""
    bullet.resetSimulation(physicsClientId=client)
    plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client)
    ball = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=RADIUS, physicsClientId=client)
    floor = bullet.createMultiBody(0.0, plane, physicsClientId=client)
    height = [0.0, 0.0, RADIUS + moment * STEP * speed]
    body = bullet.createMultiBody(1.0, ball, -1, height, physicsClientId=client)
    bullet.changeDynamics(floor, -1, restitution=1.0, physicsClientId=client)
    bullet.changeDynamics(body, -1, restitution=restitution, physicsClientId=client)
    bullet.resetBaseVelocity(body, [0.0, 0.0, -speed], [0.0, 0.0, 0.0], physicsClientId=client)
    after = -speed
    for _ in range(MOST_STEPS):
        bullet.stepSimulation(physicsClientId=client)
        after = bullet.getBaseVelocity(body, physicsClientId=client)[0][2]
        if after >= 0:
            break
    return float(after / speed)
