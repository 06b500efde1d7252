"""Convex proxies as the search sees them: support points in floats, and how to say them exactly.

Nothing here has to be believed: what is found is handed on as a certificate. Shapes are told apart by the names of
their types. All is in the coordinates of the world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from refimpl.proof.checker import Place, Weights
from refimpl.proof.points import (
    AXES,
    Vector,
    along,
    core,
    cross,
    dot,
    doubles,
    exact,
    frame,
    minus,
    opposite,
    rationals,
    turned,
)
from refimpl.shapes import AABB, Box

INWARDS = 1.0 - 2.0**-51  # a support point of a curved proxy is drawn in by this, so that rounding leaves it inside
NEAR = 1e-9  # relative; planes that come so near to a corner may pass through it
Mix = Sequence[tuple[int, Any]]
"""Weights of numbered corners."""


class Body:
    """A convex core with support points, widened by a ball."""

    radius = Fraction(0)

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        raise NotImplementedError

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point along n, and its number if it is a corner."""
        raise NotImplementedError

    def lowest(self, n: Vector) -> tuple[Vector, Mix]:
        """Point that is least far along n, as exactly as it can be said, and the corners that it is made of."""
        point, _ = self.support(_scaled(opposite(n)))
        return exact(point), ()

    def normals(self) -> list[Vector]:
        """Directions across flat parts of the surface, which a certificate may have to hit exactly."""
        return []

    def faces(self, n: Vector) -> Weights:  # noqa: ARG002
        """Shares that a certificate needs for the support along n."""
        return ()

    def place(self, point: Vector, mix: Mix = ()) -> Place:  # noqa: ARG002
        """How a certificate says where `point` is, which is the mean of some corners."""
        return doubles(point)


class Curved(Body):
    """centre + Σ tᵢ·axisᵢ, with t in the unit ball (an ellipsoid), or t₀, t₁ in the unit disc and |t₂| ≤ 1."""

    def __init__(self, centre: Vector, axes: Sequence[Vector], flat: bool) -> None:
        self.exact = centre, axes
        self.centre, self.axes, self.flat = doubles(centre), [doubles(axis) for axis in axes], flat

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        return float(max(abs(c) + sum(abs(axis[i]) for axis in self.axes) for i, c in enumerate(self.centre)))

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point, and its number."""
        t = [dot(n, axis) for axis in self.axes]
        top = math.copysign(1.0, t[2])
        if self.flat:
            t[2] = 0.0
        size = math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
        t = [INWARDS * c / size if size else 0.0 for c in t]
        if self.flat:
            t[2] = top * INWARDS
        point = self.centre
        for c, axis in zip(t, self.axes, strict=True):
            point = along(point, c, axis)
        return point, -1

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return [self.exact[1][2], opposite(self.exact[1][2])] if self.flat else []


class Corners(Body):
    """The hull of corners."""

    def __init__(self, corners: Sequence[Vector], radius: Fraction = Fraction(0)) -> None:
        self.corners, self.radius = corners, radius
        self.floats = np.array([doubles(corner) for corner in corners])
        self.flat: list[Vector] = []

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return self.flat

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        return float(np.max(np.abs(self.floats)))

    def corner(self, i: int) -> Vector:
        """Exact corner."""
        return self.corners[i]

    def heights(self, n: Vector) -> Any:
        """Scalar products of all corners with n, in floats."""
        return self.floats[:, 0] * n[0] + self.floats[:, 1] * n[1] + self.floats[:, 2] * n[2]

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point, and its number."""
        i = int(np.argmax(self.heights(n)))
        return tuple(self.floats[i].tolist()), i

    def farthest(self, n: Vector) -> int:
        """Farthest corner along n, exactly."""
        heights = self.heights(_scaled(n))
        slack = 1e-13 * max(self.extent, float(np.max(np.abs(heights))))
        near = np.nonzero(heights >= np.max(heights) - slack)[0].tolist()
        return max(near, key=lambda i: dot(n, self.corner(i))) if len(near) > 1 else int(near[0])

    def lowest(self, n: Vector) -> tuple[Vector, Mix]:
        """Least far point, exactly."""
        i = self.farthest(opposite(exact(n)))
        return self.corner(i), [(i, 1)]

    def mean(self, mix: Mix) -> Vector:
        """Weighted mean of corners, exactly."""
        total, sum_of = (Fraction(0),) * 3, sum(weight for _, weight in mix)
        for i, weight in mix:
            total = along(total, Fraction(weight) / sum_of, self.corner(i))
        return total


