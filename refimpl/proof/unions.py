"""What claims about unions prove, in exact arithmetic: part of what has to be believed.

A union is read as a list of parts, each of them convex or a solid mesh. Its atoms are its convex parts and the
triangles of its meshes. Solids are disjoint when their atoms are and none has anything inside a mesh of the other; and
they are then as far apart as their atoms.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

from refimpl.proof.bounds import bounds_of, gap
from refimpl.proof.claims import Bound, Claim, Cover, Part, Piece, Separated, Split
from refimpl.proof.rational import (
    MAX_ITEMS,
    Exact,
    InvalidCertificate,
    cross,
    direction,
    dot,
    index,
    items,
    minus,
    number,
    root,
    vector,
    whole,
)
from refimpl.proof.reading import Fields, placed, read
from refimpl.proof.sets import Hull, Line, Round, Solid

UNIONS = ("Composite", "Polyhedron")
DEPTH = 400  # of trees and of composites in composites
NOWHERE = [Fraction(0)] * 3

Atoms: TypeAlias = Sequence[tuple[int, Solid]]


class Mesh(NamedTuple):
    """The solid that a closed surface winds around."""

    vertices: Hull
    triangles: Sequence[tuple[int, int, int]]

    def atoms(self) -> list[Solid]:
        """Each triangle."""
        corners, unit = self.vertices.vertices, self.vertices.unit
        return [Hull([corners[i], corners[j], corners[k]], unit) for i, j, k in self.triangles]

    def contains(self, point: Exact) -> bool:
        """Whether the surface winds around a point, or around some point as near to it as one likes.

        Count the triangles above the point by their orientation. Whatever vanishes takes the sign that it has when
        the point is moved by (ε, ε², ε³); so no corner, edge or face is ever exactly above it or holds it.
        """
        (ints,), scale = whole([point])
        places = [
            [scale * c - self.vertices.unit * x for c, x in zip(corner, ints, strict=True)]
            for corner in self.vertices.vertices
        ]
        turns = 0
        for a, b, c in ((places[i], places[j], places[k]) for i, j, k in self.triangles):
            if min(a[0], b[0], c[0]) > 0 or max(a[0], b[0], c[0]) < 0 or max(a[2], b[2], c[2]) < 0:
                continue
            side = _side(a, b)
            if side and side == _side(b, c) == _side(c, a):
                n = cross(minus(b, a), minus(c, a))
                turns += side * (_first_sign(dot(n, a), -n[0], -n[1], -n[2]) == _first_sign(n[2]))
        return turns != 0

    def shells(self) -> list[Exact]:
        """A vertex of each connected part of the surface."""
        parent = list(range(len(self.vertices.vertices)))

        def top(i: int) -> int:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            return i

        for i, j, k in self.triangles:
            parent[top(i)] = parent[top(k)] = top(j)
        tops = {top(i) for i, _, _ in self.triangles}
        return [[Fraction(c, self.vertices.unit) for c in self.vertices.vertices[i]] for i in tops]


def _first_sign(*values: int) -> int:
    return next((1 if value > 0 else -1 for value in values if value), 0)


def _side(a: Sequence[int], b: Sequence[int]) -> int:
    """On which side of the edge ab, seen from above, the origin lies."""
    return _first_sign(a[0] * b[1] - a[1] * b[0], a[1] - b[1], b[0] - a[0])


class Union(NamedTuple):
    """Parts, and all of their atoms in order."""

    parts: Sequence[Solid | Mesh]
    atoms: Sequence[Solid]

    @property
    def meshes(self) -> list[Mesh]:
        """The parts that are not convex."""
        return [part for part in self.parts if isinstance(part, Mesh)]

    def samples(self, places: Any) -> list[Exact]:
        """A point of each convex part, as given, and of each connected part of a mesh's surface."""
        given = iter(items(places, "places", sum(not isinstance(part, Mesh) for part in self.parts)))
        found: list[Exact] = []
        for part in self.parts:
            if isinstance(part, Mesh):
                found += part.shells()
                continue
            point, outside = part.member(next(given), True)
            if outside > 0:
                raise InvalidCertificate("places: a point outside its part")
            found.append(point)
        return found

    def chosen(self, choice: Any) -> Solid:
        """A convex part: an atom, or a piece of a mesh."""
        if choice is None and len(self.parts) == 1:
            choice = 0
        if isinstance(choice, int):
            return self.atoms[index(choice, "of", len(self.atoms))]
        number_of, piece = items(choice, "of", 2)
        part = self.parts[index(number_of, "of", len(self.parts))]
        if not isinstance(part, Mesh) or not isinstance(piece, Piece):
            raise InvalidCertificate("of: not a piece of a mesh")
        return _piece(part, piece)


