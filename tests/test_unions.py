"""Polyhedra and composites against everything: by their pieces, by known answers, and by moving them apart."""

import numpy as np
import pytest

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
    Ray,
    ShapeError,
    Sphere,
    distance,
    intersect,
    large_meshes,
    raycast,
    scenes,
)
from refimpl.algorithms.surfaces import face_rows
from refimpl.contacts import contacts
from refimpl.kernels.leastmove import shortest
from refimpl.kernels.surface import face_square, foot_on_face
from refimpl.supports import support
from tests.solids import L_SHAPE, SOLIDS, box, hollow_box, prism, together, torus, turned

STILL = [0.0, 0, 0, 1]
N = 24
AXES = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, -1, 1]])


def make(kind, rng, spread=1.5, n=N):
    """A batch of proxies of a kind, around the origin."""
    c, r, q = rng.uniform(-spread, spread, (n, 3)), rng.uniform(0.2, 0.6, (n, 3)), rng.normal(size=(n, 4))
    middle = c @ AXES.T
    makers = {
        Point: lambda: Point(c),
        Sphere: lambda: Sphere(c, r[:, 0]),
        Capsule: lambda: Capsule(c, c + r, r[:, 1]),
        HalfSpace: lambda: HalfSpace(rng.normal(size=(n, 3)), rng.uniform(-1, 1, n)),
        AABB: lambda: AABB(c - r, c + r),
        Box: lambda: Box(c, r, q),
        KDOP: lambda: KDOP(AXES, middle - 0.5, middle + 0.5),
        Ellipsoid: lambda: Ellipsoid(c, r, q),
        Cylinder: lambda: Cylinder(c, c + r, r[:, 1]),
        ConvexPolyhedron: lambda: ConvexPolyhedron.from_vertices(rng.uniform(-0.5, 0.5, (9, 3)), c, q),
        Polyhedron: lambda: Polyhedron(*prism(L_SHAPE), c, q),
        Composite: lambda: Composite([Sphere(c, 0.4), Box(c + r, r / 2, q), Capsule(c, c - r, 0.2)]),
    }
    return makers[kind]()


SOLID_KINDS = [Sphere, Capsule, HalfSpace, AABB, Box, KDOP, Ellipsoid, Cylinder, ConvexPolyhedron]
KINDS = [Point, *SOLID_KINDS, Polyhedron, Composite]
BOUNDED = [kind for kind in KINDS if kind is not HalfSpace]
named = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)


def size_of(*proxies):
    return np.max([p.magnitude for p in proxies], axis=0)


def require_consistent(found, scale):
    """Witness points realise the distance along a unit normal."""
    real = np.isfinite(found.distance)
    gap = found.on_b - found.on_a - found.distance[..., None] * found.normal
    assert np.all(np.max(np.abs(gap[real]), axis=-1, initial=0.0) <= 2e-12 * scale[real])
    assert np.allclose(np.linalg.norm(found.normal[real], axis=-1), 1.0, atol=1e-14)


# ----------------------------------------------------------------------------------------- one atom


@named
def test_a_composite_of_one_part_is_the_part(kind):
    rng = np.random.default_rng(1)
    for other in (Box, Sphere, Ellipsoid):
        x, y = make(kind, rng), make(other, rng)
        one, two = distance(x, Composite([y])), distance(x, y)
        assert np.all(np.abs(one.distance - two.distance) <= 1e-14 * size_of(x, y))
        require_consistent(one, size_of(x, y))


@named
def test_a_convex_mesh_is_its_hull(kind):
    rng = np.random.default_rng(2)
    vertices, triangles = box((-0.5, -0.6, -0.7), (0.7, 0.6, 0.5))
    c, q, y = rng.uniform(-1, 1, (N, 3)), rng.normal(size=(N, 4)), make(kind, rng)
    mesh, hull = Polyhedron(vertices, triangles, c, q), ConvexPolyhedron.from_vertices(vertices, c, q)
    one, two = distance(mesh, y), distance(hull, y)
    assert np.all(np.abs(one.distance - two.distance) <= 1e-13 * size_of(mesh, y))
    require_consistent(one, size_of(mesh, y))


