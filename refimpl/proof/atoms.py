"""Unions as the search sees them: convex atoms with boxes around them, and trees of directions between two groups.

Nothing here has to be believed: what is found is handed on as a certificate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import rotation_matrix
from refimpl.proof.bodies import Body, Corners, Curved
from refimpl.proof.claims import Separated, Split, Tree, Weights
from refimpl.proof.convex import exact_nearest, plain
from refimpl.proof.planes import Planes
from refimpl.proof.points import Vector, along, exact, opposite
from refimpl.proof.search import Grid, nearest
from refimpl.proof.solids import body
from refimpl.shapes import Composite, ConvexPolyhedron, HalfSpace, Polyhedron, Proxy

Floats = NDArray[np.float64]
FAR = 1e300  # half-spaces reach everywhere
ROUNDING = 2.0**-49
WORTH = 0.4  # of the atoms of one side: worth a direction of their own
MANY = 10_000  # pairs of atoms in boxes that overlap: parted before any direction is searched


class Unproven(Exception):
    """No direction was found for some atoms."""


class Atom:
    """A convex part of a union, or a triangle of a mesh, moved by `shift`."""

    def __init__(self, number: int, shape: Proxy | Callable[[], Proxy], shift: Floats | None = None) -> None:
        self.number, self._shape = number, shape
        self.shift = np.zeros(3) if shift is None else shift
        self.corners: Floats | None = None

    @cached_property
    def shape(self) -> Proxy:
        """The atom as a proxy, not moved."""
        return self._shape if isinstance(self._shape, Proxy) else self._shape()

    def moved(self, shift: Floats) -> Atom:
        """The same atom elsewhere."""
        made = Atom(self.number, self._shape, self.shift + shift)
        made.corners = self.corners
        if made.corners is None:
            made.body = self.body
        return made

    @property
    def is_space(self) -> bool:
        """Whether it is a half-space."""
        return self.corners is None and isinstance(self.shape, HalfSpace)

    @cached_property
    def body(self) -> Body:
        """Its support points; none for a half-space."""
        return Body() if isinstance(self.shape, HalfSpace) else body(self.shape)

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Corners of a box around it."""
        if self.corners is not None:
            return self.corners.min(axis=0) + self.shift, self.corners.max(axis=0) + self.shift
        core = self.body
        if isinstance(core, Corners):
            low, high = core.floats.min(axis=0), core.floats.max(axis=0)
        elif isinstance(core, Curved):
            reach = np.sum(np.abs(np.array(core.axes)), axis=0)
            low, high = np.array(core.centre) - reach, np.array(core.centre) + reach
        else:
            return np.full(3, -FAR), np.full(3, FAR)
        widening = float(core.radius)
        return low - widening + self.shift, high + widening + self.shift


def atoms_of(shape: Proxy, shift: Floats | None = None) -> list[Atom]:
    """All atoms of a proxy, in the checker's order."""
    found: list[Atom] = []
    for part in parts_of(shape):
        if not isinstance(part, Polyhedron):
            found.append(Atom(len(found), part, shift))
            continue
        placed = part.vertices @ rotation_matrix(part.rotation).T + part.position
        for triangle in part.triangles:
            found.append(Atom(len(found), partial(_triangle, part, triangle), shift))
            found[-1].corners = placed[triangle]
    return found


def _triangle(mesh: Polyhedron, triangle: Any) -> Proxy:
    return ConvexPolyhedron.from_vertices(mesh.vertices[triangle], mesh.position, mesh.rotation)


def parts_of(shape: Proxy) -> list[Proxy]:
    """Parts that are convex or meshes."""
    if isinstance(shape, Composite):
        return [found for part in shape.parts for found in parts_of(part)]
    return [shape]


