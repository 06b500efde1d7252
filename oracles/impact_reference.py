"""What the reference says of an impact: velocities after it, in the form of an engine's answer."""

from __future__ import annotations

import numpy as np

from oracles.engine import COLUMNS, VELOCITIES, WIDTH, Answers
from oracles.motion import Motion, Moving
from refimpl.impacts import RigidBody, impact_of_bodies

REFERENCE_ERROR = 1e-13
"""Bound on the error of `refimpl.impacts`, relative to the largest velocity; held against exact rationals by tests."""


def rigid_body(moving: Moving) -> RigidBody:
    """A body as the reference has it."""
    return RigidBody(moving.position, moving.velocity, moving.angular_velocity, moving.inverse_mass, moving.inertia)


def reference_of(motion: Motion) -> Answers:
    """Answer a batch as the reference does; bodies that part keep their velocities."""
    a, b = rigid_body(motion.a), rigid_body(motion.b)
    found = impact_of_bodies(a, b, motion.point, motion.normal, motion.restitution, motion.friction)
    parting = (motion.closing >= 0)[..., None]
    table = np.full((len(motion), WIDTH), np.nan)
    before = (a.velocity, a.angular_velocity, b.velocity, b.angular_velocity)
    after = (found.a.velocity, found.a.angular_velocity, found.b.velocity, found.b.angular_velocity)
    for name, old, new in zip(VELOCITIES, before, after, strict=True):
        table[:, COLUMNS[name]] = np.where(parting, old, new)
    return Answers.from_table(np.zeros(len(motion), dtype=np.int8), table, {})
