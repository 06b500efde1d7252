"""Half-spaces, polytopes given by planes, and hulls of points."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.boxes import columns_of
from oracles.repro.pieces.exact import Refused, Vector, along, cross, dot, length, number, require, times, vector, whole
from oracles.repro.pieces.solids import Solid


def weights(pairs: Any, end: int) -> list[tuple[int, Fraction]]:
    """Read weights ≥ 0 of some of `end` things, not all 0."""
    found = [(int(i), number(weight)) for i, weight in pairs]
    require(found and all(0 <= i < end and weight >= 0 for i, weight in found), "weights must not be negative")
    require(len(dict(found)) == len(found), "a weight must not be given twice")
    require(any(weight for _, weight in found), "some weight must be positive")
    return found


class Planes(Solid):
    """The points x with normal·x + k ≤ 0 for every plane (normal, k)."""

    def __init__(self, planes: Sequence[tuple[Vector, Any]]) -> None:
        self.planes = planes

    def support(self, n: Vector, shares: Any = ()) -> Any:
        """Bound n·x: where n is Σ λᵢ nᵢ with all λᵢ ≥ 0, n·x ≤ −Σ λᵢ kᵢ. The λᵢ are given up to a common factor."""
        normal, level = [Fraction(0)] * 3, Fraction(0)
        for i, share in weights(shares if len(self.planes) > 1 else [(0, 1)], len(self.planes)):
            normal, level = along(normal, share, self.planes[i][0]), level - share * self.planes[i][1]
        scale = dot(n, normal)
        require(scale > 0 and not any(cross(n, normal)), "n is no sum of normals of planes")
        return level * scale / dot(normal, normal)

    def square(self, x: Vector) -> Any:
        """0 for points inside; a half-space has a distance, too."""
        rise, normal = max((dot(normal, x) + k, normal) for normal, k in self.planes)
        require(rise <= 0 or len(self.planes) == 1, "a point lies outside a plane of the polytope")
        return max(rise, 0) ** 2 / dot(normal, normal)

    def outside(self, x: Vector) -> Any:
        """How far a point is outside the plane that it is farthest outside of."""
        return max([0, *((dot(n, x) + k) / length(n)[1] for n, k in self.planes)])

    def holds(self, centre: Vector, columns: Sequence[Vector], _: Any) -> bool:
        """Whether {centre + Σ uᵢ·columnᵢ : ‖u‖ ≤ 1} lies behind every plane."""
        rooms = [(-dot(n, centre) - k, sum(dot(n, column) ** 2 for column in columns)) for n, k in self.planes]
        return all(room >= 0 and reach <= room * room for room, reach in rooms)


def placed_planes(planes: Sequence[Any], position: Vector, columns: Sequence[Vector]) -> Planes:
    """Planes of a frame at `position`, whose axes are `columns`."""
    found = []
    for *normal, k in planes:
        turned = [Fraction(0)] * 3
        for c, column in zip(vector(normal), columns, strict=True):
            turned = along(turned, c, column)
        require(any(turned), "a plane's normal must not be 0")
        found.append((turned, number(k) - dot(turned, position)))
    return Planes(found)


def halfspace(shape: Any) -> Planes:
    """normal·x + k ≤ 0."""
    normal = vector(shape["normal"])
    require(any(normal), "a plane's normal must not be 0")
    return Planes([(normal, number(shape["k"]))])


def kdop(shape: Any) -> Planes:
    """lowerᵢ ≤ directionᵢ·x ≤ upperᵢ."""
    found = []
    for direction, lower, upper in zip(shape["directions"], shape["lower"], shape["upper"], strict=True):
        way = vector(direction)
        found += [(way, -number(upper)), (times(-1, way), number(lower))]
    return Planes([*found[::2], *found[1::2]])


class Points:
    """Points / unit in integers, which several hulls share."""

    def __init__(self, points: Sequence[Vector]) -> None:
        self.places, self.unit = whole(points)

    @classmethod
    def of_frame(cls, shape: Any, name: str) -> Points:
        """Points position + R y of a shape."""
        position, columns = vector(shape["position"]), columns_of(shape["rotation"])
        (place, *axes), unit = whole([position, *columns])
        own, scale = whole(shape[name])
        made = object.__new__(cls)
        made.places = [
            [scale * place[i] + axes[0][i] * x + axes[1][i] * y + axes[2][i] * z for i in range(3)] for x, y, z in own
        ]
        made.unit = unit * scale
        return made

    def highest(self, n: Vector, corners: Any) -> Fraction:
        """Largest n·x over some of them."""
        ((x, y, z),), scale = whole([n])
        places = self.places
        best = max(x * places[i][0] + y * places[i][1] + z * places[i][2] for i in corners)
        return Fraction(best, scale * self.unit)

    def exactly(self, i: int) -> list[Fraction]:
        """One of them."""
        return times(Fraction(1, self.unit), self.places[i])


class Hull(Solid):
    """The hull of some points, which a certificate names by weights."""

    def __init__(self, points: Points, corners: Sequence[int], radius: Fraction = Fraction(0)) -> None:
        self.points, self.corners, self.radius = points, corners, radius

    def support(self, n: Vector, _: Any = ()) -> Any:
        """Largest n·x: at a corner."""
        return self.points.highest(n, self.corners)

    def outside(self, _: Vector) -> Any:
        """Only a search could tell."""
        return 0

    def holds(self, _: Vector, columns: Sequence[Vector], __: Any) -> bool:
        """Only a point, and `member` gave that."""
        return not any(any(column) for column in columns)

    def member(self, place: Any, _: bool = False) -> tuple[list[Fraction], Any]:
        """A weighted mean of corners cannot lie outside."""
        found, total = [Fraction(0)] * 3, Fraction(0)
        for i, weight in weights(place, len(self.corners)):
            found, total = along(found, weight, self.points.places[self.corners[i]]), total + weight
        return times(1 / (total * self.points.unit), found), 0


def polytope(shape: Any) -> Solid:
    """The hull of vertices, or what lies behind all planes; in a frame of its own."""
    if shape["given"] == "vertices":
        points = Points.of_frame(shape, "numbers")
        return Hull(points, range(len(points.places)))
    if shape["given"] == "planes":
        return placed_planes(shape["numbers"], vector(shape["position"]), columns_of(shape["rotation"]))
    raise Refused(f"a polytope given by {shape['given']!r}")


def shares_of(faces: Any, atom: int = 0) -> Any:
    """Shares of the planes of one atom of a side, where a claim gives any."""
    return {int(i): shares for i, shares in faces}.get(atom, ())
