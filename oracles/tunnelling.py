"""How often a fast ball gets through a thin wall unseen, by speed, thickness and time step, and by who looks.

A ball flies straight at a wall. Whether steps see it depends on the moment within a step at which it would arrive, so
many such moments are tried. To tunnel is, for a detector, to report no contact in any time step; for a simulation, to
end behind the wall.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

import refimpl
from oracles.engines.bullet_world import import_bullet
from oracles.engines.fcl_engine import FclEngine
from refimpl import AABB, Sphere, Translation
from refimpl.linear import Array
from refimpl.sweeps import stepped

TIME_STEPS = (1 / 240, 1 / 60, 1 / 10)
THICKNESSES = (0.01, 0.1)
SPEEDS = (3.0, 10.0, 30.0, 90.0)
"""Below 100, to which Bullet clamps velocities."""
RADIUS, HALF_SIDE = 0.05, 1.0
MOMENTS = 16
"""Moments within a step at which the ball arrives, evenly spaced."""
BESIDE = (0.01, 0.02)
"""Where on the wall the ball aims, beside its centre."""


class Flight(NamedTuple):
    """A ball's way to a wall and, if nothing stops it, past it."""

    time_step: float
    thickness: float
    speed: float

    @property
    def advance(self) -> float:
        """Way of a step."""
        return self.speed * self.time_step

    @property
    def overlap(self) -> float:
        """Way on which the ball and the wall overlap."""
        return self.thickness + 2 * RADIUS

    @property
    def steps(self) -> int:
        """So many that the ball would be behind the wall after them."""
        return 3 + math.ceil(self.overlap / self.advance)

    @property
    def starts(self) -> Array:
        """Places along the flight, one for each moment of arrival, which is in the second step."""
        moments = (np.arange(MOMENTS) + 0.5) / MOMENTS
        return np.asarray(-self.overlap / 2 - self.advance * (1 + moments))


Watch = Callable[[Flight], float]
"""Share of the moments of arrival at which the ball tunnels."""


@dataclass(frozen=True)
class Tunnelling:
    """Shares of the moments of arrival at which the ball tunnels.

    Attributes
    ----------
    flights : n of them
    shares : by who looks, (n,)
    """

    flights: tuple[Flight, ...]
    shares: dict[str, Array]


def expected(flight: Flight) -> float:
    """Share of all moments at which no step falls into the way of the overlap."""
    return max(0.0, 1 - flight.overlap / flight.advance)


def pushed_through(flight: Flight) -> float:
    """Share of all moments at which no step falls into the first half of the overlap, out of which the way is back."""
    return max(0.0, 1 - flight.overlap / 2 / flight.advance)


def _scene(flight: Flight) -> tuple[Sphere, AABB]:
    centres = np.column_stack([flight.starts, *np.broadcast_to(np.array(BESIDE)[:, None], (2, MOMENTS))])
    half = [flight.thickness / 2, HALF_SIDE, HALF_SIDE]
    return Sphere(centres, np.full(MOMENTS, RADIUS)), AABB(np.negative(half), half)


def by_stepping(flight: Flight) -> float:
    """Reference, static: `intersect` after each step."""
    way = Translation([flight.advance * flight.steps, 0, 0])
    return float(np.mean(~stepped(*_scene(flight), way, steps=flight.steps).hit))


def by_sweep(flight: Flight) -> float:
    """Reference, dynamic: `sweep` over all of the way."""
    way = Translation([flight.advance * flight.steps, 0, 0])
    return float(np.mean(~refimpl.sweep(*_scene(flight), way).hit))


