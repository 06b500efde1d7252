"""A small engine that is right about impacts, and others made from it that are wrong on purpose, each in one way."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from oracles.engine import (
    NATIVE,
    VELOCITIES,
    AnswerRow,
    Array,
    Engine,
    Kind,
    Row,
    Solver,
    Support,
    Tolerance,
    answer_row,
    unsupported,
)
from oracles.motion import WIDTH, Motion, Moving


class Impulses(Engine):
    """One impulse at the contact: Newton's restitution, and Coulomb's friction on balls, by 3 × 3 matrices."""

    name: ClassVar[str] = "impulses"

    def versions(self) -> dict[str, str]:
        return {"impulses": "1.0"}

    def warm(self) -> None:
        pass

    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        return unsupported("impacts only")

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        return NATIVE

    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        return frozenset(VELOCITIES)

    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        return Tolerance.uniform(0.0, 1e-12, "closed forms")

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        self.require(query, A, B)
        return lambda a, b: self.meet(Motion.unpack(np.array(a[-WIDTH:])))

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        return (
            f"import numpy as np\n\nfrom oracles.motion import Motion\nfrom {__name__} import {type(self).__name__}\n\n"
            f"print({type(self).__name__}().meet(Motion.unpack(np.array({row_a[-WIDTH:]!r}))))\n"
        )

    def meet(self, motion: Motion) -> AnswerRow:
        """Velocities after; the others go wrong in what is called here."""
        if self.closing(motion) >= 0:
            return told(motion.a, motion.b)
        impulse = self.impulse(motion)
        return told(self.pushed(motion.a, motion.point, -impulse), self.pushed(motion.b, motion.point, impulse))

    def closing(self, motion: Motion) -> float:
        return float(motion.closing)

    def impulse(self, motion: Motion) -> Array:
        n = motion.normal / np.linalg.norm(motion.normal)
        u = motion.approach
        give = gives(motion.a, motion.point) + gives(motion.b, motion.point)
        stop = -(n @ u) / (n @ give @ n) * n
        along = (1 + self.restitution(motion)) * stop
        if motion.friction == 0:
            return np.asarray(along)
        toward = -np.linalg.solve(give, u) - stop
        return np.asarray(along + self.share(along, toward, n, float(motion.friction)) * toward)

    def restitution(self, motion: Motion) -> float:
        return float(motion.restitution)

    def share(self, along: Array, toward: Array, n: Array, friction: float) -> float:
        """The largest share of `toward`, from 0 to 1, with which the impulse stays in the cone."""
        side = float(np.linalg.norm(np.cross(n, toward)))
        needed = side - friction * (n @ toward)
        return min(1.0, friction * (n @ along) / needed) if needed > 0 else 1.0

    def pushed(self, body: Moving, point: Array, impulse: Array) -> Moving:
        if body.inverse_mass == 0:
            return body
        turn = np.linalg.solve(body.inertia, np.cross(self.lever(body, point), impulse))
        velocity = body.velocity + body.inverse_mass * impulse
        return replace(body, velocity=velocity, angular_velocity=body.angular_velocity + turn)

    def lever(self, body: Moving, point: Array) -> Array:
        return np.asarray(point - body.position)


def gives(body: Moving, point: Array) -> Array:
    """Change of the velocity at a point by an impulse there."""
    if body.inverse_mass == 0:
        return np.zeros((3, 3))
    r = point - body.position
    cross = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    return np.asarray(body.inverse_mass * np.eye(3) - cross @ np.linalg.solve(body.inertia, cross))


def told(a: Moving, b: Moving) -> AnswerRow:
    """Answer the velocities of both."""
    return answer_row(
        velocity_a=a.velocity, angular_a=a.angular_velocity, velocity_b=b.velocity, angular_b=b.angular_velocity
    )


class WrongSign(Impulses):
    """Takes the normal for one from B to A: bodies that meet attract each other."""

    def impulse(self, motion: Motion) -> Array:
        return -super().impulse(motion)


class AlwaysElastic(Impulses):
    """Does not know of the restitution."""

    def restitution(self, motion: Motion) -> float:
        return 1.0


class NeverElastic(Impulses):
    def restitution(self, motion: Motion) -> float:
        return 0.0


class SwappedMasses(Impulses):
    """Gives each body the other's inverse mass when it applies the impulse."""

    def meet(self, motion: Motion) -> AnswerRow:
        if self.closing(motion) >= 0:
            return told(motion.a, motion.b)
        impulse = self.impulse(motion)
        a, b = motion.a, motion.b
        after_a = self.pushed(replace(a, inverse_mass=b.inverse_mass), motion.point, -impulse)
        after_b = self.pushed(replace(b, inverse_mass=a.inverse_mass), motion.point, impulse)
        return told(after_a, after_b)


class NoLever(Impulses):
    """Applies every impulse at the centre of mass, and so never spins anything."""

    def lever(self, body: Moving, point: Array) -> Array:
        return np.zeros(3)


class StickyFriction(Impulses):
    """Stops all sliding, whatever the friction."""

    def share(self, along: Array, toward: Array, n: Array, friction: float) -> float:
        return 1.0


class NoFriction(Impulses):
    def share(self, along: Array, toward: Array, n: Array, friction: float) -> float:
        return 0.0


class Stale(Impulses):
    """Reads the velocities before the step."""

    def meet(self, motion: Motion) -> AnswerRow:
        return told(motion.a, motion.b)


class Eager(Impulses):
    """Has bodies bounce that already part."""

    def closing(self, motion: Motion) -> float:
        return -1.0


class Pushover(Impulses):
    """Takes what is immovable for as heavy as the other body."""

    def meet(self, motion: Motion) -> AnswerRow:
        a, b = motion.a, motion.b
        if a.inverse_mass == 0:
            a = replace(a, inverse_mass=b.inverse_mass, inertia=b.inertia)
        if b.inverse_mass == 0:
            b = replace(b, inverse_mass=a.inverse_mass, inertia=a.inertia)
        return super().meet(replace(motion, a=a, b=b))


class Silent(Impulses):
    """Does not tell the angular velocities."""

    def meet(self, motion: Motion) -> AnswerRow:
        return answer_row(velocity_a=motion.a.velocity, velocity_b=motion.b.velocity)


class LongLever(Impulses):
    """Measures levers to half as far again as the contact."""

    def lever(self, body: Moving, point: Array) -> Array:
        return np.asarray(1.5 * (point - body.position))


LIARS: tuple[type[Impulses], ...] = (
    WrongSign,
    AlwaysElastic,
    NeverElastic,
    SwappedMasses,
    NoLever,
    StickyFriction,
    NoFriction,
    Stale,
    Eager,
    Pushover,
    Silent,
    LongLever,
)


def spec(engine: type[Engine]) -> str:
    """Name of one of these engines for `load_engine`."""
    return f"{__name__}:{engine.__name__}"
