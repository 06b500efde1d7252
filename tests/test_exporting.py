"""What is written for other programs: JSON that reads back to the bit, and URDFs that PyBullet loads as meant."""

from pathlib import Path

import numpy as np
import pytest

from oracles.exporting import proxies_from_json, proxies_to_json, urdf
from oracles.urdf import collision_elements
from refimpl import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Sphere,
    UnsupportedOperation,
    distance,
    mass_properties,
    support,
)
from refimpl.bounds import aabb, bounding_sphere
from refimpl.linear import apply, norm, rotation_matrix
from tests.solids import L_SHAPE, prism

bullet = pytest.importorskip("pybullet")
pytest.importorskip("trimesh")

CORNERS = np.random.default_rng(3).normal([0.4, -0.3, 0.2], 1.0, (12, 3))
TURN = [0.3, -0.2, 0.5, 0.7]
PROXIES = {
    "aabb": AABB([-1, 0, 0.5], [1, 0.25, 0.7]),
    "box": Box([0.1, 0.2, 0.3], [1 / 3, 0.2, 0.1], TURN),
    "sphere": Sphere([0.1, 0.2, 0.3], 1 / 3),
    "capsule": Capsule([0.1, 0.2, 0.3], [0.5, -0.2, 0.7], 0.1),
    "upright": Capsule([0, 0, -1], [0, 0, 1], 0.1),
    "along_x": Capsule([-1, 0, 0], [1, 0, 0], 0.1),
    "cylinder": Cylinder([0.1, 0.2, 0.3], [0.5, -0.2, 0.7], 0.1),
    "hull": ConvexPolyhedron.from_vertices(CORNERS, [0.1, 0, 0], TURN),
    "kdop": KDOP.around(CORNERS, 18),
    "ellipsoid": Ellipsoid([0.1, 0.2, 0.3], [0.5, 0.2, 1.0], TURN),
    "union": Composite(
        [Sphere([0, 0, 0], 0.5), Box([1, 0, 0], [0.5, 0.2, 0.1], TURN), Capsule([0, 0, 0], [1, 1, 0], 0.1)]
    ),
}  # fmt: skip
WAYS = np.random.default_rng(4).normal(size=(64, 3))
MATTER = mass_properties(Box([0.2, -0.1, 0.3], [0.4, 0.2, 0.1], TURN))


def test_json_gives_every_bit_back() -> None:
    again = proxies_from_json(proxies_to_json("a ⟨model⟩", PROXIES))
    assert list(again) == list(PROXIES)
    for name, proxy in PROXIES.items():
        assert type(again[name]) is type(proxy)
        assert np.array_equal(again[name].pack(), proxy.pack()), name


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"format": "other"}', "[" * 100_000, '{"format": "proxyproof-proxies"}',
     '{"format": "proxyproof-proxies", "proxies": []}', '{"format": "proxyproof-proxies", "proxies": {"a": 1}}',
     '{"format": "proxyproof-proxies", "proxies": {"a": {"type": "Sphere", "numbers": [0, 0, 0, -1]}}}',
     '{"format": "proxyproof-proxies", "proxies": {"a": {"type": "Sphere", "numbers": [NaN, 0, 0, 1]}}}',
     '{"format": "proxyproof-proxies", "proxies": {"a": {"type": "Path", "numbers": [1]}}}'],
)  # fmt: skip
def test_other_json_is_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  JSON's own error is one too
        proxies_from_json(text)


def written(name: str, folder: Path) -> Path:
    robot = urdf(PROXIES[name], name, matter=MATTER, mass=3.0)
    for file, content in robot.files.items():
        (folder / file).write_bytes(content)
    return folder / next(iter(robot.files))


def corners_of(path: Path) -> np.ndarray:
    lines = (line.split() for line in path.read_text().splitlines())
    return np.array([[float(x) for x in words[1:4]] for words in lines if words and words[0] == "v"])


SIZED = {
    "box": (bullet.GEOM_BOX, tuple),
    "sphere": (bullet.GEOM_SPHERE, lambda s: (s[0],) * 3),
    "capsule": (bullet.GEOM_CAPSULE, lambda s: (s[1], s[0], 0.0)),
    "cylinder": (bullet.GEOM_CYLINDER, lambda s: (s[1], s[0], 0.0)),
    "mesh": (bullet.GEOM_MESH, lambda s: (1.0, 1.0, 1.0)),
}


@pytest.fixture(scope="module")
def world():
    client = bullet.connect(bullet.DIRECT)
    yield client
    bullet.disconnect(client)


