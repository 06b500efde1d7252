"""Meshes from files: what is read, what is refused, and that the refusal says where."""

import builtins
import os
import pickle
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from refimpl import Composite, Polyhedron, distance
from refimpl.construct import points_of
from refimpl.loading import CLOUDS, FORMATS, LoadError, from_trimesh, hulls_from_trimesh, load_hulls, load_polyhedron
from refimpl.mass import mass_properties
from refimpl.repairs import REPAIRS
from tests.solids import L_SHAPE, box, hollow_box, prism, together, torus

trimesh = pytest.importorskip("trimesh")


def obj(*meshes):
    """OBJ text with an object for each mesh."""
    lines, start = [], 1
    for number, (vertices, triangles) in enumerate(meshes):
        lines.append(f"o part{number}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += [f"f {a + start} {b + start} {c + start}" for a, b, c in triangles.tolist()]
        start += len(vertices)
    return "\n".join(lines) + "\n"


@pytest.fixture
def write(tmp_path):
    def write(name, content):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_is_read(form, write):
    vertices, triangles = prism(L_SHAPE)
    exported = trimesh.Trimesh(vertices, triangles, process=False).export(file_type=form)
    mesh = load_polyhedron(write(f"solid.{form}", exported))
    assert isinstance(mesh, Polyhedron)
    assert sorted(map(tuple, mesh.vertices.tolist())) == sorted(map(tuple, vertices.tolist()))
    assert len(mesh.triangles) == len(triangles)
    assert len(mesh.pieces) == 2


def test_text_stl_and_its_split_corners(write):
    vertices, triangles = box()
    text = trimesh.Trimesh(vertices, triangles, process=False).export(file_type="stl_ascii")
    assert load_polyhedron(write("box.stl", text)).vertices.shape == (8, 3)


def test_scale_and_objects(write):
    path = write("parts.obj", obj(box(), box((0.5, 0.5, 0.5), (2, 2, 2)), torus()))
    union = load_hulls(path, scale=0.001)
    assert isinstance(union, Composite)
    assert sorted(len(part.numbers) for part in union.parts) == [8, 8, 96]
    assert np.max(union.magnitude) == 0.002
    with pytest.raises(LoadError, match=r"parts\.obj: Polyhedron: self-intersecting: face"):
        load_polyhedron(path)


def test_hulls_of_one_object_with_two_surfaces(write):
    union = load_hulls(write("two.obj", obj(together(box(), box((3, 0, 0), (4, 1, 1))))))
    assert len(union.parts) == 2
    assert distance(*(part for part in union.parts)).distance == 2.0


def test_a_hull_may_have_holes(write):
    vertices, triangles = box()
    union = load_hulls(write("open.obj", obj((vertices, triangles[2:]))))
    assert len(union.parts) == 1
    with pytest.raises(LoadError, match=r"open\.obj: Polyhedron: open: the edge from vertex \d+ \("):
        load_polyhedron(write("open.obj", obj((vertices, triangles[2:]))))


def test_objects_of_trimesh():
    mesh = trimesh.creation.icosphere(subdivisions=1)
    assert from_trimesh(mesh, scale=2.0).vertices.shape == mesh.vertices.shape
    assert len(hulls_from_trimesh(mesh).parts) == 1
    with pytest.raises(LoadError, match="expected vertices and faces"):
        from_trimesh(object())
    with pytest.raises(LoadError, match="face 0 names vertex 7 of 3"):
        from_trimesh(SimpleNamespace(vertices=np.eye(3), faces=np.array([[0, 1, 7]])))


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("solid.xyz", "0 0 0", "solid.xyz holds points, which bound no solid"),
        ("solid.step", "0 0 0", "read from obj, off, ply, stl files, this is step"),
        ("solid", "0 0 0", "this is without suffix"),
        ("empty.stl", b"", "empty.stl holds no triangle"),
        ("empty.obj", b"", "empty.obj holds no triangle"),
        ("cut.stl", b"\0" * 80 + (1000).to_bytes(4, "little") + b"\0" * 500, "cut.stl "),
        ("bomb.stl", b"\0" * 80 + (2**32 - 1).to_bytes(4, "little"), "bomb.stl "),
        ("noise.ply", bytes(range(256)) * 4, "noise.ply is broken"),
        ("lies.ply", b"ply\nformat ascii 1.0\nelement vertex 999999999\nproperty float x\nend_header\n1\n", "lies.ply"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 0 of face 0 is not finite"),
        ("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "far.obj is broken"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "points.obj holds no triangle"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "has no area"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_by_name(name, content, why, write):
    with pytest.raises(LoadError, match=why):
        load_polyhedron(write(name, content))


def test_large_files_are_refused_unread(write):
    path = write("big.obj", obj(torus()))
    with pytest.raises(LoadError, match="is too large: more than 1000 bytes"):
        load_polyhedron(path, largest=1000)


def test_what_is_no_file(tmp_path):
    with pytest.raises(LoadError, match=r"missing\.stl cannot be read"):
        load_polyhedron(tmp_path / "missing.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(LoadError, match="is no regular file"):
        load_polyhedron(tmp_path / "folder.stl")
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(LoadError, match="is no regular file"):
        load_polyhedron(tmp_path / "pipe.stl")


def test_what_a_file_refers_to_is_not_opened(write, monkeypatch):
    path = write("linked.obj", "mtllib secret.mtl\nusemtl s\n" + obj(box()))
    write("secret.mtl", "newmtl s\nmap_Kd texture.png\n")
    opened = []
    real = builtins.open
    monkeypatch.setattr(builtins, "open", lambda file, *a, **k: (opened.append(str(file)), real(file, *a, **k))[1])
    load_polyhedron(path)
    assert not any("secret" in name or "texture" in name for name in opened)


def test_a_missing_package_is_named(write, monkeypatch):
    real = builtins.__import__

    def without(name, *rest, **named):
        if name == "trimesh":
            raise ImportError(name)
        return real(name, *rest, **named)

    path = write("box.obj", obj(box()))
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(LoadError, match=r"box\.obj cannot be read: trimesh is not installed; pip install"):
        load_polyhedron(path)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_scales_are_positive(scale, write):
    with pytest.raises(LoadError, match="the scale must be positive"):
        load_polyhedron(write("box.obj", obj(box())), scale=scale)


def test_repairs_are_done_only_when_asked_for(write):
    vertices, triangles = box()
    mixed = triangles.copy()
    mixed[[2, 7, 8]] = mixed[[2, 7, 8]][:, ::-1]
    seam, stray = (
        triangles.copy(),
        np.array([[3.0, 0, 0], [3, 1, 0], [3, 0, 1], [2.5, 0.2, 0.2], [4, 0.2, 0.2], [4, 0, 1]]),
    )
    seam[0, 0] = len(vertices)
    split = np.concatenate([vertices, vertices[triangles[:1, 0]] + 1e-9])
    littered, first = np.concatenate([vertices, stray]), len(vertices)
    damaged = {
        "merge_near": (split, seam),
        "drop_degenerate": (vertices, np.concatenate([triangles, [[0, 1, 1]]])),
        "drop_duplicates": (vertices, np.concatenate([triangles, triangles[3:4]])),
        "drop_crossing": (littered, np.concatenate([triangles, np.arange(6).reshape(2, 3) + first])),
        "keep_largest": (littered, np.concatenate([triangles, np.arange(3)[None] + first])),
        "turn_outwards": (vertices, mixed),
        "fill_holes": (vertices, triangles[2:]),
        "hull": (vertices, triangles[::2]),
    }
    assert {*damaged, "simplify"} == set(REPAIRS)
    for name, (corners, faces) in damaged.items():
        path = write(f"{name}.obj", obj((corners, faces)))
        with pytest.raises(LoadError):
            load_polyhedron(path)
        mesh = load_polyhedron(path, repairs=[name])
        assert len(mesh.pieces) == 1, name
        assert mesh.pieces[0].six_volumes() == 6, name
    with pytest.raises(LoadError, match="there is no repair 'magic'; there are merge_near, "):
        load_polyhedron(path, repairs=["magic"])


def test_too_many_faces_are_simplified_when_asked_for(monkeypatch, write):
    pytest.importorskip("fast_simplification")
    monkeypatch.setattr("refimpl.loading.MOST_FACES", 1000)
    monkeypatch.setattr("refimpl.repairs.SIMPLE", 500)
    path = write("torus.obj", obj(torus(around=60, across=40)))
    with pytest.raises(LoadError, match="4800 faces, more than 1000"):
        load_polyhedron(path)
    mesh = load_polyhedron(path, repairs=["simplify"])
    assert 400 < len(mesh.triangles) <= 500
    assert mass_properties(mesh).volume == pytest.approx(2 * np.pi**2 * 0.4**2, rel=0.03)
    small = load_polyhedron(write("box.obj", obj(box())), repairs=["simplify"])
    assert len(small.triangles) == 12


def test_faces_that_fold_together_are_left_out_by_simplify(monkeypatch):
    """Of the chassis in fifty faces, eight lie on one another in pairs; with them it would be no surface."""
    data = Path(pytest.importorskip("pybullet_data").getDataPath())
    pytest.importorskip("fast_simplification")
    monkeypatch.setattr("refimpl.repairs.SIMPLE", 50)
    path = data / "racecar/meshes/chassis.STL"
    whole, few = (load_polyhedron(path, repairs=["merge_near", *more]) for more in ((), ("simplify",)))
    assert len(few.triangles) <= 50
    assert mass_properties(few).volume == pytest.approx(mass_properties(whole).volume, rel=0.05)


def test_what_would_take_minutes_is_refused(monkeypatch, write):
    apart = [box((3 * i, 0, 0), (3 * i + 1, 1, 1)) for i in range(4)]
    monkeypatch.setattr("refimpl.loading.MOST_WORK", 4 * 48 - 1)
    with pytest.raises(LoadError, match="too many pieces: 4 separate surfaces of 48 faces"):
        load_polyhedron(write("apart.obj", obj(*apart)))
    assert len(load_polyhedron(write("three.obj", obj(*apart[:3]))).triangles) == 36
    monkeypatch.undo()
    monkeypatch.setattr("refimpl.meshes.MANY", 100)
    monkeypatch.setattr("refimpl.meshes.MOST_PAIRS", 10_000)
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rim, i = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1), np.arange(400)
    both = [(i, (i + 1) % 400), ((i + 1) % 400, i)]
    fans = [np.stack([*ends, np.full(400, 400 + k)], axis=-1) for k, ends in enumerate(both)]
    double_cone = np.concatenate([rim, [[0, 0, 1.0], [0, 0, -1]]]), np.concatenate(fans)
    with pytest.raises(LoadError, match=r"crowded: each of the 800 faces is near about 799 others"):
        load_polyhedron(write("cone.obj", obj(double_cone)))
    assert len(load_polyhedron(write("torus.obj", obj(torus(around=20, across=20)))).triangles) == 800
    monkeypatch.setattr("refimpl.repairs.MOST_PAIRS", 50)
    far = np.concatenate([torus()[0], [[1e9, 0, 0]]]), np.concatenate([torus()[1], [[0, 1, len(torus()[0])]]])
    with pytest.raises(LoadError, match="merge_near: most vertices are within"):
        load_polyhedron(write("far.obj", obj(far)), repairs=["merge_near"])


def test_surfaces_are_turned_and_kept_one_by_one(write):
    """A hundred boxes, of which every other one is inside out; one is longer than all others."""
    parts = [box((3 * i, 0, 0), (3 * i + 1, 1, 1 + (i == 37))) for i in range(100)]
    mixed = [(v, t[:, ::-1] if i % 2 else t) for i, (v, t) in enumerate(parts)]
    path = write("boxes.obj", obj(*mixed))
    assert mass_properties(load_polyhedron(path, repairs=["turn_outwards"])).volume == pytest.approx(101)
    kept = load_polyhedron(path, repairs=["turn_outwards", "keep_largest"])
    assert kept.vertices.min(axis=0).tolist() == [3 * 37, 0, 0]
    assert len(kept.triangles) == 12


@pytest.mark.parametrize("name", ["cloud.xyz", "cloud.csv", "cloud.npy", "columns.npy", "cloud.ply", "cloud.obj"])
def test_points_have_a_hull_and_nothing_else(name, write, tmp_path):
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3), axis=-1).reshape(-1, 3) * [1, 2, 3]
    path, form = tmp_path / name, name.partition(".")[2]
    if form == "npy":
        np.save(path, np.asfortranarray(grid) if name.startswith("col") else grid.astype(np.float32))
    elif form == "ply":
        path.write_bytes(trimesh.PointCloud(grid).export(file_type="ply"))
    else:
        start, between = ("v ", " ") if form == "obj" else ("", "; " if form == "csv" else "\t")
        path.write_text("# points\n" + "".join(f"{start}{between.join(map(repr, p))}\n" for p in grid.tolist()))
    with pytest.raises(
        LoadError, match="holds points, which bound no solid" if form in CLOUDS else "holds no triangle"
    ):
        load_polyhedron(path)
    mesh = load_polyhedron(path, repairs=["hull"])
    assert mass_properties(mesh).volume == pytest.approx(6, rel=1e-6)
    if form in CLOUDS:
        assert points_of(path).tolist() == grid.tolist()


def npy(shape, sort="<f8", version=1):
    head = f"{{'descr': {sort!r}, 'fortran_order': False, 'shape': {shape}}}".encode()
    return b"\x93NUMPY" + bytes([version, 0]) + len(head).to_bytes(2, "little") + head


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("empty.xyz", "# nothing\n", "holds no point"),
        ("words.xyz", "x y z\n1 2 3\n", "is broken: expected three numbers in each line"),
        ("two.xyz", "1 2\n3 4\n", "is broken: expected three numbers in each line"),
        ("nan.xyz", "0 0 0\n0 nan 0\n", "is broken: point 1 is not finite"),
        ("flat.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n", "the mesh has no faces"),
        ("one.xyz", "0 0 0\n", "the mesh has no faces"),
        ("noise.npy", bytes(range(256)), "noise.npy is broken"),
        ("huge.npy", npy((10**15, 3)), "ends before the 1000000000000000 points that it announces"),
        ("wide.npy", npy((5, 4)) + bytes(160), r"expected an array \(n, 3\)"),
        ("pickle.npy", npy((1, 3), "|O") + pickle.dumps([print, 1, 2]), r"expected an array \(n, 3\) of numbers"),
        ("negative.npy", npy((-1, 3)), "is broken"),
    ],
)  # fmt: skip
def test_bad_points_are_refused_by_name(name, content, why, write):
    with pytest.raises(LoadError, match=why):
        load_polyhedron(write(name, content), repairs=["hull"])


