"""Bullet as it is stepped: sweeps by its simulation, with and without continuous detection.

A way without rotation is taken in time steps, and the answer is what the steps come to know. On PyBullet 3.2.7:

- Without more, it is static detection: what is not there where a step begins, nor within 0.02 of it, goes unseen. The
  time is that of a step's beginning. The solver brakes for the planes of contacts across a gap, which reach farther
  than bodies do: what passes at a gap of up to 0.02 may count as met.
- `ccdSweptSphereRadius` sends a sphere ahead on the way of a step, and the time is that at which it arrives, to 0.001.
  It counts for bodies made with `useMaximalCoordinates`, on ways longer than half its radius, and where it comes to
  approach what it meets by more than `allowedCcdPenetration`, 0.04.
"""

from __future__ import annotations

import math
from importlib import metadata
from typing import ClassVar

from oracles.engine import NATIVE, Bound, Engine, Kind, Row, Solver, Support, Tolerance, emulated, unsupported
from oracles.engines.bullet_shapes import MARGIN
from oracles.engines.bullet_steps import PENETRATION, THINNEST, SteppedWorld, Stepping, step_script
from oracles.engines.bullet_world import import_bullet
from oracles.scene import SWEEP
from refimpl.shapes import AABB, Box, Capsule, ConvexPolyhedron, Cylinder, HalfSpace, Point, Sphere

KINDS = (Point, Sphere, Capsule, HalfSpace, AABB, Box, Cylinder, ConvexPolyhedron)
BREAKING = 0.02
"""`contactBreakingThreshold`: contacts across smaller gaps are kept."""
EXACT = 1e-9
"""Rounding, relative to the largest coordinate."""
AS_BALL = f"a Point is a sphere of radius {THINNEST:g}, which is taken off the answer"
STEPS = 16


class BulletStepping(Engine):
    """Bullet taking a way in 16 time steps."""

    name: ClassVar[str] = "bullet-stepping"
    stepping: ClassVar[Stepping] = Stepping(STEPS, swept=False)
    movers: ClassVar[tuple[Kind, ...]] = KINDS
    near: ClassVar[float] = BREAKING + 2 * MARGIN
    """Gap, or depth, at which hit and miss are both right."""
    late: ClassVar[float] = 2 * math.sqrt(3) / STEPS
    """What a step of a way may come to, relative to the largest coordinate of both motions."""
    promise: ClassVar[str] = "contacts are looked for by steps of 1/16 of the way, and kept across gaps of 0.02"

    def __init__(self) -> None:
        self._world: SteppedWorld | None = None

    def versions(self) -> dict[str, str]:
        """Version of the binding, whose wheel contains the library."""
        return {"pybullet": metadata.version("pybullet")}

    def warm(self) -> None:
        """Import pybullet."""
        import_bullet()

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        del query, A, B
        return unsupported("steps are for sweeps: the engine bullet answers the rest")

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        if A is B is HalfSpace:
            return unsupported("Bullet has no algorithm for two planes and never reports anything")
        if A not in KINDS or B not in KINDS:
            return unsupported(f"bodies of one convex shape are stepped: {', '.join(kind.__name__ for kind in KINDS)}")
        if A not in self.movers:
            return unsupported("only of a ball is the swept sphere all of the body that moves")
        return emulated(AS_BALL) if Point in (A, B) else NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Name the columns of an answer; the point of a swept sphere's contact is that of the body's centre."""
        del query, A, B
        return frozenset({"hit", "t"})

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give the way of a step, and the gap across which contacts are kept."""
        del query, A, B
        near = Bound(self.near, EXACT)
        return Tolerance(Bound(self.near, self.late), near, near, self.promise)

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Answer one scene in 0.5 ms."""
        self.require(query, A, B)
        self._world = self._world or SteppedWorld(self.stepping)
        return self._world.solver(A, B)

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Write the script of one scene; needs pybullet only."""
        self.require(query, A, B)
        assert query == SWEEP
        return step_script(A, row_a, B, row_b, self.stepping)


class BulletSwept(BulletStepping):
    """Bullet taking a way in one time step, with a swept sphere."""

    name: ClassVar[str] = "bullet-ccd"
    stepping: ClassVar[Stepping] = Stepping(1, swept=True)
    movers: ClassVar[tuple[Kind, ...]] = (Point, Sphere)
    near: ClassVar[float] = PENETRATION + 2 * MARGIN
    late: ClassVar[float] = EXACT
    promise: ClassVar[str] = "the swept sphere is looked after where it gets nearer by 0.04 or more, and stops at 0.001"
