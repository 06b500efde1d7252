"""Asking PyBullet's simulation for a sweep: a body that moves by time steps, until one of them knows of a contact.

A step knows the contacts that there are where it begins; those across a gap of up to 0.02, for which its solver brakes
where they would be reached; and, of a body with a swept sphere, the one that this sphere meets on the way of the step.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from oracles.course import WIDTH, Course
from oracles.engine import AnswerRow, Kind, Row, Solver, UnsupportedCell, answer_row
from oracles.engines.bullet_scripts import SCRIPT, shape_text
from oracles.engines.bullet_shapes import PLANE, Placed, place
from oracles.engines.bullet_world import DISTANCE_FIELD, NORMAL_ON_B, World
from refimpl.shapes import HalfSpace

FORCE = 9
"""Place in a contact of PyBullet: the force with which the solver keeps the two from getting into each other."""
BODY = {"linearDamping": 0.0, "angularDamping": 0.0, "lateralFriction": 0.0}
"""Nothing but a contact may change the velocity."""
THINNEST = 1e-8
"""Radius of a Point, relative to coordinates above 1: Bullet drops contacts of much smaller bodies."""
ACTIVE = 0.5
"""`changeDynamics` has a swept sphere looked after on ways of a step longer than this part of its radius."""
NO_TURNING = "asked about translations: the way of a body that spins is also one of its inertia"
PENETRATION = 0.04
"""`allowedCcdPenetration`: nearer approaches are not swept."""
NOT_SWEPT = "a swept sphere is looked after on ways longer than half its radius; on this way it might get in by 0.04"


class Stepping(NamedTuple):
    """How a way is stepped: in how many steps, and whether with a swept sphere."""

    steps: int
    swept: bool


class Going(NamedTuple):
    """One scene: a body that moves by `way`, as seen from one at rest; `duration` makes it a speed about 1."""

    mover: Placed
    rest: Placed
    way: list[float]
    duration: float

    @property
    def velocity(self) -> list[float]:
        """Of the mover."""
        return [u / self.duration for u in self.way]


def going(A: Kind, row_a: Row, B: Kind, row_b: Row, stepping: Stepping) -> Going:
    """The scene as it is stepped; a plane never moves.

    Raises
    ------
    UnsupportedCell
        When either of the two turns, or the way is too short for a swept sphere.
    """
    course = Course.unpack(np.array(row_a[-WIDTH:]))
    if course.turns:
        raise UnsupportedCell(NO_TURNING)
    (a,), (b,) = place(A, row_a[:-WIDTH], THINNEST), place(B, row_b, THINNEST)
    mover, rest, way = a, b, course.a.linear - course.b.linear
    if a.geometry == PLANE:
        mover, rest, way = b, a, -way
    if stepping.swept and PENETRATION < math.hypot(*way) <= ACTIVE * _radius(mover):
        raise UnsupportedCell(NOT_SWEPT)
    return Going(mover, rest, way.tolist(), float(np.abs(way).max()) or 1.0)


def _radius(ball: Placed) -> float:
    radius = ball.sizes["radius"]
    assert isinstance(radius, float)
    return radius


class SteppedWorld(World):
    """A physics client that steps one body to another."""

    def __init__(self, stepping: Stepping) -> None:
        super().__init__()
        self.stepping = stepping

    def solver(self, A: Kind, B: Kind) -> Solver:
        """Return a function that answers one scene."""
        return lambda a, b: self.step(going(A, a, B, b, self.stepping))

    def step(self, scene: Going) -> AnswerRow:
        """First time, by steps, at which there is a contact."""
        self._begin()
        bullet, client, steps = self.bullet, self.client, self.stepping.steps
        bodies: list[int] = []
        try:
            bullet.setTimeStep(scene.duration / steps, physicsClientId=client)
            for placed, mass in ((scene.mover, 1.0), (scene.rest, 0.0)):
                bodies.append(self._made(placed, mass))
            bullet.resetBaseVelocity(bodies[0], scene.velocity, [0.0, 0.0, 0.0], physicsClientId=client)
            for number in range(steps):
                bullet.stepSimulation(physicsClientId=client)
                part = first_of(bullet.getContactPoints(*bodies, physicsClientId=client), scene, steps)
                if part < 1:
                    return answer_row(hit=1.0, t=(number + part) / steps)
            bullet.performCollisionDetection(physicsClientId=client)
            contacts = bullet.getContactPoints(*bodies, physicsClientId=client)
            if any(contact[DISTANCE_FIELD] <= scene.mover.extra for contact in contacts):
                return answer_row(hit=1.0, t=1.0)
            return answer_row(hit=0.0, t=math.inf)
        finally:
            for body in bodies:
                bullet.removeBody(body, physicsClientId=client)

    def _made(self, placed: Placed, mass: float) -> int:
        bullet, client = self.bullet, self.client
        shape, stands = self._shape(placed), (placed.position, placed.orientation)
        made = bullet.createMultiBody(
            mass, shape, self.skin, *stands, useMaximalCoordinates=self.stepping.swept, physicsClientId=client
        )
        bullet.changeDynamics(made, -1, **dynamics(placed, mass, self.stepping), physicsClientId=client)
        return int(made)


def dynamics(placed: Placed, mass: float, stepping: Stepping) -> dict[str, Any]:
    """Arguments of changeDynamics."""
    swept = {"ccdSweptSphereRadius": _radius(placed)} if stepping.swept and mass else {}
    return {**BODY, **swept}


def first_of(contacts: Iterable[Any], scene: Going, steps: int) -> float:
    """After which part of a step it comes to a contact; infinite where it comes to none.

    Contacts that there are when it begins count at once, those ahead where the solver has used some force.
    """
    first = math.inf
    for contact in contacts:
        gap = contact[DISTANCE_FIELD] - scene.mover.extra
        closing = -sum(u * n for u, n in zip(scene.way, contact[NORMAL_ON_B], strict=True)) / steps
        if gap <= 0:
            first = 0.0
        elif contact[FORCE] > 0 and gap < closing:
            first = min(first, gap / closing)
    return first


BODIES = """# What moves here is {mover_name}, as seen from {rest_name}.
pybullet.setTimeStep({step!r})
shape = {mover}
mover = pybullet.createMultiBody(1.0, shape, -1, {mover_stands}, useMaximalCoordinates={maximal})
pybullet.changeDynamics(mover, -1{dynamics})
shape = {rest}
rest = pybullet.createMultiBody(0.0, shape, -1, {rest_stands}, useMaximalCoordinates={maximal})
pybullet.changeDynamics(rest, -1{dynamics_at_rest})
pybullet.resetBaseVelocity(mover, {velocity!r}, [0.0, 0.0, 0.0])
way = {way!r}
steps, extra = {steps}, {extra!r}  # the part of a radius that is taken off again
time = float("inf")
for number in range(steps):
    pybullet.stepSimulation()
    for contact in pybullet.getContactPoints(mover, rest):
        gap = contact[8] - extra
        closing = -sum(u * n for u, n in zip(way, contact[7])) / steps
        if gap <= 0:
            time = min(time, number / steps)
        elif contact[9] > 0 and gap < closing:  # the solver brakes
            time = min(time, (number + gap / closing) / steps)
    if time < 1:
        break
