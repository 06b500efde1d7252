"""The kinds of convex sets, in exact arithmetic: part of what has to be believed.

Each convex proxy is a *core* widened by a ball: a sphere is its centre, a capsule its segment, the others are
themselves with radius 0. There are three kinds of cores: sums of segments, discs and ellipsoids at right angles to each
other (`Product`), and polytopes given by planes or by vertices. Three facts about each kind are trusted:

`support(n, shares)`
    its support function, the largest n·x over the core, or something above it by less than 2⁻¹⁵⁰ of it.
`member(point)`
    the exact point that a certificate means, and how far at most it lies outside the core, or with `widened` outside
    the widened core; 0 exactly when it lies inside.
`holds(centre, columns, share)`
    whether {centre + Σ uᵢ·columnᵢ : ‖u‖ ≤ 1} lies in the core; True only if it does.

All are in the coordinates of the world: `reading` applies a pose when it reads a proxy.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.rational import require, shares, spend, vector, whole
from refimpl.proof.vectors import NONE, Exact, Whole, cross, dot, is_positive, minus, root, times


def ball_in_ball(centre: Sequence[Any], columns: Sequence[Sequence[Any]], share: Fraction) -> bool:
    """Whether ‖centre + Σ uᵢ·columnᵢ‖² ≤ 1 for all ‖u‖ ≤ 1, in any dimension.

    It is when 1 − ‖centre + P u‖² − share·(1 − ‖u‖²) ≥ 0 for all u, for some share ≥ 0. As a quadratic form in
    (1, u), this is a matrix that is positive semidefinite; its last diagonal entries imply that share ≥ 0.
    """
    vectors, unit = whole([centre, *columns])  # and all products times unit²·the share's denominator
    spend(512, unit.bit_length())
    part, scale = share.numerator * unit * unit, share.denominator
    products = [[scale * sum(x * y for x, y in zip(u, v, strict=True)) for v in vectors] for u in vectors]
    diagonal = [scale * unit * unit - part, *(part for _ in columns)]
    return is_positive([[d * (i == j) - p for j, p in enumerate(products[i])] for i, d in enumerate(diagonal)])


class Factor(NamedTuple):
    """{Σ sᵢ vᵢ : ‖s‖ ≤ 1}: a segment has one vector; an ellipsoid three at right angles, its semi-axes; a disc three.

    Those of a disc are what its plane keeps of the three axes, times its radius. In each case the vᵢ are eigenvectors
    of M = Σ vᵢ vᵢᵀ, and whole/shareᵢ is the value. So with the coordinates tᵢ = (vᵢ·x)·shareᵢ/whole, a point x is
    Σ tᵢ vᵢ, its part in the factor's space, and a rest at right angles to that; the part is in the set when ‖t‖ ≤ 1.
    """

    vectors: Sequence[Whole]
    shares: Whole
    whole: int

    def support(self, n: Whole) -> Fraction | int:
        """Largest n·x: the length of all n·vᵢ."""
        heights = [dot(n, v) for v in self.vectors]
        return abs(heights[0]) if len(heights) == 1 else root(Fraction(sum(h * h for h in heights)))[1]

    def coordinates(self, x: Sequence[Any]) -> list[Any]:
        """All tᵢ, times `whole`."""
        return [dot(v, x) * share for v, share in zip(self.vectors, self.shares, strict=True)]

    def square(self, x: Sequence[Any]) -> Fraction:
        """‖Σ tᵢ vᵢ‖², which is Σ (vᵢ·x) tᵢ."""
        return Fraction(sum(dot(v, x) * t for v, t in zip(self.vectors, self.coordinates(x), strict=True))) / self.whole

    def beyond(self, x: Whole, scale: int) -> Fraction:
        """Square of how far at most the part of x/scale is from the set; exactly for a segment."""
        scaled = self.coordinates(x)
        if sum(c * c for c in scaled) <= (self.whole * scale) ** 2:
            return NONE
        spend(256, scale.bit_length())
        t = [Fraction(c, self.whole * scale) for c in scaled]
        square, length = sum((c * c for c in t), NONE), self.square(x) / scale**2
        if len(t) == 1:
            return length * (1 - 1 / abs(t[0])) ** 2
        moves = [length * (1 - 1 / root(square)[1]) ** 2]  # to the centre; or along the gradient of ‖t‖²/2, g:
        weights = [c * share / self.whole for c, share in zip(t, self.shares, strict=True)]
        g = [sum((w * v[i] for w, v in zip(weights, self.vectors, strict=True)), NONE) for i in range(3)]
        steep, bend = dot(g, g), sum((c / self.whole) ** 2 for c in self.coordinates(g))
        room = steep * steep - (square - 1) * bend  # after −m·g, ‖t‖² is square − 2·steep·m + bend·m²
        if room >= 0:
            moves.append(steep * ((square - 1) / (steep + root(room)[0])) ** 2)
        return min(moves)


class Product(NamedTuple):
    """(centre + the sum of factors, at right angles to each other) / unit, widened by ball(radius)."""

    centre: Whole
    factors: Sequence[Factor]
    unit: int
    radius: Fraction

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return Fraction(dot(n, self.centre) + sum(factor.support(n) for factor in self.factors)) / self.unit

    def _across(self, x: Sequence[Any]) -> Fraction:
        """Square of what is left of x without its parts in the factors' spaces."""
        return dot(x, x) - sum((factor.square(x) for factor in self.factors), NONE)  # type: ignore[no-any-return]

    def square_distance(self, point: Exact) -> Fraction:
        """Square of how far at most a point is from the core; exactly if that is made of segments."""
        (p,), scale = whole([point])
        spend(128, scale.bit_length())
        x = minus(times(self.unit, p), times(scale, self.centre))
        beyond = sum((factor.beyond(x, scale) for factor in self.factors), self._across(x) / scale**2)
        return beyond / self.unit**2

    def member(self, point: Any, widened: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        square, radius = self.square_distance(x), self.radius if widened else NONE
        return x, NONE if square <= radius * radius else root(square)[1] - radius

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """In the coordinates of each factor it is a ball in a ball; across them all it does not extend."""
        ways = [minus(times(self.unit, centre), self.centre), *(times(self.unit, column) for column in columns)]
        if any(self._across(way) for way in ways):
            return False
        for factor in self.factors:
            place, *local = [[c / factor.whole for c in factor.coordinates(way)] for way in ways]
            known = (1 - place[0] ** 2 + sum((c * c for (c, *_) in local), NONE)) / 2  # does for a segment in a segment
            if not ball_in_ball(place, local, known if len(place) == 1 else share):
                return False
        return True


class Planes(NamedTuple):
    """The points behind every plane (normal, k): normal·x + k ≤ 0, in integers. A half-space has one."""

    planes: Sequence[tuple[Whole, int]]
    radius: Fraction = NONE

    def support(self, n: Whole, faces: Any = ()) -> Fraction:
        """Above it: if n = Σ λᵢ nᵢ with λᵢ ≥ 0, then n·x ≤ −Σ λᵢ kᵢ. The λ are given, up to a common factor."""
        normal, level = [0, 0, 0], 0
        for i, share in shares(faces if len(self.planes) > 1 else [(0, 1)], len(self.planes)).items():
            m, k = self.planes[i]
            normal, level = minus(normal, times(-share, m)), level - share * k
        along = dot(n, normal)
        require(along > 0 and not any(cross(n, normal)), "shares: no normal of a plane; it may be unbounded along n")
        return Fraction(level * along, dot(normal, normal))

    def square_distance(self, point: Exact) -> Fraction:
        """Square of how far a point is from a half-space; 0 for points of a polytope, others are refused."""
        spend(len(self.planes))
        (x,), scale = whole([point])
        rise, normal = max((dot(normal, x) + k * scale, normal) for normal, k in self.planes)
        require(rise <= 0 or len(self.planes) == 1, "point: outside a face of the polytope")
        return Fraction(max(0, rise) ** 2, dot(normal, normal) * scale**2)

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        return x, root(self.square_distance(x))[1]

    def holds(self, centre: Exact, columns: Sequence[Exact], _: Fraction) -> bool:
        """Whether the ellipsoid lies behind each plane."""
        spend(len(self.planes))
        rooms = ((-dot(n, centre) - k, sum(dot(n, column) ** 2 for column in columns)) for n, k in self.planes)
        return all(room >= 0 and reach <= room * room for room, reach in rooms)


class Points:
    """Places / unit, which several hulls share."""

    def __init__(self, places: Sequence[Whole], unit: int) -> None:
        self.places, self.unit = places, unit

    def support(self, n: Whole, corners: Iterable[int]) -> Fraction:
        """Largest n·x over some of them."""
        x, y, z = n
        chosen = list(map(self.places.__getitem__, corners))
        spend(len(chosen) * (1 + (x.bit_length() >> 9)))
        return Fraction(max([x * u + y * v + z * w for u, v, w in chosen]), self.unit)


class Hull(NamedTuple):
    """The hull of some points."""

    points: Points
    corners: Sequence[int]
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return self.points.support(n, self.corners)

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """A point is given by the weights of some corners, up to a common factor: it cannot lie outside."""
        weights = shares(point, len(self.corners))
        unit = self.points.unit * sum(weights.values())
        chosen = [(weight, self.points.places[self.corners[i]]) for i, weight in weights.items()]
        return [Fraction(sum(weight * place[axis] for weight, place in chosen), unit) for axis in range(3)], NONE

    def holds(self, _centre: Exact, columns: Sequence[Exact], _share: Fraction) -> bool:
        """Only a point, and `member` gave that."""
        return not any(any(column) for column in columns)


class Line(NamedTuple):
    """A ray from `origin`."""

    origin: Exact
    direction: Exact
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        require(dot(n, self.direction) <= 0, "n: the ray is unbounded in this direction")
        return Fraction(dot(n, self.origin))

    def at(self, time: Fraction) -> Exact:
        """Point at a time."""
        return minus(self.origin, times(-time, self.direction))


Solid: TypeAlias = Product | Planes | Hull
