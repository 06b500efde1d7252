"""Solids from mesh files, and from `trimesh` objects.

What a file holds is taken as it is: corners with the same coordinates become one vertex, since most formats cannot say
that they are one, and nothing else is changed unless a repair is asked for by name.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from refimpl.linear import Array
from refimpl.meshes import Triangles, shells
from refimpl.meshfiles import FORMATS, NO_FACES, FileError, form_of, numbers, parsed, read_bytes
from refimpl.pointfiles import CLOUDS, points_in
from refimpl.proxy import ShapeError
from refimpl.repairs import REPAIRS, Mesh, merged
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron

LARGEST = 64 * 2**20  # bytes of a file
MOST_FACES = 200_000
"""Faces of a solid; a file may have more, which a repair has to make fewer."""
MOST_READ = 2_000_000
MOST_PARTS = 4096
MOST_WORK = 100_000_000
"""Separate surfaces times faces: of each surface it is found out in how many others it lies."""
POINTS_ONLY = "hull"
"""The repair that needs no face."""


class LoadError(ShapeError):
    """A mesh could not be taken from where it was asked from; the text names the file, and where in it."""


def load_polyhedron(
    path: str | Path, *, scale: float = 1.0, repairs: Iterable[str] = (), largest: int = LARGEST
) -> Polyhedron:
    """Read the solid that a file's faces bound, all of them together.

    Parameters
    ----------
    path
        OBJ, OFF, PLY or STL, as its suffix says. If the repair "hull" is asked for first, also points: XYZ, TXT, CSV or
        NPY, or a mesh file without faces.
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
    repairs = tuple(repairs)
    return polyhedron_of(str(path), read_faces(path, repairs, largest), scale=scale, repairs=repairs)


def read_faces(path: str | Path, repairs: Iterable[str] = (), largest: int = LARGEST) -> Mesh:
    """All vertices and triangles of a file, as `load_polyhedron` begins with; its arguments and errors.

    Where the first repair is the hull, points are triangles too, three at a time.
    """
    path, hull = Path(path), next(iter(repairs), "") == POINTS_ONLY
    if form_of(path) in CLOUDS:
        if not hull:
            raise LoadError(f"{path} holds points, which bound no solid: only their convex hull does")
        return _points(path, largest)
    try:
        return _joined(_read(path, largest, split=False))
    except LoadError as error:
        if not hull or NO_FACES not in str(error):
            raise
        return _points(path, largest)


def _points(path: Path, largest: int) -> Mesh:
    """Points of a file, each in a triangle: three at a time, the last one perhaps again."""
    try:
        points = points_in(read_bytes(path, largest), form_of(path))
    except FileError as error:
        raise LoadError(f"{path} {error}") from None
    return points, np.minimum(np.arange(len(points) + 2), len(points) - 1)[: -(-len(points) // 3) * 3].reshape(-1, 3)


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
    return polyhedron_of("trimesh object", _of_object(mesh), scale=scale, repairs=repairs)


def hulls_from_trimesh(mesh: Any, *, scale: float = 1.0) -> Composite:
    """Take the hulls of the connected surfaces of a `trimesh.Trimesh`; see `load_hulls`."""
    return _hulls("trimesh object", [_of_object(mesh)], scale)


def polyhedron_of(name: str, mesh: Mesh, *, scale: float = 1.0, repairs: Iterable[str] = ()) -> Polyhedron:
    """Take the solid that triangles bound after repairs; raises `LoadError`, which begins with a name."""
    for repair in (repairs := tuple(repairs)):
        if repair not in REPAIRS:
            raise LoadError(f"{name}: there is no repair {repair!r}; there are {', '.join(REPAIRS)}")
    if not repairs:
        _require_moderate(name, mesh[1])
    vertices, triangles = merged(*mesh)
    try:
        for repair in repairs:
            vertices, triangles = merged(*REPAIRS[repair](vertices, triangles))
        _require_moderate(name, triangles)
        _require_few_surfaces(name, vertices, triangles)
        return Polyhedron(_scaled(name, scale) * vertices, triangles)
    except LoadError:
        raise
    except ShapeError as error:
        raise LoadError(f"{name}: {error}") from None


def _require_moderate(name: str, triangles: Triangles) -> None:
    """Refuse what would be searched for defects for minutes."""
    if len(triangles) > MOST_FACES:
        raise LoadError(f"{name} is too large: {len(triangles)} faces, more than {MOST_FACES}")


def _require_few_surfaces(name: str, vertices: Array, triangles: Triangles) -> None:
    surfaces = int(shells(triangles, len(vertices)).max(initial=0)) + 1
    if surfaces * len(triangles) > MOST_WORK:
        raise LoadError(f"{name} is in too many pieces: {surfaces} separate surfaces of {len(triangles)} faces")


def _hulls(name: str, meshes: list[Mesh], scale: float) -> Composite:
    factor = _scaled(name, scale)
    _require_moderate(name, _joined(meshes)[1])
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
    if sum(len(triangles) for _, triangles in found) > MOST_READ:
        raise LoadError(
            f"{path} is too large: more than {MOST_READ} faces; make them fewer in the program it comes from"
        )
    return found


def _of_object(mesh: Any) -> Mesh:
    """Checked arrays of anything with vertices and faces."""
    try:
        found = numbers(mesh)
    except FileError as error:
        raise LoadError(f"trimesh object {error}") from None
    return found


def _joined(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    faces = [triangles + start for (_, triangles), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)
