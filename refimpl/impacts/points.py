"""Impacts of particles in space: a velocity has a part normal to the impact plane, and one parallel to it.

The normal parts meet as on a line. The parallel parts stay as they are, unless there is friction. The plane's normal
may have any length but 0: the formulas divide by n·n instead of taking a root. All arguments broadcast, and fractions
give fractions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.fields import ShapeError
from refimpl.impacts import line
from refimpl.impacts.evaluating import DIRECTION, IMPULSE, INVERSE_MASS, PURE, SPEED, Given, evaluate
from refimpl.impacts.friction import SIGN_BITS, share_in_cone
from refimpl.impacts.numbers import Numbers, dot, known, quotient, rough
from refimpl.impacts.reading import Array, at_least_zero, direction, real, share


@dataclass(frozen=True)
class ParticleImpact:
    """Outcome of an impact of two particles.

    Attributes
    ----------
    velocity_a, velocity_b : (..., 3)
        After the impact.
    impulse : (..., 3), mass · velocity
        What B receives, and A with the opposite sign. Infinite where no double can hold it.
    """

    velocity_a: Array
    velocity_b: Array
    impulse: Array


def split(velocity: Any, normal: Any) -> tuple[Array, Array]:
    """Split velocities into their parts normal and parallel to a plane.

    Parameters
    ----------
    velocity : (..., 3)
    normal : (..., 3)
        Of any length but 0.

    Returns
    -------
    normal part, parallel part : (..., 3)
        (v·n / n·n) n, and what remains of v.
    """
    given = {
        "v": Given(real("velocity", velocity, 3), SPEED, 1),
        "n": Given(direction("normal", normal), DIRECTION, 1),
    }
    along, across = evaluate(_split, given, (SPEED, SPEED))
    return along, across


def impact_of_particles(
    velocity_a: Any,
    velocity_b: Any,
    inverse_mass_a: Any,
    inverse_mass_b: Any,
    normal: Any,
    restitution: Any,
    *,
    damping: Any = 0,
    friction: Any = 0,
) -> ParticleImpact:
    """Impact of two particles with an impact plane.

    Parameters
    ----------
    velocity_a, velocity_b : (..., 3)
        Before the impact.
    inverse_mass_a, inverse_mass_b : (...), at least 0
        0 is the immovable body. If both are, nothing can be exchanged.
    normal : (..., 3)
        Of the impact plane, of any length but 0. With Coulomb friction it points from A to B: bodies that separate
        along it do not press on each other, and nothing rubs.
    restitution : (...), from 0 to 1
        Of the normal parts: n·(v_b′ − v_a′) = −e n·(v_b − v_a).
    damping : (...), from 0 to 1
        Friction as the share that is dumped of the parallel part of the relative velocity v_b − v_a; 1 dumps all of
        it. Momentum is kept: both bodies change, in the ratio of their inverse masses. On an immovable body at rest
        the other body loses this share of its own parallel velocity.
    friction : (...), at least 0
        Coulomb's μ: the parallel impulse ends the sliding, or is μ times the normal impulse if that is less.

    Raises
    ------
    ShapeError
        A ValueError: negative inverse mass or μ, e or damping outside of [0, 1], a zero normal, numbers that are not
        finite; damping and friction both positive.
    """
    lost, mu = share("damping", damping), at_least_zero("friction", friction)
    if np.any((lost > 0) & (mu > 0)):
        raise ShapeError("damping and friction: only one of them may be positive, they are two models of one thing")
    given = {
        **_particles(velocity_a, velocity_b, inverse_mass_a, inverse_mass_b),
        "n": Given(direction("normal", normal), DIRECTION, 1),
        "e": Given(share("restitution", restitution), PURE),
        "damping": Given(lost, PURE),
        "mu": Given(mu, PURE),
    }
    return ParticleImpact(*evaluate(_impact, given, (SPEED, SPEED, IMPULSE)))


def merge_particles(velocity_a: Any, velocity_b: Any, inverse_mass_a: Any, inverse_mass_b: Any) -> ParticleImpact:
    """Impact after which both particles go on as one, with the velocity of their centre of mass.

    Normal and parallel parts merge alike, so there is no impact plane. This is not e = 0, which leaves the parallel
    parts alone. An immovable body keeps its velocity, and the other takes it; two immovable bodies both keep theirs.

    Parameters
    ----------
    velocity_a, velocity_b : (..., 3)
    inverse_mass_a, inverse_mass_b : (...), at least 0
    """
    given = _particles(velocity_a, velocity_b, inverse_mass_a, inverse_mass_b)
    return ParticleImpact(*evaluate(_merge, given, (SPEED, SPEED, IMPULSE)))


def _particles(velocity_a: Any, velocity_b: Any, inverse_mass_a: Any, inverse_mass_b: Any) -> dict[str, Given]:
    return {
        "va": Given(real("velocity_a", velocity_a, 3), SPEED, 1),
        "vb": Given(real("velocity_b", velocity_b, 3), SPEED, 1),
        "wa": Given(at_least_zero("inverse_mass_a", inverse_mass_a), INVERSE_MASS),
        "wb": Given(at_least_zero("inverse_mass_b", inverse_mass_b), INVERSE_MASS),
    }


def _split(v: Numbers, n: Numbers) -> tuple[Numbers, Numbers]:
    along = dot(v, n) / dot(n, n) * n
    return along, v - along


def _impact(
    va: Numbers, vb: Numbers, wa: Numbers, wb: Numbers, n: Numbers, e: Numbers, damping: Numbers, mu: Numbers
) -> tuple[Numbers, Numbers, Numbers]:
    """The line's impulse along n, and across it what friction adds."""
    nn = dot(n, n)
    impulse = line.impact(dot(va, n) / nn, dot(vb, n) / nn, wa, wb, e)[2] * n
    u = vb - va
    stop = quotient(-1, wa + wb) * _split(u, n)[1]
    if np.any(mu > 0):
        approach = known(dot(n, u), dot(rough(n), rough(va) + rough(vb)), SIGN_BITS)
        damping = damping + share_in_cone(approach, n, impulse, stop, mu, np.asarray(wa + wb == 0, dtype=bool))[1]
    impulse = impulse + damping * stop
    return va - wa * impulse, vb + wb * impulse, impulse


def _merge(va: Numbers, vb: Numbers, wa: Numbers, wb: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    impulse = quotient(-1, wa + wb) * (vb - va)
    return va - wa * impulse, vb + wb * impulse, impulse
