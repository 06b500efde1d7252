"""URDF files: what their numbers mean, and that a stranger's file can do no harm."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

import numpy as np
import pytest

from oracles.meshfiles import ModelError
from oracles.models import MeshPiece, urdf_model
from oracles.urdf import collision_elements
from refimpl import Box, Capsule, Cylinder, Sphere
from refimpl.linear import rotation_matrix

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def robot(*links: str, joints: str = "") -> bytes:
    body = "".join(f'<link name="l{i}">{link}</link>' for i, link in enumerate(links))
    return f'<?xml version="1.0"?>\n<robot name="r">{body}{joints}</robot>'.encode()


def collides(shape: str, origin: str = "") -> str:
    return f"<collision>{origin}<geometry>{shape}</geometry></collision>"


def turned(about: int, angle: float) -> np.ndarray:
    i, j = (about + 1) % 3, (about + 2) % 3
    matrix = np.eye(3)
    matrix[[i, j], [i, j]], matrix[i, j], matrix[j, i] = math.cos(angle), -math.sin(angle), math.sin(angle)
    return matrix


def test_angles_are_turns_about_x_then_y_then_z():
    roll, pitch, yaw = 0.3, -1.1, 2.5
    origin = f'<origin xyz="1 2 3" rpy="{roll} {pitch} {yaw}"/>'
    (box,) = collision_elements(robot(collides('<box size="2 4 6"/>', origin)))
    expected = turned(2, yaw) @ turned(1, pitch) @ turned(0, roll)
    assert np.allclose(rotation_matrix(box.pose.rotation), expected, atol=1e-15)
    assert box.pose.position.tolist() == [1, 2, 3]
    assert box.sizes == (2, 4, 6)


def test_links_hang_on_joints_in_any_order():
    ball = collides('<sphere radius="1"/>', '<origin xyz="0 0 1"/>')
    joints = """<joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 1 0"/></joint>
      <joint name="a" type="fixed"><parent link="l0"/><child link="l1"/>
      <origin xyz="5 0 0" rpy="0 0 1.5707963267948966"/></joint>"""
    first, second, third = collision_elements(robot(ball, ball, ball, joints=joints))
    assert np.allclose(first.pose.position, [0, 0, 1])
    assert np.allclose(second.pose.position, [5, 0, 1])
    assert np.allclose(third.pose.position, [4, 0, 1])


def test_shapes_and_their_sizes(tmp_path: Path):
    (tmp_path / "t.obj").write_text(TRIANGLE)
    shapes = ('<box size="2 4 6"/>', '<sphere radius="3"/>', '<cylinder radius="1" length="4"/>')
    shapes += ('<capsule radius="1" length="4"/>', '<mesh filename="t.obj" scale="2 3 -4"/>')
    (tmp_path / "all.urdf").write_bytes(robot(*("".join(map(collides, shapes)),)))
    box, ball, can, pill, mesh = urdf_model(tmp_path / "all.urdf", tmp_path)
    assert isinstance(box, Box)
    assert box.half_extents.tolist() == [1, 2, 3]
    assert isinstance(ball, Sphere)
    assert ball.radius == 3
    for kind, found in ((Cylinder, can), (Capsule, pill)):
        assert isinstance(found, kind)
        assert (found.p.tolist(), found.q.tolist(), float(found.radius)) == ([0, 0, -2], [0, 0, 2], 1)
    assert isinstance(mesh, MeshPiece)
    assert sorted(mesh.corners.tolist()) == [[0, 0, 0], [0, 3, 0], [2, 0, 0]]
    x, y, z = (mesh.corners[i] for i in mesh.mesh.triangles[0])
    assert np.cross(y - x, z - x)[2] < 0  # a mirror image is turned over


LAUGHS = "<!DOCTYPE r [" + "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 10}">' for i in range(9)) + "]><robot>&a9;</robot>"
EXTERNAL = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>'
JOINT = '<joint name="j{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
BALL = collides('<sphere radius="1"/>')


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (LAUGHS.encode(), "a document type is not read"),
        (EXTERNAL.encode(), "a document type is not read"),
        (b"", "is no XML"),
        (b"\x00\xff\xfe garbage", "is no XML"),
        (b"<robot>", "is no XML"),
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "is no XML"),
        (b"<sdf/>", "its root element is <sdf> in line 1, not <robot>"),
        (b"<robot>" + b"<a>" * 5000 + b"</a>" * 5000 + b"</robot>", "nested too deeply"),
        (b"<robot>" + b"<a/>" * 200_000 + b"</robot>", "too many before it"),
        (robot(""), "has no collision element"),
        (robot("<collision/>"), "<collision> in line 2, <link l0> in line 2, has no geometry"),
        (robot(collides("")), "has no geometry"),
        (robot(collides('<torus r="1"/>')), "torus is no shape that is read"),
        (robot(collides("<sphere/>")), "<sphere> in line 2 has no attribute radius"),
        (robot(collides('<sphere radius="NaN"/>')), "radius must be a number up to 1e9, got 'NaN'"),
        (robot(collides('<sphere radius="inf"/>')), "radius must be a number up to 1e9"),
        (robot(collides('<sphere radius="1e300"/>')), "radius must be a number up to 1e9, got '1e300'"),
        (robot(collides('<sphere radius="-1"/>')), "radius must be greater than 0, got '-1'"),
        (robot(collides('<sphere radius="${r}"/>')), "radius must be a number"),
        (robot(collides('<sphere radius="' + "9" * 100_000 + '"/>')), "radius must be a number up to 1e9, got '999"),
        (robot(collides('<box size="1 2"/>')), "size must be 3 numbers"),
        (robot(collides('<box size="1 2 0"/>')), "size must be greater than 0"),
        (robot(collides('<box size="1 2 3"/>', '<origin rpy="0 nan 0"/>')), "rpy must be 3 numbers"),
        (robot(collides('<mesh scale="1 1 1"/>')), "<mesh> in line 2 has no attribute filename"),
        (robot(collides('<mesh filename="t.obj" scale="1 0 1"/>')), "scale must not be 0"),
        (robot(BALL, BALL), "links l0 and l1 both hang on no joint"),
        (robot(BALL, joints=JOINT.format(1, "l0", "nobody")), "there is no link nobody"),
        (robot(BALL, joints='<joint name="j"/>'), "<joint j> in line 2 has no <parent>"),
        (robot(BALL, BALL, joints=JOINT.format(1, "l0", "l1") * 2), "link l1 has two parents"),
        (robot(BALL, joints=JOINT.format(1, "l0", "l0")), "run in a circle"),
        (robot(BALL, BALL, joints=JOINT.format(1, "l0", "l1") + JOINT.format(2, "l1", "l0")), "run in a circle"),
        (b'<robot><link name="a"/><link name="a"/></robot>', "a link of that name stands in line 1"),
        (b"<robot><link/></robot>", "<link> in line 1 has no attribute name"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(data: bytes, words: str):
    began = time.monotonic()
    with pytest.raises(ModelError) as error:
        collision_elements(data)
    assert words in str(error.value)
    assert len(str(error.value)) < 600
    assert time.monotonic() - began < 5


def test_a_long_chain_of_links_takes_no_long_time():
    n = 10_000
    joints = "".join(JOINT.format(i, f"l{i + 1}", f"l{i}") for i in range(n))
    began = time.monotonic()
    assert len(collision_elements(robot(BALL, *[""] * n, joints=joints))) == 1
    assert time.monotonic() - began < 5


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("../secret.obj", "lies outside of the folder"),
        ("sub/../../secret.obj", "lies outside of the folder"),
        ("package://../secret.obj", "lies outside of the folder"),
        ("../../../../../../../../etc/passwd", "lies outside of the folder"),
        ("/etc/passwd", "is an absolute path"),
        ("package:///etc/passwd", "is an absolute path"),
        ("\\\\host\\share.obj", "is an absolute path"),
        ("file:///etc/passwd", "is no file: only relative paths and package://"),
        ("http://localhost/mesh.obj", "is no file: only relative paths and package://"),
        ("link.obj", "lies outside of the folder"),
        ("loop.obj", "'loop.obj'"),
        ("gone.obj", "is not there"),
        ("sub", "is not there"),
        ("pipe.obj", "is not there"),
        ("r.urdf", "is of no format that is read: .urdf"),
        ("broken.obj", "holds no triangle"),
        ("x" * 5000 + ".obj", "cannot be read"),
        ("", "is not there"),
    ],
)
def test_meshes_are_found_only_within_the_folder(tmp_path: Path, said: str, words: str):
    root = tmp_path / "models"
    (root / "sub").mkdir(parents=True)
    (tmp_path / "secret.obj").write_text(TRIANGLE)
    (root / "link.obj").symlink_to(tmp_path / "secret.obj")
    (root / "loop.obj").symlink_to(root / "loop.obj")
    (root / "broken.obj").write_text("secret")
    os.mkfifo(root / "pipe.obj")  # opening it would wait for ever
    (root / "r.urdf").write_bytes(robot(collides(f'<mesh filename="{said}"/>')))
    with pytest.raises(ModelError) as error:
        urdf_model(root / "r.urdf", root)
    assert words in str(error.value)
    assert "<mesh> in line 2, <link l0> in line 2" in str(error.value)
    assert len(str(error.value)) < 600


@pytest.mark.parametrize("said", ["../meshes/t.obj", "package://bot/meshes/t.obj", "package://meshes/t.obj", "t.obj"])
def test_meshes_beside_above_and_in_packages_are_found(tmp_path: Path, said: str):
    (tmp_path / "bot" / "meshes").mkdir(parents=True)
    (tmp_path / "bot" / "urdf").mkdir()
    for folder in ("meshes", "urdf"):
        (tmp_path / "bot" / folder / "t.obj").write_text(TRIANGLE)
    path = tmp_path / "bot" / "urdf" / "r.urdf"
    path.write_bytes(robot(collides(f'<mesh filename="{said}"/>')))
    (piece,) = urdf_model(path, tmp_path)
    assert isinstance(piece, MeshPiece)
    assert len(piece.mesh.triangles) == 1