def _mesh(shape: Any) -> Mesh:
    field = Fields(shape)
    vertices = placed(field.rows("vertices", 3), *field.pose())
    triangles, edges = [], Counter[tuple[int, int]]()
    for row in field.indices("triangles", len(vertices.vertices)):
        i, j, k = row
        triangles.append((i, j, k))
        edges.update([(i, j), (j, k), (k, i)])
    if not edges or any(edges[i, j] != edges[j, i] for i, j in list(edges)):
        raise InvalidCertificate("Polyhedron.triangles: the surface is not closed")
    return Mesh(vertices, triangles)


def _parts(shape: Any, depth: int = 0) -> list[Solid | Mesh]:
    match type(shape).__name__:
        case "Composite":
            if depth > DEPTH:
                raise InvalidCertificate("Composite: nested too deeply")
            parts = items(getattr(shape, "parts", None), "Composite.parts")
            if not parts:
                raise InvalidCertificate("Composite.parts: none")
            return [found for part in parts for found in _parts(part, depth + 1)]
        case "Polyhedron":
            return [_mesh(shape)]
    solid = read(shape)
    if isinstance(solid, Line):
        raise InvalidCertificate("Composite: a ray is no part of a solid")
    return [solid]


def _union(shape: Any) -> Union:
    parts = _parts(shape)
    return Union(parts, [a for part in parts for a in (part.atoms() if isinstance(part, Mesh) else [part])])


def _piece(mesh: Mesh, piece: Piece) -> Hull:
    """The hull of a piece's vertices, once it is shown to lie in the solid."""
    points = [vector(v, "vertices") for v in items(piece.vertices, "vertices")]
    corners, unit = whole(points)
    hull = Hull(corners, unit, number(piece.radius, "radius"))
    edges = [minus(corner, corners[0]) for corner in corners]
    normals = [n for n in (cross(u, v) for u, v in pairwise(edges)) if any(n)]
    if hull.radius < 0 or not (hull.radius or any(dot(n, edge) for n in normals[:1] for edge in edges)):
        raise InvalidCertificate("vertices: the piece is flat, or its first vertices are on a line")
    middle = [sum((point[axis] for point in points), Fraction(0)) / len(points) for axis in range(3)]
    if _apart(piece.tree, [(0, hull)], list(enumerate(mesh.atoms())), _distance(NOWHERE)) < 0:
        raise InvalidCertificate("tree: a triangle may enter the piece")
    if not mesh.contains(middle):
        raise InvalidCertificate("vertices: the piece is not inside the solid")
    return hull


Leaf: TypeAlias = Callable[[Separated, Atoms, Atoms], Bound]


def _apart(tree: Any, a: Atoms, b: Atoms, leaf: Leaf, depth: int = 0) -> Bound:
    """Least of what the leaves of a tree prove; every atom of one side meets every atom of the other in one leaf."""
    if isinstance(tree, Separated):
        return leaf(tree, a, b) if a and b else math.inf
    if not isinstance(tree, Split) or depth > DEPTH:
        raise InvalidCertificate("tree: neither parted nor separated, or too deep")
    side, first = index(tree.side, "side", 2), {index(i, "first", MAX_ITEMS) for i in items(tree.first, "first")}
    one, other = items(tree.branches, "branches", 2)
    chosen = [atom for atom in (a, b)[side] if atom[0] in first]
    others = [atom for atom in (a, b)[side] if atom[0] not in first]
    if side == 0:
        return min(_apart(one, chosen, b, leaf, depth + 1), _apart(other, others, b, leaf, depth + 1))
    return min(_apart(one, a, chosen, leaf, depth + 1), _apart(other, a, others, leaf, depth + 1))


def _faces(given: Any) -> tuple[dict[int, Any], dict[int, Any]]:
    """Shares of the planes of each atom that has planes, by its number."""
    found: tuple[dict[int, Any], dict[int, Any]] = {}, {}
    for side, entries in zip(found, items(given, "faces", 2), strict=True):
        for entry in items(entries, "faces"):
            atom, shares_of = items(entry, "faces", 2)
            side[index(atom, "faces", MAX_ITEMS)] = shares_of
    return found


def _distance(shift: Exact) -> Leaf:
    """Leaf that bounds the distance of two groups of atoms, the second moved by `shift`."""

    def leaf(claim: Separated, a: Atoms, b: Atoms) -> Fraction:
        n, faces = direction(claim.n), _faces(claim.faces)
        low, high = root(Fraction(dot(n, n)))
        rise = -dot(n, shift)
        for way, atoms, shares in ((n, a, faces[0]), ([-c for c in n], b, faces[1])):
            rise += _height(atoms, way, high, shares)
        return Fraction(-rise) / (high if rise <= 0 else low)

    return leaf


