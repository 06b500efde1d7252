"""What a convex shape is: a core, widened by a ball."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.exact import Vector, minus, root, vector
from oracles.repro.pieces.inscribed import ball_in_ball


class Solid:
    """A convex core and the `radius` of a ball around each of its points."""

    radius = Fraction(0)
    centre: Vector = ()

    def support(self, n: Vector, shares: Any = ()) -> Any:
        """Largest n·x over the core, or a little more."""
        raise NotImplementedError

    def square(self, x: Vector) -> Any:
        """Square of the distance of a point from the core, or a little more; 0 only inside."""
        raise NotImplementedError

    def member(self, place: Any, widened: bool = False) -> tuple[list[Fraction], Any]:
        """Read a point of the certificate, and find how far at most it lies outside the core, or the solid."""
        x = vector(place)
        square, radius = self.square(x), self.radius if widened else 0
        return x, 0 if square <= radius * radius else root(Fraction(square))[1] - radius

    def outside(self, x: Vector) -> Any:
        """How far a point is outside, at least; 0 where that cannot be told without a search."""
        return max(0, root(Fraction(self.square(x)))[0] - self.radius)

    def local(self, way: Vector) -> tuple[list[list[Any]], list[Any]]:
        """A way in coordinates in which the core is a product of balls, and what is left of it."""
        raise NotImplementedError

    def holds(self, centre: Vector, columns: Sequence[Vector], share: Any) -> bool:
        """Whether {centre + Σ uᵢ·columnᵢ : ‖u‖ ≤ 1} lies in the core."""
        parts = [self.local(way) for way in (minus(centre, self.centre), *columns)]
        if any(any(rest) for _, rest in parts):
            return False
        for place, *ways in zip(*(coordinates for coordinates, _ in parts), strict=True):
            if len(place) == 1:  # a segment in a segment
                room = 1 - abs(place[0])
                if room < 0 or sum(t * t for (t,) in ways) > room * room:
                    return False
            elif not ball_in_ball(place, ways, share):
                return False
        return True
