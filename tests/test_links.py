"""The solid of a robot's link: placed as its URDF says, from files that its package holds and no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oracles.links import solid_of_link
from oracles.meshfiles import ModelError
from refimpl.linear import rotation_matrix
from refimpl.loading import LoadError
from refimpl.mass import mass_properties
from tests.solids import L_SHAPE, box, prism
from tests.test_loading import obj
from tests.test_urdf import turned

pytest.importorskip("trimesh")

JOINT = """<joint name="j" type="fixed"><parent link="l0"/><child link="l1"/><origin xyz="5 0 0"/></joint>"""
PLACE = '<origin xyz="1 2 3" rpy="0.3 -1.1 2.5"/>'


def shape(geometry: str, origin: str = "", sort: str = "collision") -> str:
    return f"<{sort}>{origin}<geometry>{geometry}</geometry></{sort}>"


def mesh(file: str, scale: str = "1 1 1") -> str:
    return f'<mesh filename="{file}" scale="{scale}"/>'


@pytest.fixture
def robot(tmp_path: Path):
    """Write a URDF of links to robot/urdf, with meshes beside it in robot/meshes; gives its path."""
    (tmp_path / "robot" / "urdf").mkdir(parents=True)
    (tmp_path / "robot" / "meshes").mkdir()
    (tmp_path / "robot" / "meshes" / "part.obj").write_text(obj(prism(L_SHAPE)))

    def write(*links: str) -> Path:
        body = "".join(f'<link name="l{i}">{link}</link>' for i, link in enumerate(links))
        path = tmp_path / "robot" / "urdf" / "arm.urdf"
        path.write_text(f'<robot name="r">{body}{JOINT if len(links) > 1 else ""}</robot>')
        return path

    return write


@pytest.mark.parametrize("file", ["../meshes/part.obj", "package://robot/meshes/part.obj", "package://meshes/part.obj"])
def test_a_mesh_is_placed_in_the_frame_of_its_link(robot, file: str) -> None:
    name, solid = solid_of_link(robot(shape(mesh(file, "2 3 -4"), PLACE)))
    corners = np.array(prism(L_SHAPE)[0]) * [2, 3, -4]
    expected = corners @ (turned(2, 2.5) @ turned(1, -1.1) @ turned(0, 0.3)).T + [1, 2, 3]
    assert name == "l0"
    found = solid.vertices[np.lexsort(solid.vertices.T.round(6))]
    assert found == pytest.approx(expected[np.lexsort(expected.T.round(6))], abs=1e-12)
    assert mass_properties(solid).volume == pytest.approx(24 * mass_of_l_prism(), rel=1e-12)  # mirrored, not inside out


def mass_of_l_prism() -> float:
    x, y = np.array(L_SHAPE).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2  # the shoelace formula; the prism is 1 high


def test_boxes_are_solids_too_and_joints_do_not_matter(robot) -> None:
    two = shape('<box size="1 2 3"/>', PLACE) + shape('<box size="2 2 2"/>', '<origin xyz="9 0 0"/>')
    path = robot(shape(mesh("../meshes/part.obj")), two)
    _, solid = solid_of_link(path, "l1", scale=2.0)
    found = mass_properties(solid)
    assert found.volume == pytest.approx(8 * (6 + 8), rel=1e-12)
    assert found.barycentre == pytest.approx(2 * (6 * np.array([1, 2, 3]) + 8 * np.array([9, 0, 0])) / 14, rel=1e-12)


def test_what_is_seen_takes_the_place_of_what_collides_when_asked_or_alone(robot) -> None:
    seen = shape(mesh("../meshes/part.obj"), sort="visual")
    both = robot(shape('<box size="1 1 1"/>') + seen)
    assert len(solid_of_link(both)[1].vertices) == 8
    assert len(solid_of_link(both, sort="visual")[1].vertices) == 12
    assert len(solid_of_link(robot(seen))[1].vertices) == 12


def test_links_are_chosen_by_name(robot) -> None:
    ball, one = shape('<sphere radius="1"/>'), shape('<box size="1 1 1"/>')
    with pytest.raises(ModelError, match="has 2 links with shapes: l0, l1"):
        solid_of_link(robot(ball, one))
    with pytest.raises(ModelError, match="has no link l2 with a collision or visual element; there are l0, l1"):
        solid_of_link(robot(ball, one), "l2")
    with pytest.raises(ModelError, match=r"<sphere> in line 1, .*: a sphere is a proxy already"):
        solid_of_link(robot(ball, one), "l0")
    assert solid_of_link(robot(ball, one), "l1")[0] == "l1"
    with pytest.raises(ModelError, match="has no link with a visual element"):
        solid_of_link(robot(one), sort="visual")


def test_nothing_outside_of_the_package_is_opened(robot, tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text(obj(box()))
    (tmp_path / "robot" / "meshes" / "link.obj").symlink_to(tmp_path / "secret.obj")
    for file in ("../../secret.obj", "package://../secret.obj", "../meshes/link.obj"):
        path = robot(shape(mesh(file)))
        with pytest.raises(ModelError, match="lies outside of the folder"):
            solid_of_link(path)
        with pytest.raises(ModelError, match="is an absolute path"):
            solid_of_link(robot(shape(mesh(str(tmp_path / "secret.obj")))))
    assert len(solid_of_link(robot(shape(mesh("../../secret.obj"))), root=tmp_path)[1].triangles) == 12
    (tmp_path / "package.xml").write_text("<package/>")
    assert len(solid_of_link(robot(shape(mesh("../../secret.obj"))))[1].triangles) == 12


def test_defects_and_their_repairs_are_those_of_files(robot, tmp_path: Path) -> None:
    vertices, triangles = box()
    (tmp_path / "robot" / "meshes" / "open.obj").write_text(obj((vertices, triangles[2:])))
    (tmp_path / "robot" / "meshes" / "none.obj").write_text("v 0 0 0\n")
    path = robot(shape(mesh("../meshes/open.obj"), '<origin xyz="1 0 0"/>'))
    with pytest.raises(LoadError, match=r"^arm\.urdf, link l0: Polyhedron: open: the edge"):
        solid_of_link(path)
    _, solid = solid_of_link(path, repairs=["fill_holes"])
    assert mass_properties(solid).barycentre == pytest.approx([1.5, 0.5, 0.5])
    with pytest.raises(ModelError, match=r"'\.\./meshes/none\.obj': meshes/none\.obj holds no triangle"):
        solid_of_link(robot(shape(mesh("../meshes/none.obj"))))


def test_links_of_pybullets_robots() -> None:
    """The foot of the arm is where PyBullet's own study has it: link 0 hangs on nothing, and has no placement."""
    data = Path(pytest.importorskip("pybullet_data").getDataPath())
    name, solid = solid_of_link(data / "kuka_iiwa/model.urdf", "lbr_iiwa_link_0", repairs=("merge_near", "fill_holes"))
    assert name == "lbr_iiwa_link_0"
    assert mass_properties(solid).volume == pytest.approx(0.005479, rel=1e-3)
    assert np.all(rotation_matrix(solid.rotation) == np.eye(3))
