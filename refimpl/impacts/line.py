"""Impacts on a line: two bodies with masses and signed velocities, no rotation.

The impulse acts along + on B and along − on A. That the bodies meet is the caller's knowledge: the formulas apply as
they are, whichever way the velocities point. All arguments broadcast, and fractions give fractions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from refimpl.impacts.evaluating import IMPULSE, INVERSE_MASS, PURE, SPEED, Given, evaluate
from refimpl.impacts.numbers import Numbers, quotient
from refimpl.impacts.reading import Array, at_least_zero, real, share


@dataclass(frozen=True)
class LineImpact:
    """Outcome of an impact on a line.

    Attributes
    ----------
    velocity_a, velocity_b : (...)
        After the impact.
    impulse : (...), mass · velocity
        What B receives, and A with the opposite sign. Infinite where no double can hold it.
    """

    velocity_a: Array
    velocity_b: Array
    impulse: Array


def impact_on_line(
    velocity_a: Any, velocity_b: Any, inverse_mass_a: Any, inverse_mass_b: Any, restitution: Any
) -> LineImpact:
    """Impact with a coefficient of restitution: the bodies part with e times the speed of approach.

    Parameters
    ----------
    velocity_a, velocity_b : (...)
        Before the impact.
    inverse_mass_a, inverse_mass_b : (...), at least 0
        0 is the immovable body. If both are, nothing can be exchanged: the velocities stay and the impulse is 0.
    restitution : (...), from 0 to 1
        The e in v_b′ − v_a′ = −e (v_b − v_a).

    Raises
    ------
    ShapeError
        A ValueError: negative inverse mass, e outside of [0, 1], numbers that are not finite.
    """
    given = {
        "va": Given(real("velocity_a", velocity_a), SPEED),
        "vb": Given(real("velocity_b", velocity_b), SPEED),
        "wa": Given(at_least_zero("inverse_mass_a", inverse_mass_a), INVERSE_MASS),
        "wb": Given(at_least_zero("inverse_mass_b", inverse_mass_b), INVERSE_MASS),
        "e": Given(share("restitution", restitution), PURE),
    }
    return LineImpact(*evaluate(impact, given, (SPEED, SPEED, IMPULSE)))


def elastic_on_line(velocity_a: Any, velocity_b: Any, inverse_mass_a: Any, inverse_mass_b: Any) -> LineImpact:
    """Completely elastic impact, e = 1: kinetic energy is kept. Equal masses swap their velocities."""
    return impact_on_line(velocity_a, velocity_b, inverse_mass_a, inverse_mass_b, 1)


def inelastic_on_line(velocity_a: Any, velocity_b: Any, inverse_mass_a: Any, inverse_mass_b: Any) -> LineImpact:
    """Completely inelastic impact, e = 0: both go on with the velocity of their centre of mass."""
    return impact_on_line(velocity_a, velocity_b, inverse_mass_a, inverse_mass_b, 0)


def impact(va: Numbers, vb: Numbers, wa: Numbers, wb: Numbers, e: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """P = −(1 + e) (v_b − v_a) / (w_a + w_b), with inverse masses w; v_a′ = v_a − w_a P, v_b′ = v_b + w_b P."""
    impulse = quotient(-(1 + e) * (vb - va), wa + wb)
    return va - wa * impulse, vb + wb * impulse, impulse