@pytest.mark.parametrize("name", PROXIES)
def test_bullet_loads_what_was_written(name: str, tmp_path: Path, world: int) -> None:
    """Sort, sizes and place of each collision shape are those of the file, which are those of the proxy."""
    path = written(name, tmp_path)
    bullet.resetSimulation(physicsClientId=world)
    flags = bullet.URDF_USE_IMPLICIT_CYLINDER | bullet.URDF_USE_INERTIA_FROM_FILE
    body = bullet.loadURDF(str(path), flags=flags, physicsClientId=world)
    info = bullet.getDynamicsInfo(body, -1, physicsClientId=world)
    shapes = bullet.getCollisionShapeData(body, -1, physicsClientId=world)
    elements = collision_elements(path.read_bytes())
    parts = PROXIES[name].parts if name == "union" else (PROXIES[name],)
    assert len(shapes) == len(elements) == len(parts)
    for shape, element, part in zip(shapes, elements, parts, strict=True):
        sort, sizes = SIZED[element.sort]
        assert shape[2] == sort
        assert shape[3] == pytest.approx(sizes(element.sizes), rel=1e-15)
        there = bullet.multiplyTransforms(info[3], info[4], shape[5], shape[6])
        assert there[0] == pytest.approx(element.pose.position.tolist(), abs=1e-6)  # PyBullet multiplies in floats
        ours, theirs = (rotation_matrix(np.array(q)) for q in (element.pose.rotation, there[1]))
        assert np.abs(ours - theirs).max() < 1e-6
        assert np.abs(reach(element, path) / support(part, WAYS) - 1).max() < (0.02 if "ellipsoid" in name else 1e-12)
    assert info[0] == 3.0
    assert info[3] == pytest.approx(MATTER.barycentre.tolist(), rel=1e-12)
    axes = rotation_matrix(np.array(info[4]))
    assert axes @ np.diag(info[2]) @ axes.T == pytest.approx(MATTER.of_mass(3.0), rel=1e-5, abs=1e-8)
    assert np.ptp(info[2]) > 0.1 * max(info[2])  # a tensor that a turn changes
    assert_alike(body, PROXIES[name], 0.014 if name == "ellipsoid" else 0.0, world)


MARGIN = 0.001
"""PyBullet's collision margin, by which corners and edges of convex shapes are rounded off and rays hit too early."""


def assert_alike(body: int, proxy: Proxy, larger: float, world: int) -> None:
    """Rays and a ball meet the loaded body where they meet the proxy; a hull around it may be a bit larger."""
    ball, rng = bounding_sphere(proxy), np.random.default_rng(6)
    middle, size, count = np.array(ball.center), float(ball.radius), 80
    way, allowed = rng.normal(size=(count, 3)), 1.5 * MARGIN + larger * size
    start = middle + 3 * size * way / norm(way)[:, None]
    around = aabb(proxy)
    aim = (around.lower + around.upper) / 2 + 0.7 * (around.upper - around.lower) * rng.uniform(-1, 1, (count, 3))
    end = start + 2 * (aim - start)
    bullet.performCollisionDetection(physicsClientId=world)  # rays see no body that was only loaded
    found = bullet.rayTestBatch(start.tolist(), end.tolist(), physicsClientId=world)
    hit, where = np.array([f[0] == body for f in found]), np.array([f[3] for f in found])
    near = distance(Capsule(start, end, np.zeros(count)), proxy).distance
    assert np.all(hit[near < -allowed])
    assert not np.any(hit[near > allowed])
    assert 5 < np.sum(hit) < count
    assert np.abs(distance(Point(where[hit]), proxy).distance).max() < allowed
    shape = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.2 * size, physicsClientId=world)
    other = bullet.createMultiBody(1.0, shape, physicsClientId=world)
    for at in middle + size * rng.normal(size=(30, 3)):
        gap = float(distance(proxy, Sphere(at, 0.2 * size)).distance)
        bullet.resetBasePositionAndOrientation(other, at.tolist(), [0, 0, 0, 1], physicsClientId=world)
        points = bullet.getClosestPoints(body, other, 10 * size, physicsClientId=world)
        if gap > allowed:  # overlaps are as deep as each engine's algorithm finds them
            assert min(point[8] for point in points) == pytest.approx(gap, abs=allowed)


def reach(element, path: Path) -> np.ndarray:
    """Support of a collision element along the ways, from what the file says."""
    local = apply(rotation_matrix(element.pose.rotation).T, WAYS)
    far = WAYS @ element.pose.position
    sizes = np.array(element.sizes)
    match element.sort:
        case "box":
            return far + np.abs(local) @ sizes / 2
        case "sphere":
            return far + sizes[0] * norm(WAYS)
        case "capsule":
            return far + sizes[0] * norm(WAYS) + np.abs(local[:, 2]) * sizes[1] / 2
        case "cylinder":
            return far + sizes[0] * np.hypot(local[:, 0], local[:, 1]) + np.abs(local[:, 2]) * sizes[1] / 2
    return far + np.max(local @ corners_of(path.parent / element.file).T, axis=1)


def test_the_hull_of_an_ellipsoid_contains_it(tmp_path: Path) -> None:
    path = written("ellipsoid", tmp_path)
    (element,) = collision_elements(path.read_bytes())
    assert np.all(reach(element, path) >= support(PROXIES["ellipsoid"], WAYS))


def test_what_no_urdf_holds_is_refused() -> None:
    for proxy in (HalfSpace([0, 0, 1], 0), Polyhedron(*prism(L_SHAPE)), Composite([HalfSpace([0, 0, 1], 0)])):
        with pytest.raises(UnsupportedOperation, match="cannot stand in a URDF"):
            urdf(proxy, "x")


def test_names_are_escaped_by_the_xml_writer() -> None:
    robot = urdf(PROXIES["sphere"], 'a"<&>b')
    assert b'name="a&quot;&lt;&amp;&gt;b"' in robot.files['a"<&>b.urdf']
