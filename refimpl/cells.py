"""Convex cells cut by planes, exactly.

Planes are four whole numbers, on the grid that holds a mesh's coordinates. A point is where three of them meet (or a
corner of the mesh, or where a plane cuts one of its edges), kept as whole homogeneous coordinates. However often a
cell is cut, its points are made from the first planes, so that numbers do not grow with the depth of the cutting
(Bernstein & Fussell 2009, Fast, Exact, Linear Booleans).
"""

from __future__ import annotations

import math
from typing import NamedTuple

Plane = tuple[int, int, int, int]
Point = tuple[int, int, int, int]
Loop = tuple[int, ...]

UNSURE = 1e-14
"""Where no coordinate exceeds 1, heights above a plane of which no coefficient exceeds 1 (its offset 3) err less."""


class Facet(NamedTuple):
    """A face of a cell: the plane's number, the side of it on which the cell lies (−1: below), and its corners.

    Corners run anticlockwise seen from outside.
    """

    plane: int
    side: int
    loop: Loop


class Arrangement:
    """Planes and the points where they meet, numbered; each is stored once.

    Parameters
    ----------
    reach : int
        No coordinate's absolute value exceeds it.
    """

    def __init__(self, reach: int) -> None:
        self.unit = 1 << reach.bit_length()
        self.planes: list[Plane] = []
        self.slopes: list[tuple[float, float, float, float]] = []
        self.points: list[Point] = []
        self.near: list[tuple[float, float, float]] = []
        self._plane_numbers: dict[Plane, int] = {}
        self._point_numbers: dict[Point, int] = {}
        self._made: dict[tuple[int, int, int] | tuple[str, int, int, int], int] = {}
        self._on: set[tuple[int, int]] = set()

    def plane(self, a: int, b: int, c: int, d: int) -> tuple[int, int]:
        """Number of the plane ax + by + cz + d = 0, and whether it is stored as given (1) or turned over (−1)."""
        shared = math.gcd(a, b, c, d)
        side = 1 if (a or b or c) > 0 else -1
        plane = (a // shared * side, b // shared * side, c // shared * side, d // shared * side)
        if plane not in self._plane_numbers:
            self._plane_numbers[plane] = len(self.planes)
            self.planes.append(plane)
            size = max(map(abs, plane[:3]))
            x, y, z, w = plane
            self.slopes.append((x / size, y / size, z / size, w / (size * self.unit)))
        return self._plane_numbers[plane], side

    def point(self, x: int, y: int, z: int, w: int = 1) -> int:
        """Number of the point (x, y, z) / w."""
        shared = math.gcd(x, y, z, w)
        if w < 0:
            shared = -shared
        point = (x // shared, y // shared, z // shared, w // shared)
        if point not in self._point_numbers:
            self._point_numbers[point] = len(self.points)
            self.points.append(point)
            size = point[3] * self.unit
            self.near.append((point[0] / size, point[1] / size, point[2] / size))
        return self._point_numbers[point]

    def meeting(self, f: int, g: int, h: int) -> int:
        """Number of the point where three planes meet (Cramer's rule)."""
        i, j, k = sorted((f, g, h))
        number = self._made.get((i, j, k))
        if number is None:
            (a, b, c, d), (p, q, r, s), (t, u, v, w) = self.planes[i], self.planes[j], self.planes[k]
            jk = q * v - r * u, r * t - p * v, p * u - q * t
            ki = u * c - v * b, v * a - t * c, t * b - u * a
            ij = b * r - c * q, c * p - a * r, a * q - b * p
            x, y, z = (-(d * m + s * n + w * o) for m, n, o in zip(jk, ki, ij, strict=True))
            number = self.point(x, y, z, a * jk[0] + b * jk[1] + c * jk[2])
            self._made[i, j, k] = number
            self._on.update(((number, f), (number, g), (number, h)))
        return number

    def edge_point(self, p: int, q: int, h: int) -> int:
        """Number of the point where a plane cuts the segment between two points of which each is on another side."""
        if p > q:
            p, q = q, p
        number = self._made.get(("", p, q, h))
        if number is None:
            height_p, height_q = self._height(p, h), self._height(q, h)
            a, b = self.points[p], self.points[q]
            x, y, z, w = (height_q * i - height_p * j for i, j in zip(a, b, strict=True))
            number = self.point(x, y, z, w)
            self._made["", p, q, h] = number
            self._on.add((number, h))
        return number

    def _height(self, point: int, plane: int) -> int:
        x, y, z, w = self.points[point]
        a, b, c, d = self.planes[plane]
        return a * x + b * y + c * z + d * w

    def lies_on(self, point: int, plane: int) -> None:
        """Note that a point is on a plane."""
        self._on.add((point, plane))

    def side(self, point: int, plane: int) -> int:
        """On which side of a plane a point lies: 1, 0 or −1."""
        x, y, z = self.near[point]
        a, b, c, d = self.slopes[plane]
        height = a * x + b * y + c * z + d
        if height > UNSURE:
            return 1
        if height < -UNSURE:
            return -1
        if (point, plane) in self._on:
            return 0
        exact = self._height(point, plane)
        if exact == 0:
            self._on.add((point, plane))
        return (exact > 0) - (exact < 0)


class Cell:
    """A convex polyhedron with interior points, as its facets; corners are true corners, and facets true facets."""

    def __init__(self, facets: list[Facet]) -> None:
        self.facets = facets
        self.corners = {corner for facet in facets for corner in facet.loop}

    def split(self, space: Arrangement, plane: int) -> tuple[Cell | None, Cell | None]:
        """Parts below and above a plane; None where there is no interior."""
        side = {corner: space.side(corner, plane) for corner in self.corners}
        if 1 not in side.values():
            return self, None
        if -1 not in side.values():
            return None, self
        owner = {}
        for facet in self.facets:
            for u, v in _edges(facet.loop):
                if side[u] * side[v] < 0:
                    owner[u, v] = facet.plane
        crossing = {(u, v): space.meeting(f, owner[v, u], plane) for (u, v), f in owner.items()}
        return self._part(plane, -1, side, crossing), self._part(plane, 1, side, crossing)

    def _part(self, plane: int, keep: int, side: dict[int, int], crossing: dict[tuple[int, int], int]) -> Cell:
        facets: list[Facet] = []
        rim: dict[int, int] = {}
        for facet in self.facets:
            sides = [side[corner] for corner in facet.loop]
            if keep not in sides:
                continue
            if -keep in sides:
                loop = _clipped(facet.loop, keep, side, crossing)
            elif sides.count(0) >= 2:
                loop = facet.loop
            else:
                facets.append(facet)
                continue
            facets.append(Facet(facet.plane, facet.side, loop))
            rim.update((v, u) for u, v in _edges(loop) if side.get(u, 0) == side.get(v, 0) == 0)  # new ones are on it
        start = here = next(iter(rim))
        ring = [start]
        while (here := rim[here]) != start:
            ring.append(here)
        facets.append(Facet(plane, keep, tuple(ring)))
        return Cell(facets)

    def joined(self, other: Cell, space: Arrangement, plane: int) -> Cell | None:
        """The union with a cell on the other side of a common facet, if it is convex; else None.

        It is when the corners of each satisfy all planes of the other but the common one.
        """
        for one, two in ((self, other), (other, self)):
            for facet in one.facets:
                if facet.plane != plane and any(space.side(p, facet.plane) == -facet.side for p in two.corners):
                    return None
        mine, theirs = ({f.plane: f for f in cell.facets if f.plane != plane} for cell in (self, other))
        facets = [_welded(f, theirs[f.plane]) if f.plane in theirs else f for f in mine.values()]
        facets += [f for f in theirs.values() if f.plane not in mine]
        seam = {corner for facet in self.facets if facet.plane == plane for corner in facet.loop}
        count = dict.fromkeys(seam, 0)
        for facet in facets:
            for corner in seam.intersection(facet.loop):
                count[corner] += 1
        gone = {corner for corner, number in count.items() if number < 3}
        return Cell([f._replace(loop=tuple(p for p in f.loop if p not in gone)) for f in facets])


def _edges(loop: Loop) -> list[tuple[int, int]]:
    return list(zip(loop, loop[1:] + loop[:1], strict=True))


def _clipped(loop: Loop, keep: int, side: dict[int, int], crossing: dict[tuple[int, int], int]) -> Loop:
    found = []
    for u, v in _edges(loop):
        if side[u] != -keep:
            found.append(u)
        if side[u] * side[v] < 0:
            found.append(crossing[u, v])
    return tuple(found)


def _welded(one: Facet, other: Facet) -> Facet:
    """Two facets in one plane, joined along their common edge."""
    back = set(_edges(other.loop))
    a, b = next((u, v) for u, v in _edges(one.loop) if (v, u) in back)
    i, j = one.loop.index(b), other.loop.index(a)
    first = one.loop[i:] + one.loop[:i]
    second = other.loop[j:] + other.loop[:j]
    return one._replace(loop=first + second[1:-1])


def bounding_cell(space: Arrangement, reach: int) -> Cell:
    """The cube of the points whose coordinates do not exceed `reach`."""
    corner = {
        (x, y, z): space.point(x * reach, y * reach, z * reach) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)
    }
    facets = []
    for axis in range(3):
        for sign in (-1, 1):
            normal = [0, 0, 0]
            normal[axis] = sign
            plane, turned = space.plane(normal[0], normal[1], normal[2], -reach)
            ring = []
            for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                at = [0, 0, 0]
                at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3] = sign, u, v
                ring.append(corner[at[0], at[1], at[2]])
                space.lies_on(ring[-1], plane)
            facets.append(Facet(plane, -turned, tuple(ring if sign > 0 else ring[::-1])))
    return Cell(facets)
