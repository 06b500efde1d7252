"""What hangs on meshes: the tree of their faces' boxes, and the tree of the planes that part inside from outside."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

from refimpl import AABB, Point, Polyhedron, Ray, ShapeError, Sphere, distance, intersect, raycast
from refimpl.broadphase import SolidTree, SurfaceTree
from refimpl.bsp import EMPTY
from refimpl.meshes import six_volumes, winding_numbers
from refimpl.signs import Points
from tests.solids import SOLIDS

POSES = {"still": {}, "turned": {"position": (0.3, -2.0, 1.1), "rotation": (1.0, 2.0, 3.0, 4.0)}}
CASES = [(name, pose) for name in SOLIDS for pose in POSES]


@pytest.fixture(scope="module")
def trees():
    """Both trees of each solid, made once."""
    meshes = {(name, pose): Polyhedron(*SOLIDS[name], **POSES[pose]) for name, pose in CASES}
    return {case: (mesh, SolidTree(mesh), SurfaceTree(mesh)) for case, mesh in meshes.items()}


def rays_around(mesh, share=0.3, count=100):
    """Rays from whole and half coordinates of the mesh's frame, many of them through edges and along faces.

    `share` of them are in general position.
    """
    rng = np.random.default_rng(3)
    origin, way = rng.integers(-4, 9, (count, 3)) / 2, rng.integers(-2, 3, (count, 3)) * 1.0
    way[~way.any(axis=1)] = 1.0
    wild = rng.random(count) < share
    origin[wild] += rng.normal(size=(np.sum(wild), 3))
    toward = mesh.vertices.mean(axis=0) - origin
    way = np.where((rng.random(count) < 0.4)[:, None], toward, way)
    return Ray(origin, way).rotated(mesh.rotation).translated(mesh.position)


# ---------------------------------------------------------------------------------- partition: points


@pytest.mark.parametrize("name", SOLIDS)
def test_points_are_located_exactly(trees, name):
    """By winding numbers off the surface, and on it by construction: corners, and midpoints of whole edges."""
    mesh, tree, _ = trees[name, "still"]
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    some = np.random.default_rng(1).uniform(low - 0.2, high + 0.2, (300, 3))
    expected = np.where(winding_numbers(mesh.vertices[mesh.triangles], some) > 0, 1, -1)
    assert np.array_equal(tree.locate(some), expected)
    assert {1, -1} == set(expected.tolist())
    assert np.all(tree.locate(mesh.vertices) == 0)
    if name != "torus":  # of which the midpoints are rounded
        corners = mesh.vertices[mesh.triangles]
        assert np.all(tree.locate(corners / 2 + np.roll(corners, 1, axis=1) / 2) == 0)


def test_one_unit_in_the_last_place_is_told(trees):
    _, tree, _ = trees["U", "still"]
    floor = np.array([1.5, 1.0, 0.5])  # of the notch
    below, above = np.nextafter(floor, [1.5, 0.0, 0.5]), np.nextafter(floor, [1.5, 2.0, 0.5])
    assert tree.locate([below, floor, above]).tolist() == [1, 0, -1]
    seam = np.array([1.0, 0.5, 0.5])  # on planes of faces, and inside
    assert tree.locate(seam) == 1
    assert tree.locate([1.0, 1.5, 1.0]) == 0  # in the plane of another face, on the surface


def test_a_placed_solid_is_located_in_rational_numbers():
    """The rotation by a quaternion that is no unit is rational, and so is where its corners go."""
    box = Polyhedron(*SOLIDS["box"], rotation=(0.0, 0.0, 2.0, 4.0))  # cosine 3/5, sine 4/5
    tree = SolidTree(box)
    x = 0.75
    y = float(Fraction(3, 4) * Fraction(4, 3))  # on the line from 0 along the rotated x axis, where y = 4/3 x
    assert Fraction(y) == Fraction(x) * Fraction(4, 3)
    inside = Fraction(x) * Fraction(3, 5) + Fraction(y) * Fraction(4, 5) < 1  # else beyond the corner
    assert not inside
    assert tree.locate([0.375, 0.5, 0.5]) == 0
    assert tree.locate([np.nextafter(0.375, 1), 0.5, 0.5]) == -1
    assert tree.locate([np.nextafter(0.375, 0), 0.5, 0.5]) == 1


def test_bad_arguments():
    box = Polyhedron(*SOLIDS["box"])
    for kind in (SolidTree, SurfaceTree):
        with pytest.raises(ShapeError, match="single"):
            kind(box.broadcast_to((2,)))
    with pytest.raises(ShapeError, match="finite"):
        SolidTree(box).locate([np.nan, 0, 0])


# ------------------------------------------------------------------------------------ partition: rays


@pytest.mark.parametrize(("name", "pose"), CASES)
def test_rays_enter_when_raycast_says(trees, name, pose):
    mesh, tree, _ = trees[name, pose]
    rays = rays_around(mesh, 0.3 if pose == "still" else 1.0)  # a pose is rounded by raycast, and here it is not
    times, hits = tree.enter(rays), raycast(rays, mesh)
    assert np.array_equal(np.isfinite(times), hits.hit)
    both = hits.hit
    assert 10 < np.sum(both) < len(times)
    assert np.allclose(times[both], hits.t[both], rtol=1e-12, atol=1e-12)
    assert np.array_equal(times == 0, tree.locate(rays.origin) >= 0)


def test_a_ray_that_starts_on_the_surface_has_met_the_solid():
    """Where the point of the surface next to it is rounded, and the origin counts as outside by 1e-16."""
    hollow = Polyhedron(*SOLIDS["hollow"])
    origin = [[1.0, 0.5, 0.0], [1.0, 0.5, 0.0], [-0.5, 1.0, 0.0]]
    rays = Ray(origin, [[0.0, 1.0, -2.0], [0.0, 0.0, -1.0], [-2.0, 0.0, 2.0]])  # along the surface
    inwards = Ray(origin, [[-1.0, 0.0, 0.5], [-2.0, 0.5, 1.0], [0.0, -1.0, -3.0]])
    for some in (rays, inwards):
        assert SolidTree(hollow).enter(some).tolist() == [0, 0, 0]
        assert raycast(some, hollow).t.tolist() == [0, 0, 0]


def test_nothing_cut_off_is_solid(trees):
    """Taking a node's solid half for empty changes what is found: the tests see every part of the tree."""
    mesh, tree, _ = trees["U", "still"]
    points = np.random.default_rng(2).uniform(0, 3, (400, 3)) * [1, 0.7, 0.35]
    right = tree.locate(points)
    for cut in tree.cuts:
        for place, child in enumerate(cut.children):
            if child != EMPTY:
                wrong = SolidTree(mesh)
                wrong._children[tree.cuts.index(cut), place] = EMPTY
                assert not np.array_equal(wrong.locate(points), right)


