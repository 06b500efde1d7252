"""Solids from mesh files, and from `trimesh` objects.

Files are read by trimesh, an extra that is imported when first needed. What a file holds is taken as it is: corners
with the same coordinates become one vertex, since most formats cannot say that they are one, and nothing else is
changed unless a repair is asked for by name. Nothing that a file refers to is opened.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from refimpl.meshes import shells
from refimpl.proxy import ShapeError
from refimpl.repairs import REPAIRS, Mesh, merged
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron

FORMATS = ("obj", "off", "ply", "stl")
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
    return _polyhedron("trimesh object", _numbers("trimesh object", mesh), scale, repairs)


def hulls_from_trimesh(mesh: Any, *, scale: float = 1.0) -> Composite:
    """Take the hulls of the connected surfaces of a `trimesh.Trimesh`; see `load_hulls`."""
    return _hulls("trimesh object", [_numbers("trimesh object", mesh)], scale)


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


# ------------------------------------------------------------------------------------------- reading


def _read(path: Path, largest: int, split: bool) -> list[Mesh]:
    """Meshes of a file, object by object where the format has objects and `split` asks for them."""
    form = path.suffix.lower().removeprefix(".")
    if form not in FORMATS:
        raise LoadError(f"{path}: meshes are read from {', '.join(FORMATS)} files, this is {form or 'without suffix'}")
    try:
        regular = path.is_file() or not path.exists()
        with path.open("rb") if regular else io.BytesIO() as file:
            data = file.read(largest + 1)
    except (OSError, ValueError) as error:
        raise LoadError(f"{path}: cannot be read ({error})") from None
    if not regular:  # a pipe or a device might never end
        raise LoadError(f"{path}: not a regular file")
    if len(data) > largest:
        raise LoadError(f"{path}: larger than {largest} bytes; raise `largest` if that is meant")
    if form in {"obj", "off"} or (form == "stl" and not _is_binary_stl(data)):
        data = data.decode("utf-8", errors="replace").encode()  # names and comments may be in any encoding
    trimesh = _trimesh(str(path))
    options: dict[str, Any] = {"split_object": split, "skip_materials": True} if form == "obj" else {}
    try:
        loaded = trimesh.load(io.BytesIO(data), file_type=form, process=False, **options)
        found = list(loaded.geometry.values()) if isinstance(loaded, trimesh.Scene) else [loaded]
        found = [mesh for mesh in found if isinstance(mesh, trimesh.Trimesh)]
    except Exception as error:  # what a parser raises on a broken file is anything
        raise LoadError(f"{path}: not a readable {form} file ({type(error).__name__}: {str(error)[:200]})") from None
    if not found:
        raise LoadError(f"{path}: the file holds no triangles")
    return [_numbers(str(path), mesh) for mesh in found]


def _is_binary_stl(data: bytes) -> bool:
    return len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def _trimesh(name: str) -> Any:
    try:
        import trimesh  # noqa: PLC0415  an extra, and slow to import
    except ImportError:
        raise LoadError(f"{name}: reading meshes needs the package trimesh: pip install 'proxyproof[meshes]'") from None
    return trimesh


def _numbers(name: str, mesh: Any) -> Mesh:
    """Checked arrays of anything with vertices and faces."""
    try:
        vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces)
    except (AttributeError, TypeError, ValueError) as error:
        raise LoadError(f"{name}: expected vertices and faces ({error})") from None
    if (
        vertices.ndim != 2
        or vertices.shape[1] != 3
        or faces.ndim != 2
        or faces.shape[1] != 3
        or faces.dtype.kind not in "iu"
    ):
        raise LoadError(
            f"{name}: expected m × 3 vertices and t × 3 whole numbers, got shapes {vertices.shape}, {faces.shape}"
        )
    if len(faces) > MOST_FACES:
        raise LoadError(f"{name}: {len(faces)} faces, more than {MOST_FACES}")
    faces = faces.astype(np.int64)
    wrong = np.argwhere((faces < 0) | (faces >= len(vertices)))
    if len(wrong):
        face, corner = wrong[0].tolist()
        raise LoadError(f"{name}: face {face} names vertex {faces[face, corner]} of {len(vertices)}")
    bad = np.argwhere(~np.isfinite(vertices[faces]))
    if len(bad):
        face, corner, _ = bad[0].tolist()
        raise LoadError(f"{name}: vertex {faces[face, corner]} of face {face} is not finite")
    return vertices, faces


def _joined(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    faces = [triangles + start for (_, triangles), start in zip(meshes, starts, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)