else:
    pybullet.performCollisionDetection()
    if any(contact[8] <= extra for contact in pybullet.getContactPoints(mover, rest)):
        time = 1.0
print("hit =", float(time <= 1))
print("t =", repr(time))
"""


def step_script(A: Kind, row_a: Row, B: Kind, row_b: Row, stepping: Stepping) -> str:
    """Write the script of one scene, with the calls that `SteppedWorld.step` makes; needs pybullet only."""
    scene = going(A, row_a, B, row_b, stepping)
    mover, rest, mover_is_a = scene.mover, scene.rest, A is not HalfSpace
    body = BODIES.format(
        mover_name="ba"[mover_is_a],
        rest_name="ab"[mover_is_a],
        step=scene.duration / stepping.steps,
        mover=shape_text(mover),
        mover_stands=f"{mover.position!r}, {mover.orientation!r}",
        rest=shape_text(rest),
        rest_stands=f"{rest.position!r}, {rest.orientation!r}",
        maximal=stepping.swept,
        dynamics=_arguments(dynamics(mover, 1.0, stepping)),
        dynamics_at_rest=_arguments(dynamics(rest, 0.0, stepping)),
        velocity=scene.velocity,
        way=scene.way,
        steps=stepping.steps,
        extra=mover.extra,
    )
    return SCRIPT.format(query="sweep, by steps,", A=A.__name__, B=B.__name__, body=body)


def _arguments(values: dict[str, Any]) -> str:
    return "".join(f", {name}={value!r}" for name, value in values.items())
