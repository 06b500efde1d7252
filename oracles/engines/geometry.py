"""Rows of the types without a fixed form, taken apart for an engine: hulls, meshes, parts of composites.

What an engine makes of a geometry (a hull, a tree of boxes) is kept by its content in a `Kept`, since most scenes
of a batch share theirs; places and rotations are no part of it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from oracles.engine import Array, Kind, Row
from oracles.keeping import kept_by_rows
from refimpl.shapes import KDOP, Composite, ConvexPolyhedron, Polyhedron

T = TypeVar("T")
Key = tuple[float, ...]
Face = list[int]

ORIGIN, UPRIGHT = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]
MOST_KEPT = 256
MOST_HULLS = 1024
"""More hulls than a batch has: each query asks about all of them, and they take a few kilobytes each."""


class Kept(Generic[T]):
    """What was made of the geometries that were asked for last."""

    def __init__(self, make: Callable[[Key], T], most: int = MOST_KEPT) -> None:
        self._make, self._most = make, most
        self._made: OrderedDict[Key, T] = OrderedDict()

    def __getitem__(self, key: Key) -> T:
        """What is made of a geometry, now or before."""
        if key not in self._made:
            self._made[key] = self._make(key)
            if len(self._made) > self._most:
                self._made.popitem(last=False)
        self._made.move_to_end(key)
        return self._made[key]

    def clear(self) -> None:
        """Forget everything."""
        self._made.clear()


class Framed(NamedTuple):
    """A geometry by its numbers, and where it stands."""

    key: Key
    position: list[float]
    rotation: list[float]


def parts(kind: Kind, row: Row) -> list[tuple[Kind, Row]]:
    """A proxy as the parts that an engine holds one by one; most are their own only part."""
    return _PARTS[tuple(row)] if kind is Composite else [(kind, row)]


def _parts_of(key: Key) -> list[tuple[Kind, Row]]:
    found = []
    for part in Composite.unpack(np.array(key)).parts:
        found += parts(type(part), part.pack().tolist())
    return found


_PARTS: Kept[list[tuple[Kind, Row]]] = Kept(_parts_of)


# -- hulls ---------------------------------------------------------------------------------------------------


def polytope(kind: Kind, row: Row) -> Framed:
    """Geometry of a `KDOP`, which stands in the world as it is, or of a `ConvexPolyhedron`."""
    if kind is KDOP:
        return Framed((0.0, *row), ORIGIN, UPRIGHT)
    end = len(row) - 7
    return Framed((1.0, *row[:end]), row[end : end + 3], row[end + 3 :])


def _vertices(key: Key) -> Array:
    own, numbers = key[0] == 1.0, np.array(key[1:])
    if own and numbers[0] == 1.0:
        return np.unique(numbers[2:].reshape(-1, 3), axis=0)
    shape = ConvexPolyhedron(numbers[2:].reshape(-1, 4)) if own else KDOP.unpack(numbers)
    return np.unique(shape.hull.vertices, axis=0)


_VERTICES: Kept[Array] = Kept(_vertices, MOST_HULLS)


def vertices(key: Key) -> Array:
    """Vertices (m, 3) of a polytope in its own frame, no two of them equal: those given, or the corners, rounded."""
    return _VERTICES[key]


def different(points: Array) -> Array:
    """Vertices (n, m, 3) of a batch in order, no two of a row equal; a row with fewer than others repeats its last."""
    every, order = np.arange(len(points))[:, None], np.lexsort(np.moveaxis(points[..., ::-1], -1, 0), axis=-1)
    ordered = points[every, order]
    new = np.ones(ordered.shape[:-1], dtype=bool)
    new[:, 1:] = (ordered[:, 1:] != ordered[:, :-1]).any(axis=-1)
    counts = new.sum(axis=1)
    places = np.minimum(np.arange(counts.max()), counts[:, None] - 1)
    return np.asarray(ordered[every, np.take_along_axis(np.argsort(~new, axis=1, kind="stable"), places, axis=1)])


class Faced(NamedTuple):
    """A hull as vertices and faces, each of them a list of vertices, anticlockwise from outside."""

    vertices: Array
    faces: list[Face]


def _faced(key: Key) -> Faced:
    points = vertices(key)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # flat, or a segment or point: one face and its back
        ring = list(range(len(points)))
        return Faced(points, [ring, ring[::-1]])
    rank = {int(old): new for new, old in enumerate(hull.vertices)}
    a, b, c = (points[hull.simplices[:, i]] for i in range(3))
    inward = np.sum(np.cross(b - a, c - a) * hull.equations[:, :3], axis=1) < 0
    faces = []
    for corners, turn in zip(hull.simplices, inward, strict=True):
        face = [rank[int(i)] for i in corners]
        faces.append(face[::-1] if turn else face)
    return Faced(points[hull.vertices], faces)


_FACED: Kept[Faced] = Kept(_faced, MOST_HULLS)


def faced(key: Key) -> Faced:
    """A polytope in its own frame as a surface: without vertices inside."""
    return _FACED[key]


# -- meshes --------------------------------------------------------------------------------------------------


def solid(row: Row) -> Framed:
    """Geometry of a `Polyhedron`."""
    end = len(row) - 7
    return Framed(tuple(row[:end]), row[end : end + 3], row[end + 3 :])


def mesh(key: Key) -> tuple[Array, np.ndarray[tuple[int, ...], np.dtype[np.int64]]]:
    """Vertices (m, 3) and triangles (t, 3) of a mesh in its own frame."""
    m, t = int(key[0]), int(key[1])
    numbers = np.array(key[2:])
    return numbers[: 3 * m].reshape(m, 3), numbers[3 * m : 3 * (m + t)].reshape(t, 3).astype(np.int64)


@kept_by_rows
def surface(rows: Array) -> Composite:
    """One mesh in many poses as what engines take it for: the union of its triangles, which are flat hulls."""
    return Composite.of_faces(Polyhedron.unpack(rows))
