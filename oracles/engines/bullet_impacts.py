"""Impacts in PyBullet: two bodies that touch, one step, and the velocities after it.

Bullet solves the formula of an impact, and not its own stabilisation, with the settings of `STRICT` and `BODY`. Of
these the following had to be found out, on PyBullet 3.2.7:

- A step of 1e-15, the shortest that is safely one (of any below 2.2e-16 Bullet takes none). In it a body spins freely,
  by its gyroscopic torque, before the contact is solved; `as_held` says what spin it comes to.
- An overlap of 1e-12 of the coordinates: of bodies that touch exactly, rounding parts one in six, and their impact is
  missed, because `contactProcessingThreshold = 0` keeps Bullet from stopping bodies ahead of a contact.
- `solverResidualThreshold = 0`: else the solver ends early, and a bounce with friction is off by up to 1e-3.
- `collisionMargin = 0`, which makes edges and corners of boxes sharp.
- `maxJointVelocity`: the velocities of any body are clamped at 100, whether it has joints or not.

The restitution and the friction of a contact are the products of those of the bodies. Friction is Coulomb's cone, by
default: a pyramid only with `enableConeFriction = 0`. Off the line of centres, where the bounce changes the sliding,
Bullet ends the sliding that is left after the bounce; the reference's law (Chatterjee and Ruina) ends that of the
compression, for Bullet's may gain energy. Both are in the cone: the difference is a convention, the energy is not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from oracles.engine import (
    AnswerRow,
    Array,
    Kind,
    Row,
    Solver,
    Tolerance,
    answer_row,
)
from oracles.engines.bullet_scripts import shape_text
from oracles.engines.bullet_shapes import PLANE, SPHERE, Placed, place
from oracles.engines.bullet_world import World
from oracles.motion import WIDTH, Motion, Moving
from refimpl import HalfSpace
from refimpl.linear import rotation_matrix

STEP = 1e-15
STRICT: Mapping[str, float] = MappingProxyType(
    {
        "fixedTimeStep": STEP,
        "restitutionVelocityThreshold": 0.0,
        "erp": 0.0,
        "contactERP": 0.0,
        "frictionERP": 0.0,
        "contactSlop": 0.0,
        "numSolverIterations": 1000,
        "solverResidualThreshold": 0.0,
    }
)
BODY: Mapping[str, float] = MappingProxyType(
    {
        "linearDamping": 0.0,
        "angularDamping": 0.0,
        "rollingFriction": 0.0,
        "spinningFriction": 0.0,
        "contactProcessingThreshold": 0.0,
        "maxJointVelocity": 1e30,
    }
)
NO_MARGIN = {"collisionMargin": 0.0}
TOLERANCE = Tolerance.uniform(0.0, 1e-12, "the overlap moves the contact by 1e-12; measured, errors stay below 1e-13")

OVERLAP = 1e-12
"""Relative to the scene's largest coordinate."""


class Thrown(NamedTuple):
    """A body as PyBullet is given it."""

    placed: Placed
    mass: float
    dynamics: dict[str, Any]
    velocity: list[float]
    spin: list[float]


class Settings(NamedTuple):
    """Settings of the simulation, and of each body, beside its restitution and friction."""

    simulation: Mapping[str, float]
    body: Mapping[str, float]
    strict: bool


EXACTLY = Settings(STRICT, BODY, strict=True)
BY_DEFAULT = Settings(MappingProxyType({}), MappingProxyType({}), strict=False)


def thrown(A: Kind, row_a: Row, B: Kind, row_b: Row, settings: Settings) -> tuple[Thrown, Thrown]:
    """Both bodies of one scene."""
    motion = Motion.unpack(np.array(row_a[-WIDTH:]))
    (a,), (b,) = place(A, row_a[:-WIDTH], 0.0), place(B, row_b, 0.0)
    if settings.strict:
        normal = motion.normal / math.sqrt(float(np.sum(motion.normal**2)))
        size = max(1.0, float(np.abs(motion.point).max()), *map(abs, (*a.position, *b.position)))
        a = a._replace(position=(np.array(a.position) + OVERLAP * size * normal).tolist())
    shares = (float(motion.restitution), float(motion.friction)), (1.0, 1.0)
    return _thrown(a, motion.a, *shares[0], settings), _thrown(b, motion.b, *shares[1], settings)


def _thrown(placed: Placed, body: Moving, restitution: float, friction: float, settings: Settings) -> Thrown:
    mass = 1 / float(body.inverse_mass) if body.inverse_mass > 0 else 0.0
    dynamics: dict[str, Any] = {**settings.body, "restitution": restitution, "lateralFriction": friction}
    if settings.strict and placed.geometry not in (SPHERE, PLANE):
        dynamics |= NO_MARGIN
    if settings.strict and mass:
        dynamics["localInertiaDiagonal"] = own_moments(body.inertia, placed.orientation)
    return Thrown(placed, mass, dynamics, body.velocity.tolist(), body.angular_velocity.tolist())


