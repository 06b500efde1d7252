"""Claims about two bounded proxies of the plane z = 0: exact from beginning to end, in doubles where these do.

Apart, or touching, they are found as in space. Where the cores overlap, all sides of their Minkowski difference decide:
the nearest one is the way out, and its corners, one after the other, prove that there is no shorter one.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from refimpl.flat.corners import Place as Homogeneous
from refimpl.flat.corners import wrapped
from refimpl.proof.bodies import Corners
from refimpl.proof.claims import Claim, Core
from refimpl.proof.convex import Search
from refimpl.proof.points import Vector, cross, dot, minus
from refimpl.shapes import Proxy

UPWARDS: Vector = (0, 0, 1)


class Corner(NamedTuple):
    """A corner of A ⊖ B, and the numbers of the corners of A and B whose difference it is."""

    y: Vector
    i: int
    j: int


class FlatSearch(Search):
    """Two proxies of the plane, and the best claims about them so far."""

    def claims(self) -> tuple[Claim, ...]:
        """Search nearest features, and the sides of the difference."""
        self._features()
        if not self._done():
            self._sides()
        return tuple(claim for _, claim in (self.lower, self.upper) if claim is not None)

    def _sides(self) -> None:
        """Claim what the nearest side proves, and all corners; a segment or a point is left along any way across it."""
        a, b = self.bodies
        assert isinstance(a, Corners)
        assert isinstance(b, Corners)
        corners = difference_of(a, b)
        sides = [(corners[i - 1].y, corner.y) for i, corner in enumerate(corners)]
        if len(corners) == 1:
            self.across([(1, 0, 0)])
            return
        u, v = min(sides, key=lambda side: _square_height(*side))
        self.across([cross(minus(v, u), UPWARDS)])
        if len(corners) > 2:
            ends = (
                (self._place(0, a.corner(i), [(i, 1)]), self._place(1, b.corner(j), [(j, 1)])) for _, i, j in corners
            )
            self.propose_upper(Core(tuple(ends)))


def _square_height(u: Vector, v: Vector) -> Fraction:
    """Square of the distance of the line uv from 0."""
    edge, area = minus(v, u), cross(u, v)[2]
    return Fraction(area * area) / Fraction(dot(edge, edge))


def hull_of(points: list[Vector]) -> list[int]:
    """Numbers of the corners of the hull of points of the plane z = 0, anticlockwise."""
    numbers: dict[Homogeneous, int] = {}
    for i, (x, y, _) in enumerate(points):
        u, v = Fraction(x), Fraction(y)
        numbers[u.numerator * v.denominator, v.numerator * u.denominator, u.denominator * v.denominator] = i
    return [numbers[place] for place in wrapped(list(numbers))]


def difference_of(a: Corners, b: Corners) -> list[Corner]:
    """Corners of the hull of all differences of corners, anticlockwise."""
    of_a, of_b = (hull_of([body.corner(i) for i in range(len(body.corners))]) for body in (a, b))
    pairs = [Corner(minus(a.corner(i), b.corner(j)), i, j) for i in of_a for j in of_b]
    return [pairs[number] for number in hull_of([pair.y for pair in pairs])]


def flat_claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    """Claims about two bounded proxies of the plane."""
    return FlatSearch(a, b).claims()
