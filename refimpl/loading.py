"""Solids from mesh files, and from `trimesh` objects.

What a file holds is taken as it is: corners with the same coordinates become one vertex, since most formats cannot say
that they are one, and nothing else is changed unless a repair is asked for by name.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from refimpl.meshes import shells
from refimpl.meshfiles import FORMATS, FileError, form_of, numbers, parsed, read_bytes
from refimpl.proxy import ShapeError
from refimpl.repairs import REPAIRS, Mesh, merged
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron

LARGEST = 64 * 2**20  # bytes of a file
MOST_FACES = 200_000
MOST_PARTS = 4096


class LoadError(ShapeError):
    """A mesh could not be taken from where it was asked from; the text names the file, and where in it."""


def load_polyhedron(
    path: str | Path, *, scale: float = 1.0, repairs: Iterable[str] = (), largest: int = LARGEST
) -> Polyhedron:
    """Read the solid that a file's faces bound, all of them together.

    Parameters
    ----------
    path
        OBJ, OFF, PLY or STL, as its suffix says.
    scale : float
        Factor from the file's unit to the caller's.
    repairs : names out of `REPAIRS`, done in the order given
    largest : int
        Bytes that a file may have.

    Raises
    ------
    LoadError
        Where the file is missing, too large, of another format or broken, trimesh is not installed, or the faces are
        open, flipped, without area or intersecting: then it names the first such place.
    """
    name = str(path)
    return _polyhedron(name, _joined(_read(Path(path), largest, split=False)), scale, repairs)


def load_hulls(path: str | Path, *, scale: float = 1.0, largest: int = LARGEST) -> Composite:
    """Read a file of convex solids, such as V-HACD writes, as a composite of their hulls.

    Each connected surface of each object of the file is one solid; whether it is closed does not matter.

    Parameters
    ----------
    path, scale, largest
        As for `load_polyhedron`.
    """
    name = str(path)
    return _hulls(name, _read(Path(path), largest, split=True), scale)


def from_trimesh(mesh: Any, *, scale: float = 1.0, repairs: Iterable[str] = ()) -> Polyhedron:
    """Take the solid that a `trimesh.Trimesh`, or what else has `vertices` and `faces`, bounds."""
    return _polyhedron("trimesh object", _of_object(mesh), scale, repairs)


def hulls_from_trimesh(mesh: Any, *, scale: float = 1.0) -> Composite:
    """Take the hulls of the connected surfaces of a `trimesh.Trimesh`; see `load_hulls`."""
    return _hulls("trimesh object", [_of_object(mesh)], scale)


def _polyhedron(name: str, mesh: Mesh, scale: float, repairs: Iterable[str]) -> Polyhedron:
    vertices, triangles = merged(*mesh)
    for repair in repairs:
        if repair not in REPAIRS:
            raise LoadError(f"{name}: there is no repair {repair!r}; there are {', '.join(REPAIRS)}")
        vertices, triangles = merged(*REPAIRS[repair](vertices, triangles))
    try:
        return Polyhedron(_scaled(name, scale) * vertices, triangles)
    except ShapeError as error:
        raise LoadError(f"{name}: {error}") from None


def _hulls(name: str, meshes: list[Mesh], scale: float) -> Composite:
    factor = _scaled(name, scale)
    parts = []
    for mesh in meshes:
        vertices, triangles = merged(*mesh)
        label = shells(triangles, len(vertices))
        for i in range(int(label.max(initial=-1)) + 1):
            parts.append(factor * vertices[np.unique(triangles[label == i])])
            if len(parts) > MOST_PARTS:
                raise LoadError(f"{name}: more than {MOST_PARTS} separate surfaces")
    if not parts:
        raise LoadError(f"{name}: the mesh has no faces")
    try:
        return Composite([ConvexPolyhedron.from_vertices(part) for part in parts])
    except ShapeError as error:
        raise LoadError(f"{name}: {error}") from None


def _scaled(name: str, scale: float) -> float:
    if not (np.isfinite(scale) and scale > 0):
        raise LoadError(f"{name}: the scale must be positive and finite, got {scale!r}")
    return float(scale)


def _read(path: Path, largest: int, split: bool) -> list[Mesh]:
    """Meshes of a file, object by object where the format has objects and `split` asks for them."""
    form = form_of(path)
    if form not in FORMATS:
        raise LoadError(f"{path}: meshes are read from {', '.join(FORMATS)} files, this is {form or 'without suffix'}")
    try:
        found = parsed(read_bytes(path, largest), form, split=split)
    except FileError as error:
        raise LoadError(f"{path} {error}") from None
    return [_limited(str(path), mesh) for mesh in found]


def _of_object(mesh: Any) -> Mesh:
    """Checked arrays of anything with vertices and faces."""
    try:
        found = numbers(mesh)
    except FileError as error:
        raise LoadError(f"trimesh object {error}") from None
    return _limited("trimesh object", found)


def _limited(name: str, mesh: Mesh) -> Mesh:
    if len(mesh[1]) > MOST_FACES:
        raise LoadError(f"{name} is too large: {len(mesh[1])} faces, more than {MOST_FACES}")
    return mesh


def _joined(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    faces = [triangles + start for (_, triangles), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)
