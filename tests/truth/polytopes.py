"""Signed distance of two convex polytopes in exact arithmetic, whatever their dimension.

The least h(n) = h_A(n) + h_B(−n) over unit n is found at a facet's normal, at the cross product of two edges, at right
angles to an edge and towards a corner, or from corner to corner (`tests.truth.cells`): each is tried.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from tests.truth.bodies import Body
from tests.truth.cells import Search, straight_directions, units
from tests.truth.rationals import dot, whole

ROUNDING = 1e-12
"""More than what doubles can err by in h, relative to the scene: who is this close to the least is tried exactly."""


def straight_distance(a: Body, b: Body) -> Fraction:
    """Signed square σ·|σ| of the signed distance of two polytopes without their radii."""
    directions = straight_directions(a, b)
    if not directions:
        return Fraction(0)
    n = units(directions)
    search = Search.of(a, b)
    up, down = search.height(n), search.height(-n)
    least = min(up.min(), down.min()) + ROUNDING
    numbers, unit = whole([*a.points, *b.points])
    of_a, of_b = numbers[: len(a.points)], numbers[len(a.points) :]
    squares = []
    for i in np.flatnonzero((up <= least) | (down <= least)):
        d = directions[i]
        along_a, along_b = [dot(p, d) for p in of_a], [dot(q, d) for q in of_b]
        for h in (max(along_a) - min(along_b), max(along_b) - min(along_a)):
            squares.append(Fraction(h * abs(h), dot(d, d)))
    return -min(squares) / unit**2
