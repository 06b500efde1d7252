"""Bullet as it is used by default: impacts in one step of 1/240, with everything that Bullet adds to the formula.

Only what a user has to say is said: shapes, masses, velocities, and the restitution and friction of the bodies. What
comes of it is then not an impact alone. On PyBullet 3.2.7:

- Velocities are damped by 0.04 (1 + |v|) of themselves a second, before the step; their coordinates are clamped at 100.
- Approaches slower than 0.2 do not bounce, whatever the restitution.
- Bodies that touch are let sink in by 1e-5 a step, so that 0.0024 of the approach stay. Where there is a gap, however
  small, the approach is ended by just so much that they touch after the step, and there is no bounce.
- Spin turns a body by 1/240 of itself before the contact is solved.
- Inertia is that of the shape with uniform density, of a capsule that of the box around it.
- Boxes and capsules have the margin of 0.001 about their edges.
- The solver ends at a residual of 1e-7, which a contact with friction reaches before it has converged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib import metadata
from typing import ClassVar

import numpy as np

from oracles.engine import (
    NATIVE,
    VELOCITIES,
    Convention,
    Engine,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    unsupported,
)
from oracles.engines import bullet_impacts as impacts
from oracles.engines.bullet_world import import_bullet
from oracles.motion import Motion, Moving
from oracles.scene import SWEEP
from refimpl.linear import Array, norm
from refimpl.mass import mass_properties
from refimpl.shapes import Capsule, HalfSpace

TOLERANCE = Tolerance.uniform(5e-3, 5e-3, "what damping, sinking in and turning before the contact come to in a step")


class BulletDefaults(Engine):
    """Bullet with its default settings, for impacts only."""

    name: ClassVar[str] = "pybullet-defaults"
    velocity_limit: ClassVar[float] = 100.0
    speed_thresholds: ClassVar[Mapping[str, float]] = {
        "restitutionVelocityThreshold": 0.2,
        "limit of velocities": velocity_limit,
    }

    def __init__(self) -> None:
        self._world: impacts.ImpactWorld | None = None

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains the library."""
        return {"pybullet": metadata.version("pybullet")}

    def warm(self) -> None:
        """Import pybullet."""
        import_bullet()

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        del query, A, B
        return unsupported("settings are for impacts: the engine bullet answers the rest")

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        return self._support(SWEEP, A, B)

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        del A, B
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer."""
        del query, A, B
        return frozenset(VELOCITIES)

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give what a step adds to the formula, whatever the impact."""
        del query, A, B
        return TOLERANCE

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Tell of the limit on velocities."""
        del query, A, B
        return {Convention.CLAMPED: "no coordinate of a velocity exceeds 100"}

    def effective_motion(self, A: Kind, B: Kind, motion: Motion, rows: tuple[Array, Array]) -> Motion:
        """Give bodies the inertia that Bullet takes from their shapes, whatever the scene's own."""
        kinds, bodies = (A, B), (motion.a, motion.b)
        a, b = (_of_shape(kind, body, packed) for kind, body, packed in zip(kinds, bodies, rows, strict=True))
        return replace(motion, a=a, b=b)

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 1 ms."""
        self.require(query, A, B)
        self._world = self._world or impacts.ImpactWorld(impacts.BY_DEFAULT)
        return self._world.solver(A, B)

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs pybullet only."""
        self.require(query, A, B)
        return impacts.script(A, row_a, B, row_b, impacts.BY_DEFAULT)


def _of_shape(kind: Kind, body: Moving, packed: Array) -> Moving:
    """Inertia of a solid of uniform density; a capsule's is that of the box around it."""
    if kind is HalfSpace:
        return body
    if kind is Capsule:
        return _boxed(body, packed)
    inertia = mass_properties(kind.unpack(packed)).of_mass(1 / np.where(body.inverse_mass > 0, body.inverse_mass, 1.0))
    return replace(body, inertia=(inertia + np.swapaxes(inertia, -1, -2)) / 2)


def _boxed(body: Moving, capsules: Array) -> Moving:
    """Capsules with the inertia of the boxes around them: m/3 of the squares of the half extents across each axis."""
    axis, radius = capsules[:, 3:6] - capsules[:, :3], capsules[:, 6]
    length = norm(axis)
    axis = axis / np.where(length > 0, length, 1.0)[:, None]
    mass = 1 / np.where(body.inverse_mass > 0, body.inverse_mass, 1.0)
    along = mass / 3 * 2 * radius**2
    across = mass / 3 * (radius**2 + (radius + length / 2) ** 2)
    inertia = across[:, None, None] * np.eye(3) + (along - across)[:, None, None] * axis[:, :, None] * axis[:, None, :]
    return replace(body, inertia=(inertia + np.swapaxes(inertia, -1, -2)) / 2)
