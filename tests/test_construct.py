"""Bounding volumes contain every point, exactly, and are as small as they claim.

Membership is decided here by the checker's own reading of the proxies (`refimpl.proof.reading`), not by the polynomials
that built them.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from refimpl.construct import (
    KINDS,
    ConstructionError,
    aabb,
    bounding,
    box,
    capsule,
    contains,
    cylinder,
    ellipsoid,
    fast_sphere,
    hierarchy,
    hull,
    kdop,
    least_box,
    points_of,
    simplified_hull,
    sphere,
)
from refimpl.construct.optimality import (
    check_ellipsoid,
    check_touching,
    excess_of_ellipsoid,
    prove_ellipsoid,
)
from refimpl.mass import mass_properties
from refimpl.shapes import KDOP, Box, Composite, ConvexPolyhedron, HalfSpace, Polyhedron, Sphere
from tests.clouds import CLOUDS, TURN, exact_sides, lies_behind, lies_in, matrix_of

NEEDS_SOLID = {"ellipsoid": 3, "cylinder": 2}  # dimensions that points must have
DIMENSION = {"coplanar": 2, "coplanar grid": 2, "collinear": 1, "along an axis": 1, "one": 0, "one, many times": 0,
             "two": 1, "of three scales": 1}  # fmt: skip


@pytest.mark.parametrize("kind", [k for k in KINDS if not k.startswith("hull") and k != "kdop18"])
def test_every_point_lies_inside_in_exact_arithmetic(kind):
    for name, points in CLOUDS.items():
        if kind in {"capsule", "cylinder"} and name in {"on a sphere", "tiny", "huge", "far away"}:
            continue  # a search of an axis takes 0.2 s, and of these scales others are asked
        if DIMENSION.get(name, 3) < NEEDS_SOLID.get(kind, 0):
            with pytest.raises(ConstructionError, match=r"line|plane"):
                KINDS[kind](points)
            continue
        found = KINDS[kind](points)
        assert all(lies_in(found, x) for x in points), (kind, name)
        assert contains(found, points).all(), (kind, name)


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder", "kdop26", "ellipsoid", "aabb", "hull8"])
def test_contains_agrees_with_the_checker_next_to_the_surface(kind):
    points = CLOUDS["random"]
    found = KINDS[kind](points)
    mixed = [points, points * 1.5, np.nextafter(points, np.inf), np.nextafter(points, -np.inf)]
    many = np.concatenate(mixed)
    truth = [lies_in(found, x) for x in many]
    assert contains(found, many).tolist() == truth
    assert not all(truth)


def test_contains_agrees_for_turned_and_moved_polytopes():
    points = CLOUDS["random"]
    solid = ConvexPolyhedron([[1, 0, 0, -1], [-1, 0, 0, -1], [0, 1, 1, -1], [0, -1, 0.5, -1], [0, 0, -1, -1]],
                             [0.1, 0.2, 0.3], TURN)  # fmt: skip
    for proxy in (solid, KDOP([[1e200, 0, 0], [0, 1, 0], [0, 0, 1e-200]], [-1e200, -1, -1e-200], [1e200, 1, 1e-200])):
        truth = [lies_in(proxy, x) for x in points]
        assert contains(proxy, points).tolist() == truth
        assert 0 < sum(truth) < len(truth)
    space = HalfSpace([1e-300, 2e-300, 0], 0.0)
    assert contains(space, points).tolist() == (points[:, 0] + 2 * points[:, 1] <= 0).tolist()


def test_contains_knows_unions_and_refuses_what_it_cannot_decide():
    two = Composite([Sphere([0, 0, 0], 1.0), Sphere([3, 0, 0], 1.0)])
    assert contains(two, [[1, 0, 0], [4, 0, 0], [1.5, 0, 0]]).tolist() == [True, True, False]
    tetrahedron = Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    with pytest.raises(TypeError, match="Polyhedron"):
        contains(tetrahedron, [[0, 0, 0]])
    with pytest.raises(ValueError, match="finite"):
        contains(two, [[np.nan, 0, 0]])
    with pytest.raises(ValueError, match="batch"):
        contains(Sphere([[0, 0, 0]], [1.0]), [[0, 0, 0]])


@pytest.mark.parametrize("name", CLOUDS)
def test_one_bit_less_leaves_a_point_outside(name):
    points = CLOUDS[name]
    for ball in (sphere(points), fast_sphere(points)):
        if ball.radius > 5e-324:
            less = replace(ball, radius=np.nextafter(ball.radius, 0))
            assert not contains(less, points).all()
    brick = box(points)
    for axis in range(3):
        if brick.half_extents[axis] > 0:
            half = brick.half_extents.copy()
            half[axis] = np.nextafter(half[axis], 0)
            assert not contains(Box(brick.center, half, brick.rotation), points).all()
    rod = capsule(points)
    if rod.radius > 0:
        assert not contains(replace(rod, radius=np.nextafter(rod.radius, 0)), points).all()
    bounds = aabb(points)
    assert np.array_equal(bounds.lower, points.min(axis=0))
    assert np.array_equal(bounds.upper, points.max(axis=0))


@pytest.mark.parametrize("name", ["random", "cospherical", "far away", "denormal", "huge", "collinear"])
def test_bounds_of_kdops_touch(name):
    points = CLOUDS[name]
    found = kdop(points, 26)
    exact = [[[sum(Fraction(a) * Fraction(b) for a, b in zip(w, x, strict=True)) for x in points.tolist()]
              for w in found.directions.tolist()]][0]  # fmt: skip
    names = [(heights.index(min(heights)), heights.index(max(heights))) for heights in exact]
    assert check_touching(points, found, names)
    wider = KDOP(found.directions, found.lower, np.nextafter(found.upper, np.inf))
    assert not check_touching(points, wider, names)


@pytest.mark.parametrize("name", ["random", "on a sphere", "cospherical", "huge", "tiny"])
def test_the_ellipsoid_is_nearly_the_least(name):
    points = CLOUDS[name]
    found = ellipsoid(points)
    assert 0 <= excess_of_ellipsoid(found, check_ellipsoid(points, prove_ellipsoid(points))) < 1e-7
    larger = replace(found, radii=found.radii * 1.01)
    assert excess_of_ellipsoid(larger, check_ellipsoid(points, prove_ellipsoid(points))) > 0.03


def test_boxes_are_found_that_no_face_of_the_hull_shows():
    """Around a regular tetrahedron the least box is the cube of whose faces its edges are diagonals: O'Rourke's."""
    turned = ConvexPolyhedron.from_vertices([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], rotation=TURN)
    corners = turned.vertices @ matrix_of(TURN).T
    assert np.prod(2 * least_box(corners).half_extents) == pytest.approx(8.0, rel=1e-9)
    cuboid = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)]) @ matrix_of(TURN).T + 5.0
    assert np.prod(2 * least_box(cuboid).half_extents) == pytest.approx(6.0, rel=1e-9)


def test_flat_points_get_flat_boxes():
    flat = CLOUDS["coplanar"]
    assert np.min(least_box(flat).half_extents) < 1e-15
    assert np.min(least_box(CLOUDS["coplanar grid"]).half_extents) == 0
    area = np.prod(np.sort(least_box(CLOUDS["coplanar grid"]).half_extents)[1:] * 2)
    assert area == pytest.approx(16.0, rel=1e-12)
    assert np.sort(box(CLOUDS["collinear"]).half_extents)[1] < 1e-15


def test_rods_of_rods():
    rng = np.random.default_rng(3)
    angle, height = rng.random(200) * 2 * np.pi, rng.random(200) * 4
    side = np.stack([np.cos(angle), np.sin(angle), height], axis=1)
    ends = np.stack([np.cos(angle), np.sin(angle), np.where(height > 2, 4.0, 0.0)], axis=1)
    barrel = np.concatenate([side, ends]) @ matrix_of(TURN).T
    assert mass_properties(cylinder(barrel)).volume <= 4 * np.pi * (1 + 1e-6)
    way = rng.normal(size=(400, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    pill = way + np.where(way[:, 2:] > 0, 3.0, 0.0) * [0, 0, 1]
    assert mass_properties(capsule(pill @ matrix_of(TURN).T)).volume <= (3 * np.pi + 4 / 3 * np.pi) * (1 + 1e-2)


@pytest.mark.parametrize("name", CLOUDS)
def test_hulls_are_made_of_their_corners(name):
    points = CLOUDS[name]
    found = hull(points)
    given_rows = {tuple(row) for row in points.tolist()}
    corners = [tuple(row) for row in found.vertices.tolist()]
    assert set(corners) <= given_rows
    assert len(set(corners)) == len(corners)
    assert contains(found, points).all()
    for i in range(len(corners) if len(corners) > 1 else 0):  # and each of them is needed
        rest = ConvexPolyhedron.from_vertices([c for j, c in enumerate(corners) if j != i])
        assert not contains(rest, [corners[i]])[0]


def test_hulls_against_all_planes_through_three_corners():
    points = CLOUDS["random"]
    found = hull(points)
    sides = list(exact_sides(found))
    assert len(sides) == 2 * len(found.vertices) - 4
    assert all(lies_behind(side, x) for side in sides for x in points)


@pytest.mark.parametrize("planes", [4, 5, 6, 9, 20])
def test_hulls_of_few_planes(planes):
    points = CLOUDS["on a sphere"]
    found = simplified_hull(points, planes)
    assert len(found.numbers) <= planes
    assert contains(found, points).all()
    moved = found.numbers.copy()
    moved[:, 3] = np.nextafter(moved[:, 3], np.inf)
    assert all(not contains(HalfSpace(n, k), points).all() for *n, k in moved.tolist())


def test_more_planes_cut_off_more():
    points = CLOUDS["random"]
    volumes = [float(mass_properties(simplified_hull(points, k)).volume) for k in (6, 8, 12, 24, 60)]
    assert volumes == sorted(volumes, reverse=True)
    whole = float(mass_properties(hull(points)).volume)
    assert whole <= volumes[-1] <= whole * (1 + 1e-9)


@pytest.mark.parametrize("kind", ["aabb", "sphere", "box", "capsule"])
def test_nodes_of_hierarchies_contain_what_is_below_them(kind):
    points = CLOUDS["random"][:12] if kind == "capsule" else CLOUDS["random"]
    tree = hierarchy(points, kind, leaf=4)
    for volume, items in zip(tree.volumes, tree.items, strict=True):
        assert contains(volume, points[items]).all()
    for node, (left, right) in enumerate(tree.children.tolist()):
        if left >= 0:
            both = np.concatenate([tree.items[left], tree.items[right]])
            assert np.array_equal(np.sort(both), tree.items[node])
    assert sorted(np.concatenate([tree.items[i] for i in tree.leaves]).tolist()) == list(range(len(points)))
    assert max(len(tree.items[i]) for i in tree.leaves) <= 4
    assert len(hierarchy(np.ones((9, 3)), kind, leaf=2).volumes) == 1


@pytest.mark.parametrize(
    ("given_points", "message"),
    [
        (np.zeros((0, 3)), "no point"),
        ([[0, 0, 0], [0, np.nan, 0]], "point 1 is not finite"),
        ([[0, 0, np.inf]], "point 0 is not finite"),
        ([1.0, 2.0, 3.0], "shape"),
        ([["a", "b", "c"]], "expected points"),
        ("nowhere.obj", "cannot be read"),
        ("model.step", "meshes are read from"),
        (ConvexPolyhedron([[1, 1, 1, -1], [-1, 0, 0, -1], [0, -1, 0, -1], [0, 0, -1, -1]]), "from_vertices"),
        (ConvexPolyhedron.from_vertices([[0, 0, 0], [1, 1, 1]], position=[1, 2, 3]), "its own frame"),
    ],
)  # fmt: skip
def test_what_has_no_points_is_refused(given_points, message):
    with pytest.raises(ConstructionError, match=message):
        sphere(given_points)


def test_bad_choices_are_refused():
    points = CLOUDS["random"]
    for call, message in (
        (lambda: kdop(points, 7), "usual k"),
        (lambda: kdop(points, [[0, 0, 0]]), "none zero"),
        (lambda: kdop(points, [[1, 0, 0], [0, 1, 0]]), "unbounded"),
        (lambda: simplified_hull(points, 3), "at least 4"),
        (lambda: bounding(points, "torus"), "no bounding volume 'torus'"),
        (lambda: hierarchy(points, "torus"), "no bounding volume 'torus'"),
        (lambda: hierarchy(points, leaf=0), "at least one"),
        (lambda: sphere([[-1.7e308] * 3, [1.7e308] * 3]), "beyond the largest float"),
        (lambda: hull([[1e300, 0, 0], [3e-320, 1, 0], [0, 0, 1]]), "2\\^1000"),
    ):
        with pytest.raises(ConstructionError, match=message):
            call()


def test_points_come_from_meshes(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    solid = trimesh.creation.icosphere(subdivisions=1)
    path = tmp_path / "ball.off"
    solid.export(path)
    there = {tuple(row) for row in solid.vertices.tolist()}
    assert {tuple(row) for row in points_of(solid).tolist()} == there
    read_back = points_of(path)
    assert len(read_back) == len(there)
    assert np.abs(np.sort(read_back, axis=0) - np.sort(solid.vertices, axis=0)).max() < 1e-6
    body = Polyhedron(solid.vertices, solid.faces)
    assert {tuple(row) for row in points_of(Composite([body, body])).tolist()} == there
    cloud = trimesh.PointCloud(solid.vertices)
    assert len(points_of(cloud)) == len(there)