class Group(Body):
    """The hull of several atoms, for the search of a direction; with a `way`, of what they sweep along it."""

    def __init__(self, whole: Sequence[Atom], way: Floats | None = None) -> None:
        self.atoms, self.way = whole, way
        atoms = self.placed = whole if way is None else [*whole, *(atom.moved(way) for atom in whole)]
        points = [atom.corners + atom.shift for atom in atoms if atom.corners is not None]
        radii = [0.0] * (3 * len(points))
        cores = [(atom.body, atom.shift) for atom in atoms if atom.corners is None]
        for core, shift in cores:
            if isinstance(core, Corners):
                points.append(core.floats + shift)
                radii += [float(core.radius)] * len(core.floats)
        self.points = np.concatenate(points) if points else np.zeros((0, 3))
        self.radii = np.array(radii)
        self.curved = [(core, shift) for core, shift in cores if isinstance(core, Curved)]
        boxes = [atom.box for atom in atoms]
        self.low, self.high = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)

    @property
    def extent(self) -> float:
        """Largest coordinate."""
        return float(max(np.max(np.abs(self.low)), np.max(np.abs(self.high))))

    def support(self, n: Vector) -> tuple[Vector, int]:
        """Farthest point of all atoms; n has about unit length."""
        way = np.array(n)
        length = math.sqrt(way @ way)
        found = []
        if len(self.points):
            heights = self.points @ way + self.radii * length
            i = int(np.argmax(heights))
            found.append((float(heights[i]), self.points[i] + self.radii[i] / length * way))
        for core, shift in self.curved:
            point = np.array(core.support(n)[0]) + shift
            found.append((float(point @ way), point))
        x, y, z = max(found, key=lambda pair: pair[0])[1].tolist()
        return (x, y, z), -1

    def levels(self, n: Vector) -> Floats:
        """How far each atom reaches along n."""
        way = np.array(n)
        flat = [i for i, atom in enumerate(self.placed) if atom.corners is not None]
        found = np.empty(len(self.placed))
        found[flat] = (self.points[: 3 * len(flat)] @ way).reshape(-1, 3).max(axis=1)
        for i, atom in enumerate(self.placed):
            if atom.corners is None:
                point = np.array(atom.body.support(n)[0]) + atom.shift
                found[i] = way @ point + float(atom.body.radius) * math.hypot(*n)
        return found if self.way is None else np.maximum(*np.split(found, 2))

    def halves(self) -> tuple[list[Atom], list[Atom]]:
        """Two groups on either side of the middle of the longest extent."""
        middles = np.array([(atom.box[0] + atom.box[1]) / 2 for atom in self.atoms])
        axis = int(np.argmax(np.max(middles, axis=0) - np.min(middles, axis=0)))
        order = np.argsort(middles[:, axis], kind="stable").tolist()
        half = len(order) // 2
        return [self.atoms[i] for i in order[:half]], [self.atoms[i] for i in order[half:]]


def gap_along(a: Group, b: Group, n: Vector) -> float:
    """Gap that planes across n leave, in floats."""
    way = np.array(n)
    length = math.sqrt(way @ way)
    if not length:
        return -math.inf
    way /= length
    unit: Vector = tuple(way.tolist())
    return float(way @ np.array(b.support(opposite(unit))[0]) - way @ np.array(a.support(unit)[0]))


