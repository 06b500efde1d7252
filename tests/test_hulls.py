"""Corners, faces and edges of polytopes, against exact enumeration of all triples."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from refimpl import faces, hulls, proposals
from refimpl.derived import hull_of_planes, hull_of_vertices
from refimpl.hulls import hull_of_box
from refimpl.linear import apply, rotation_matrix
from refimpl.shapes import AABB, KDOP, Box, ConvexPolyhedron, ShapeError

CUBE_PLANES = np.concatenate([np.concatenate([np.eye(3), -np.eye(3)]), -np.ones((6, 1))], axis=1)
GRID = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
CORNERS = GRID[np.all(GRID != 0, axis=1)]
TURN = rotation_matrix(np.array([0.1, 0.5, -0.3, 0.7]))


def fractions(rows):
    return [tuple(Fraction(float(x)) for x in row) for row in np.asarray(rows)]


def cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def dot(u, v):
    return sum(a * b for a, b in zip(u, v, strict=True))


def minus(u, v):
    return tuple(a - b for a, b in zip(u, v, strict=True))


def sign(x):
    return (x > 0) - (x < 0)


# ---- independent enumeration -------------------------------------------------------------------------------------


def faces_by_enumeration(points):
    """Sets of points on each supporting plane through three of them: every triple, in fractions."""
    exact = fractions(points)
    found = set()
    for a, b, c in itertools.combinations(exact, 3):
        n = cross(minus(b, a), minus(c, a))
        if not any(n):
            continue
        heights = [dot(n, minus(p, a)) for p in exact]
        if max(heights) <= 0 or min(heights) >= 0:
            found.add(frozenset(p for p, h in zip(exact, heights, strict=True) if h == 0))
    return found


def corners_by_enumeration(planes):
    """Every point where three planes meet that lies behind all planes, in fractions, by Cramer's rule."""
    exact = fractions(planes)
    found = set()
    for p, q, r in itertools.combinations(exact, 3):
        bc, ca, ab = cross(q[:3], r[:3]), cross(r[:3], p[:3]), cross(p[:3], q[:3])
        det = dot(p[:3], bc)
        if det == 0:
            continue
        x = tuple(-(p[3] * bc[i] + q[3] * ca[i] + r[3] * ab[i]) / det for i in range(3))
        if all(dot(s[:3], x) + s[3] <= 0 for s in exact):
            found.add(x)
    return found


def check_hull_of_points(hull, points):
    """Raise where a hull differs from the enumeration, or is no closed surface with its edges the right way round."""
    exact = fractions(hull.vertices)
    faces = faces_by_enumeration(points)
    extreme = {p for p in set(fractions(points)) if len([f for f in faces if p in f]) >= 3}
    assert set(exact) == extreme
    assert len(exact) == len(extreme)
    assert fractions(np.asarray(points)[hull.active_vertices]) == exact
    around = [
        {exact[i] for v, w, *sides in rows(hull) if face in sides for i in (v, w)} for face in range(len(hull.planes))
    ]
    assert {frozenset(f) for f in around} == {frozenset(f & extreme) for f in faces}
    check_surface(hull)
    for f, corners in enumerate(around):
        a, b, c, *_ = spread(list(corners))
        n = cross(minus(b, a), minus(c, a))
        inner = max((dot(n, minus(p, a)) for p in exact), key=abs)
        n = tuple((-x if inner > 0 else x) / max(map(abs, n)) for x in n)
        size = np.sqrt(float(dot(n, n)))
        assert np.allclose(hull.planes[f, :3], [float(x) / size for x in n], rtol=0, atol=1e-15)
        reach = float(max(abs(x) for p in corners for x in p))
        assert abs(hull.planes[f, 3] + float(dot(n, a)) / size) <= 1e-15 * reach


def spread(corners):
    """Corners of which the first three are not collinear."""
    for a, b, c in itertools.combinations(corners, 3):
        if any(cross(minus(b, a), minus(c, a))):
            return a, b, c
    raise AssertionError("a face has no three corners that span it")


def rows(hull):
    return [tuple(int(i) for i in row) for row in hull.edges]


