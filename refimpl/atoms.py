"""Unions as their convex atoms: the parts of a composite, the pieces or the faces of a polyhedron.

Atoms of one kind are one batch of proxies, so that many pairs of them are answered by one call, with a tree of boxes
that tells which pairs matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from refimpl.bounds import aabb
from refimpl.boxtree import BoxTree, gaps, near_pairs
from refimpl.derived import Derived
from refimpl.hulls import Hull
from refimpl.linear import Array, apply_inverse, rotation_matrix
from refimpl.proxy import Proxy
from refimpl.shapes import KDOP, Composite, ConvexPolyhedron, HalfSpace, Point, Polyhedron
from refimpl.signs import Indices
from refimpl.solids import Solid, face_hulls, piece_hulls

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

    def shifted(self, offset: Array) -> Group:
        """The group with its boxes translated, and its proxies where they were."""
        return replace(self, translation=self.translation + offset)


def leaves(shape: Proxy) -> list[Proxy]:
    """Parts of a single proxy that are no composites, in order."""
    if isinstance(shape, Composite):
        return [leaf for part in shape.parts for leaf in leaves(part)]
    return [shape]


def portions(shape: Proxy) -> list[Proxy]:
    """The same, with the surface of a mesh, of which all parts move as one, left whole."""
    if isinstance(shape, Composite) and shape.mesh is None:
        return [portion for part in shape.parts for portion in portions(part)]
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
            alike.setdefault(_form(part), []).append((number, part))
            number += 1
    for same in alike.values():
        proxies = stacked([part for _, part in same])
        tree = None if isinstance(proxies, HalfSpace) else _tree(proxies)
        found.append(Group(proxies, np.array([n for n, _ in same]), tree, STILL, np.zeros(3)))
    return found


def _form(part: Proxy) -> tuple[type[Proxy], str]:
    """What proxies have in common that can be in one batch."""
    return type(part), part.given if isinstance(part, ConvexPolyhedron) else ""


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
    parts = [part.broadcast_to((1,)) for part in parts]
    if len(parts) == 1:
        return parts[0]
    columns = [[value for value, _ in column] for column in zip(*(part._columns() for part in parts), strict=True)]
    sized = SIZED.get(type(parts[0]), 0)
    made = parts[0]._trusted(*(_after(column, i < sized) for i, column in enumerate(columns)))
    if sized:
        derived = [part.derived() for part in parts]
        different = list({id(d.table): d for d in derived}.values())
        starts = np.cumsum([0] + [len(d.digests) for d in different])
        first = {id(d.table): int(start) for d, start in zip(different, starts, strict=False)}
        which = np.concatenate([first[id(d.table)] + d.which for d in derived])
        exponent = np.concatenate([d.exponent for d in derived])
        table = _together([d.table for d in different])
        digests = np.concatenate([d.digests for d in different])
        object.__setattr__(made, "_derived", Derived(table, digests, which, exponent))
    return made


def _after(arrays: Sequence[NDArray[Any]], fill: bool) -> NDArray[Any]:
    """Batches one after the other; with `fill`, rows of the second axis are repeated up to the longest."""
    if fill:
        most = max(a.shape[1] for a in arrays)
        arrays = [a[:, np.minimum(np.arange(most), a.shape[1] - 1)] for a in arrays]
    return np.concatenate(arrays)


SIZED: dict[type[Proxy], int] = {KDOP: 3, ConvexPolyhedron: 1}  # how many fields are as long as the proxy's size


def _together(tables: Sequence[Hull]) -> Hull:
    """Tables of hulls one after the other; kept, for what is derived of a table is kept with it."""
    if len(tables) == 1:
        return tables[0]
    key = tuple(map(id, tables))
    if key in _TOGETHER:
        return _TOGETHER[key][1]
    vertices, planes, edges, active_planes, active_vertices = (
        _after([getattr(table, name) for table in tables], True) for name in HULL
    )
    dimension = np.concatenate([table.dimension for table in tables])
    whole = Hull(vertices, planes, edges, active_planes, active_vertices, dimension)
    _TOGETHER[key] = tables, whole  # the tables too, so that no other one gets their ids
    while len(_TOGETHER) > REMEMBERED:
        del _TOGETHER[next(iter(_TOGETHER))]
    return whole


REMEMBERED = 256  # combinations of hulls
_TOGETHER: dict[tuple[int, ...], tuple[Sequence[Hull], Hull]] = {}
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
    digests = np.array([_digest(v) for v in hulls.vertices]).reshape(-1, 2)
    index = np.arange(count)
    object.__setattr__(made, "_derived", Derived(hulls, digests, index, np.zeros(count, dtype=np.int64)))
    return made


def _digest(vertices: Array) -> list[float]:
    """Two doubles that tell an atom's vertices from others."""
    digest = blake2b(vertices.tobytes(), digest_size=12).digest()
    return [float(int.from_bytes(digest[:6], "big")), float(int.from_bytes(digest[6:], "big"))]


def candidates(x: Group, y: Group, bound: float, nearest: bool = True) -> tuple[Indices, Indices, Array]:
    """Pairs of atoms that may be nearest or may meet, with a lower bound of their distance; see `near_pairs`."""
    if x.tree is None or y.tree is None or len(x) * len(y) <= FEW:
        i, j = np.repeat(np.arange(len(x)), len(y)), np.tile(np.arange(len(y)), len(x))
        if x.tree is None or y.tree is None:
            return i, j, np.zeros(len(i))
        gap = gaps(x.tree.items.at(i), y.tree.items.at(j).moved(*_relative(x, y)))
        keep = np.flatnonzero(gap <= bound)
        keep = keep[np.argsort(gap[keep], kind="stable")]
        return i[keep], j[keep], gap[keep]
    return near_pairs(x.tree, y.tree, *_relative(x, y), bound, nearest)


def _relative(x: Group, y: Group) -> tuple[Array, Array]:
    """Rotation and translation from the frame of the second tree to that of the first."""
    columns = apply_inverse(x.rotation, y.rotation.T).T  # one column of y's frame after the other
    return columns, apply_inverse(x.rotation, y.translation - x.translation)
