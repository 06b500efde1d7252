"""Unions of convex sets and solid meshes, in exact arithmetic: part of what has to be believed.

A union is read as a list of parts, each of them convex or a solid mesh. Its atoms are its convex parts and the
triangles of its meshes. Solids are disjoint when their atoms are and none has anything inside a mesh of the other; and
they are then as far apart as their atoms. A convex proxy, and a ray, is a union of one part.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.plane import PLANE, read
from refimpl.proof.rational import items, require, spend, surface, whole
from refimpl.proof.reading import Fields, placed
from refimpl.proof.sets import Hull, Line, Points, Solid
from refimpl.proof.vectors import NONE, Exact, Whole, cross, dot, minus, root, times

DEPTH = 400  # of composites in composites

Corners: TypeAlias = tuple[int, int, int]


class Mesh(NamedTuple):
    """The solid that a closed surface winds around."""

    points: Points
    triangles: Sequence[Corners]

    def contains(self, point: Exact) -> bool:
        """Whether the surface winds around a point, or around some point as near to it as one likes.

        Count the triangles above the point by their orientation. Whatever vanishes takes the sign that it has when
        the point is moved by (ε, ε², ε³); so no corner, edge or face is ever exactly above it or holds it.
        """
        spend(2 * len(self.triangles))
        (ints,), scale = whole([point])
        origin, places = times(self.points.unit, ints), self.points.places
        aside = [scale * place[0] - origin[0] for place in places]
        turns = 0
        for i, j, k in self.triangles:
            u, v, w = aside[i], aside[j], aside[k]
            if (u > 0 and v > 0 and w > 0) or (u < 0 and v < 0 and w < 0):
                continue
            a, b, c = (minus(times(scale, places[corner]), origin) for corner in (i, j, k))
            side = _side(a, b)
            if side == _side(b, c) == _side(c, a):
                n = cross(minus(b, a), minus(c, a))
                turns += side * (_first_sign(dot(n, a), -n[0], -n[1], -n[2]) == _first_sign(n[2]))
        return turns != 0

    def shells(self) -> list[Exact]:
        """A vertex of each connected part of the surface."""
        spend(4 * len(self.triangles))
        parent = list(range(len(self.points.places)))

        def top(i: int) -> int:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            return i

        for i, j, k in self.triangles:
            parent[top(i)] = parent[top(k)] = top(j)
        tops = {top(i) for i, _, _ in self.triangles}
        return [times(Fraction(1, self.points.unit), self.points.places[i]) for i in tops]


def _first_sign(*values: int) -> int:
    return next((1 if value > 0 else -1 for value in values if value), 0)


def _side(a: Sequence[int], b: Sequence[int]) -> int:
    """On which side of the edge ab, seen from above, the origin lies."""
    return _first_sign(a[0] * b[1] - a[1] * b[0], a[1] - b[1], b[0] - a[0])


class Union:
    """Convex parts and meshes by their numbers, and all of their atoms in order."""

    def __init__(self, parts: Sequence[Solid | Mesh | Line]) -> None:
        self.convex: dict[int, Solid | Line] = {}
        self.meshes: dict[int, Mesh] = {}
        self.atoms: list[Solid | Line] = []
        for i, part in enumerate(parts):
            if isinstance(part, Mesh):
                self.meshes[i] = part
                self.atoms += [Hull(part.points, corners) for corners in part.triangles]
            else:
                self.convex[i] = part
                self.atoms.append(part)

    def alone(self) -> Solid | Line:
        """The only part, which is convex."""
        require(len(self.convex) == 1 and not self.meshes, "a claim about convex shapes, made about a union")
        return self.convex[0]

    def height(self, n: Whole, chosen: Iterable[int], faces: Mapping[int, Any]) -> tuple[Fraction, Fraction]:
        """Find (h, r): the support function of some atoms is at most h + r·‖n‖; exactly, if their radii are equal."""
        levels: list[tuple[Fraction, Fraction]] = []
        hulls: dict[Points, list[Sequence[int]]] = {}
        for i in chosen:
            atom = self.atoms[i]
            if isinstance(atom, Hull) and not atom.radius:
                hulls.setdefault(atom.points, []).append(atom.corners)
            else:
                levels.append((atom.support(n, faces.get(i, ())), atom.radius))
        levels += [(points.support(n, set[int]().union(*corners)), NONE) for points, corners in hulls.items()]
        radius = max([r for _, r in levels])
        if any(r != radius for _, r in levels):
            least = root(Fraction(dot(n, n)))[0]
            levels = [(h - (radius - r) * least, radius) for h, r in levels]
        return max([h for h, _ in levels]), radius

    def contains(self, point: Exact) -> bool:
        """Whether one of the meshes contains a point."""
        return any(mesh.contains(point) for mesh in self.meshes.values())

    def samples(self, places: Any) -> list[Exact]:
        """A point of each convex part, as given, and of each connected part of a mesh's surface."""
        found = [point for mesh in self.meshes.values() for point in mesh.shells()]
        for part, place in zip(self.convex.values(), items(places, "places", len(self.convex)), strict=True):
            assert not isinstance(part, Line)
            point, outside = part.member(place, True)
            require(outside == 0, "places: a point outside its part")
            found.append(point)
        return found


def _mesh(shape: Any) -> Mesh:
    field = Fields(shape)
    points = placed(field, "vertices")
    return Mesh(points, surface(field.values("triangles"), "Polyhedron.triangles", len(points.places)))


def parts_of(shape: Any, depth: int = 0) -> list[Solid | Mesh | Line]:
    """Read any proxy: its parts, those of composites in it too."""
    kind = type(shape).__name__
    if kind == "Composite":
        parts = items(getattr(shape, "parts", None), "Composite.parts")
        require(parts and depth <= DEPTH, "Composite.parts: none, or nested too deeply")
        return [found for part in parts for found in parts_of(part, depth + 1)]
    require(depth == 0 or kind not in {"Ray", *PLANE}, f"Composite: a {kind} is no part of a solid")
    return [_mesh(shape) if kind == "Polyhedron" else read(shape)]