def own_moments(inertia: Array, orientation: list[float]) -> list[float]:
    """Moments of inertia (3,) about the body's own axes."""
    return _moments(inertia, rotation_matrix(np.array(orientation))).tolist()  # type: ignore[no-any-return]


def _moments(inertia: Array, turns: Array) -> Array:
    return np.diagonal(np.swapaxes(turns, -1, -2) @ inertia @ turns, axis1=-2, axis2=-1)


def as_held(kind: Kind, body: Moving, rows: Array) -> Moving:
    """Bodies as Bullet has them meet: with the moments about the shape's own axes, after a step of spinning freely.

    By Euler's equations a body of unequal moments loses or gains spin without any torque: where it turns by 1e4 in a
    unit of time, 1e-11 of it in this step.
    """
    if kind is HalfSpace:
        return body
    turns = rotation_matrix(np.array([place(kind, row, 0.0)[0].orientation for row in rows.tolist()]).reshape(-1, 4))
    moments = _moments(body.inertia, turns)
    held = turns * moments[:, None, :] @ np.swapaxes(turns, -1, -2)
    spin = np.einsum("nji,nj->ni", turns, body.angular_velocity)
    turning = np.where((body.inverse_mass > 0)[:, None] & (moments > 0), np.cross(moments * spin, spin), 0.0)
    gained = np.einsum("nij,nj->ni", turns, STEP * turning / np.where(moments > 0, moments, 1.0))
    held = (held + np.swapaxes(held, -1, -2)) / 2
    return replace(body, inertia=held, angular_velocity=body.angular_velocity + gained)


class ImpactWorld(World):
    """A physics client that has two bodies meet."""

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.settings = settings

    def _begin(self) -> None:
        fresh = not self.scenes_left
        super()._begin()
        if fresh and self.settings.simulation:
            self.bullet.setPhysicsEngineParameter(**self.settings.simulation, physicsClientId=self.client)

    def solver(self, A: Kind, B: Kind) -> Solver:
        """Return a function that answers one scene."""
        return lambda a, b: self.impact(*thrown(A, a, B, b, self.settings))

    def impact(self, a: Thrown, b: Thrown) -> AnswerRow:
        """Velocities after one step."""
        self._begin()
        bullet, client = self.bullet, self.client
        bodies: list[int] = []
        try:
            for one in (a, b):
                body = self._body(one.placed, one.mass)
                bodies.append(body)
                bullet.changeDynamics(body, -1, **one.dynamics, physicsClientId=client)
                bullet.resetBaseVelocity(body, one.velocity, one.spin, physicsClientId=client)
            bullet.stepSimulation(physicsClientId=client)
            (va, wa), (vb, wb) = (bullet.getBaseVelocity(body, physicsClientId=client) for body in bodies)
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)
        return answer_row(velocity_a=va, angular_a=wa, velocity_b=vb, angular_b=wb)


SCRIPT = '''"""Bullet: impact of {A} (a) and {B} (b){how}."""

from importlib.metadata import version

import pybullet

print("pybullet", version("pybullet"))
pybullet.connect(pybullet.DIRECT)
{simulation}
bodies = []
{bodies}
pybullet.stepSimulation()
for name, body in zip("ab", bodies):
    velocity, angular = pybullet.getBaseVelocity(body)
    print(f"velocity_{{name}} =", list(velocity))
    print(f"angular_{{name}} =", list(angular))
'''


def script(A: Kind, row_a: Row, B: Kind, row_b: Row, settings: Settings) -> str:
    """Write the script of one scene, with the calls that `ImpactWorld.impact` makes."""
    a, b = thrown(A, row_a, B, row_b, settings)
    simulation = f"pybullet.setPhysicsEngineParameter(\n{_arguments(settings.simulation)})\n" if settings.strict else ""
    how = "" if settings.strict else ", with its default settings"
    bodies = "\n".join(_body(one) for one in (a, b))
    return SCRIPT.format(A=A.__name__, B=B.__name__, how=how, simulation=simulation, bodies=bodies)


def _body(one: Thrown) -> str:
    placed = one.placed
    return f"""shape = {shape_text(placed)}
body = pybullet.createMultiBody({one.mass!r}, shape, -1, {placed.position!r}, {placed.orientation!r})
pybullet.changeDynamics(
    body,
    -1,
{_arguments(one.dynamics)})
pybullet.resetBaseVelocity(body, {one.velocity!r}, {one.spin!r})
bodies.append(body)
"""


def _arguments(values: Mapping[str, Any]) -> str:
    return "".join(f"    {name}={value!r},\n" for name, value in values.items())
