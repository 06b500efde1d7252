"""Meshes from files of strangers: STL and OBJ, with stricter limits than a caller's own files have.

Nothing is repaired: equal corners become one vertex, which the formats cannot say themselves, and what remains is
what the file holds, defects and all.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from refimpl import meshfiles, repairs
from refimpl.linear import Array
from refimpl.meshes import Triangles
from refimpl.meshfiles import FileError

FORMATS = ("obj", "stl")
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
        return meshfiles.read_bytes(path, largest)
    except FileError as error:
        raise ModelError(str(error)) from None


def read_mesh(path: Path) -> tuple[Mesh, ...]:
    """Objects of a mesh file, each a mesh of its own: those of an OBJ's ``o`` and ``g`` lines; an STL holds one.

    Raises
    ------
    ModelError
        When the file is none, too large, broken, or holds no triangle or no finite coordinates.
    """
    form = meshfiles.form_of(path)
    if form not in FORMATS:
        raise ModelError(f"is of no format that is read: {path.suffix or 'no suffix'}; convert it to OBJ or STL")
    data = read_bytes(path)
    if form == "obj":
        _require_moderate(data)
    try:
        found = meshfiles.parsed(data, form, split=True)
    except FileError as error:
        raise ModelError(str(error)) from None
    for vertices, triangles in found:
        require_usable(vertices[triangles])
    meshes = tuple(merged([Mesh(*mesh)]) for mesh in found)
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


def require_usable(coordinates: Array) -> None:
    """Refuse numbers that are not finite or too large to be a model's."""
    if not np.all(np.isfinite(coordinates)):
        raise ModelError("has a coordinate that is not finite")
    largest = float(np.max(np.abs(coordinates), initial=0.0))
    if largest > LARGEST_COORDINATE:
        raise ModelError(f"has a coordinate of {largest:g}, at most {LARGEST_COORDINATE:g} is used")


def merged(meshes: list[Mesh]) -> Mesh:
    """One mesh out of several: equal vertices become one, and those of no triangle are left out."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(*repairs.merged(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(triangles)))
