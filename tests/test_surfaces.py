"""Points, balls and rays against meshes: by exact arithmetic over all triangles, and by moving balls out."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from refimpl import (
    Box,
    ConvexPolyhedron,
    Point,
    Polyhedron,
    Ray,
    Sphere,
    collide,
    compiling,
    distance,
    intersect,
    raycast,
)
from refimpl.algorithms import surfaces
from refimpl.contacts import contacts
from refimpl.kernels import windings
from refimpl.linear import apply, apply_inverse, rotation_matrix
from refimpl.meshes import winding_numbers
from tests.benchmarks.scenes import globe
from tests.solids import SOLIDS, U_SHAPE, box, hollow_box, prism, together, turned
from tests.truth.rationals import cross, dot, minus, plus, scaled, vector
from tests.truth.unions import corners_of, surrounds

BUMPY = globe(9, 12, 0.1)
SLIT = prism([(0, 0), (3, 0), (3, 2), (1.5001, 2), (1.5, 0.5), (1.4999, 2), (0, 2)])
MESHES = {**SOLIDS, "bumpy": BUMPY, "slit": SLIT}


def square_from_triangle(p, t):
    """Square of the exact distance of a point from a triangle."""
    normal = cross(minus(t[1], t[0]), minus(t[2], t[0]))
    foot = minus(p, scaled(Fraction(dot(minus(p, t[0]), normal)) / dot(normal, normal), normal))
    sides = [(t[i], minus(t[(i + 1) % 3], t[i])) for i in range(3)]
    if all(dot(cross(way, minus(foot, start)), normal) >= 0 for start, way in sides):
        return dot(minus(p, foot), minus(p, foot))
    feet = []
    for start, way in sides:
        share = min(max(Fraction(dot(minus(p, start), way)) / dot(way, way), Fraction(0)), Fraction(1))
        feet.append(plus(start, scaled(share, way)))
    return min(dot(minus(p, foot), minus(p, foot)) for foot in feet)


def at_least(p, t):
    """Lower bound of the distance from a triangle, rounded down: by a ball around the triangle."""
    corners, x = np.array(t, dtype=float), np.array(p, dtype=float)
    middle = corners.mean(axis=0)
    reach = np.max(np.linalg.norm(corners - middle, axis=1))
    return np.linalg.norm(x - middle) - reach - 1e-12 * (np.max(np.abs(corners)) + np.max(np.abs(x)))


def exact_height(p, triangles):
    """Signed distance by the exact square of the least distance, and by an exact ray."""
    p = vector(p)
    square = Fraction(0)
    for rough, t in sorted((at_least(p, t), t) for t in triangles):
        if square and rough > float(square) ** 0.5:
            break
        here = square_from_triangle(p, t)
        if here == 0:
            return 0.0
        square = min(square or here, here)
    gap = float(square) ** 0.5
    return -gap if surrounds(triangles, p) else gap


def awkward_points(vertices, triangles, rng, count):
    """On vertices, edges, faces and chords, next to them, around, and far away."""
    corners = vertices[triangles]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    on = [vertices, corners[:, 0] / 2 + corners[:, 1] / 2, corners.mean(axis=1)]
    on.append((vertices[:4, None] / 2 + vertices[None, :4] / 2).reshape(-1, 3))
    points = np.concatenate(on)
    beside = points + rng.choice([0.0, 1e-16, -1e-12, 1e-8, 0.1], points.shape)
    around = rng.uniform(low - 0.3, high + 0.3, (count, 3))
    far = vertices.mean(axis=0) + rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(0, 6, (count, 1))
    chosen = rng.permutation(2 * len(points))[: 2 * count]
    return np.concatenate([np.concatenate([points, beside])[chosen], around, far])


def require_heights(points, mesh, found):
    """Answers are those of exact arithmetic, and their witness points realise them."""
    size = np.maximum(mesh.magnitude, np.max(np.abs(points), axis=1))
    triangles = corners_of(mesh)
    exact = np.array([exact_height(p, triangles) for p in points])
    assert np.all(np.abs(found.distance - exact) <= 1e-15 * size)
    assert np.all((found.distance * exact >= 0) | (np.abs(exact) <= 1e-15 * size))
    assert np.all(
        np.linalg.norm(found.on_b - found.on_a - found.distance[:, None] * found.normal, axis=1) <= 1e-12 * size
    )
    assert np.allclose(np.linalg.norm(found.normal, axis=1), 1.0, atol=1e-15)


@pytest.mark.parametrize("name", MESHES)
def test_heights_are_those_of_exact_arithmetic(name):
    rng = np.random.default_rng(21)
    count = 8 if len(MESHES[name][1]) < 100 else 2
    for vertices, triangles in (MESHES[name], turned(MESHES[name], 22)):
        for size in (1.0, 1e6):
            mesh = Polyhedron(vertices * size, triangles)
            points = awkward_points(vertices * size, triangles, rng, count)
            require_heights(points, mesh, distance(Point(points), mesh))


@pytest.mark.parametrize("thin", [1e-3, 1e-9, 1e-15])
def test_heights_of_slivers(thin):
    rng = np.random.default_rng(23)
    vertices, triangles = prism(U_SHAPE)
    mesh = Polyhedron(vertices * [1, thin, 1], triangles)
    points = rng.uniform([-0.5, -2 * thin, -0.5], [3.5, 4 * thin, 1.5], (40, 3))
    require_heights(points, mesh, distance(Point(points), mesh))


def test_the_exact_check_sees_what_is_wrong():
    mesh = Polyhedron(*prism(U_SHAPE))
    points = np.random.default_rng(24).uniform(-1, 3, (30, 3))
    found = distance(Point(points), mesh)
    for change in (lambda d: -d, lambda d: d * (1 + 1e-13), np.abs):
        wrong = type(found)(change(found.distance), found.on_a, found.on_b, found.normal)
        with pytest.raises(AssertionError):
            require_heights(points, mesh, wrong)


@pytest.mark.parametrize("name", MESHES)
def test_where_doubles_cannot_tell_the_side_exact_arithmetic_does(name, monkeypatch):
    """The same answers when every ray is refused, and the same signs as the exact winding numbers."""
    rng = np.random.default_rng(25)
    monkeypatch.setattr(surfaces, "module_for", lambda name, rows: __import__(f"refimpl.kernels.{name}", fromlist="x"))
    vertices, triangles = turned(MESHES[name], 26)
    points = awkward_points(vertices, triangles, rng, 20)
    mesh = Polyhedron(vertices, triangles)
    found = distance(Point(points), mesh)
    clear = np.abs(found.distance) > 1e-14 * mesh.magnitude
    assert np.array_equal((found.distance < 0)[clear], winding_numbers(vertices[triangles], points[clear]) > 0)
    monkeypatch.setattr(windings, "winding", lambda *_: (0, False))
    again = distance(Point(points), mesh)
    assert np.array_equal(found.distance[clear], again.distance[clear])
    assert np.array_equal(found.normal[clear], again.normal[clear])


@pytest.mark.parametrize("name", ["box", "U", "hollow"])
def test_rays_through_corners_and_edges_tell_nothing_wrong(name):
    """From points whose rays meet a corner, or the middle of an edge, as exactly as doubles can."""
    vertices, triangles = MESHES[name]
    corners = vertices[triangles]
    targets = np.unique(np.concatenate([vertices, corners[:, 0] / 2 + corners[:, 1] / 2]), axis=0)
    for way in np.array(windings.WAYS):
        for target in targets:
            moved = Polyhedron(vertices - target, triangles)
            points = -way * np.array([[0.125], [0.5]])
            found = distance(Point(points), moved).distance
            triangles_there = corners_of(moved)
            exact = [surrounds(triangles_there, vector(p)) for p in points]
            assert np.array_equal(found < 0, exact)


def test_distances_that_dwarf_the_mesh():
    """Their squares overflow in the mesh's own unit."""
    mesh = Polyhedron(*prism(U_SHAPE))
    place = np.array([[1e200, 0, 0], [0, -1e300, 0], [1e150, 1e150, 0], [2.0, 3.0, 0.5]])
    found = distance(Point(place), mesh)
    assert np.allclose(found.distance, [1e200, 1e300, np.sqrt(2) * 1e150, 1.0], rtol=1e-15)
    assert distance(Sphere([0, 0, 0], 1e200), mesh).distance == pytest.approx(-1e200, rel=1e-15)


