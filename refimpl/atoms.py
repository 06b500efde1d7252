"""Unions as their convex atoms: the parts of a composite, the pieces or the faces of a polyhedron.

Atoms of one kind are one batch of proxies, so that many pairs of them are answered by one call, with a tree of boxes
that tells which pairs matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from refimpl.bounds import aabb
from refimpl.boxtree import BoxTree, gaps, near_pairs
from refimpl.derived import of_hulls
from refimpl.hulls import Hull
from refimpl.linear import Array, apply_inverse, rotation_matrix
from refimpl.proxy import Proxy
from refimpl.shapes import KDOP, Composite, ConvexPolyhedron, HalfSpace, Point, Polyhedron
from refimpl.signs import Indices
from refimpl.solids import Solid, face_hulls, filled, piece_hulls

STILL = np.eye(3)
FEW = 64  # so many pairs are not worth a tree


@dataclass(frozen=True, eq=False)
class Group:
    """Convex atoms of one kind.

    Attributes
    ----------
    proxies : Proxy with one batch axis
        Where they are.
    numbers : (k,) int
        How they are called in contacts: pieces and parts are counted through.
    tree : BoxTree or None
        Boxes around them, before `rotation` and `translation`; None for unbounded ones.
    rotation, translation : (3, 3), (3,)
        Put the tree where the proxies are.
    """

    proxies: Proxy
    numbers: Indices
    tree: BoxTree | None
    rotation: Array
    translation: Array

    def __len__(self) -> int:
        return len(self.proxies)

    def moved(self, offset: Array) -> Group:
        """The group after a translation."""
        return replace(self, proxies=self.proxies.translated(offset), translation=self.translation + offset)


def leaves(shape: Proxy) -> list[Proxy]:
    """Parts of a single proxy that are no composites, in order."""
    if isinstance(shape, Composite):
        return [leaf for part in shape.parts for leaf in leaves(part)]
    return [shape]


def groups(parts: Sequence[Proxy], surfaces: bool = False) -> list[Group]:
    """Atoms of single proxies.

    Parameters
    ----------
    parts : sequence of Proxy
        As `leaves` gives them.
    surfaces : bool
        Take the faces of polyhedra, which need no splitting, for their pieces.
    """
    found: list[Group] = []
    alike: dict[tuple[Any, ...], list[tuple[int, Proxy]]] = {}
    number = 0
    for part in parts:
        if isinstance(part, Polyhedron):
            batches = surface_atoms(part.solid) if surfaces else piece_atoms(part.solid)
            found += [_posed(part, atoms, number) for atoms in batches]
            number += len(part.triangles) if surfaces else len(part.pieces)
        else:
            form = (
                type(part),
                *(size if i == 0 and part.header > 1 else _class(size) for i, size in enumerate(part.sizes)),
            )
            alike.setdefault(form, []).append((number, part))
            number += 1
    for same in alike.values():
        proxies = stacked([part for _, part in same])
        tree = None if isinstance(proxies, HalfSpace) else _tree(proxies)
        found.append(Group(proxies, np.array([n for n, _ in same]), tree, STILL, np.zeros(3)))
    return found


def _tree(proxies: Proxy) -> BoxTree:
    if isinstance(proxies, Point):
        return BoxTree(proxies.position, proxies.position)
    box = aabb(proxies)
    return BoxTree(box.lower, box.upper)


def _posed(part: Polyhedron, atoms: Atoms, number: int) -> Group:
    count = len(atoms.proxies)
    placed = atoms.proxies._placed(
        np.broadcast_to(part.position, (count, 3)), np.broadcast_to(part.rotation, (count, 4))
    )
    return Group(placed, number + atoms.numbers, atoms.tree, rotation_matrix(part.rotation), part.position)


def stacked(parts: Sequence[Any]) -> Any:
    """Single proxies of one type as a batch; those of fewer planes or vertices than others repeat their last."""
    if len(parts) == 1:
        return parts[0].broadcast_to((1,))
    columns = zip(*(part._columns() for part in parts), strict=True)
    sized = parts[0].header > 0
    made = parts[0]._trusted(
        *(
            filled([value for value, _ in column])
            if sized and i < SIZED[type(parts[0])]
            else np.stack([value for value, _ in column])
            for i, column in enumerate(columns)
        )
    )
    if sized:
        object.__setattr__(made, "_derived", of_hulls(_together([part.hull for part in parts])))
    return made


SIZED: dict[type[Proxy], int] = {KDOP: 3, ConvexPolyhedron: 1}  # how many fields are as long as the proxy's size


def _together(hulls: Sequence[Hull]) -> Hull:
    columns: list[Any] = [filled([getattr(hull, name) for hull in hulls]) for name in HULL]
    return Hull(*columns, np.array([hull.dimension for hull in hulls], dtype=np.int64))


HULL = ("vertices", "planes", "edges", "active_planes", "active_vertices")


def _class(size: int) -> int:
    """Binary logarithm, rounded up: sizes that agree in it are filled up to one another."""
    return max(size - 1, 1).bit_length()


class Atoms(NamedTuple):
    """Atoms of a mesh, in its own frame: convex polyhedra, their numbers, and the tree of their boxes."""

    proxies: ConvexPolyhedron
    numbers: Indices
    tree: BoxTree


_SURFACES: WeakKeyDictionary[Solid, list[Atoms]] = WeakKeyDictionary()
_PIECES: WeakKeyDictionary[Solid, list[Atoms]] = WeakKeyDictionary()


def surface_atoms(solid: Solid) -> list[Atoms]:
    """Faces of a solid as flat convex polyhedra; made once."""
    if solid not in _SURFACES:
        faces = _atoms(face_hulls(solid.corners))
        _SURFACES[solid] = [Atoms(faces, np.arange(len(solid.triangles)), solid.surface)]
    return _SURFACES[solid]


def piece_atoms(solid: Solid) -> list[Atoms]:
    """Convex pieces of a solid, those of about the same size together; made once."""
    if solid not in _PIECES:
        classes: dict[int, list[int]] = {}
        for number, piece in enumerate(solid.pieces):
            classes.setdefault(_class(len(piece.vertices)) // 2, []).append(number)
        made = []
        for numbers in classes.values():
            hulls = piece_hulls([solid.pieces[i] for i in numbers])
            tree = BoxTree(hulls.vertices.min(axis=1), hulls.vertices.max(axis=1))
            made.append(Atoms(_atoms(hulls), np.array(numbers), tree))
        _PIECES[solid] = made
    return _PIECES[solid]


def _atoms(hulls: Hull) -> ConvexPolyhedron:
    """Convex polyhedra of which the hulls are known."""
    count = len(hulls.vertices)
    identity = np.broadcast_to(np.array([0.0, 0.0, 0.0, 1.0]), (count, 4))
    made = ConvexPolyhedron._trusted(hulls.vertices, np.zeros((count, 3)), identity)
    object.__setattr__(made, "_derived", of_hulls(hulls))
    return made


def candidates(x: Group, y: Group, bound: float) -> tuple[Indices, Indices, Array]:
    """Pairs of atoms that may be nearest or may meet, with a lower bound of their distance; see `near_pairs`."""
    if x.tree is None or y.tree is None or len(x) * len(y) <= FEW:
        i, j = np.repeat(np.arange(len(x)), len(y)), np.tile(np.arange(len(y)), len(x))
        if x.tree is None or y.tree is None:
            return i, j, np.zeros(len(i))
        gap = gaps(x.tree.items.at(i), y.tree.items.at(j).moved(*_relative(x, y)))
        keep = np.flatnonzero(gap <= bound)
        keep = keep[np.argsort(gap[keep], kind="stable")]
        return i[keep], j[keep], gap[keep]
    return near_pairs(x.tree, y.tree, *_relative(x, y), bound)


def _relative(x: Group, y: Group) -> tuple[Array, Array]:
    """Rotation and translation from the frame of the second tree to that of the first."""
    columns = apply_inverse(x.rotation, y.rotation.T).T  # one column of y's frame after the other
    return columns, apply_inverse(x.rotation, y.translation - x.translation)