# ---------------------------------------------------------------------------------------- many atoms


@named
def test_apart_is_the_least_over_the_parts(kind):
    rng = np.random.default_rng(3)
    x, y = make(Composite, rng), make(kind, rng)
    least = np.min([distance(part, y).distance for part in x.parts], axis=0)
    found = distance(x, y)
    apart = least > 0
    assert np.any(apart)
    assert np.all(np.abs(found.distance - least)[apart] <= 1e-13 * size_of(x, y)[apart])
    assert np.all(found.distance[~apart] <= least[~apart] + 1e-13)
    assert np.array_equal(intersect(x, y), ~apart)


@named
def test_moving_by_the_depth_separates(kind):
    rng = np.random.default_rng(4)
    for union in (Composite, Polyhedron):
        count = 200 if kind is Point else N
        one, other = make(union, rng, 0.8, count), make(kind, rng, 0.8, count)
        found = distance(one, other)
        require_consistent(found, size_of(one, other))
        deep = np.flatnonzero((found.distance < 0) & np.isfinite(found.distance))
        assert len(deep) > 3
        moved = other[deep].translated(-found.distance[deep, None] * found.normal[deep])
        assert np.all(distance(one[deep], moved).distance >= -3e-12 * size_of(one, other)[deep])


@pytest.mark.parametrize("kind", BOUNDED, ids=lambda kind: kind.__name__)
def test_the_interval_holds(kind):
    """No pair of atoms is deeper than what separates the unions; one pair alone leaves no doubt."""
    rng = np.random.default_rng(5)
    one, other = make(Composite, rng, 0.8), make(kind, rng, 0.8)
    doubtful = 0
    for i in range(N):
        found = contacts(one[i], other[i])
        low, high = found.depth_interval
        assert low <= high == max(0.0, -found.separation.distance)
        if len(found):
            assert np.all(found.pairs.distance < 0)
            assert -found.pairs.distance.min() <= low * (1 + 1e-12)
            assert np.all(np.diff(found.pairs.distance) >= 0)
            doubtful += low < high * (1 - 1e-9)
        if len(found) == 1 and kind not in (Polyhedron, Composite):
            alone = one.parts[found.part_a[0]][i].translated([0, 0, 0])
            assert distance(alone, other[i]).distance == pytest.approx(found.pairs.distance[0], abs=1e-13)
    assert doubtful <= N // 2


