"""PyBullet stepping many bodies: balls between walls, without gravity.

Two ways to set it up: as PyBullet does by default, or so that its solver computes the impact formula and nothing
besides (no damping, no friction, no correction of penetration, no threshold below which nothing bounces).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from oracles.engines.bullet_impacts import BODY, STRICT
from oracles.engines.bullet_world import import_bullet

WORLD = {name: value for name, value in STRICT.items() if name != "fixedTimeStep"}
"""Settings under which impacts follow the formula, but for the step, which is long enough to move here."""


class Balls:
    """A PyBullet world of balls between planes, that can be stepped. Use it as a context manager.

    Parameters
    ----------
    radius : float
    positions, velocities : (n, 3)
    walls : sequence of (point, normal)
        Immovable planes; normals point into the room.
    restitution : float
        Of every body; PyBullet multiplies those of two that meet, and this is done for the pair.
    time_step : float
    defaults : bool
        Leave PyBullet's settings as they are.
    """

    def __init__(
        self,
        radius: float,
        positions: Any,
        velocities: Any,
        walls: Sequence[tuple[Any, Any]],
        restitution: float,
        time_step: float,
        defaults: bool,
    ) -> None:
        self.bullet = bullet = import_bullet()
        self.client = client = bullet.connect(bullet.DIRECT)
        bullet.setGravity(0, 0, 0, physicsClientId=client)
        bullet.setTimeStep(time_step, physicsClientId=client)
        if not defaults:
            bullet.setPhysicsEngineParameter(**WORLD, physicsClientId=client)
        ball = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=radius, physicsClientId=client)
        self.balls = [
            bullet.createMultiBody(1.0, ball, basePosition=[float(c) for c in p], physicsClientId=client)
            for p in positions
        ]
        fixed = []
        for point, normal in walls:
            plane = bullet.createCollisionShape(
                bullet.GEOM_PLANE, planeNormal=[float(c) for c in normal], physicsClientId=client
            )
            place = [float(c) for c in point]
            fixed.append(bullet.createMultiBody(0.0, plane, basePosition=place, physicsClientId=client))
        for body in [*self.balls, *fixed]:
            bullet.changeDynamics(body, -1, restitution=float(np.sqrt(restitution)), physicsClientId=client)
            if not defaults:
                bullet.changeDynamics(body, -1, lateralFriction=0, **BODY, physicsClientId=client)
        for body, velocity in zip(self.balls, velocities, strict=True):
            bullet.resetBaseVelocity(body, [float(c) for c in velocity], physicsClientId=client)

    def step(self) -> NDArray[np.float64]:
        """Advance one time step; give the velocities (n, 3)."""
        self.bullet.stepSimulation(physicsClientId=self.client)
        return np.array([self.bullet.getBaseVelocity(b, physicsClientId=self.client)[0] for b in self.balls])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.bullet.disconnect(self.client)
