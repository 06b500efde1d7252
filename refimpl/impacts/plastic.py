"""The perfectly plastic impact of rigid bodies: both go on as one.

Linear and angular momentum of the two together are kept; afterwards both turn alike, and their velocities match at
every point of space. It takes an impulse and an angular impulse: more than a contact at one point can give, as when the
bodies are glued or interlocked. It is not e = 0, which only ends the approach.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.impacts.bodies import RigidBody, moving
from refimpl.impacts.definite import factors
from refimpl.impacts.evaluating import ANGULAR_IMPULSE, IMPULSE, SPEED, TURNING, evaluate
from refimpl.impacts.numbers import IDENTITY, Numbers, apply, choose, cross, dot, quotient, stack
from refimpl.impacts.reading import Array


@dataclass(frozen=True)
class JoinedImpact:
    """Outcome of an impact after which two bodies are one.

    Attributes
    ----------
    a, b : RigidBody
        After the impact, where they were; they turn alike.
    impulse : (..., 3), mass · velocity
    angular_impulse : (..., 3), mass · length² / time
        What B receives at its centre of mass. A receives the opposite of both, at the same point of space.
    """

    a: RigidBody
    b: RigidBody
    impulse: Array
    angular_impulse: Array


def join_bodies(a: RigidBody, b: RigidBody) -> JoinedImpact:
    """Impact after which both bodies go on as one rigid body.

    An immovable body keeps its motion, and the other takes it as if it were a part of it. Two immovable bodies both
    keep theirs.

    Parameters
    ----------
    a, b : RigidBody
    """
    given = {**a.motion("_a"), **a.matter("_a"), **b.motion("_b"), **b.matter("_b")}
    va, spin_a, vb, spin_b, impulse, angular = evaluate(
        _join, given, (SPEED, TURNING, SPEED, TURNING, IMPULSE, ANGULAR_IMPULSE)
    )
    return JoinedImpact(a.with_velocities(va, spin_a), b.with_velocities(vb, spin_b), impulse, angular)


def _join(**bodies: Numbers) -> tuple[Numbers, ...]:
    """All moments are about the common centre of mass, which divides x_b − x_a as w_a : w_b."""
    a, b = moving(bodies, "_a"), moving(bodies, "_b")
    a_fixed, b_fixed = np.asarray(a.w == 0, dtype=bool), np.asarray(b.w == 0, dtype=bool)
    d, u = b.position - a.position, b.velocity - a.velocity
    reduced = quotient(1, a.w + b.w)
    inertia = (a.inertia + b.inertia) + reduced * (dot(d, d) * IDENTITY - stack([d[i] * d for i in range(3)]))
    momentum = (apply(a.inertia, a.spin) + apply(b.inertia, b.spin)) + reduced * cross(d, u)
    free = factors(choose(a_fixed | b_fixed, IDENTITY, inertia)).solve(momentum)
    spin = choose(a_fixed, a.spin, choose(b_fixed, b.spin, free))
    rising = cross(spin, d)  # what B's centre moves faster than A's
    impulse = reduced * (rising - u)
    of_a = -apply(a.inertia, spin - a.spin) - cross(d, impulse)
    of_b = apply(b.inertia, spin - b.spin)
    both = a_fixed & b_fixed
    return (
        a.velocity - a.w * impulse,
        spin,
        b.velocity + b.w * impulse,
        choose(both, b.spin, spin),
        impulse,
        choose(both, 0, choose(b_fixed, of_a, of_b)),
    )