def _height(atoms: Atoms, n: Sequence[int], length: Fraction, shares: dict[int, Any]) -> Fraction:
    """Support function of a group, at most; triangles of one mesh are compared as integers."""
    heights, levels = [], dict[int, int]()
    for number_of, atom in atoms:
        if isinstance(atom, Hull) and not atom.radius:
            level = max(n[0] * x + n[1] * y + n[2] * z for x, y, z in atom.vertices)
            levels[atom.unit] = max(level, levels.get(atom.unit, level))
        else:
            heights.append(atom.support(n, shares.get(number_of, ())) + atom.radius * length)
    return max([*heights, *(Fraction(level, unit) for unit, level in levels.items())])


def _free(ray: Line, time: Fraction | None, ray_first: bool) -> Leaf:
    """Leaf that shows a ray to be free of a group of atoms up to a time, or for ever."""
    part: Round | Line = ray
    if time is not None:
        (start, edge), unit = whole([ray.origin, minus(ray.at(time), ray.origin)])
        part = Round(start, [edge], unit, Fraction(0))

    def leaf(claim: Separated, a: Atoms, b: Atoms) -> Bound:
        n, faces = direction(claim.n), _faces(claim.faces)[ray_first]
        towards = n if ray_first else [-c for c in n]
        rises = time is not None and dot(towards, ray.direction) > 0  # then only the end of the segment may touch
        for number_of, solid in b if ray_first else a:
            _, side = gap(towards, part, solid, ((), faces.get(number_of, ())), solid.radius)
            if side < (0 if rises else 1):
                raise InvalidCertificate("n: the supporting planes do not leave a gap")
        return math.inf

    return leaf


def union_bounds(a: Any, b: Any) -> Callable[[Claim], tuple[Bound, Bound]]:
    """Bounds from one claim about two proxies of which one at least is a union."""
    if type(a).__name__ == "Ray" or type(b).__name__ == "Ray":
        ray_first = type(a).__name__ == "Ray"
        ray, solid = read(a if ray_first else b), _union(b if ray_first else a)
        assert isinstance(ray, Line)
        return lambda claim: _times(claim, ray, solid, ray_first)
    first, second = _union(a), _union(b)
    return lambda claim: _bounds(claim, first, second)


def _bounds(claim: Claim, a: Union, b: Union) -> tuple[Bound, Bound]:
    if isinstance(claim, Part):
        return -math.inf, bounds_of(claim.claim, a.chosen(claim.of_a), b.chosen(claim.of_b))[1]
    if not isinstance(claim, Cover) or claim.until is not None:
        raise InvalidCertificate(f"{type(claim).__name__}: not a claim about unions of solids")
    shift = vector(claim.shift, "shift")
    least = _apart(claim.tree, list(enumerate(a.atoms)), list(enumerate(b.atoms)), _distance(shift))
    if least <= 0:  # not even touching: a flat part between two others touches both, and is inside their union
        raise InvalidCertificate("tree: the planes do not leave a gap")
    of_a, of_b = items(claim.places, "places", 2)
    back = [-c for c in shift]
    for meshes, other, places, way in ((a.meshes, b, of_b, back), (b.meshes, a, of_a, shift)):
        points = other.samples(places) if meshes else []
        if any(mesh.contains(minus(point, way)) for mesh in meshes for point in points):
            raise InvalidCertificate("places: one lies inside the other")
    return (-root(dot(shift, shift))[1] if any(shift) else least), math.inf


def _times(claim: Claim, ray: Line, solid: Union, ray_first: bool) -> tuple[Bound, Bound]:
    if isinstance(claim, Part):
        part = solid.chosen(claim.of_b if ray_first else claim.of_a)
        return Fraction(0), bounds_of(claim.claim, ray, part)[1]
    if not isinstance(claim, Cover):
        raise InvalidCertificate(f"{type(claim).__name__}: not a claim about a ray and a union")
    time = None if claim.until is None else number(claim.until, "until")
    atoms: Atoms = list(enumerate(solid.atoms))
    itself: Atoms = [(0, Round([0, 0, 0], [], 1, Fraction(0)))]  # stands for the ray, which the leaves know
    sides = (itself, atoms) if ray_first else (atoms, itself)
    _apart(claim.tree, *sides, _free(ray, time, ray_first))
    if (time is not None and time < 0) or any(vector(claim.shift, "shift")):
        raise InvalidCertificate("until: before the start")
    if any(mesh.contains(ray.origin) for mesh in solid.meshes):
        raise InvalidCertificate("the ray starts inside")
    return math.inf if time is None else time, math.inf