def test_a_rim_that_touches_itself_is_several_holes(write):
    """Two faces of a cube that share one corner only are left out: four triangles, one pinched rim."""
    vertices, triangles = box()
    normals = np.cross(*(vertices[triangles[:, k]] - vertices[triangles[:, 0]] for k in (1, 2)))
    top, side = (np.flatnonzero(normals[:, axis] > 0) for axis in (2, 0))
    corner = np.flatnonzero(np.all(vertices == [1, 1, 1], axis=1))[0]
    gone = [next(f for f in top if corner in triangles[f]), next(f for f in side if corner in triangles[f])]
    assert len(np.intersect1d(*triangles[gone])) == 1
    path = write("pinched.obj", obj((vertices, np.delete(triangles, gone, axis=0))))
    assert load_polyhedron(path, repairs=["fill_holes"]).pieces[0].six_volumes() == 6


def test_the_duck_is_a_solid_after_repairs_that_are_named():
    """The mesh that PyBullet ships crosses itself at its beak: a handful of faces make the difference."""
    data = pytest.importorskip("pybullet_data").getDataPath()
    with pytest.raises(LoadError, match=r"duck\.obj: Polyhedron: self-intersecting: face 2180"):
        load_polyhedron(f"{data}/duck.obj")
    duck = load_polyhedron(f"{data}/duck.obj", repairs=["drop_crossing", "fill_holes"] * 2)
    assert 4200 < len(duck.triangles) < 4212


def test_cavities_are_kept(write):
    mesh = load_polyhedron(write("hollow.obj", obj(hollow_box())))
    assert sum(piece.six_volumes() for piece in mesh.pieces) == 6 * (8 - 1)
