"""Triangles as files hold them: read through trimesh, with limits, and never with what a file refers to.

Nothing is repaired, and nothing decided: corners that are equal are still several vertices, and the faces need not
bound anything.
"""

from __future__ import annotations

import io
import re
import stat
from pathlib import Path
from typing import Any

import numpy as np

from refimpl.proxy import ShapeError
from refimpl.repairs import Mesh

FORMATS = ("obj", "off", "ply", "stl")
NO_FACES = "holds no triangle"
"""What is said of a file of nothing or of points."""


MOST_CORNERS = 2**24
"""Corners of faces that a file may have room for: each may become a triangle, of far more bytes than it takes there."""
LONGEST_HEAD = 2**16
"""Bytes within which the head of a PLY file has to end."""


class FileError(ShapeError):
    """A file, or what claims to be a mesh, is none; the text goes on from its name: "is too large: …"."""


def form_of(path: Path) -> str:
    """Format of a file by its suffix, in small letters; empty without one."""
    return path.suffix.lower().removeprefix(".")


def read_bytes(path: Path, largest: int) -> bytes:
    """Content of a regular file of at most so many bytes; raises `FileError` for anything else."""
    try:
        regular = stat.S_ISREG(path.stat().st_mode)  # a pipe would be waited for, a device never ends
        with path.open("rb") if regular else io.BytesIO() as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise FileError(f"cannot be read: {error.strerror or error}") from None
    except ValueError:
        raise FileError("cannot be read: its name holds a null character") from None
    if not regular:
        raise FileError("is no regular file")
    if len(data) > largest:
        size = f"{largest / 2**20:g} MiB" if largest >= 2**20 else f"{largest} bytes"
        raise FileError(f"is too large: more than {size}")
    return data


def parsed(data: bytes, form: str, *, split: bool) -> list[Mesh]:
    """Meshes of a file's content, each with finite corners; raises `FileError` where it has none or is broken.

    Parameters
    ----------
    data, form
        The content, and one of `FORMATS`.
    split : bool
        Make each object and group of an OBJ a mesh of its own.
    """
    found = [g for g in geometries(data, form, split=split) if len(getattr(g, "faces", ()))]
    if not found:
        raise FileError(NO_FACES)
    return [numbers(mesh) for mesh in found]


def geometries(data: bytes, form: str, *, split: bool = False) -> list[Any]:
    """What trimesh makes of a file's content: meshes and point clouds; arguments and errors as for `parsed`."""
    try:
        import trimesh  # noqa: PLC0415  an extra, and slow to import
    except ImportError:
        raise FileError("cannot be read: trimesh is not installed; pip install 'proxyproof[meshes]'") from None
    if _room_for_corners(data, form) > MOST_CORNERS:
        raise FileError("is too large: few bytes may say many faces, and it has room for millions")
    # no resolver and no materials: whatever the file refers to is not opened
    options: dict[str, Any] = {}
    if form == "obj":
        options = {"skip_materials": True, "split_objects": split, "split_groups": split, "group_material": False}
    try:
        scene = trimesh.load_scene(io.BytesIO(_text_in_utf8(data, form)), file_type=form, process=False, **options)
        return [found for found in scene.geometry.values() if isinstance(found, trimesh.Trimesh | trimesh.PointCloud)]
    except Exception as error:  # a parser meets what nobody foresaw: any complaint of its means a broken file
        raise FileError(f"is broken: {type(error).__name__}: {str(error)[:200]}") from None


def _room_for_corners(data: bytes, form: str) -> int:
    """How many corners of faces a file's content may hold: words of text, or what fits into its bytes."""
    if form == "ply":
        head, _, rest = data[:LONGEST_HEAD].partition(b"end_header")
        if not rest:
            raise FileError(f"is broken: its head does not end within {LONGEST_HEAD} bytes")
        if b"binary" in head:
            lists = re.findall(rb"property\s+list\s+\w+\s+(\w+)", head)
            return len(data) // min((SIZES.get(sort, 4) for sort in lists), default=4)
    if form == "stl" and _is_binary_stl(data):
        return 0
    blank = np.frombuffer(data, np.uint8) <= ord(" ")
    return int(np.count_nonzero(blank[:-1] & ~blank[1:])) + 1


SIZES = {b"char": 1, b"uchar": 1, b"int8": 1, b"uint8": 1, b"short": 2, b"ushort": 2, b"int16": 2, b"uint16": 2}
"""Bytes of a PLY file's numbers, where these are fewer than 4."""


def _is_binary_stl(data: bytes) -> bool:
    return len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def _text_in_utf8(data: bytes, form: str) -> bytes:
    """Text of any encoding with whatever is not UTF-8, in comments and names, replaced; binary data as it is."""
    if form == "ply" or (form == "stl" and _is_binary_stl(data)):
        return data
    return data.decode("utf-8", errors="replace").encode()


def numbers(mesh: Any) -> Mesh:
    """Checked vertices (m, 3) and triangles (t, 3) of anything that has `vertices` and `faces`."""
    try:
        vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces)
    except (AttributeError, TypeError, ValueError) as error:
        raise FileError(f"is broken: expected vertices and faces ({error})") from None
    if vertices.shape[1:] != (3,) or faces.shape[1:] != (3,) or faces.dtype.kind not in "iu":
        shapes = f"{vertices.shape}, {faces.shape}"
        raise FileError(f"is broken: expected m × 3 vertices and t × 3 whole numbers, got shapes {shapes}")
    faces = faces.astype(np.int64)
    wrong = np.argwhere((faces < 0) | (faces >= len(vertices)))
    if len(wrong):
        face, corner = wrong[0].tolist()
        raise FileError(f"is broken: face {face} names vertex {faces[face, corner]} of {len(vertices)}")
    bad = np.argwhere(~np.isfinite(vertices[faces]))
    if len(bad):
        face, corner, _ = bad[0].tolist()
        raise FileError(f"is broken: vertex {faces[face, corner]} of face {face} is not finite")
    return vertices, faces