def exactly(mix: Mix) -> Weights:
    """Weights as a certificate says them, without rounding."""
    return tuple((i, weight) for i, weight in mix if weight)


class Vertices(Corners):
    """A polytope given by vertices: a certificate says a point by their weights."""

    def place(self, point: Vector, mix: Mix = ()) -> Place:  # noqa: ARG002
        """How a certificate says the point."""
        largest = max(weight for _, weight in mix)
        return exactly([(i, float(Fraction(weight) / largest)) for i, weight in mix])


class Planes(Corners):
    """A polytope given by planes: a certificate has to show a direction as a sum of normals."""

    def __init__(self, planes: Sequence[tuple[Any, ...]], position: Vector, columns: Sequence[Vector]) -> None:
        self.planes, self.position, self.columns = planes, position, columns
        self._array = np.array([[float(x) for x in plane] for plane in planes])
        self._lengths = np.sqrt((self._array[:, :3] ** 2).sum(axis=1))
        self._unit = self._array / self._lengths[:, None]
        found = self._exact_corners()
        self.active = [planes for _, planes in found]
        super().__init__([_placed(corner, position, columns) for corner, _ in found])
        self.middle = self.floats.mean(axis=0).tolist()

    def _exact_corners(self) -> list[tuple[Vector, list[int]]]:
        """Intersections of three planes behind all others, and the planes through each."""
        found: dict[Vector, list[int]] = {}
        for triple in self._triples():
            corner = _meet([self.planes[i] for i in triple])
            if corner is not None and corner not in found:
                sides = [dot(plane, corner) + plane[3] for plane in self.planes]
                if max(sides) <= 0:
                    found[corner] = [i for i, side in enumerate(sides) if side == 0]
        return list(found.items())

    def _triples(self) -> Sequence[tuple[int, ...]]:
        """Which triples of planes meet, in floats, behind all others or nearly so."""
        triples = np.array(list(combinations(range(len(self._unit)), 3)))
        normals, k = self._unit[triples, :3], self._unit[triples, 3]
        volumes = np.einsum("ij,ij->i", normals[:, 0], np.cross(normals[:, 1], normals[:, 2]))
        triples, normals, k, volumes = (x[np.abs(volumes) > 1e-14] for x in (triples, normals, k, volumes))
        points = (
            -(
                k[:, :1] * np.cross(normals[:, 1], normals[:, 2])
                + k[:, 1:2] * np.cross(normals[:, 2], normals[:, 0])
                + k[:, 2:] * np.cross(normals[:, 0], normals[:, 1])
            )
            / volumes[:, None]
        )
        worst = np.max(points @ self._unit[:, :3].T + self._unit[:, 3], axis=1)
        slack = NEAR * (np.max(np.abs(self._unit[:, 3])) + np.max(np.abs(points), axis=1))
        chosen: list[tuple[int, ...]] = triples[worst <= slack].tolist()
        return chosen

    def normals(self) -> list[Vector]:
        """Directions across flat parts."""
        return [_placed(plane[:3], (0, 0, 0), self.columns) for plane in self.planes]

    def levels(self) -> list[Fraction]:
        """Offset k of each plane in the world: normal·x + k ≤ 0."""
        pairs = zip(self.normals(), self.planes, strict=True)
        return [plane[3] - dot(normal, self.position) for normal, plane in pairs]

    def faces(self, n: Vector) -> Weights:
        """Shares of the planes through the farthest corner."""
        local = tuple(dot(column, n) for column in self.columns)
        return cone(local, [(i, self.planes[i][:3]) for i in self.active[self.farthest(n)]])

    def place(self, point: Vector, mix: Mix = ()) -> Place:
        """Doubles, drawn in a little if that makes them lie inside; or else the exact point."""
        if not mix:
            return point
        for inwards in (0.0, 2.0**-52, 2.0**-50, 2.0**-47):
            here = doubles(point)
            drawn = tuple(c + inwards * (float(m) - c) for c, m in zip(here, self.middle, strict=True))
            if self.holds(drawn):
                return drawn
        return self.mean(mix)

    def holds(self, point: Vector) -> bool:
        """Whether a point lies inside, exactly."""
        offset = minus(exact(point), self.position)
        local = tuple(dot(column, offset) for column in self.columns)
        return all(dot(plane, local) + plane[3] <= 0 for plane in self.planes)


