"""The kinds of convex sets, in exact arithmetic: part of what has to be believed.

Each convex proxy is a *core* widened by a ball: a sphere is its centre, a capsule its segment, the others are
themselves with radius 0. Three facts about each kind of core are trusted:

`support(n, shares)`
    its support function, the largest n·x over the core, or something above it by less than 2⁻¹⁵⁰ of it.
`member(point, widened)`
    the exact point that a certificate means, and how far at most it lies outside the core, or outside the
    widened core; 0 exactly when it lies inside.
`holds(centre, columns, share)`
    whether {centre + Σ uᵢ·columnᵢ : ‖u‖ ≤ 1} lies in the core; True only if it does.

All are in the coordinates of the world: `reading` applies a pose when it reads a proxy.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.rational import (
    Exact,
    InvalidCertificate,
    Whole,
    cross,
    dot,
    is_positive,
    minus,
    root,
    shares,
    vector,
    whole,
)

NONE = Fraction(0)


def _beyond(square: Fraction, radius: Fraction) -> Fraction:
    """At most so much is the root of `square` larger than `radius`; 0 exactly when it is not."""
    return NONE if square <= radius * radius else root(square)[1] - radius


def ball_in_ball(centre: Exact, columns: Sequence[Exact], square: Fraction, share: Fraction) -> bool:
    """Whether ‖centre + Σ uᵢ·columnᵢ‖² ≤ square for all ‖u‖ ≤ 1.

    It is when square − ‖centre + P u‖² − share·(1 − ‖u‖²) ≥ 0 for all u, for some share ≥ 0. As a quadratic form in
    (1, u), this is a matrix that is positive semidefinite; its last three diagonal entries imply that share ≥ 0.
    """
    sides = [-dot(centre, column) for column in columns]
    matrix = [[square - dot(centre, centre) - share, *sides]]
    for i, u in enumerate(columns):
        matrix.append([sides[i], *(share * (i == j) - dot(u, v) for j, v in enumerate(columns))])
    return is_positive(matrix)


class Round(NamedTuple):
    """{(corner + Σ tᵢ edgeᵢ) / unit : 0 ≤ tᵢ ≤ 1} ⊕ ball(radius), the edges at right angles to each other."""

    corner: Whole
    edges: Sequence[Whole]
    unit: int
    radius: Fraction

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return Fraction(dot(n, self.corner) + sum(max(0, dot(n, edge)) for edge in self.edges), self.unit)

    def square_distance(self, point: Exact) -> Fraction:
        """‖x − corner‖², less the parts along the edges as far as these reach."""
        (x,), scale = whole([point])
        offset = [self.unit * a - scale * c for a, c in zip(x, self.corner, strict=True)]
        numerator, denominator = dot(offset, offset), 1
        for edge in self.edges:
            square, along = dot(edge, edge), dot(offset, edge)
            beyond = max(-along, 0, along - scale * square)
            numerator = numerator * square - (along * along - beyond * beyond) * denominator
            denominator *= square
        return Fraction(numerator, denominator * (scale * self.unit) ** 2)

    def member(self, point: Any, widened: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        return x, _beyond(self.square_distance(x), self.radius if widened else NONE)

    def holds(self, centre: Exact, columns: Sequence[Exact], _: Fraction) -> bool:
        """Along each edge it stays between the ends; across all edges it does not extend."""
        start = [self.unit * x - c for x, c in zip(centre, self.corner, strict=True)]
        for way in (start, *columns):
            if dot(way, way) != sum(Fraction(dot(way, edge) ** 2) / dot(edge, edge) for edge in self.edges):
                return False
        for edge in self.edges:
            square, reach = dot(edge, edge), sum(dot(edge, column) ** 2 for column in columns)
            room = square - abs(2 * dot(edge, start) - square)
            if room < 0 or 4 * self.unit**2 * reach > room * room:
                return False
        return True


class Half(NamedTuple):
    """normal·x + k ≤ 0, in integers; its own core."""

    normal: Whole
    k: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        along = dot(n, self.normal)
        if any(cross(n, self.normal)) or along <= 0:
            raise InvalidCertificate("n: the half-space is unbounded in this direction")
        return Fraction(-self.k * along, dot(self.normal, self.normal))

    def square_distance(self, point: Exact) -> Fraction:
        """Square distance of a point."""
        beyond = max(NONE, dot(self.normal, point) + self.k)
        return Fraction(beyond * beyond, dot(self.normal, self.normal))

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        return x, _beyond(self.square_distance(x), NONE)

    def holds(self, centre: Exact, columns: Sequence[Exact], _: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        room = -(dot(self.normal, centre) + self.k)
        reach = sum((dot(self.normal, column) ** 2 for column in columns), NONE)
        return bool(room >= 0 and reach <= room * room)


class Planes(NamedTuple):
    """The points behind every plane: normal·x + k ≤ 0, in integers."""

    halves: Sequence[Half]
    radius: Fraction = NONE

    def support(self, n: Whole, faces: Any = ()) -> Fraction:
        """Above it: if n = Σ λᵢ nᵢ with λᵢ ≥ 0, then n·x ≤ −Σ λᵢ kᵢ. The λ are given, up to a common factor."""
        normal, k = [NONE] * 3, NONE
        for i, share in shares(faces, len(self.halves)).items():
            half = self.halves[i]
            normal, k = [c + share * m for c, m in zip(normal, half.normal, strict=True)], k + share * half.k
        along = dot(n, normal)
        if any(cross(n, normal)) or along <= 0:
            raise InvalidCertificate("shares: the sum of these normals does not point along n")
        return Fraction(-k * along / dot(normal, normal))

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        (ints,), scale = whole([x])
        if any(dot(half.normal, ints) + half.k * scale > 0 for half in self.halves):
            raise InvalidCertificate("point: outside a face of the polytope")
        return x, NONE

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        return all(half.holds(centre, columns, share) for half in self.halves)


class Hull(NamedTuple):
    """The hull of vertices / unit."""

    vertices: Sequence[Whole]
    unit: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        return Fraction(max(dot(n, vertex) for vertex in self.vertices), self.unit)

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """A point is given by the weights of some vertices, up to a common factor: it cannot lie outside."""
        weights = shares(point, len(self.vertices))
        unit = self.unit * sum(weights.values())
        mean = [sum(w * self.vertices[i][axis] for i, w in weights.items()) / unit for axis in range(3)]
        return [Fraction(x) for x in mean], NONE

    def holds(self, _centre: Exact, columns: Sequence[Exact], _share: Fraction) -> bool:
        """Only a point, and `member` gave that."""
        return not any(any(column) for column in columns)


class Ellipsoid(NamedTuple):
    """{(centre + Σ tᵢ axisᵢ) / unit : ‖t‖ ≤ 1}, the three axes at right angles to each other."""

    centre: Whole
    axes: Sequence[Whole]
    unit: int
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        swell = root(Fraction(sum(dot(n, axis) ** 2 for axis in self.axes)))[1]
        return Fraction(dot(n, self.centre) + swell) / self.unit

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        x = vector(point, "point")
        (ints,), scale = whole([x])
        offset = [self.unit * a - scale * c for a, c in zip(ints, self.centre, strict=True)]
        squares = [dot(axis, axis) for axis in self.axes]
        size = squares[0] * squares[1] * squares[2]
        parts = [(dot(offset, axis) * (size // s)) ** 2 for axis, s in zip(self.axes, squares, strict=True)]
        whole_square = (scale * size) ** 2
        if sum(parts) <= whole_square:
            return x, NONE
        t = [Fraction(part, whole_square) for part in parts]  # tᵢ²; now by how much it has to move to come inside:
        unit = scale * self.unit
        moves = [root(Fraction(dot(offset, offset), unit * unit))[1] * (1 - 1 / root(sum(t, NONE))[1])]  # to the centre
        for i, s in enumerate(squares):  # or along one axis
            rest = 1 - (sum(t, NONE) - t[i])
            if rest >= 0:
                moves.append((root(t[i])[1] - root(rest)[0]) * root(Fraction(s, self.unit**2))[1])
        return x, min(moves)

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """In the coordinates t it is a ball in a ball."""
        start = [self.unit * x - c for x, c in zip(centre, self.centre, strict=True)]
        squares = [dot(axis, axis) for axis in self.axes]
        local = [[dot(way, axis) / s for axis, s in zip(self.axes, squares, strict=True)] for way in (start, *columns)]
        scaled = [[self.unit * c for c in column] for column in local[1:]]
        return ball_in_ball(local[0], scaled, Fraction(1), share)


class Cylinder(NamedTuple):
    """Within `breadth` of the line from `start` along `way`, between the planes across its ends."""

    start: Exact
    way: Exact
    breadth: Fraction
    radius: Fraction = NONE

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        along = dot(n, self.way)
        across = dot(n, n) - along * along / dot(self.way, self.way)
        return Fraction(dot(n, self.start) + max(NONE, along) + self.breadth * root(across)[1])

    def _across(self, v: Exact) -> Exact:
        share = dot(v, self.way) / dot(self.way, self.way)
        return [x - share * w for x, w in zip(v, self.way, strict=True)]

    def member(self, point: Any, _: bool = False) -> tuple[Exact, Fraction]:
        """Outside by the way to the nearest cap plane, and by the way to the side, at right angles to it."""
        x = vector(point, "point")
        offset, square = minus(x, self.start), dot(self.way, self.way)
        across = self._across(offset)
        aside = _beyond(dot(across, across), self.breadth)
        ends = max(NONE, -dot(offset, self.way), dot(offset, self.way) - square)
        return x, root(ends * ends / square + aside * aside)[1]

    def holds(self, centre: Exact, columns: Sequence[Exact], share: Fraction) -> bool:
        """Whether the ellipsoid lies inside."""
        offset, square = minus(centre, self.start), dot(self.way, self.way)
        room = square - abs(2 * dot(offset, self.way) - square)
        if room < 0 or 4 * sum(dot(column, self.way) ** 2 for column in columns) > room * room:
            return False
        aside = [self._across(column) for column in columns]
        return ball_in_ball(self._across(offset), aside, self.breadth * self.breadth, share)


class Line(NamedTuple):
    """A ray from `origin`."""

    origin: Exact
    direction: Exact

    def support(self, n: Whole, _: Any = ()) -> Fraction:
        """Largest n·x."""
        if dot(n, self.direction) > 0:
            raise InvalidCertificate("n: the ray is unbounded in this direction")
        return Fraction(dot(n, self.origin))

    def at(self, time: Fraction) -> Exact:
        """Point at a time."""
        return [o + time * d for o, d in zip(self.origin, self.direction, strict=True)]


Solid: TypeAlias = Round | Half | Planes | Hull | Ellipsoid | Cylinder
