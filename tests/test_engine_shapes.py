"""Hulls, meshes and composites as FCL and PyBullet hold them: effective shapes, surfaces, parts."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from oracles.bodies import random_body, round_body
from oracles.draws import NumpyDraws
from oracles.engine import Array, Engine, Status
from oracles.engines import load_engine
from oracles.engines.geometry import Kept, different, faced
from oracles.keeping import rows_of
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, Cell
from oracles.solids import block
from oracles.worker import EngineWorker
from refimpl import distance
from refimpl.shapes import (
    KDOP,
    Box,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)
from tests.facing import rows, support_in

ENGINES: dict[str, Engine] = {name: load_engine(name) for name in ("fcl", "bullet")}
HULLS = (KDOP, ConvexPolyhedron)

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
BLOCK = Polyhedron(*block(0.0))


@pytest.fixture(scope="module")
def workers() -> Iterator[dict[str, EngineWorker]]:
    running = {name: EngineWorker(name) for name in ENGINES}
    yield running
    for worker in running.values():
        worker.close()


def far_points(n: int) -> Array:
    rng = np.random.default_rng(4)
    away = rng.normal(size=(n, 3))
    return 6.0 * away / np.linalg.norm(away, axis=1, keepdims=True)


def test_bullet_keeps_hulls_on_a_grid_and_grows_them(workers: dict[str, EngineWorker]) -> None:
    """The model of the grid is exact; without it, answers would be off by up to 3e-4 of the size."""
    worst = 0.0
    for number in range(12):
        body = (round_body if number % 3 == 0 else random_body)(NumpyDraws(9, (number,), 40))
        for kind in HULLS:
            shapes = body.make(kind)
            points = shapes.reference_point + far_points(40)
            found = workers["bullet"].answer(DISTANCE, Point, kind, points, shapes.pack()).distance
            used = ENGINES["bullet"].effective(DISTANCE, Point, points, kind, shapes.pack())[1]
            expected = distance(Point(points), used.kind.unpack(used.rows)).distance - 0.001
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)
            worst = max(worst, float(np.abs(found + 0.001 - distance(Point(points), shapes).distance).max()))
    assert 1e-5 < worst < 1e-3


def test_bullet_rounds_the_rims_of_cylinders(workers: dict[str, EngineWorker]) -> None:
    a, b = rows(Point([4, 0, 5])), rows(Cylinder([0, 0, -1], [0, 0, 1], 1.0))
    found = workers["bullet"].answer(DISTANCE, Point, Cylinder, a, b).distance[0]
    assert found - 5.0 == pytest.approx(
        0.001 * (math.hypot(1, 1) * math.cos(math.atan2(4, 3) - math.pi / 4) - 1), abs=1e-6
    )
    used = ENGINES["bullet"].effective(DISTANCE, Point, a, Cylinder, b)[1]
    assert distance(Point(a), Cylinder.unpack(used.rows)).distance[0] - 0.001 == pytest.approx(found, abs=1e-6)
    thin = rows(Cylinder([0, 0, 0], [0, 0, 1e-4], 1e-5), Cylinder([0, 0, 0], [0, 1e-300, 0], 1.0))
    kept = Cylinder.unpack(ENGINES["bullet"].effective(DISTANCE, Point, np.tile(a, (2, 1)), Cylinder, thin)[1].rows)
    assert (kept.radius <= [1e-10, 1.0]).all()


@pytest.mark.parametrize("query", [DISTANCE, CONTACTS, BOOLEAN])
@pytest.mark.parametrize("name", ENGINES)
def test_a_shape_inside_a_mesh_is_at_a_distance_from_it(
    name: str, query: str, workers: dict[str, EngineWorker]
) -> None:
    """By design: engines take meshes for surfaces; the judge sees that in the effective shape."""
    margin = {"fcl": 0.0, "bullet": 0.001}[name]
    for inside, gap in ((Sphere([0.25, 0, 0], 0.25), 0.5), (Box([0, 0, 0.5], [0.25] * 3, [0, 0, 0, 1]), 0.25 - margin)):
        cell = Cell(query, type(inside), Polyhedron)
        found = workers[name].answer(query, cell.type_a, cell.type_b, rows(inside), rows(BLOCK))
        assert query == DISTANCE or found.hit[0] == 0
        assert query != DISTANCE or found.distance[0] == pytest.approx(gap, abs=1e-6)
        used = ENGINES[name].effective(query, cell.type_a, rows(inside), Polyhedron, rows(BLOCK))
        a, b = (side.kind.unpack(side.rows) for side in used)
        grown = float(used[0].margin[0] + used[1].margin[0])
        assert len(b.parts) == 12
        assert distance(a, b).distance[0] - grown == pytest.approx(gap, abs=1e-12)


def test_a_composite_is_as_near_as_its_nearest_part(workers: dict[str, EngineWorker]) -> None:
    shape = support_in(Composite, np.array([0.6, 0.0, 0.8]), np.zeros(3))
    balls = rows(*[Sphere(point, 0.5) for point in 0.6 * far_points(30)])
    for name, worker in workers.items():
        whole = worker.answer(DISTANCE, Sphere, Composite, balls, np.tile(shape.pack(), (30, 1)))
        each = [worker.answer(DISTANCE, Sphere, type(p), balls, np.tile(p.pack(), (30, 1))) for p in shape.parts]
        nearest = np.min([one.distance for one in each], axis=0)
        np.testing.assert_allclose(whole.distance, nearest, rtol=0, atol=1e-9, err_msg=name)
        hits = worker.answer(BOOLEAN, Sphere, Composite, balls, np.tile(shape.pack(), (30, 1))).hit
        single = [worker.answer(BOOLEAN, Sphere, type(p), balls, np.tile(p.pack(), (30, 1))) for p in shape.parts]
        np.testing.assert_array_equal(hits, np.max([one.hit for one in single], axis=0))


def test_a_composite_of_many_parts_loses_none(workers: dict[str, EngineWorker]) -> None:
    """Compounds of PyBullet end after 16 parts: more of them stand side by side."""
    chain = Composite([Sphere([3.0 * i, 0, 0], 1.0) for i in range(20)])
    balls = rows(*[Sphere([3.0 * i, 4, 0], 1.0) for i in range(20)])
    for name, worker in workers.items():
        found = worker.answer(DISTANCE, Sphere, Composite, balls, np.tile(chain.pack(), (20, 1)))
        np.testing.assert_allclose(found.distance, 2.0, rtol=0, atol=1e-5, err_msg=name)


def test_parts_that_an_engine_cannot_hold_are_unsupported_and_cost_nothing_else(
    workers: dict[str, EngineWorker],
) -> None:
    ball = Sphere([0, 0, 0], 1)
    parts = {"bullet": Ellipsoid([3, 0, 0], [1, 1, 1]), "fcl": HalfSpace([0, 0, 1], 5)}
    for name, part in parts.items():
        for impossible in (part, BLOCK):
            shapes = Composite([ball, impossible]), Composite([ball, Sphere([5, 0, 0], 1)])
            packed = [[*shape.pack().tolist()] for shape in shapes]
            for row, status in zip(packed, (Status.UNSUPPORTED, Status.ANSWERED), strict=True):
                found = workers[name].answer(DISTANCE, Point, Composite, [[9.0, 0.0, 0.0]], [row])
                assert found.status.tolist() == [status]
                assert bool(found.errors) == (status == Status.UNSUPPORTED)


@pytest.mark.parametrize("name", ENGINES)
def test_hulls_without_thickness(name: str, workers: dict[str, EngineWorker]) -> None:
    """A square, a segment, a point; the hull of Bullet is grown by 0.001."""
    flat = [CUBE[CUBE[:, 2] > 0] * [1, 1, 0], CUBE[:2] * [0, 0, 1], CUBE[:1] * 0.0]
    point = Point([0.3, 0.1, 4.0])
    for vertices, dimension in zip(flat, (2, 1, 0), strict=True):
        hull = ConvexPolyhedron.from_vertices(vertices, [0, 0, 1])
        assert hull.hull.dimension == dimension
        found = workers[name].answer(DISTANCE, Point, ConvexPolyhedron, rows(point), rows(hull))
        gap = distance(point, hull).distance - (0.001 if name == "bullet" else 0.0)
        assert found.distance[0] == pytest.approx(gap, abs=1e-5)


def test_different_vertices_are_those_that_differ_in_order() -> None:
    points = np.random.default_rng(2).integers(-1, 2, (200, 6, 3)).astype(float)
    found = different(points)
    counts = [len(np.unique(row, axis=0)) for row in points]
    assert found.shape[1] == max(counts) > min(counts)
    for row, count, given in zip(found, counts, points, strict=True):
        np.testing.assert_array_equal(row[:count], np.unique(given, axis=0))
        assert (row[count:] == row[count - 1]).all()


@pytest.mark.parametrize("kind", HULLS)
def test_hulls_on_a_grid_are_those_of_each_shape_alone(kind: type[KDOP | ConvexPolyhedron]) -> None:
    shapes = random_body(NumpyDraws(4, (2,), 12)).make(kind)
    points, given = far_points(12), rows_of(shapes)
    used = ENGINES["bullet"].effective(DISTANCE, Point, points, kind, given)[1].made
    assert isinstance(used, ConvexPolyhedron)
    for i in range(len(shapes)):
        corners = np.unique(shapes[i].vertices, axis=0)
        lower, upper = corners.min(axis=0), corners.max(axis=0)
        middle, step = (lower + upper) * 0.5, (upper - lower) * (1.0 / 10216)
        grid = np.trunc((corners - middle) * (1.0 / step)) * step + middle
        np.testing.assert_array_equal(used[i].numbers[: len(grid)], grid)
        assert (used[i].numbers[len(grid) :] == grid[-1]).all()


def test_geometries_are_kept_by_content_and_not_without_end() -> None:
    made: list[tuple[float, ...]] = []

    def make(key: tuple[float, ...]) -> int:
        made.append(key)
        return len(made)

    kept = Kept(make, most=2)
    assert [kept[1.0,], kept[2.0,], kept[1.0,], kept[3.0,], kept[1.0,], kept[2.0,]] == [1, 2, 1, 3, 1, 4]
    kept.clear()
    assert kept[1.0,] == 5


def test_degenerate_hulls_have_two_faces_and_solid_ones_triangles() -> None:
    key = (1.0, *ConvexPolyhedron.from_vertices(CUBE).pack()[:-7])
    vertices, faces = faced(key)
    assert len(vertices) == 8
    assert len(faces) == 12
    for i, j, k in faces:
        normal = np.cross(vertices[j] - vertices[i], vertices[k] - vertices[i])
        assert normal @ vertices[i] > 0
    flat = (1.0, *ConvexPolyhedron.from_vertices(CUBE[:4]).pack()[:-7])
    assert faced(flat).faces == [[0, 1, 2, 3], [3, 2, 1, 0]]