# --------------------------------------------------------------------------- partition: decomposition


def exact_heights(planes, corners):
    """Heights of corners (x, y, z, w) above planes, up to positive factors."""
    return [[a * x + b * y + c * z + d * w for x, y, z, w in corners] for a, b, c, d in planes]


def dot(n, corner):
    return sum(a * b for a, b in zip(n, corner, strict=False))


def parted(one, two):
    """Whether a plane of a facet, or one along an edge of each, has no point of either interior on its other side."""
    for p, q in ((one, two), (two, one)):
        if np.any(p.vertices.max(axis=0) < q.vertices.min(axis=0)):  # correctly rounded, so this is exact too
            return True
        if any(min(row) >= 0 for row in exact_heights(p.planes, q.corners)):
            return True
    ways = [
        {
            tuple(int(v) for v in np.cross(np.array(p.planes[i][:3], object), np.array(p.planes[j][:3], object)))
            for i, j in combinations(range(len(p.planes)), 2)
        }
        for p in (one, two)
    ]
    for u in ways[0]:
        for v in ways[1]:
            n = np.cross(np.array(u, object), np.array(v, object))
            if any(n):
                spans = [[Fraction(int(dot(n, c)), c[3]) for c in piece.corners] for piece in (one, two)]
                if max(spans[0]) <= min(spans[1]) or max(spans[1]) <= min(spans[0]):
                    return True
    return False