def check_surface(hull):
    """A closed surface: Euler's formula, each face one loop, and each edge turning outwards."""
    edges, corners = rows(hull), fractions(hull.vertices)
    assert len(hull.vertices) - len(edges) + len(hull.planes) == 2
    for face in range(len(hull.planes)):
        steps = {v: w for v, w, left, _ in edges if left == face} | {w: v for v, w, _, right in edges if right == face}
        start = at = next(iter(steps))
        for _ in range(len(steps)):
            at = steps[at]
        assert at == start
        assert len(set(steps.values())) == len(steps) >= 3
        loop = [corners[v] for v in steps]
        a = loop[0]
        area = (0, 0, 0)
        at = next(iter(steps))
        for _ in range(len(steps)):
            there = steps[at]
            part = cross(minus(corners[at], a), minus(corners[there], a))
            area = tuple(s + t for s, t in zip(area, part, strict=True))
            at = there
        assert dot(area, fractions([hull.planes[face, :3]])[0]) > 0, "the loop turns clockwise"


# ---- points ------------------------------------------------------------------------------------------------------

rng = np.random.default_rng(7)
POINT_SETS = {
    "tetrahedron": np.concatenate([np.zeros((1, 3)), np.eye(3)]),
    "cube": CORNERS,
    "grid: points inside faces and edges": GRID,
    "cube, each corner twice": np.concatenate([CORNERS, CORNERS]),
    "turned cube: nearly coplanar": apply(TURN, CORNERS),
    "turned cube far away": apply(TURN, CORNERS) + 1e6,
    "cloud": rng.normal(size=(14, 3)),
    "prism of a hexagon": np.array(
        [[2, 0], [1, 2], [-1, 2], [-2, 0], [-1, -2], [1, -2]] * 2 + [[0, 0]] * 2, dtype=float
    )[:, [0, 1, 1]] * [1, 1, 0] + np.array([[0, 0, z] for z in [0] * 6 + [1] * 6 + [0, 1]]),
    "sliver": rng.normal(size=(9, 3)) * [1, 1, 1e-9],
    "needle": rng.normal(size=(9, 3)) * [1, 1e-9, 1e-9],
    "turned needle": apply(TURN, rng.normal(size=(8, 3)) * [1, 1e-9, 1e-9]),
    "thinner than rounding": CORNERS * [1, 1, 2.0**-70] + [0, 0, 0],
    "of very different sizes": rng.normal(size=(9, 3)) * 10.0 ** rng.integers(-9, 9, (9, 1)),
    "huge": rng.normal(size=(8, 3)) * 1e300,
    "tiny": rng.normal(size=(8, 3)) * 1e-290,
    "one number of 5e-300": np.array([[-1, -1, -1], [-1, 1, 1], [1, -1, 1], [1, 1, -1], [0, 0, 5e-300]]),
}  # fmt: skip


@pytest.mark.parametrize("name", POINT_SETS)
def test_hull_of_points_is_the_enumerated_one(name):
    check_hull_of_points(hull_of_vertices(POINT_SETS[name]), POINT_SETS[name])


def test_clouds_on_a_coarse_grid():
    """Many coplanar and repeated points, of every shape."""
    solids = 0
    for _ in range(60):
        points = rng.integers(-1, 2, (rng.integers(4, 12), 3)).astype(float)
        hull = hull_of_vertices(points)
        if hull.dimension == 3:
            solids += 1
            check_hull_of_points(hull, points)
    assert solids > 30


WRONG = {
    "a corner missing": lambda h: replace(h, vertices=h.vertices[:-1]),
    "a corner moved by one unit in the last place": lambda h: replace(h, vertices=np.nextafter(h.vertices, 2)),
    "an edge the wrong way round": lambda h: replace(h, edges=np.concatenate([h.edges[:1, [1, 0, 2, 3]], h.edges[1:]])),
    "an edge missing": lambda h: replace(h, edges=h.edges[1:]),
    "a normal turned round": lambda h: replace(h, planes=-h.planes),
    "a plane shifted": lambda h: replace(h, planes=h.planes + 1e-14 * np.eye(4)[3]),
    "other numbers for the given": lambda h: replace(h, active_vertices=h.active_vertices[::-1]),
    "all faces inside out": lambda h: replace(h, edges=h.edges[:, [0, 1, 3, 2]]),
}


@pytest.mark.parametrize("name", WRONG)
def test_the_check_sees_a_wrong_hull(name):
    wrong = WRONG[name](hull_of_vertices(CORNERS))
    with pytest.raises((AssertionError, IndexError, KeyError)):
        check_hull_of_points(wrong, CORNERS)


# ---- planes ------------------------------------------------------------------------------------------------------