@contextmanager
def bullet(swept: bool, maximal: bool) -> Iterator[Watch]:
    """PyBullet, without its damping: as it comes, with a swept sphere of the ball's radius, in maximal coordinates."""
    engine = import_bullet()
    client = engine.connect(engine.DIRECT)

    def watch(flight: Flight) -> float:
        ball = _bullet_world(engine, client, flight, swept, maximal)
        ends = []
        for start in flight.starts.tolist():
            engine.resetBasePositionAndOrientation(ball, [start, *BESIDE], [0, 0, 0, 1], physicsClientId=client)
            engine.resetBaseVelocity(ball, [flight.speed, 0, 0], [0, 0, 0], physicsClientId=client)
            for _ in range(flight.steps):
                engine.stepSimulation(physicsClientId=client)
            ends.append(engine.getBasePositionAndOrientation(ball, physicsClientId=client)[0][0])
        return float(np.mean(np.array(ends) > 0))

    try:
        yield watch
    finally:
        engine.disconnect(client)


def _bullet_world(engine: Any, client: int, flight: Flight, swept: bool, maximal: bool) -> int:
    engine.resetSimulation(physicsClientId=client)
    engine.setGravity(0, 0, 0, physicsClientId=client)
    engine.setTimeStep(flight.time_step, physicsClientId=client)
    half = [flight.thickness / 2, HALF_SIDE, HALF_SIDE]
    wall = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=half, physicsClientId=client)
    ball = engine.createCollisionShape(engine.GEOM_SPHERE, radius=RADIUS, physicsClientId=client)
    engine.createMultiBody(0.0, wall, useMaximalCoordinates=maximal, physicsClientId=client)
    body = engine.createMultiBody(1.0, ball, useMaximalCoordinates=maximal, physicsClientId=client)
    engine.changeDynamics(body, -1, linearDamping=0, physicsClientId=client)  # it grows with the speed: 90 soon is 31
    if swept:
        engine.changeDynamics(body, -1, ccdSweptSphereRadius=RADIUS, physicsClientId=client)
    return int(body)


def fcl(solver: str, motion: str) -> Watch:
    """FCL's `continuousCollide`, asked for each time step, with its default of 10 iterations."""
    FclEngine().warm()
    import fcl as engine  # noqa: PLC0415  an optional package, and it is there

    request = engine.ContinuousCollisionRequest(
        ccd_solver_type=getattr(engine.CCDSolverType, f"CCDC_{solver}"),
        ccd_motion_type=getattr(engine.CCDMotionType, f"CCDM_{motion}"),
    )
    ball, rest = engine.Sphere(RADIUS), engine.Transform(np.zeros(3))

    def watch(flight: Flight) -> float:
        wall = engine.CollisionObject(engine.Box(flight.thickness, 2 * HALF_SIDE, 2 * HALF_SIDE), rest)

        def seen(x: float) -> bool:
            start, end = (engine.Transform(np.array([place, *BESIDE])) for place in (x, x + flight.advance))
            result = engine.ContinuousCollisionResult()
            engine.continuousCollide(engine.CollisionObject(ball, start), end, wall, rest, request, result)
            return bool(result.is_collide)

        tunnelled = [
            not any(seen(start + k * flight.advance) for k in range(flight.steps)) for start in flight.starts.tolist()
        ]
        return float(np.mean(tunnelled))

    return watch


def measured() -> Tunnelling:
    """Let the ball fly in all ways, watched by all.

    Raises
    ------
    EngineUnavailable
        When PyBullet or python-fcl is not installed.
    """
    flights = tuple(Flight(*numbers) for numbers in product(TIME_STEPS, THICKNESSES, SPEEDS))
    watches = {
        "stepping": by_stepping,
        "`sweep`": by_sweep,
        "FCL, naive": fcl("NAIVE", "TRANS"),
        "FCL, advancing": fcl("CONSERVATIVE_ADVANCEMENT", "TRANS"),
        "FCL, advancing along a screw": fcl("CONSERVATIVE_ADVANCEMENT", "SCREW"),
    }
    shares = {name: np.array([watch(flight) for flight in flights]) for name, watch in watches.items()}
    for name, swept, maximal in (
        ("PyBullet", False, False),
        ("PyBullet, CCD", True, False),
        ("PyBullet, CCD, maximal coordinates", True, True),
    ):
        with bullet(swept, maximal) as watch:
            shares[name] = np.array([watch(flight) for flight in flights])
    return Tunnelling(flights, shares)