def _placed(y: Vector, position: Vector, columns: Sequence[Vector]) -> Vector:
    """Point position + R y."""
    x = position
    for c, column in zip(y, columns, strict=True):
        x = along(x, c, column)
    return x


def _scaled(n: Vector) -> Vector:
    """Doubles along n."""
    largest = max(abs(Fraction(c)) for c in n)
    x, y, z = (Fraction(c) / largest for c in n)
    return doubles((x, y, z))


def _meet(planes: Sequence[tuple[Any, ...]]) -> Vector | None:
    """Point that three planes have in common (Cramer)."""
    u, v, w = ((plane[0], plane[1], plane[2]) for plane in planes)
    a, b, c = (plane[3] for plane in planes)
    vw, wu, uv = cross(v, w), cross(w, u), cross(u, v)
    volume = dot(u, vw)
    if volume == 0:
        return None
    total = along(along(along((0, 0, 0), -a, vw), -b, wu), -c, uv)
    return total[0] / volume, total[1] / volume, total[2] / volume


def cone(n: Vector, normals: Sequence[tuple[int, Vector]]) -> Weights:
    """Shares ≥ 0 of up to three normals that add up to n, exactly; none if n is not in their cone (Carathéodory)."""
    for i, u in normals:
        if not any(cross(u, n)) and dot(u, n) > 0:
            return ((i, 1),)
    for (i, u), (j, v) in combinations(normals, 2):
        across = cross(u, v)
        if any(across) and dot(across, n) == 0:
            of_u, of_v = dot(cross(n, v), across), dot(cross(u, n), across)
            if of_u >= 0 and of_v >= 0:
                return (i, of_u), (j, of_v)
    for (i, u), (j, v), (k, w) in combinations(normals, 3):
        volume = dot(u, cross(v, w))
        if volume != 0:
            sizes = [x / volume for x in (dot(n, cross(v, w)), dot(n, cross(w, u)), dot(n, cross(u, v)))]
            if min(sizes) >= 0:
                return tuple(zip((i, j, k), sizes, strict=True))
    return ()


def _cylinder(shape: Any) -> Curved:
    p, q, radius = rationals(shape.p), rationals(shape.q), float(shape.radius)
    half = along((0, 0, 0), Fraction(1, 2), minus(q, p))
    way = _scaled(half)
    side = _scaled(cross(way, min(AXES, key=lambda axis: abs(dot(axis, way)))))
    disc = [along((0, 0, 0), radius / math.sqrt(dot(u, u)), u) for u in (side, cross(way, side))]
    return Curved(along(p, 1, half), [*disc, half], flat=True)


def body(shape: Any) -> Body:
    """Read a bounded convex proxy."""
    match type(shape).__name__:
        case "Ellipsoid":
            return _ellipsoid(shape)
        case "Cylinder":
            return _cylinder(shape)
        case "KDOP":
            lower, upper = rationals(shape.lower), rationals(shape.upper)
            ways = [rationals(way) for way in shape.directions]
            planes = [(*way, -high) for way, high in zip(ways, upper, strict=True)]
            planes += [(*opposite(way), low) for way, low in zip(ways, lower, strict=True)]
            return Planes(planes, (0, 0, 0), AXES)
        case "ConvexPolyhedron":
            return _polyhedron(shape)
    found = Corners(*core(shape))
    if isinstance(shape, AABB | Box):
        found.flat = [n for axis in frame(shape)[2] for n in (axis, opposite(axis))]
    return found


def _ellipsoid(shape: Any) -> Body:
    centre, radii = rationals(shape.center), rationals(shape.radii)
    if len(set(radii)) == 1:
        return Corners([centre], radii[0])
    axes = zip(radii, turned(shape.rotation), strict=True)
    return Curved(centre, [along((0, 0, 0), r, column) for r, column in axes], flat=False)


def _polyhedron(shape: Any) -> Body:
    numbers = [rationals(row) for row in shape.numbers]
    position, columns = rationals(shape.position), turned(shape.rotation)
    if shape.given == "planes":
        return Planes(numbers, position, columns)
    return Vertices([_placed(vertex, position, columns) for vertex in numbers])