class Directions:
    """Builds a tree of directions that leave a gap of at least `least`, all along the `course` of B if there is one."""

    def __init__(self, least: float, guesses: Sequence[Vector], course: Floats | None = None) -> None:
        self.least, self.guesses, self.course = least, list(guesses), course

    def build(self, a: Sequence[Atom], b: Sequence[Atom], inherited: Vector | None = None) -> Tree:
        """Find one direction for all, or part the larger group."""
        for side, atoms in ((0, a), (1, b)):
            spaces = [atom for atom in atoms if atom.is_space]
            if spaces:
                return self._off(side, spaces[0], a, b)
        one, other = Group(a), Group(b, self.course)
        best, normal = self._best(one, other, inherited)
        if best >= self.least:
            return _leaf(normal, a, b)
        if len(a) == len(b) == 1:
            return _leaf(self._exactly(a[0], b[0], normal), a, b)
        peeled = self._peeled(one, other, [normal, *([inherited] if inherited else [])])
        if peeled is not None:
            return peeled
        by_size = float(np.max(one.high - one.low)) >= float(np.max(other.high - other.low))
        side = 0 if len(b) == 1 or (len(a) > 1 and by_size) else 1
        left, right = (one, other)[side].halves()
        branches = (
            (self.build(left, b, normal), self.build(right, b, normal))
            if side == 0
            else (self.build(a, left, normal), self.build(a, right, normal))
        )
        return Split(side, tuple(atom.number for atom in left), branches)

    def _best(self, one: Group, other: Group, inherited: Vector | None) -> tuple[float, Vector]:
        """Largest gap along the directions at hand, and its direction; then along one that is searched."""
        boxes = np.concatenate([other.low - one.high, one.low - other.high])
        widest = int(np.argmax(boxes))
        x, y, z = (math.copysign(1.0, 2.5 - widest) * (k == widest % 3) for k in range(3))
        known: list[Vector] = [(x, y, z), *self.guesses, *([inherited] if inherited else [])]
        best = max(((gap_along(one, other, n), n) for n in known), key=lambda pair: pair[0])
        if best[0] >= self.least or (boxes[widest] < 0 and len(one.atoms) * len(other.atoms) > MANY):
            return best
        for way in nearest(Grid(one, other)).normals:
            n = plain(way)
            best = max(best, (gap_along(one, other, n), n), key=lambda pair: pair[0])
        return best

    def _peeled(self, one: Group, other: Group, normals: Sequence[Vector]) -> Tree | None:
        """Part off what one direction separates from all of the other side, if that is much."""
        most, found = WORTH, None
        for n in normals:
            away = one.levels(n), other.levels(opposite(n))
            least = self.least * math.hypot(*n)
            for side, group in enumerate((one, other)):
                off = away[side] + np.max(away[1 - side]) <= -least
                share = np.count_nonzero(off) / len(group.atoms)
                if most < share < 1:
                    most, found = share, (side, n, off)
        if found is None:
            return None
        side, n, off = found
        atoms = (one, other)[side].atoms
        parted = [atom for atom, gone in zip(atoms, off, strict=True) if gone]
        rest = [atom for atom, gone in zip(atoms, off, strict=True) if not gone]
        if side == 0:
            branches = _leaf(n, parted, other.atoms), self.build(rest, other.atoms, n)
        else:
            branches = _leaf(n, one.atoms, parted), self.build(one.atoms, rest, n)
        return Split(side, tuple(atom.number for atom in parted), branches)

    def _exactly(self, a: Atom, b: Atom, normal: Vector) -> Vector:
        """Direction between two atoms; exact where both have corners."""
        core, other = a.body, b.body
        if isinstance(core, Corners) and isinstance(other, Corners):
            shift = exact(b.shift.tolist())
            moved = Corners([along(other.corner(i), 1, shift) for i in range(len(other.floats))])
            found = exact_nearest(core, moved)[0].normal
            if any(found):
                way = plain(found)
                roomy = gap_along(Group([a]), Group([b]), way) >= max(self.least, ROUNDING * Group([a, b]).extent)
                return way if roomy else found
        if gap_along(Group([a]), Group([b]), normal) < self.least - 1e-9 * abs(self.least):
            raise Unproven
        return normal

    def _off(self, side: int, space: Atom, a: Sequence[Atom], b: Sequence[Atom]) -> Tree:
        """Part off a half-space, which has a supporting plane along its own normal only."""
        normal: Vector = tuple(space.shape.normal.tolist())  # type: ignore[attr-defined]
        n = normal if side == 0 else opposite(normal)
        rest = [atom for atom in (a, b)[side] if atom is not space]
        leaf = _leaf(n, [space] if side == 0 else a, b if side == 0 else [space])
        if not rest:
            return leaf
        return Split(side, (space.number,), (leaf, self.build(rest, b) if side == 0 else self.build(a, rest)))


def _leaf(n: Vector, a: Sequence[Atom], b: Sequence[Atom]) -> Separated:
    def faces(atoms: Sequence[Atom], way: Vector) -> tuple[tuple[int, Weights], ...]:
        with_planes = [atom for atom in atoms if atom.corners is None and isinstance(atom.body, Planes)]
        return tuple((atom.number, atom.body.faces(way)) for atom in with_planes)

    return Separated(n, None, (faces(a, exact(n)), faces(b, opposite(exact(n)))))


def boxes_of(atoms: Sequence[Atom]) -> tuple[Floats, Floats]:
    """Boxes of all atoms, as arrays."""
    return np.array([atom.box[0] for atom in atoms]), np.array([atom.box[1] for atom in atoms])


def near_pairs(a: Sequence[Atom], b: Sequence[Atom], reach: float) -> list[tuple[int, int]]:
    """Pairs of atoms whose boxes are no farther apart than `reach`, nearest boxes first."""
    (low_a, high_a), (low_b, high_b) = boxes_of(a), boxes_of(b)
    square = np.zeros((len(a), len(b)))
    for k in range(3):
        beyond = np.maximum(low_b[None, :, k] - high_a[:, None, k], low_a[:, None, k] - high_b[None, :, k])
        square += np.maximum(beyond, 0.0) ** 2
    chosen = np.argwhere(square <= reach * reach)
    order = np.argsort(square[chosen[:, 0], chosen[:, 1]], kind="stable")
    found: list[tuple[int, int]] = [(int(i), int(j)) for i, j in chosen[order]]
    return found