@pytest.mark.parametrize("name", SOLIDS)
def test_pieces_have_disjoint_interiors_and_fill_the_solid(trees, name):
    """In integers: each two are parted by a plane, none leaves the solid, and the volumes add up to the solid's."""
    mesh, tree, _ = trees[name, "still"]
    for one, two in combinations(tree.pieces, 2):
        assert parted(one, two)
    assert not any(parted(piece, piece) for piece in tree.pieces[:3])
    points = Points(mesh.vertices)
    volume = Fraction(six_volumes(points, mesh.triangles)) * Fraction(2) ** (3 * points.grid_exponent)
    assert sum(piece.six_volumes() for piece in tree.pieces) == volume
    thick = [piece for piece in tree.pieces if piece.six_volumes() > 1e-6]  # the middles of others are rounded out
    assert np.all(tree.locate([piece.vertices.mean(axis=0) for piece in thick]) == 1)
    assert float(sum(piece.six_volumes() for piece in thick) / volume) > 0.9999


# ---------------------------------------------------------------------------------------- the surface


@pytest.mark.parametrize(("name", "pose"), CASES)
def test_first_hits_are_those_of_raycast(trees, name, pose):
    mesh, _, tree = trees[name, pose]
    rays = rays_around(mesh)
    found, expected = tree.raycast(rays), raycast(rays, mesh)
    assert np.array_equal(found.hit, expected.hit)
    facing = [np.sum(hits.normal * rays.direction, axis=1) for hits in (found, expected)]  # an edge has two normals
    for mine, other in ((found.t, expected.t), (found.point, expected.point), facing):
        assert np.allclose(mine, other, rtol=1e-14, atol=1e-14, equal_nan=True)


@pytest.mark.parametrize(("name", "pose"), CASES)
def test_all_hits_alternate(trees, name, pose):
    """A ray in general position leaves and enters in turn, at as many faces as it has to; the first one is the hit."""
    mesh, partition, tree = trees[name, pose]
    rng = np.random.default_rng(9)
    origin = Point(rng.normal(size=(60, 3)) * 2).rotated(mesh.rotation).translated(mesh.position).position
    rays = Ray(origin, rng.normal(size=(60, 3)))
    row, face, time = tree.crossings(rays)
    corners = mesh.vertices[mesh.triangles[face]]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    way = rays.rotated(mesh.rotation * [-1, -1, -1, 1]).direction[row]
    out = np.sum(outward * way, axis=1) > 0
    starts = partition.locate(rays.origin) > 0
    for i in range(60):
        mine = out[row == i].tolist()
        assert mine == [(k % 2 == 0) == starts[i] for k in range(len(mine))]
        assert len(mine) % 2 == starts[i]
        assert np.all(np.diff(time[row == i]) > 0)
    first = dict(zip(row[::-1].tolist(), time[::-1].tolist(), strict=True))
    outside = np.flatnonzero(~starts)
    assert np.allclose(raycast(rays[outside], mesh).t, [first.get(i, np.inf) for i in outside.tolist()], rtol=1e-12)


@pytest.mark.parametrize(("name", "pose"), CASES)
def test_nearest_points_of_the_surface(trees, name, pose):
    mesh, _, tree = trees[name, pose]
    points = Point(np.random.default_rng(4).normal(size=(60, 3)) * 1.5).translated(mesh.position)
    gap, foot, face = tree.nearest(points.position)
    assert np.allclose(gap, np.abs(distance(points, mesh).distance), rtol=1e-12, atol=1e-14)
    assert np.allclose(np.linalg.norm(points.position - foot, axis=1), gap, rtol=1e-12, atol=1e-14)
    every = distance(points[:, None], tree._faces[None]).distance
    assert np.allclose(every[np.arange(60), face], every.min(axis=1), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("name", "pose"), CASES)
def test_faces_that_a_proxy_meets(trees, name, pose):
    mesh, _, tree = trees[name, pose]
    rng = np.random.default_rng(6)
    center = rng.integers(-2, 5, (25, 3)) / 2 + mesh.position
    for shape in (Sphere(center, rng.uniform(0.1, 1.0, 25)), AABB(center - 0.25, center + rng.random((25, 3)))):
        found = set(zip(*(x.tolist() for x in tree.meeting(shape)), strict=True))
        met = intersect(shape[:, None], tree._faces[None])
        assert found == set(map(tuple, np.argwhere(met).tolist()))
        assert len(found) > 0
