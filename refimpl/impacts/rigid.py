"""Impacts of rigid bodies at a point: impulses through the effective mass.

An impulse P at a point that lies r from the centre of mass changes the velocity there by K P, with
K = w 1 − [r] I⁻¹ [r], where w is the inverse mass, I the inertia tensor, and [r] v = r × v. What matters is the sum K
of both bodies, for u = v_b − v_a at the point changes by K P when B receives P and A receives −P.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from refimpl.impacts.bodies import Moving, RigidBody, moving
from refimpl.impacts.definite import Factors, factors
from refimpl.impacts.evaluating import DIRECTION, IMPULSE, LENGTH, PURE, SPEED, TURNING, Given, Unit, evaluate
from refimpl.impacts.friction import SIGN_BITS, share_in_cone
from refimpl.impacts.numbers import IDENTITY, LAST, NEXT, Numbers, choose, cross, dot, known, quotient, rough, stack
from refimpl.impacts.reading import Array, at_least_zero, direction, real, share
from refimpl.linear import Bools


@dataclass(frozen=True)
class BodyImpact:
    """Outcome of an impact of rigid bodies.

    Attributes
    ----------
    a, b : RigidBody
        After the impact, where they were.
    impulse : (..., 3), mass · velocity
        What B receives at the point, and A with the opposite sign.
    sticks : (...) bool
        Whether friction ends the sliding there; false without friction.
    """

    a: RigidBody
    b: RigidBody
    impulse: Array
    sticks: Bools


def impact_of_bodies(
    a: RigidBody, b: RigidBody, point: Any, normal: Any, restitution: Any, friction: Any = 0
) -> BodyImpact:
    """Impact of two rigid bodies at a point, with restitution and Coulomb friction.

    Without friction P = −(1 + e) (n·u) / (n·K n) n. With friction the law is that of Chatterjee and Ruina (A New
    Algebraic Rigid-Body Collision Law Based on Impulse Space Considerations, 1998): from
    P_I = −(n·u) / (n·K n) n, which ends the approach, and P_II = −K⁻¹ u, which ends sliding as well, it takes
    P = (1 + e) P_I + κ (P_II − P_I), with κ = 1 if that lies in the friction cone, else the largest κ that does.
    Both change n·u alike, so the normal velocity is reversed by −e exactly. And as P_I and P_II − P_I are orthogonal
    in K, the energy is a sum of two parabolas, of the shares 1 + e and κ, each lowest at 1: it is never gained. The
    usual way, Newton's e with an impulse that stops all sliding, can gain energy (Kane's paradox).

    Parameters
    ----------
    a, b : RigidBody
    point : (..., 3)
        Where they touch.
    normal : (..., 3)
        From A to B, of any length but 0.
    restitution : (...), from 0 to 1
        The e in n·u′ = −e n·u.
    friction : (...), at least 0
        Coulomb's μ. Bodies that do not approach (n·u ≥ 0) do not press on each other, and nothing rubs; the formula
        without friction applies whatever the sign.

    Raises
    ------
    ShapeError
        A ValueError that names the argument and the value.

    Notes
    -----
    Two immovable bodies keep their velocities, and the impulse is 0.
    """
    given = {
        **a.motion("_a"),
        **a.matter("_a"),
        **b.motion("_b"),
        **b.matter("_b"),
        "point": Given(real("point", point, 3), LENGTH, 1),
        "n": Given(direction("normal", normal), DIRECTION, 1),
        "e": Given(share("restitution", restitution), PURE),
        "mu": Given(at_least_zero("friction", friction), PURE),
    }
    va, spin_a, vb, spin_b, impulse, sticks = evaluate(_impact, given, (SPEED, TURNING, SPEED, TURNING, IMPULSE, None))
    return BodyImpact(a.with_velocities(va, spin_a), b.with_velocities(vb, spin_b), impulse, sticks.astype(bool))


def approach(a: RigidBody, b: RigidBody, point: Any, normal: Any) -> Array:
    """n·(v_b − v_a) at a point (...), with n of any length: negative, exactly, where the bodies approach."""
    given = {
        **a.motion("_a"),
        **a.matter("_a"),
        **b.motion("_b"),
        **b.matter("_b"),
        "point": Given(real("point", point, 3), LENGTH, 1),
        "n": Given(direction("normal", normal), LENGTH, 1),
    }
    return evaluate(_approach, given, (Unit(speed=1, length=1),))[0]


class Touched(NamedTuple):
    """A body seen from a point: its inverse mass w, the lever arm r to the point, and its inertia in factors."""

    w: Numbers
    lever: Numbers
    inertia: Factors

    def turn(self, impulse: Numbers) -> Numbers:
        """Change of its angular velocity by an impulse at the point: I⁻¹ (r × P)."""
        return self.inertia.solve(cross(self.lever, impulse))

    def give(self) -> Numbers:
        """Matrix K (3, 3, n): change of the velocity at the point by an impulse there, w P + I⁻¹ (r × P) × r."""
        x, y, z = (self.lever[i] for i in range(3))
        none = 0 * x
        arms = stack([stack([none, -z, y]), stack([z, none, -x]), stack([-y, x, none])])
        turns = self.inertia.solve(arms)
        columns = stack([cross(turns[:, i], self.lever) for i in range(3)])  # and rows: it is symmetric
        return self.w * IDENTITY + columns


def touched(body: Moving, point: Numbers) -> Touched:
    """See a body from a point; an impulse on an immovable one has no lever to turn it."""
    fixed = np.asarray(body.w == 0, dtype=bool)
    return Touched(body.w, choose(fixed, 0, point - body.position), factors(choose(fixed, IDENTITY, body.inertia)))


def _relative(a: Moving, b: Moving, point: Numbers, n: Numbers) -> tuple[Numbers, Numbers]:
    """Relative velocity u at the point, and n·u, of a known sign."""
    arm_a, arm_b = point - a.position, point - b.position
    u = (b.velocity + cross(b.spin, arm_b)) - (a.velocity + cross(a.spin, arm_a))
    terms = (rough(b.velocity) + _spread(b.spin, arm_b)) + (rough(a.velocity) + _spread(a.spin, arm_a))
    return u, known(dot(n, u), dot(rough(n), terms), SIGN_BITS)


def _spread(u: Numbers, v: Numbers) -> Any:
    """Sizes of what a vector product subtracts."""
    x, y = rough(u), rough(v)
    return x[NEXT] * y[LAST] + x[LAST] * y[NEXT]


def _approach(point: Numbers, n: Numbers, **bodies: Numbers) -> tuple[Numbers]:
    return (_relative(moving(bodies, "_a"), moving(bodies, "_b"), point, n)[1],)


def _impact(point: Numbers, n: Numbers, e: Numbers, mu: Numbers, **bodies: Numbers) -> tuple[Numbers, ...]:
    of_a, of_b = moving(bodies, "_a"), moving(bodies, "_b")
    a, b = touched(of_a, point), touched(of_b, point)
    u, approach = _relative(of_a, of_b, point, n)
    turn_a, turn_b = a.turn(n), b.turn(n)
    turning = dot(cross(a.lever, n), turn_a) + dot(cross(b.lever, n), turn_b)
    stop = -quotient(dot(n, u), (a.w + b.w) * dot(n, n) + turning)
    size = (1 + e) * stop
    impulse, turn_a, turn_b = size * n, size * turn_a, size * turn_b
    sticks = np.zeros(u.shape[-1], dtype=bool)
    rubs = np.asarray((mu > 0) & (a.w + b.w > 0), dtype=bool)
    if rubs.any():
        k = choose(rubs, a.give() + b.give(), IDENTITY)
        toward = factors(k).solve(-u) - stop * n
        sticks, kappa = share_in_cone(approach, n, impulse, toward, mu, ~rubs)
        more = choose(rubs, kappa * toward, 0)
        impulse, turn_a, turn_b = impulse + more, turn_a + a.turn(more), turn_b + b.turn(more)
    return (
        of_a.velocity - a.w * impulse,
        of_a.spin - turn_a,
        of_b.velocity + b.w * impulse,
        of_b.spin + turn_b,
        impulse,
        sticks,
    )
