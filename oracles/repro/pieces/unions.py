"""Unions of convex shapes, and solid meshes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from oracles.repro.pieces.claims import CLAIMS, Interval, sign_of, width_of
from oracles.repro.pieces.exact import (
    Refused,
    Vector,
    along,
    cross,
    dot,
    length,
    minus,
    number,
    require,
    times,
    vector,
    whole,
)
from oracles.repro.pieces.polytopes import Hull, Points, shares_of
from oracles.repro.pieces.solids import Solid


class Mesh:
    """The solid that a closed surface of triangles winds around."""

    def __init__(self, points: Points, triangles: Sequence[Sequence[int]]) -> None:
        self.points, self.triangles = points, triangles
        edges = Counter((t[i - 1], t[i]) for t in triangles for i in range(3))
        require(all(n == edges[j, i] for (i, j), n in list(edges.items())), "the surface of a mesh is not closed")

    def contains(self, point: Vector) -> bool:
        """Whether the surface winds around a point: the triangles above it, counted by their orientation.

        The point is moved by (ε, ε², ε³), so that no corner, edge or face is exactly above it.
        """
        ((x, y, z),), scale = whole([point])
        unit, turns = self.points.unit, 0
        for triangle in self.triangles:
            corners = [self.points.places[i] for i in triangle]
            aside = [scale * corner[0] > unit * x for corner in corners]
            if all(aside) or not any(scale * corner[0] >= unit * x for corner in corners):
                continue
            a, b, c = ([scale * u - unit * w for u, w in zip(corner, (x, y, z), strict=True)] for corner in corners)
            side = side_of(a, b)
            if side == side_of(b, c) == side_of(c, a):
                n = cross(minus(b, a), minus(c, a))
                turns += side * (first_sign(dot(n, a), -n[0], -n[1], -n[2]) == first_sign(n[2]))
        return turns != 0

    def shells(self) -> list[list[Fraction]]:
        """A vertex of each connected part of the surface."""
        part = list(range(len(self.points.places)))

        def first(i: int) -> int:
            while part[i] != i:
                part[i] = part[part[i]]
                i = part[i]
            return i

        for i, j, k in self.triangles:
            part[first(i)] = part[first(k)] = first(j)
        return [self.points.exactly(i) for i in {first(i) for i, _, _ in self.triangles}]


def first_sign(*values: Any) -> int:
    """Sign of the first number that is not 0."""
    return next((1 if value > 0 else -1 for value in values if value), 0)


def side_of(a: Vector, b: Vector) -> int:
    """On which side of the edge ab, seen from above, the origin lies."""
    return first_sign(a[0] * b[1] - a[1] * b[0], a[1] - b[1], b[0] - a[0])


def polyhedron(shape: Any) -> Mesh:
    """The solid bounded by a closed triangle surface."""
    triangles = [[int(i) for i in triangle] for triangle in shape["triangles"]]
    return Mesh(Points.of_frame(shape, "vertices"), triangles)


class Union:
    """Parts, convex ones and meshes; its atoms are the convex parts and the triangles of the meshes, in order."""

    def __init__(self, parts: Sequence[Any]) -> None:
        self.convex = [part for part in parts if not isinstance(part, Mesh)]
        self.meshes = {i: part for i, part in enumerate(parts) if isinstance(part, Mesh)}
        self.atoms: list[Any] = []
        for part in parts:
            self.atoms += [Hull(part.points, t) for t in part.triangles] if isinstance(part, Mesh) else [part]

    def height(self, n: Vector, chosen: Sequence[int], faces: Any) -> tuple[Any, Any]:
        """Find (h, r): n·x ≤ h + r ‖n‖ for all x of some atoms."""
        radius = max(self.atoms[i].radius for i in chosen)
        levels, corners = [], dict[Points, set[int]]()
        for i in chosen:
            atom = self.atoms[i]
            if isinstance(atom, Hull) and atom.radius == radius:
                corners.setdefault(atom.points, set()).update(atom.corners)
            else:
                lack = radius - atom.radius
                levels.append(atom.support(n, shares_of(faces, i)) - (lack * length(n)[0] if lack else 0))
        return max([*levels, *(points.highest(n, some) for points, some in corners.items())]), radius

    def contains(self, point: Vector) -> bool:
        """Whether a mesh contains a point."""
        return any(mesh.contains(point) for mesh in self.meshes.values())

    def samples(self, places: Any) -> list[Vector]:
        """A point of each convex part, as given, and of each connected part of a mesh."""
        found: list[Vector] = [point for mesh in self.meshes.values() for point in mesh.shells()]
        for part, place in zip(self.convex, places, strict=True):
            point, outside = part.member(place, True)
            require(outside == 0, "a point lies outside its part")
            found.append(point)
        return found


def gaps(tree: Any, a: Union, b: Union, shift: Vector = (0, 0, 0)) -> Iterator[tuple[Vector, Any, Any]]:
    """For each leaf of a tree of directions: n, the room that planes across it leave, times ‖n‖, and all radii.

    Each node parts the atoms of one side; so every atom of A meets every one of B in one leaf. B is moved by `shift`.
    """
    waiting = [(tree, list(range(len(a.atoms))), list(range(len(b.atoms))))]
    while waiting:
        node, of_a, of_b = waiting.pop()
        if node["kind"] == "split":
            first = set(node["first"])
            group = of_b if node["side"] else of_a
            halves = [i for i in group if i in first], [i for i in group if i not in first]
            for branch, half in zip(node["branches"], halves, strict=True):
                waiting.append((branch, of_a, half) if node["side"] else (branch, half, of_b))
        elif of_a and of_b:
            n, (faces_a, faces_b) = vector(node["n"]), node["faces"]
            require(any(n), "a direction must not be 0")
            (high_a, radius_a), (high_b, radius_b) = a.height(n, of_a, faces_a), b.height(times(-1, n), of_b, faces_b)
            yield n, dot(n, shift) - high_a - high_b, radius_a + radius_b


def cover(claim: Any, a: Union, b: Union) -> Interval:
    """σ ≥ L, or σ ≥ −‖shift‖: with B moved by `shift`, planes part all atoms, and nothing is inside a mesh."""
    shift, least = vector(claim["shift"]), math.inf
    for n, room, radius in gaps(claim["tree"], a, b, shift):
        require(sign_of(room, n, radius) > 0, "the planes across n leave no gap")
        least = min(least, width_of(room, n, radius))
    of_a, of_b = claim["places"]
    for mesh, other, places, way in ((a, b, of_b, shift), (b, a, of_a, times(-1, shift))):
        for point in other.samples(places) if mesh.meshes else []:
            require(not mesh.contains(along(point, 1, way)), "one lies inside the other")
    return (-length(shift)[1] if any(shift) else max(least, 0)), math.inf


def part(claim: Any, a: Union, b: Union) -> Interval:
    """σ ≤ what a claim proves about a convex part of A and one of B."""
    one, other = chosen(a, claim["of_a"]), chosen(b, claim["of_b"])
    return -math.inf, CLAIMS[claim["claim"]["kind"]](claim["claim"], one, other)[1]


def chosen(side: Union, choice: Any) -> Any:
    """An atom, the only part, or a convex piece inside a mesh."""
    if choice is None:
        require(len(side.atoms) == 1, "more than one part")
        return side.atoms[0]
    if isinstance(choice, int):
        require(0 <= choice < len(side.atoms), "no such part")
        return side.atoms[choice]
    mesh, piece = choice
    return piece_of(side.meshes[mesh], piece)


def piece_of(mesh: Mesh, piece: Any) -> Solid:
    """The hull of some points, widened by a ball: no triangle enters it, and its middle lies in the solid."""
    points, radius = Points([vector(v) for v in piece["vertices"]]), number(piece["radius"])
    hull = Hull(points, range(len(points.places)), radius)
    edges = [minus(place, points.places[0]) for place in points.places]
    normal = next((n for n in map(cross, edges[1:], edges[2:]) if any(n)), (0, 0, 0))
    require(radius >= 0 and (radius or any(dot(normal, edge) for edge in edges)), "a flat piece")
    for n, room, radii in gaps(piece["tree"], Union([hull]), Union([mesh])):
        if sign_of(room, n, radii) < 0:
            raise Refused("a triangle may enter a piece")
    middle = [Fraction(sum(column), points.unit * len(edges)) for column in zip(*points.places, strict=True)]
    require(mesh.contains(middle), "a piece does not lie inside the solid")
    return hull