@named
def test_orders_and_batches_agree_to_the_bit(kind):
    rng = np.random.default_rng(6)
    for one in (make(Composite, rng, 1.0), make(Polyhedron, rng, 1.0)):
        other = make(kind, rng, 1.0)
        there, back = distance(one, other), distance(other, one)
        assert np.array_equal(there.distance, back.distance)
        for i in (0, N // 2, N - 1):
            alone = distance(one[i], other[i])
            assert alone.distance == there.distance[i]
            assert np.array_equal(alone.normal, there.normal[i], equal_nan=True)


@pytest.mark.parametrize(
    "kind", [Point, Sphere, Capsule, Box, Cylinder, Polyhedron, Composite], ids=lambda k: k.__name__
)
def test_trees_answer_as_all_pairs_do(kind, monkeypatch):
    rng = np.random.default_rng(7)
    mesh, other = make(Polyhedron, rng, 1.0), make(kind, rng, 1.0)
    few = distance(mesh, other)
    hit = intersect(mesh, other)
    monkeypatch.setattr(large_meshes, "FEW_FACES", 0)
    monkeypatch.setattr(scenes, "MOST_PAIRS", 1)
    many = distance(mesh, other)
    apart = few.distance > 1e-9
    assert np.all(np.abs(few.distance - many.distance)[apart] <= 1e-13 * size_of(mesh, other)[apart])
    assert np.array_equal(few.distance < 0, many.distance < 0)
    assert np.array_equal(hit, intersect(mesh, other))
    require_consistent(many, size_of(mesh, other))
    deep = np.flatnonzero(many.distance < 0)
    moved = other[deep].translated(-many.distance[deep, None] * many.normal[deep])
    assert np.all(distance(mesh[deep], moved).distance >= -3e-12 * size_of(mesh, other)[deep])


# -------------------------------------------------------------------------------------- known answers


def test_a_ball_in_the_notch_of_an_l():
    """It touches both walls: out of each by 0.1, so out of both by √2 times that."""
    wall, floor = Box([-1.5, 1, 0], [0.5, 1.5, 0.5], STILL), Box([0, 0, 0], [2, 0.5, 0.5], STILL)
    found = contacts(Composite([floor, wall]), Sphere([-0.6, 0.9, 0], 0.5))
    assert found.separation.distance == pytest.approx(-0.1 * np.sqrt(2), abs=1e-15)
    assert np.allclose(found.separation.normal, [np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-15)
    assert found.depth_interval[0] == pytest.approx(0.1, abs=1e-15)
    assert sorted(zip(found.part_a.tolist(), found.part_b.tolist(), strict=True)) == [(0, 0), (1, 0)]


def test_a_ball_between_two_half_spaces():
    slot = Composite([HalfSpace([1, 0, 0], 0.0), HalfSpace([-1, 0, 0], 1.0)])  # what is not 0 < x < 1
    assert distance(slot, Sphere([0.2, 0, 0], 0.4)).distance == pytest.approx(-0.2, abs=1e-15)
    assert distance(slot, Sphere([0.5, 3, 4], 0.25)).distance == pytest.approx(0.25, abs=1e-15)
    assert distance(slot, Sphere([0.2, 0, 0], 0.6)).distance == -np.inf
    assert distance(Sphere([0.2, 0, 0], 0.6), slot).distance == -np.inf
    assert np.isnan(distance(slot, Sphere([0.2, 0, 0], 0.6)).normal).all()


def test_a_half_space_is_left_along_its_normal():
    rng = np.random.default_rng(8)
    plane = HalfSpace([0, 0, 2.0], -1.0)  # z ≤ 1/2
    for union in (make(Composite, rng), make(Polyhedron, rng)):
        lowest = -support(union, np.array([0.0, 0, -1]))
        found = distance(plane, union)
        assert np.array_equal(found.normal, np.broadcast_to([0.0, 0, 1], (N, 3)))
        assert np.allclose(found.distance, lowest - 0.5, atol=1e-14)


@pytest.mark.parametrize("power", [-300, 0, 300])
def test_a_ball_inside_a_solid_and_inside_its_cavity(power):
    unit = 2.0**power
    solid = Polyhedron(*box((-unit,) * 3, (unit,) * 3))
    v, t = hollow_box(0.5)
    shell = Polyhedron(unit * v, t)
    ball = Sphere([0, 0, 0.25 * unit], 0.125 * unit)
    assert distance(solid, ball).distance == pytest.approx(-0.875 * unit, rel=1e-14)
    assert distance(shell, ball).distance == pytest.approx(0.125 * unit, rel=1e-14)
    assert intersect(solid, ball)
    assert not intersect(shell, ball)
    assert distance(shell, Sphere([0, 0, 0.75 * unit], 0.125 * unit)).distance == pytest.approx(
        -0.375 * unit, rel=1e-12
    )


def test_a_solid_in_a_cavity_is_free_until_it_touches():
    shell, small = Polyhedron(*hollow_box(0.5)), Polyhedron(*box((-0.1,) * 3, (0.1,) * 3))
    assert distance(shell, small).distance == pytest.approx(0.4, abs=1e-15)
    assert distance(shell, small.translated([0.3, 0, 0])).distance == pytest.approx(0.1, abs=1e-15)
    assert distance(shell, small.translated([0.41, 0, 0])).distance == pytest.approx(-0.01, abs=1e-15)
    assert distance(shell, small.translated([0.41, 0, 0])).normal == pytest.approx([-1, 0, 0], abs=1e-15)


def test_two_rings_linked_are_apart():
    """Their hulls overlap deeply."""
    vertices, triangles = torus(24, 12, 1.0, 0.2)
    one = Polyhedron(vertices, triangles)
    other = Polyhedron(vertices, triangles, [1.0, 0, 0], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    gap = distance(one, other).distance
    assert 2 * 0.8 * np.cos(np.pi / 24) - 1 <= gap <= 0.6  # 0.6 for round ones; chords of the hole come nearer
    assert not intersect(one, other)


def nearest_by_hand(p, corners):
    """Distance of a point from a triangle: foot on the plane if it is inside, on the sides, and the corners."""
    a, b, c = corners
    found = [np.linalg.norm(p - x) for x in corners]
    for u, v in ((a, b), (b, c), (c, a)):
        t = np.dot(p - u, v - u) / np.dot(v - u, v - u)
        if 0 < t < 1:
            found.append(np.linalg.norm(p - (u + t * (v - u))))
    n = np.cross(b - a, c - a)
    foot = p - np.dot(p - a, n) / np.dot(n, n) * n
    if all(np.dot(np.cross(v - u, foot - u), n) > 0 for u, v in ((a, b), (b, c), (c, a))):
        found.append(np.linalg.norm(p - foot))
    return min(found)


@pytest.mark.parametrize("name", SOLIDS)
def test_the_depth_of_a_point_is_that_of_the_surface(name):
    rng = np.random.default_rng(9)
    vertices, triangles = turned(SOLIDS[name], 5)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    points = rng.uniform(low - 0.2, high + 0.2, (60, 3))
    found = distance(Point(points), Polyhedron(vertices, triangles))
    by_hand = [min(nearest_by_hand(p, corners) for corners in vertices[triangles]) for p in points]
    scale = np.max(np.abs(vertices))
    assert np.all(np.abs(np.abs(found.distance) - by_hand) <= 1e-14 * scale)
    assert 0 < np.sum(found.distance < 0) < 60
    outside = points - found.distance[:, None] * (1 + 1e-9) * -found.normal  # over the surface point, and a bit beyond
    assert np.all(
        np.sign(distance(Point(outside), Polyhedron(vertices, triangles)).distance) == -np.sign(found.distance)
    )


def test_nearest_points_of_needles():
    """A foot that errs along a thin triangle must not cost distance."""
    rng = np.random.default_rng(10)
    for thin in 10.0 ** -np.arange(0, 16, 3):
        corners = np.array([[0, 0, 0], [1, 0, 0], [0.3, thin, 0]]) + 0.0
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        p = rng.uniform(-1, 2, (200, 3)) * [1, 1, 0.5]
        line = np.hypot(np.clip(p[:, 0], 0, 1) - p[:, 0], np.hypot(p[:, 1], p[:, 2]))
        row = face_rows((corners @ q.T)[None], np.zeros(1, dtype=np.int64))[0].tolist()
        feet = np.array([foot_on_face(row, 0, x) for x in (p @ q.T).tolist()])
        gap = np.linalg.norm(p @ q.T - feet, axis=1)
        assert np.allclose(gap**2, [face_square(row, 0, x) for x in (p @ q.T).tolist()], rtol=1e-14, atol=1e-15)
        assert np.all(gap <= line + 1e-15)
        assert np.all(gap >= line - thin - 1e-15)


# ---------------------------------------------------------------------------------------------- rays


@pytest.mark.parametrize("name", SOLIDS)
def test_rays_at_inner_points_hit_before(name):
    vertices, triangles = turned(SOLIDS[name], 6)
    mesh = Polyhedron(vertices, triangles)
    rng = np.random.default_rng(11)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    inner = rng.uniform(low, high, (100, 3))
    depth = -distance(Point(inner), mesh).distance
    inner, depth = inner[depth > 0], depth[depth > 0]
    assert len(inner) > 10
    outer = inner + rng.normal(size=inner.shape) * 100
    hit = raycast(Ray(outer, inner - outer), mesh)
    assert np.all(hit.t * np.linalg.norm(inner - outer, axis=1) <= np.linalg.norm(inner - outer, axis=1) - depth + 1e-9)
    assert np.all(np.abs(distance(Point(hit.point), mesh).distance) < 1e-11)
    assert np.all(np.sum(hit.normal * (inner - outer), axis=1) <= 0)


def test_no_ray_slips_through_an_edge():
    """Through the exact middle of the diagonals that split the box's faces, and through its edges and corners."""
    mesh = Polyhedron(*box((-1, -1, -1), (1, 1, 1)))
    steps = [-1.0, -0.5, 0.0, 0.5, 1.0]
    targets = np.array([[x, y, 1.0] for x in steps for y in steps])
    for way in ([0, 0, -1.0], [0.25, 0.125, -1.0], [-0.5, 0.25, -0.125]):
        rays = Ray(targets - 4 * np.array(way), np.array(way))
        hit = raycast(rays, mesh)
        within = np.all(np.abs(targets[:, :2]) < 1, axis=1) | (np.array(way)[:2] == 0).all()
        assert np.all(hit.t[within] == 4.0)
        assert np.array_equal(hit.point[within], targets[within])


def test_rays_at_a_hollow_box():
    mesh = Polyhedron(*hollow_box(0.5))
    inside = raycast(Ray([0, 0, 0], [0, 0, 2.0]), mesh)
    assert (inside.t, inside.normal.tolist()) == (0.25, [0, 0, -1])
    outside = raycast(Ray([0, 0, 5], [0, 0, -1.0]), mesh)
    assert (outside.t, outside.normal.tolist()) == (4.0, [0, 0, 1])
    within = raycast(Ray([0, 0, 0.75], [0, 0, 1.0]), mesh)
    assert within.t == 0
    assert np.isnan(within.normal).all()
    assert not raycast(Ray([0, 0, 5], [0, 0, 1.0]), mesh).hit
    edge = raycast(Ray([-3, 1, 1], [1.0, 0, 0]), mesh)  # along an edge
    assert edge.t == 2.0
    corner = raycast(Ray([-3, -1, 1], [1.0, 1, 0]), mesh)  # grazes an edge in one point
    assert not corner.hit or corner.t >= 2.0


def test_a_ray_enters_the_first_part():
    rng = np.random.default_rng(12)
    union = make(Composite, rng)
    start = rng.uniform(-4, 4, (N, 3))
    ray = Ray(start, union.parts[0].center - start + rng.normal(size=(N, 3)) / 2)
    found = raycast(ray, union)
    each = np.min([raycast(ray, part).t for part in union.parts], axis=0)
    assert np.array_equal(found.t, each)
    assert 0 < np.sum(found.hit) < N


# --------------------------------------------------------------------------------------- the proxies


def test_a_composite_of_everything_survives_packing():
    rng = np.random.default_rng(13)
    parts = [make(kind, rng, n=3) for kind in (*SOLID_KINDS, Polyhedron, Composite)]
    union = Composite(parts)
    again = Composite.unpack(union.pack())
    assert np.array_equal(again.pack(), union.pack())
    assert union.storage == union.pack().shape[-1]
    assert [type(part) for part in again.parts] == [type(part) for part in parts]
    assert np.array_equal(Polyhedron.unpack(parts[-2].pack()).pack(), parts[-2].pack())


def test_polyhedra_move_without_being_split_again():
    mesh = Polyhedron(*torus())
    moved = mesh.rotated([1.0, 2, 3, 4]).translated([1, 2, 3])
    assert moved.pieces is mesh.pieces
    point = np.array([1.0, 0.1, 0.2])
    there = Point(point).rotated([1.0, 2, 3, 4]).translated([1, 2, 3])
    assert distance(there, moved).distance == pytest.approx(distance(Point(point), mesh).distance, abs=1e-15)
    assert distance(Point(point).scaled(3.0), mesh.scaled(3.0)).distance == pytest.approx(
        3 * distance(Point(point), mesh).distance, abs=1e-15
    )


@pytest.mark.parametrize(
    ("build", "why"),
    [
        (lambda: Composite([]), "no parts"),
        (lambda: Composite([Point([0, 0, 0])]), r"parts\[0\]: expected a solid proxy, got Point"),
        (lambda: Composite(Sphere([0, 0, 0], 1)), "sequence of solids"),
        (
            lambda: Composite([make(Box, np.random.default_rng(0), n=2), make(Box, np.random.default_rng(0), n=3)]),
            "broadcast",
        ),
        (lambda: Polyhedron([[0, 0, 0]], [[0, 0, 0]]), "no area"),
        (lambda: Polyhedron([[0, 0, np.nan]], [[0, 0, 0]]), "must be finite"),
        (lambda: Polyhedron(box()[0], [[0, 1, 0.5]]), "whole numbers"),
        (lambda: Polyhedron(box()[0], box()[1][1:]), "Polyhedron: open: the edge"),
        (lambda: Polyhedron(*together(box(), box((0.5, 0.5, 0.5), (2, 2, 2)))), "self-intersecting"),
        (lambda: Composite.unpack(np.array([1.0, 99.0, 3.0, 0, 0, 0])), "known code"),
        (lambda: Composite.unpack(np.array([1.0, 1.0, 1e9, 0, 0, 0])), "cannot be"),
        (lambda: Polyhedron.unpack(np.array([8.0, 12.0, 0])), "expected rows of"),
    ],
)
def test_what_is_no_union_is_refused(build, why):
    with pytest.raises(ShapeError, match=why):
        build()


# -------------------------------------------------------------------------------- the shortest vector


def test_the_shortest_vector_beyond_planes():
    corner = [1.0, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3]
    assert shortest(corner, 3) == ((1.0, 2.0, 3.0), (0, 1, 2), True)
    assert shortest(corner, 1) == ((1.0, 0.0, 0.0), (0, -1, -1), True)
    assert not shortest([1.0, 0, 0, 1, -1, 0, 0, 1, 0, 1, 0, 0], 3)[2]
    assert shortest([1.0, 0, 0, 1, 0.6, 0.8, 0, 0.1], 2) == ((1.0, 0.0, 0.0), (0, -1, -1), True)
    assert shortest([], 0) == ((0.0, 0.0, 0.0), (-1, -1, -1), True)


def test_the_shortest_vector_meets_the_conditions_of_a_minimum():
    """It satisfies the planes, and is a combination of those it lies on, with weights that are not negative."""
    rng = np.random.default_rng(14)
    normals = rng.normal(size=(300, 6, 3)) + np.array([0.7, 0, 0])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    levels = rng.uniform(-0.5, 1.0, (300, 6))
    planes = np.concatenate([normals, levels[:, :, None]], axis=2).reshape(300, -1).tolist()
    moves, corners, whether = zip(*(shortest(row, 6) for row in planes), strict=True)
    found, possible = np.array(moves), np.array(whether)
    assert 100 < possible.sum() < 300
    for row, t, corner in zip(normals[possible], found[possible], np.array(corners)[possible], strict=True):
        held = row[corner[corner >= 0]]
        assert np.linalg.norm(t - held.T @ np.linalg.lstsq(held.T, t, rcond=None)[0]) <= 1e-12 * np.linalg.norm(t)
    for n, level, t in zip(normals[possible], levels[possible], found[possible], strict=True):
        slack = n @ t - level
        assert np.min(slack) >= -1e-11 * (1 + np.linalg.norm(t))
        on = np.abs(slack) <= 1e-11 * (1 + np.linalg.norm(t))
        weights = np.linalg.lstsq(n[on].T, t, rcond=None)[0] if np.any(on) else np.zeros(0)
        assert np.all(weights >= -1e-6 * np.linalg.norm(t))
        assert np.allclose(n[on].T @ weights, t, atol=1e-9 * (1 + np.linalg.norm(t)))
