"""Meshes from files of strangers: STL and OBJ, read through trimesh, with limits, and never with what a file refers to.

Nothing is repaired: equal corners become one vertex, which the formats cannot say themselves, and what remains is
what the file holds, defects and all.
"""

from __future__ import annotations

import io
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array

Triangles = NDArray[np.int64]

FORMATS = {".obj": "obj", ".stl": "stl"}
LARGEST_FILE = 8 * 2**20
MOST_FACES = 50_000
MOST_OBJECTS = 1_000
WORDS_PER_FACE = 5  # "f" and four corners: a triangle has fewer words, a larger face fewer for each of its triangles
LARGEST_COORDINATE = 1e9
"""In the file's own unit: beyond it, squares of distances leave little room above."""


class ModelError(Exception):
    """A model cannot be used; the text says why, and where in its file."""


@dataclass(frozen=True)
class Mesh:
    """Triangles as a file holds them, no two vertices equal, every vertex in a triangle.

    Attributes
    ----------
    vertices : (m, 3)
    triangles : (t, 3)
    """

    vertices: Array
    triangles: Triangles


def read_bytes(path: Path, largest: int = LARGEST_FILE) -> bytes:
    """Content of a regular file that is not too large; anything else is a `ModelError`."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe would be waited for, a device never ends
            raise ModelError("is no regular file")
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise ModelError(f"cannot be read: {error.strerror or error}") from None
    except ValueError:
        raise ModelError("cannot be read: its name holds a null character") from None
    if len(data) > largest:
        raise ModelError(f"is too large: more than {largest / 2**20:g} MiB")
    return data


def read_mesh(path: Path) -> tuple[Mesh, ...]:
    """Objects of a mesh file, each a mesh of its own: those of an OBJ's ``o`` and ``g`` lines; an STL holds one.

    Raises
    ------
    ModelError
        When the file is none, too large, broken, or holds no triangle or no finite coordinates.
    """
    form = FORMATS.get(path.suffix.lower())
    if form is None:
        raise ModelError(f"is of no format that is read: {path.suffix or 'no suffix'}; convert it to OBJ or STL")
    data = read_bytes(path)
    if form == "obj":
        _require_moderate(data)
    meshes = tuple(_mesh(*numbers) for numbers in _arrays(data, form))
    if not meshes:
        raise ModelError("holds no triangle")
    faces = sum(len(mesh.triangles) for mesh in meshes)
    if faces > MOST_FACES:
        raise ModelError(f"is too large: {faces} faces, at most {MOST_FACES}")
    return meshes


def _require_moderate(data: bytes) -> None:
    """Refuse an OBJ that would take long to parse: few bytes may say many objects, or faces of many corners."""
    objects = words = 0
    for line in data.replace(b"\r\n", b"\n").replace(b"\\\n", b"").split(b"\n"):
        start = line.lstrip()[:2]
        objects += start in (b"o ", b"g ")
        words += 0 if start[:1] in (b"v", b"#") else len(line.split())
    if objects > MOST_OBJECTS:
        raise ModelError(f"is too large: {objects} objects, at most {MOST_OBJECTS}")
    if words > WORDS_PER_FACE * MOST_FACES:
        raise ModelError(f"is too large: as long as {MOST_FACES} faces")


def _arrays(data: bytes, form: str) -> list[tuple[Array, Triangles]]:
    try:
        import trimesh  # noqa: PLC0415  an extra, and slow to import
    except ImportError:
        raise ModelError("cannot be read: trimesh is not installed (the extra 'meshes')") from None
    # no resolver and no materials: whatever the file refers to is not opened
    options: dict[str, Any] = {}
    if form == "obj":
        options = {"skip_materials": True, "split_objects": True, "split_groups": True, "group_material": False}
    try:
        scene = trimesh.load_scene(io.BytesIO(_text_in_utf8(data, form)), file_type=form, process=False, **options)
        found = [g for g in scene.geometry.values() if isinstance(g, trimesh.Trimesh) and len(g.faces)]
        return [(np.array(g.vertices, dtype=np.float64), np.array(g.faces, dtype=np.int64)) for g in found]
    except Exception as error:  # a parser meets what nobody foresaw: any complaint of its means a broken file
        raise ModelError(f"is broken: {type(error).__name__}: {str(error)[:200]}") from None


def _text_in_utf8(data: bytes, form: str) -> bytes:
    """Text of any encoding with whatever is not UTF-8, in comments and names, replaced; a binary STL as it is."""
    count = int.from_bytes(data[80:84], "little")
    if form == "stl" and len(data) == 84 + 50 * count:
        return data
    return data.decode("utf-8", errors="replace").encode()


def _mesh(vertices: Array, triangles: Triangles) -> Mesh:
    if np.any((triangles < 0) | (triangles >= len(vertices))):
        raise ModelError(f"is broken: a face names a vertex that is none of the {len(vertices)}")
    require_usable(vertices[triangles])
    return merged([Mesh(vertices, triangles)])


def require_usable(coordinates: Array) -> None:
    """Refuse numbers that are not finite or too large to be a model's."""
    if not np.all(np.isfinite(coordinates)):
        raise ModelError("has a coordinate that is not finite")
    largest = float(np.max(np.abs(coordinates), initial=0.0))
    if largest > LARGEST_COORDINATE:
        raise ModelError(f"has a coordinate of {largest:g}, at most {LARGEST_COORDINATE:g} is used")


def merged(meshes: list[Mesh]) -> Mesh:
    """One mesh out of several: equal vertices become one, and those of no triangle are left out."""
    corners = np.concatenate([mesh.vertices[mesh.triangles].reshape(-1, 3) for mesh in meshes]) + 0.0
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return Mesh(vertices, np.asarray(index, dtype=np.int64).reshape(-1, 3))