def test_compiled_kernels_give_the_bits_of_plain_ones(monkeypatch):
    if compiling._compiled_package() is None:
        pytest.skip("numba is not installed")
    rng = np.random.default_rng(27)
    mesh = Polyhedron(*turned(BUMPY, 28))
    n = 300
    center, q = rng.normal(size=(n, 3)) * 4, rng.normal(size=(n, 4))
    poses = mesh.broadcast_to((n,))._placed(rng.normal(size=(n, 3)), q)
    ball, ray = Sphere(center, rng.uniform(0.1, 6.0, n)), Ray(center, rng.normal(size=(n, 3)))
    one = distance(ball, poses), distance(Point(center), poses), raycast(ray, poses)
    monkeypatch.setattr(compiling, "_compiled_package", lambda: None)
    two = distance(ball, poses), distance(Point(center), poses), raycast(ray, poses)
    for x, y in zip(one, two, strict=True):
        assert all(np.array_equal(getattr(x, f), getattr(y, f), equal_nan=True) for f in x.__dataclass_fields__)
    alone = distance(ball[7], poses[7])
    assert (alone.distance, alone.normal.tolist()) == (one[0].distance[7], one[0].normal[7].tolist())


# ----------------------------------------------------------------------------------------------- balls


def balls_at(vertices, rng, count):
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = np.max(high - low)
    return Sphere(rng.uniform(low - 0.2 * size, high + 0.2 * size, (count, 3)), size * rng.uniform(0.01, 0.6, count))