def check_hull_of_planes(hull, planes):
    exact = corners_by_enumeration(planes)
    rounded = sorted(tuple(float(x) for x in p) for p in exact)  # a fraction becomes the nearest double
    assert sorted(map(tuple, hull.vertices.tolist())) == rounded
    on = [[p for p in exact if dot(plane[:3], p) + plane[3] == 0] for plane in fractions(planes)]
    needed = {i for i, corners in enumerate(on) if len(corners) >= 3}
    assert set(hull.active_planes.tolist()) <= needed
    normals = {direction(fractions(planes)[i]) for i in needed}
    assert {direction(fractions(planes)[i]) for i in hull.active_planes} == normals
    assert len(hull.active_planes) == len(normals)
    given = np.asarray(planes)[hull.active_planes]
    assert np.allclose(hull.planes[:, :3], given[:, :3] / np.linalg.norm(given[:, :3], axis=1)[:, None], atol=1e-15)
    if len(set(rounded)) == len(rounded):  # corners that rounding merges leave loops of no area
        assert len(hull.vertices) - len(hull.edges) + len(hull.planes) == 2


def direction(plane):
    size = max(abs(x) for x in plane[:3])
    return tuple(x / size for x in plane)


def around_unit_ball(count, spread_=1.0):
    n = np.concatenate([[[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], rng.normal(size=(count - 4, 3))])
    return np.concatenate([n, -np.linalg.norm(n, axis=1)[:, None] * rng.uniform(1, 1 + spread_, (count, 1))], axis=1)


NEARLY = np.array([1e-3, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15])
PLANE_SETS = {
    "cube": CUBE_PLANES,
    "cube, planes of any length, twice": np.concatenate([CUBE_PLANES, CUBE_PLANES * [[2.5]] * 1e5]),
    "cube, redundant: touching a corner, an edge, nothing": np.concatenate(
        [CUBE_PLANES, [[1, 1, 1, -3], [1, 1, 0, -2], [1, 2, 3, -50]]]
    ),
    "cube with corners cut off": np.concatenate([CUBE_PLANES, np.c_[CORNERS, np.full(8, -2.5)]]),
    "octahedron: four planes in each corner": np.c_[CORNERS, -np.ones(8)],
    "around a ball": around_unit_ball(12),
    "nearly parallel planes": np.concatenate([CUBE_PLANES, [[e, 0, 1, -1 + e / 3] for e in NEARLY]]),
    "sliver": CUBE_PLANES * [1, 1, 1, 1] + np.c_[np.zeros((6, 3)), [0, 0, 1 - 1e-9, 0, 0, 1 - 1e-9]],
    "wedge of 1e-15": np.array([[0, 0, -1, 0], [1e-15, 0, 1, 0], [-1, 0, 0, -1.0], [0, 1, 0, -1], [0, -1, 0, -1]]),
    "huge": around_unit_ball(9) * [1, 1, 1, 1e250],
    "tiny": around_unit_ball(9) * [1, 1, 1, 1e-250],
    "normals of very different lengths": around_unit_ball(9) * 10.0 ** rng.integers(-100, 100, (9, 1)),
}


@pytest.mark.parametrize("name", PLANE_SETS)
def test_corners_of_planes_are_the_enumerated_ones_rounded_once(name):
    check_hull_of_planes(hull_of_planes(PLANE_SETS[name]), PLANE_SETS[name])


WRONG_CORNERS = {
    "a corner off by one unit in the last place": lambda h: replace(
        h, vertices=np.concatenate([np.nextafter(h.vertices[:1], 9), h.vertices[1:]])
    ),
    "a redundant plane kept": lambda h: replace(h, active_planes=np.r_[h.active_planes, 8]),
    "a plane missing": lambda h: replace(h, active_planes=h.active_planes[1:], planes=h.planes[1:]),
}


@pytest.mark.parametrize("name", WRONG_CORNERS)
def test_the_check_sees_wrong_corners(name):
    planes = PLANE_SETS["cube, redundant: touching a corner, an edge, nothing"]
    with pytest.raises((AssertionError, IndexError)):
        check_hull_of_planes(WRONG_CORNERS[name](hull_of_planes(planes)), planes)


@pytest.mark.parametrize(
    ("planes", "words"),
    [
        (CUBE_PLANES[:5], "the set is unbounded along (0.0, 0.0, -1.0)"),
        (CUBE_PLANES[1:], "the set is unbounded along (1.0, 0.0, 0.0)"),
        (CUBE_PLANES[:1], "the set is unbounded along"),
        (CUBE_PLANES[[0, 3]], "the set is unbounded along"),
        (np.concatenate([CUBE_PLANES, [[1, 1, 1, 3 + 1e-15]]]), "the set is empty"),
        ([[1, 0, 0, 1], [-1, 0, 0, 1]], "the set is empty"),
        ([[1, 0, 0, 1], [-1, 0, 0, 1 - 2**-52]], "the set is empty"),
    ],
)  # fmt: skip
def test_sets_that_are_no_polytopes_are_refused_saying_why(planes, words):
    with pytest.raises(ShapeError) as caught:
        ConvexPolyhedron(planes)
    assert "ConvexPolyhedron" in str(caught.value)
    assert words in str(caught.value)


def test_the_direction_of_an_unbounded_set_is_one():
    for _ in range(50):
        n = rng.normal(size=(6, 3))
        planes = np.c_[n, -np.ones(6)]
        try:
            hull_of_planes(planes)
        except ShapeError as error:
            way = np.array(eval(str(error).split("along ")[1]))
            assert np.any(way != 0)
            assert np.all(n @ way <= 1e-13)


def test_a_bad_row_is_named_in_a_batch():
    batch = np.stack([CUBE_PLANES, np.concatenate([CUBE_PLANES[:5], CUBE_PLANES[:1]]), CUBE_PLANES])
    with pytest.raises(ShapeError, match=r"unbounded along \(0.0, 0.0, -1.0\), at index \(1,\)"):
        ConvexPolyhedron(batch)
    with pytest.raises(ShapeError, match=r"KDOP: .* empty, at index \(1,\)"):
        KDOP([*np.eye(3), [1, 1, 1]], [-1, -1, -1, 0], [[1] * 4, [-0.5, -0.5, -0.5, 1], [1] * 4])


# ---- two methods, one answer --------------------------------------------------------------------------------------


def both_ways(monkeypatch, find, numbers):
    """What is found with proposals, and by the double description method alone."""
    found = []
    for fewest in (proposals.FEWEST, 10**9):
        hulls._kept.cache_clear()
        monkeypatch.setattr(proposals, "FEWEST", fewest)
        found.append(find(numbers))
    monkeypatch.undo()
    return found


def test_proposals_change_nothing_but_the_time(monkeypatch):
    """Random sets in general position and not, thin ones, and those near the doubt: the same faces to the bit."""
    kinds = [np.random.default_rng(20).normal(size=(n, 3)) for n in (9, 20, 60)]
    kinds += [np.round(k * 2) / 2 for k in kinds] + [k * [1, 1, s] for k in kinds for s in (1e-3, 1e-9, 1e-12)]
    kinds += [apply(TURN, CORNERS * [1, 2, 3]).repeat(2, axis=0), around_unit_ball(40)[:, :3] * 1e-13 + 1]
    for points in kinds:
        assert same(*both_ways(monkeypatch, hull_of_vertices, points))
    for planes in [around_unit_ball(n, s) for n in (9, 20, 60) for s in (0.1, 1e-3, 1e-9)] + list(PLANE_SETS.values()):
        assert same(*both_ways(monkeypatch, hull_of_planes, planes))


def test_proposals_are_made_where_they_should_be_and_proven(monkeypatch):
    points = np.random.default_rng(21).uniform(-1, 1, (20, 3))
    rows = [(x, y, z, 1) for x, y, z in faces.on_grid(points)[0]]
    near = np.c_[points, np.ones(20)]
    found = proposals.proposed_rays(rows, near, upwards=False)
    assert len(found) >= 20
    right = proposals._faces_by_qhull(points)
    for wrong in (
        right[1:],
        right[[0, *range(len(right))]],
        np.sort((right + np.eye(3, dtype=int)[2]) % 20, axis=1),
        right[:0],
    ):
        monkeypatch.setattr(proposals, "_faces_by_qhull", lambda _, wrong=wrong: wrong)
        assert proposals.proposed_rays(rows, near, upwards=False) is None
    monkeypatch.undo()


def test_proposals_of_many_points_on_a_face_are_told_by_whole_numbers(monkeypatch):
    """A cube with points on its faces and edges, each twice: six rays, and none where a piece is missing."""
    points = GRID.repeat(2, axis=0)
    rows, near = [(x, y, z, 1) for x, y, z in faces.on_grid(points)[0]], np.c_[points, np.ones(54)]
    found = proposals.proposed_rays(rows, near, upwards=False)
    assert {ray[:3] for ray, _ in found} == {tuple(int(x) for x in n[:3]) for n in CUBE_PLANES}
    assert all(names == [i for i in range(54) if points[i] @ ray[:3] == 1] for ray, names in found)
    right = proposals._faces_by_qhull(points)
    monkeypatch.setattr(proposals, "_faces_by_qhull", lambda _: right[1:])
    assert proposals.proposed_rays(rows, near, upwards=False) is None  # a face is not filled
    monkeypatch.undo()
    points = points * (1.0 + 1e-14 * np.arange(54)[:, None])  # faces within the doubt, but bent
    bent = [(x, y, z, 1) for x, y, z in faces.on_grid(points)[0]]
    monkeypatch.setattr(proposals, "_faces_by_qhull", lambda _: right)
    assert proposals.proposed_rays(bent, np.c_[points, np.ones(54)], upwards=False) is None


# ---- flat sets ---------------------------------------------------------------------------------------------------

FLAT_POINTS = {
    "polygon": (GRID * [1, 1, 0] + [0, 0, 0.3], 2, 4, 4),
    "slanted polygon": (CORNERS @ np.array([[1, 0, 1], [0, 1, 1], [0, 0, 0]]), 2, 4, 4),
    "triangle": (np.eye(3), 2, 3, 3),
    "segment": (GRID[:, :1] * [[1.0, 2.0, 3.0]], 1, 2, 1),
    "point": (GRID * 0 + [1, 2, 3], 0, 1, 0),
    "one vertex": (np.array([[4.0, 5.0, 6.0]]), 0, 1, 0),
}


def check_flat(hull, dimension, corners, sides):
    """Planes all around: they support the corners, and their normals do not lie in a half-space."""
    assert int(hull.dimension) == dimension
    assert len(hull.vertices) == corners
    heights = hull.planes[:, :3] @ hull.vertices.T + hull.planes[:, 3:]
    assert np.max(np.abs(np.max(heights, axis=1))) <= 1e-15 * (1 + np.abs(hull.vertices).max())
    assert np.allclose(np.linalg.norm(hull.planes[:, :3], axis=1), 1, atol=1e-15)
    ways = rng.normal(size=(200, 3))
    assert np.all(np.max(ways @ hull.planes[:, :3].T, axis=1) > 0)
    assert len({frozenset(row[:2]) for row in rows(hull)}) == sides
    for v, w, left, right in rows(hull):
        way = hull.vertices[w] - hull.vertices[v]
        turn = np.cross(hull.planes[left, :3], hull.planes[right, :3])
        assert np.allclose(turn, way / np.linalg.norm(way), atol=1e-14)


@pytest.mark.parametrize("name", FLAT_POINTS)
def test_flat_hulls_are_prisms_of_no_thickness(name):
    points, *expected = FLAT_POINTS[name]
    check_flat(hull_of_vertices(points), *expected)


def test_flat_sets_of_planes():
    flat = CUBE_PLANES.copy()
    expected = [(2, 4, 4), (1, 2, 1), (0, 1, 0)]
    for axis, numbers in zip((2, 0, 1), expected, strict=True):
        flat[axis, 3], flat[axis + 3, 3] = -0.25, 0.25
        check_flat(hull_of_planes(flat), *numbers)
    only_a_corner = np.concatenate([CUBE_PLANES, [[-1, -1, -1, 3]]])
    check_flat(hull_of_planes(only_a_corner), 0, 1, 0)
    only_an_edge = np.concatenate([CUBE_PLANES, [[-1, -1, 0, 2]]])
    check_flat(hull_of_planes(only_an_edge), 1, 2, 1)
    with pytest.raises(AssertionError):
        check_flat(hull_of_planes(only_an_edge), 2, 2, 1)


def test_boxes_need_no_search_and_are_the_same_hull():
    lower, upper = np.array([-1.0, 0.5, 2.0]), np.array([3.0, 0.75, 2.5])
    fast, points = hull_of_box(lower, upper), np.where(CORNERS > 0, upper, lower)
    numbers = [points.tolist().index(v) for v in fast.vertices.tolist()]
    check_hull_of_points(replace(fast, active_vertices=numbers), points)
    assert fast.dimension == 3
    assert AABB(lower, upper * [0, 0, 1] + lower * [1, 1, 0]).hull.dimension == 1
    flat = Box([1, 2, 3], [1, 2, 0], [0, 0, 0, 1]).hull
    assert flat.dimension == 2
    assert flat.vertices.shape == (8, 3)


# ---- batches, copies, speed of the second time -------------------------------------------------------------------

NAMES = ("vertices", "planes", "edges", "active_planes", "active_vertices", "dimension")


def same(a, b):
    return all(np.array_equal(getattr(a, n), getattr(b, n)) for n in NAMES)


def test_a_row_of_a_batch_is_the_hull_alone_then_repeats():
    clouds = np.stack([POINT_SETS["cloud"][:8], np.concatenate([CORNERS]), CORNERS * [1, 1, 0], CORNERS * 0])
    batch = hull_of_vertices(clouds)
    for i, cloud in enumerate(clouds):
        alone = hull_of_vertices(cloud)
        for name in NAMES[:-1]:
            whole, part = getattr(batch, name)[i], getattr(alone, name)
            assert np.array_equal(whole[: len(part)], part)
            assert not len(part) or all(np.array_equal(x, part[-1]) for x in whole[len(part) :])
    assert batch.dimension.tolist() == [3, 3, 2, 0]


MOVES = {
    "a row": (lambda s: s[1], 1.0),
    "some rows": (lambda s: s[1:], 1.0),
    "flattened": (lambda s: s.flattened(), 1.0),
    "repeated": (lambda s: s.broadcast_to((2, 3)), 1.0),
    "times a power of two": (lambda s: s.times_power(np.array([3, -4, 20])), None),
}


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("kind", ["planes", "vertices", "KDOP"])
def test_copies_carry_what_was_derived(move, kind):
    numbers = np.stack([around_unit_ball(9) for _ in range(3)])
    if kind == "planes":
        shape = ConvexPolyhedron(numbers)
    elif kind == "vertices":
        shape = ConvexPolyhedron.from_vertices(numbers[..., :3])
    else:
        shape = KDOP.around(numbers[..., :3], 14)
    _ = shape.hull
    copy = MOVES[move][0](shape)
    assert "_derived" in copy.__dict__
    again = type(copy).unpack(copy.pack())
    if copy.batch_shape:
        assert same(copy.hull, again.hull)
    else:  # a row of a batch that may be filled up
        assert np.array_equal(copy.hull.vertices[: len(again.hull.vertices)], again.hull.vertices)
    assert not same(copy.hull, shape.hull) or move == "flattened"


def test_poses_share_one_geometry():
    cube = ConvexPolyhedron(CUBE_PLANES, rng.normal(size=(1000, 3)))
    moved = cube.translated([1, 2, 3]).rotated(rng.normal(size=(1000, 4))).flattened()
    assert moved.numbers.strides[0] == 0
    assert moved.hull.vertices.strides[0] == 0
    assert same(moved[5].hull, hull_of_planes(CUBE_PLANES))


@pytest.mark.parametrize("given", ["planes", "vertices"])
def test_a_shared_geometry_is_copied_only_when_its_numbers_are_asked_for(given):
    """Scaled row by row, it is what each row would be alone."""
    cloud = around_unit_ball(9)
    one = ConvexPolyhedron(cloud) if given == "planes" else ConvexPolyhedron.from_vertices(cloud[:, :3])
    exponents = np.arange(-5, 5)
    many = one.translated(rng.normal(size=(10, 3)))
    scaled = many.times_power(exponents).times_power(2)[::-1].rotated([1, 2, 3, 4])[1:]
    assert "numbers" not in scaled.__dict__
    assert scaled.derived().table is one.derived().table
    for i in range(9):
        alone = (
            one.translated(many.position[8 - i]).times_power(int(exponents[8 - i])).times_power(2).rotated([1, 2, 3, 4])
        )
        again = type(one).unpack(alone.pack())
        for row in (scaled[i], alone):
            assert np.array_equal(row.pack(), again.pack())
            assert same(row.hull, again.hull)
            assert np.array_equal(row.identity()[1], again.identity()[1])
        assert np.array_equal(scaled.identity()[1][i], alone.identity()[1])
    assert np.array_equal(scaled.numbers, np.stack([scaled[i].numbers for i in range(9)]))
    assert not scaled.numbers.flags.writeable
    with pytest.raises(AttributeError):
        _ = scaled.number
