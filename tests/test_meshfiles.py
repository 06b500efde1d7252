"""Mesh files of strangers: what they hold, and that they can do no harm."""

from __future__ import annotations

import math
import pickle
import struct
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from oracles import meshfiles
from oracles.meshfiles import ModelError, read_mesh

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
OPEN = TETRAHEDRON.replace("f 2 3 4\n", "")
TWO = (
    TETRAHEDRON.replace("v", "o one\nv", 1)
    + "o two\n"
    + "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n"
)


def stl(*triangles: list[list[float]], said: int | None = None) -> bytes:
    """Binary STL; `said` is how many triangles its header claims."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t), 0) for t in triangles)
    return b"\0" * 80 + struct.pack("<I", len(triangles) if said is None else said) + rows


def test_equal_corners_become_one_vertex(tmp_path: Path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 1]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    (tmp_path / "t.STL").write_bytes(stl(*(corners[f].tolist() for f in faces)))
    (mesh,) = read_mesh(tmp_path / "t.STL")
    assert mesh.vertices.shape == (4, 3)
    assert mesh.triangles.shape == (4, 3)
    (tmp_path / "t.obj").write_text(TETRAHEDRON.replace("f", "# a comment, and a vertex of no face\nv 9 9 9\nf", 1))
    (other,) = read_mesh(tmp_path / "t.obj")
    assert np.array_equal(mesh.vertices, other.vertices)


def test_quads_relative_indices_and_objects(tmp_path: Path):
    (tmp_path / "q.obj").write_bytes("# grün\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n".encode("latin-1"))
    (mesh,) = read_mesh(tmp_path / "q.obj")
    assert mesh.triangles.shape == (2, 3)
    (tmp_path / "two.obj").write_text(TWO)
    one, two = read_mesh(tmp_path / "two.obj")
    assert len(one.vertices) == len(two.vertices) == 4


def test_what_a_file_refers_to_is_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "m.obj").write_text("mtllib ../secret.mtl\nusemtl x\n" + TETRAHEDRON)
    (tmp_path.parent / "secret.mtl").write_text("newmtl x\nmap_Kd /etc/passwd\n")
    opened = []
    monkeypatch.setattr("builtins.open", lambda *a, **_: opened.append(a))
    assert len(read_mesh(tmp_path / "m.obj")[0].triangles) == 4
    assert opened == []


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.obj", b"", "holds no triangle"),
        ("a.obj", b"v 1 2 3\n", "holds no triangle"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v nan 0 0").encode(), "not finite"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v 1e999 0 0").encode(), "not finite"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v 1e300 0 0").encode(), "a coordinate of 1e+300, at most 1e+09"),
        ("a.obj", TETRAHEDRON.replace("f 2 3 4", "f 2 3 99").encode(), "is broken"),
        ("a.obj", TETRAHEDRON.replace("f 2 3 4", "f 2 3 -99").encode(), "is broken"),
        ("a.obj", TETRAHEDRON.replace("v 1 0 0", "v one 0 0").encode(), "is broken"),
        ("a.obj", pickle.dumps({"vertices": [1, 2, 3]}), "holds no triangle"),
        ("a.obj", b"\xff\xfe\x00\x01" * 1000, "holds no triangle"),
        ("a.obj", b"o x\n" * 5000 + TETRAHEDRON.encode(), "is too large: 5000 objects, at most 1000"),
        ("a.stl", b"", "holds no triangle"),
        ("a.stl", stl(), "holds no triangle"),
        ("a.stl", stl([[0, 0, 0], [1, 0, 0], [0, 1, 0]], said=2**32 - 1), "holds no triangle"),
        ("a.stl", stl([[0, 0, math.nan], [1, 0, 0], [0, 1, 0]]), "not finite"),
        ("a.stl", stl([[0, 0, 1e38], [1, 0, 0], [0, 1, 0]]), "a coordinate of 1e+38"),
        ("a.stl", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0\n", "holds no triangle"),
        ("a.dae", b"<COLLADA/>", "is of no format that is read: .dae; convert it to OBJ or STL"),
        ("a.zip", b"PK\3\4", "is of no format that is read"),
    ],
)
def test_broken_meshes_are_refused_with_the_reason(tmp_path: Path, name: str, data: bytes, words: str):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ModelError) as error:
        read_mesh(tmp_path / name)
    assert words in str(error.value)
    assert len(str(error.value)) < 400


def test_large_files_are_refused_before_they_are_parsed(tmp_path: Path):
    path = tmp_path / "large.obj"
    with path.open("wb") as file:
        file.truncate(2**40)  # a terabyte, sparse
    began = time.monotonic()
    with pytest.raises(ModelError, match="more than 8 MiB"):
        read_mesh(path)
    faces = meshfiles.MOST_FACES + 1
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * faces)
    with pytest.raises(ModelError, match=f"is too large: {faces} faces"):
        read_mesh(path)
    for many in ("f" + " 1 2 3" * 10**6, "f 1 2 3 \\\n 4 " * 300_000, "usemtl a\nf 1 2 3\n" * 400_000):
        path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + many)
        with pytest.raises(ModelError, match="is too large: as long as 50000 faces"):
            read_mesh(path)
    assert time.monotonic() - began < 10


def test_without_trimesh_the_error_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "m.obj").write_text(TETRAHEDRON)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(ModelError, match="trimesh is not installed"):
        read_mesh(tmp_path / "m.obj")