def least(ball, mesh):
    return np.where(collide(ball, mesh).hit, collide(ball, mesh).least, 0.0)


@pytest.mark.parametrize("name", MESHES)
def test_the_way_out_is_free_and_nothing_much_shorter_is(name):
    """By exact heights: the moved centre is as high as the radius, and the centre as low as the lower bound says."""
    rng = np.random.default_rng(31)
    vertices, triangles = turned(MESHES[name], 32)
    mesh, ball = Polyhedron(vertices, triangles), balls_at(vertices, rng, 60)
    found, lower = distance(ball, mesh), least(ball, mesh)
    deep = np.flatnonzero(found.distance < 0)[: 20 if len(triangles) < 100 else 6]
    assert len(deep) >= 6
    corners = corners_of(mesh)
    size = mesh.magnitude + np.max(np.abs(ball.center), axis=1) + ball.radius
    for i in deep:
        there = ball.center[i] + found.distance[i] * found.normal[i]
        assert exact_height(there, corners) >= ball.radius[i] - 1e-14 * size[i]
        bound = ball.radius[i] - exact_height(ball.center[i], corners)
        assert abs(lower[i] - bound) <= 1e-15 * size[i]
        assert lower[i] <= -found.distance[i]


@pytest.mark.parametrize("name", MESHES)
def test_no_sampled_way_is_shorter_than_the_bound(name):
    rng = np.random.default_rng(33)
    vertices, triangles = turned(MESHES[name], 34)
    mesh, ball = Polyhedron(vertices, triangles), balls_at(vertices, rng, 80)
    found, lower = distance(ball, mesh), least(ball, mesh)
    found_shorter = 0
    for i in np.flatnonzero(found.distance < 0):
        ways = rng.normal(size=(200, 3))
        ways *= (-found.distance[i] * rng.uniform(0.0, 1.0, 200) ** (1 / 3) / np.linalg.norm(ways, axis=1))[:, None]
        free = distance(Point(ball.center[i] + ways), mesh).distance >= ball.radius[i]
        lengths = np.linalg.norm(ways[free], axis=1)
        assert np.all(lengths >= lower[i] * (1 - 1e-12))
        found_shorter += np.any(lengths < -found.distance[i] * (1 - 1e-2))
    assert found_shorter <= 2


