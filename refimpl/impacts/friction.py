"""Coulomb's friction of an impact: the impulse lies in the cone |parallel part| ≤ μ · normal part."""

from __future__ import annotations

import numpy as np

from refimpl.impacts.numbers import Numbers, choose, cross, dot, known, quotient, root_above, rough
from refimpl.linear import Bools

SIGN_BITS = 90
"""A difference smaller than its terms by more bits than these has no certain sign, and is left to fractions."""
DIVISOR_BITS = 40
"""The same of a divisor, which has to have digits as well."""


def share_in_cone(
    approach: Numbers, n: Numbers, impulse: Numbers, toward: Numbers, mu: Numbers, fixed: Bools
) -> tuple[Bools, Numbers]:
    """Find how far an impulse may go from the axis of the friction cone toward another impulse.

    Parameters
    ----------
    approach : (n)
        n·u before the impact, of a `known` sign. Bodies that do not approach (n·u ≥ 0) do not press on each other.
    n : (3, n)
        Normal from A to B, the axis of the cone, of any length.
    impulse : (3, n)
        On B without friction: along n.
    toward : (3, n)
        What is added to the impulse, if the cone allows.
    mu : (n)
    fixed : (n) bool
        Whether both bodies are immovable: there is no impulse.

    Returns
    -------
    sticks : (n) bool
        Whether there is friction, and impulse + toward lies in the cone.
    kappa : (n)
        The largest κ from 0 to 1 with impulse + κ · toward in the cone; 0 without friction. In fractions rounded
        down, so that it is inside exactly.
    """
    rubs = np.asarray(mu > 0, dtype=bool) & ~fixed
    pressed = rubs & np.asarray(approach < 0, dtype=bool)
    aside = cross(n, toward)  # |n × Q| = |n| · |parallel part of Q|, and n·Q = |n| · normal part: |n| cancels
    square, normal, gain = dot(aside, aside), mu * dot(n, impulse), mu * dot(n, toward)
    bound = normal + gain
    slack = known(bound * bound - square, rough(normal) ** 2 + rough(gain) ** 2 + rough(square), SIGN_BITS)
    sticks = pressed & np.asarray(bound >= 0, dtype=bool) & np.asarray(slack >= 0, dtype=bool)
    slips = pressed & ~sticks
    root = root_above(choose(slips, square, 0))
    kappa = choose(slips, quotient(normal, known(root - gain, rough(root) + rough(gain), DIVISOR_BITS)), 0)
    doubt = 0 * approach + choose(pressed, 0 * slack, 0)  # not a number where a sign above is not known
    return sticks, choose(sticks, 1, kappa) + choose(rubs, doubt, 0)