def test_out_of_a_convex_mesh_the_way_is_that_of_its_hull():
    rng = np.random.default_rng(35)
    vertices, triangles = globe(7, 9)
    n = 100
    c, q, ball = rng.normal(size=(n, 3)), rng.normal(size=(n, 4)), balls_at(2 * vertices, rng, n)
    mesh, hull = Polyhedron(vertices, triangles, c, q), ConvexPolyhedron.from_vertices(vertices, c, q)
    one, two = distance(ball, mesh), distance(hull, ball)
    assert np.sum(one.distance < 0) >= 30
    assert np.all(np.abs(one.distance - two.distance) <= 1e-14 * (6 + ball.radius))
    assert np.all(np.abs(least(ball, mesh) - np.maximum(0.0, -one.distance)) <= 1e-14 * (6 + ball.radius))


def test_a_ball_through_one_face_leaves_across_it():
    for depth in 10.0 ** -np.arange(0, 13, 3) / 4:
        found = collide(Sphere([0.5, 0.5, 1.25 - depth], 0.25), Polyhedron(*prism(U_SHAPE)))
        assert found.depth == pytest.approx(depth, abs=4e-16)
        assert found.least == found.depth
        assert np.array_equal(found.normal, [0, 0, -1])


@pytest.mark.parametrize(("x", "y", "radius"), [(1.6, 2.2, 0.7), (1.9, 1.8, 0.6), (1.7, 1.7, 0.6)])
def test_a_ball_in_a_channel_rests_on_both_walls(x, y, radius):
    """Too wide for the channel of a U, it comes up until it touches both upper edges, also where a wall is nearer."""
    mesh = Polyhedron(*prism(U_SHAPE, 40.0))
    found = distance(Sphere([x, y, 20.0], radius), mesh)
    way = np.array([1.5 - x, 2 + np.sqrt(radius**2 - 0.25) - y, 0.0])
    assert -found.distance == pytest.approx(np.linalg.norm(way), abs=1e-9)
    assert np.allclose(found.normal, -way / np.linalg.norm(way), atol=1e-6)


@pytest.mark.parametrize(("x", "y", "radius"), [(1.5, 0.6, 1.3), (1.1, 0.6, 1.4), (2.0, 0.9, 1.5)])
def test_a_ball_below_a_channel_leaves_downwards(x, y, radius):
    """The channel's floor is the nearest face, but above it there is no room."""
    found = distance(Sphere([x, y, 20.0], radius), Polyhedron(*prism(U_SHAPE, 40.0)))
    assert found.distance == pytest.approx(-(y + radius), abs=1e-14)
    assert np.allclose(found.normal, [0, 1, 0], atol=1e-14)


def test_a_ball_in_a_cavity_goes_to_the_nearest_free_place():
    """Inside the cavity it has room; between the walls it has none, and must leave the whole."""
    mesh = Polyhedron(*hollow_box(0.5))
    assert distance(Sphere([0.2, 0.3, 0.1], 0.25), mesh).distance == pytest.approx(-0.05, abs=1e-15)
    assert distance(Sphere([0.3, 0.3, 0.3], 0.4), mesh).distance == pytest.approx(-np.sqrt(3) * 0.2, abs=1e-12)
    tight = distance(Sphere([0.3, 0.0, 0.0], 0.6), mesh)
    assert tight.distance == pytest.approx(-(1 + 0.6 - 0.3), abs=1e-12)


def test_no_pieces_are_made_and_contacts_still_name_them():
    mesh = Polyhedron(*turned(BUMPY, 36))
    ball = Sphere(mesh.vertices[40], np.linalg.norm(mesh.vertices[40] - mesh.reference_point))
    assert intersect(ball, mesh)
    found = distance(ball, mesh)
    assert raycast(Ray(mesh.reference_point + 100.0, [-1.0, -1, -1]), mesh).hit
    assert "pieces" not in mesh.solid.__dict__
    told = contacts(ball, mesh)
    assert told.separation.distance == found.distance
    assert len(told) > 1
    assert np.all(told.pairs.distance < 0)
    assert np.all(np.diff(told.pairs.distance) >= 0)
    alone = [distance(ball, hull_of(mesh, i)).distance for i in told.part_b]
    assert np.allclose(alone, told.pairs.distance, atol=1e-13 * mesh.magnitude)


def hull_of(mesh, number):
    return ConvexPolyhedron.from_vertices(mesh.pieces[number].vertices, mesh.position, mesh.rotation)


# ------------------------------------------------------------------------------------------------ rays


def exact_time(origin, way, triangles):
    """First time at which a ray meets a triangle, exactly; inf without one."""
    times = []
    for t in triangles:
        normal = cross(minus(t[1], t[0]), minus(t[2], t[0]))
        speed, height = dot(normal, way), dot(normal, minus(t[0], origin))
        if speed != 0 and height / speed >= 0:
            x = plus(origin, scaled(height / speed, way))
            if all(dot(cross(minus(t[(i + 1) % 3], t[i]), minus(x, t[i])), normal) >= 0 for i in range(3)):
                times.append(height / speed)
    return float(min(times)) if times else np.inf


@pytest.mark.parametrize("name", MESHES)
def test_rays_hit_when_exact_arithmetic_says(name):
    rng = np.random.default_rng(37)
    vertices, triangles = turned(MESHES[name], 38)
    q = rng.normal(size=4)
    mesh = Polyhedron(vertices, triangles, [0.0, 0, 0], [0.0, 0, 0, 1])
    start = vertices.mean(axis=0) + rng.normal(size=(12, 3)) * np.max(np.abs(vertices))
    targets = vertices[triangles[rng.integers(0, len(triangles), 12)]]
    shares = np.concatenate([np.eye(3), [[0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]], rng.dirichlet((1, 1, 1), 6)])
    way = np.sum(shares[:, :, None] * targets, axis=1) - start
    found = raycast(Ray(start, way), mesh)
    corners = corners_of(mesh)
    for i in range(12):
        inside = exact_height(start[i], corners) < 0
        exact = 0.0 if inside else exact_time(vector(start[i]), vector(way[i]), corners)
        assert found.t[i] == pytest.approx(exact, rel=1e-12) if np.isfinite(exact) else not found.hit[i]
    turn = rotation_matrix(q)
    offset = np.array([1.0, 2, 3])
    placed = mesh._placed(offset, q)
    again = raycast(Ray(apply(turn, start) + offset, apply(turn, way)), placed)
    both = found.hit & again.hit & (np.arange(12) >= 6)
    assert np.allclose(again.t[both], found.t[both], rtol=1e-10)
    assert np.allclose(apply_inverse(turn, again.normal[both]), found.normal[both], atol=1e-13, equal_nan=True)


def test_faces_on_the_way_are_all_there_however_many():
    """A long row of boxes along the ray: more faces than room was made for at first."""
    mesh = Polyhedron(*together(*(box((2 * i, 0, 0), (2 * i + 1, 1, 1)) for i in range(40))))
    origin, way = np.array([[-1.0, 0.3, 0.6]]), np.array([[1.0, 0, 0]])
    ray, face = surfaces.faces_on_the_way(mesh.solid, origin, way)
    crossed = np.ptp(mesh.solid.corners[:, :, 0], axis=1) == 0
    assert set(np.flatnonzero(crossed)) <= set(face.tolist())
    assert np.all(ray == 0)
    assert raycast(Ray(origin[0], way[0]), mesh).t == 1.0


def test_far_rays_meet_a_mesh_where_they_meet_the_box_that_it_is() -> None:
    """From far away the shares of a face's corners cancel; the plane still tells the time."""
    rng = np.random.default_rng(11)
    place, turn = [0.1, -0.2, 0.3], [0.1, 0.5, -0.3, 0.7]
    solid = Box(place, [1.0, 2.0, 0.5], turn)
    mesh = Polyhedron(*box((-1.0, -2.0, -0.5), (1.0, 2.0, 0.5)), place, turn)
    inside = place + rng.uniform(-0.25, 0.25, (300, 3))
    origin = inside + 5000.0 * rng.normal(size=(300, 3))
    rays = Ray(origin, inside - origin)
    found, expected = raycast(rays, mesh), raycast(rays, solid)
    assert np.all(found.hit & expected.hit)
    slope = np.abs(np.sum(expected.normal * rays.direction, axis=1))
    size = np.abs(origin).max(axis=1)
    assert np.all(slope * np.abs(found.t - expected.t) <= 2e-15 * size)
