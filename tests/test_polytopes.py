"""Polytopes against polytopes: the scalar kernels against exact arithmetic, against each other, and in two ways."""

from __future__ import annotations

import importlib.util
from itertools import product

import numpy as np
import pytest

import refimpl
from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from refimpl import AABB, KDOP, Box, Capsule, ConvexPolyhedron, HalfSpace, Point, Sphere
from refimpl.algorithms import polytopes
from refimpl.compiling import is_compiled, module_for
from refimpl.kernels import axes
from refimpl.kernels import polytopes as rows
from refimpl.kernels import polytopes_batch as batch
from refimpl.pairs import TABLE
from tests import truth
from tests.conftest import effort, name_of, scenes_of

ACCURACY = 1e-14
CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
NO_TURN = (0.0, 0.0, 0.0, 1.0)


def hull(vertices, position=(0, 0, 0), rotation=NO_TURN):
    return ConvexPolyhedron.from_vertices(vertices, position, rotation)


def require_contract(a, b, found):
    """σ is true, and the witness points and the normal belong to it."""
    true = truth.signed_distance(a, b)
    size = truth.scene_scale(a, b) or 1.0
    assert abs(true - float(found.distance)) <= ACCURACY * size, f"{float(true)}, {found.distance}: {a!r}, {b!r}"
    relation = found.on_b - found.on_a - found.distance * found.normal
    assert np.linalg.norm(relation) <= 2 * ACCURACY * size, f"{relation}: {a!r}, {b!r}"
    assert abs(np.linalg.norm(found.normal) - 1) <= 1e-15 * 4
    for witness, shape in ((found.on_a, a), (found.on_b, b)):
        assert truth.signed_distance(Point(witness), shape) <= 2 * ACCURACY * size, f"{a!r}, {b!r}"
    moved = b.translated(-found.distance * found.normal)
    assert abs(truth.signed_distance(a, moved)) <= 3 * ACCURACY * size, f"{a!r}, {b!r}"


# ---- known answers -----------------------------------------------------------------------------------------

OCTAHEDRON = hull(np.concatenate([np.eye(3), -np.eye(3)]))
SQUARE = hull([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
ROD = hull([[-1, 0, 0], [1, 0, 0]])
SPOT = hull([[0, 0, 0], [0, 0, 0]])
SLABS = KDOP(np.eye(3), -np.ones(3), np.ones(3))

KNOWN = [
    (Point((3, 0, 0)), OCTAHEDRON, 2),
    (Point((0, 0, 0)), OCTAHEDRON, -1 / np.sqrt(3)),
    (Point((1, 1, 1)), OCTAHEDRON, 2 / np.sqrt(3)),
    (Point((1, 0, 0)), OCTAHEDRON, 0),
    (Point((0.5, 0.25, 0)), SLABS, -0.5),
    (Point((0, 0, 0)), SPOT, 0),
    (Sphere((0, 0, 3), 1), SQUARE, 2),
    (Sphere((0, 0, 0), 1), SQUARE, -1),
    (Capsule((0, -5, 0), (0, 5, 0), 1), ROD, -1),
    (Capsule((-5, 0, 0), (5, 0, 0), 0), ROD, 0),
    (Capsule((-5, 0, 0), (5, 0, 0), 0.5), SLABS, -1.5),
    (HalfSpace((0, 0, 1), 0), OCTAHEDRON, -1),
    (HalfSpace((1, 1, 1), 0), SLABS, -np.sqrt(3)),
    (AABB((0, 0, 0), (1, 1, 1)), SLABS, -1),
    (AABB((2, 2, 2), (3, 3, 3)), SLABS, np.sqrt(3)),
    (Box((0, 0, 0), (1, 1, 1), (0, 0, 1, 2)), SLABS, -2),
    (Box((0, 0, 5), (1, 1, 1), NO_TURN), OCTAHEDRON, 3),
    (SLABS, SLABS, -2),
    (SLABS, OCTAHEDRON, -2),
    (OCTAHEDRON, OCTAHEDRON, -2 / np.sqrt(3)),
    (OCTAHEDRON, hull(OCTAHEDRON.vertices, (2, 0, 0)), 0),
    (SQUARE, SQUARE, 0),
    (SQUARE, hull(SQUARE.vertices, (0, 0, 0.25)), 0.25),
    (SQUARE, hull(SQUARE.vertices, (0, 0.5, 0), (1, 0, 0, 1)), -0.5),
    (ROD, hull(ROD.vertices, (0.5, 0, 0)), 0),
    (ROD, hull(ROD.vertices, (3, 0, 0)), 1),
    (ROD, hull(ROD.vertices, (0, 0, 2), (0, 0, 1, 1)), 2),
    (ROD, SPOT, 0),
    (SPOT, SPOT, 0),
    (SPOT, hull([[0, 0, 0]], (0, 3, 4)), 5),
]


@pytest.mark.parametrize(("a", "b", "expected"), KNOWN)
def test_known_distances(a, b, expected):
    found = refimpl.distance(a, b)
    assert found.distance == pytest.approx(expected, abs=1e-15 * 4)
    require_contract(a, b, found)


# ---- small hulls of every awkward kind, against exact arithmetic -------------------------------------------


def awkward_vertices(rng, kind):
    """Vertices of a small hull."""
    count = int(rng.integers(4, 13))
    ball = rng.normal(size=(count, 3))
    made = {
        "any": lambda: ball,
        "round": lambda: rng.integers(-2, 3, (count, 3)) / 2,
        "sliver": lambda: ball * 10.0 ** -rng.integers(0, 10, 3),
        "flat": lambda: rng.integers(-2, 3, (count, 3)) * rng.permutation([0.0, 1.0, 1.0]),
        "straight": lambda: rng.integers(-2, 3, (count, 1)) * rng.normal(size=3),
        "coplanar": lambda: prism(rng.uniform(0, 2 * np.pi, 5)),
        "repeated": lambda: np.repeat(ball[:4], 3, axis=0),
    }
    return made[kind]()


def prism(angles):
    """A prism with many corners, and more points within its top."""
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=-1)
    return np.concatenate([ring, ring + np.array([0, 0, 1]), ring / 2 + np.array([0, 0, 1])])


KINDS = ("any", "round", "sliver", "flat", "straight", "coplanar", "repeated")


def awkward_pair(rng, kind):
    """Two small hulls: far or near, turned by much or by hardly anything, or the same one twice."""
    u, v = awkward_vertices(rng, kind), awkward_vertices(rng, rng.choice(KINDS))
    if rng.random() < 0.3:
        v = u
    turn = rng.normal(size=4) if rng.random() < 0.5 else np.array(NO_TURN)
    tiny = 10.0 ** -rng.integers(1, 17) * rng.normal(size=4) if rng.random() < 0.6 else 0.0
    place = (
        rng.choice([0.0, 1.0, -0.5, 2.0], 3) if kind == "round" else rng.normal(size=3) * rng.choice([0.1, 1.0, 3.0])
    )
    a, b = hull(u, (0, 0, 0), turn), hull(v, place, turn + tiny)
    if rng.random() < 0.5:  # touching, or nearly so
        found = refimpl.distance(a, b)
        gap = rng.choice([0.0, 1e-15, 1e-12, -1e-12, 1e-8, -1e-4])
        b = b.translated((gap - found.distance) * found.normal)
    return a, b


@pytest.mark.parametrize("kind", KINDS)
def test_small_hulls_keep_the_contract(kind):
    rng = np.random.default_rng([20, KINDS.index(kind)])
    overlapping = 0
    for _ in range(4 * effort()):
        a, b = awkward_pair(rng, kind)
        found = refimpl.distance(a, b)
        overlapping += found.distance <= 0
        require_contract(a, b, found)
    assert 0 < overlapping < 4 * effort()


# ---- large hulls -------------------------------------------------------------------------------------------


def large_hull(rng, count):
    ball = rng.normal(size=(count, 3))
    return hull(ball / np.linalg.norm(ball, axis=1)[:, None] * rng.uniform(0.5, 1.5, 3))


def edge_directions(shape):
    start, end = (shape.vertices[shape.hull.edges[:, i]] for i in (0, 1))
    return end - start


def least_depth_of_all(a, b):
    """Least depth over all faces of both and all their edges crossed, in the world's frame without turns."""
    u, v = edge_directions(a), edge_directions(b)
    crosses = np.cross(u[:, None, :], v[None, :, :]).reshape(-1, 3)
    crosses = crosses[np.linalg.norm(crosses, axis=1) > 1e-9]
    n = np.concatenate([a.planes[:, :3], -b.planes[:, :3], crosses, -crosses])
    n /= np.linalg.norm(n, axis=1)[:, None]
    return min(
        np.min(np.max(part @ (a.vertices + a.position).T, axis=1) - np.min(part @ (b.vertices + b.position).T, axis=1))
        for part in np.array_split(n, 20)
    )


def test_large_hulls_overlap_by_the_least_of_all_axes():
    """Pruning by a directory of vertices and by bounds over arcs loses no axis."""
    rng = np.random.default_rng(21)
    for _ in range(6):
        a, b = large_hull(rng, int(rng.integers(40, 90))), large_hull(rng, int(rng.integers(5, 90)))
        b = b.translated(rng.normal(size=3) * rng.choice([0.01, 0.3]))
        found = refimpl.distance(a, b)
        assert found.distance < 0
        assert -found.distance == pytest.approx(least_depth_of_all(a, b), abs=1e-14)


def test_large_hulls_keep_the_contract():
    rng = np.random.default_rng(22)
    for _ in range(3):
        a, b = large_hull(rng, 60), large_hull(rng, 50).rotated(rng.normal(size=4)).translated(rng.normal(size=3))
        require_contract(a, b, refimpl.distance(a, b))


def test_the_directory_names_the_farthest_vertex_in_the_middle_of_each_cell():
    rng = np.random.default_rng(23)
    shape = large_hull(rng, 50)
    geometry = polytopes.side(shape[None]).geometries[0]
    start = int(geometry[rows.DIRECTORY])
    assert start > 0
    assert len(geometry) == start + 6 * rows.GRID**2
    seen = set()
    for ways in product(polytopes.MIDDLES, repeat=2):
        for side in range(3):
            for sign in (1.0, -1.0):
                way = np.roll([sign, *ways], side)
                cell = rows.cell_of(*way)
                seen.add(cell)
                heights = shape.vertices @ way
                assert heights[int(geometry[start + cell])] == pytest.approx(heights.max(), abs=1e-15 * 8)
    assert len(seen) == 6 * rows.GRID**2


def test_what_an_arc_promises_is_never_less_than_the_gap_along_it():
    rng = np.random.default_rng(24)
    for _ in range(20):
        a, b = (large_hull(rng, 12)[None] for _ in range(2))
        b = b.translated(rng.normal(size=3) * rng.choice([0.1, 1.0, 4.0]))
        placed = []
        for shape in (a, b):
            found = polytopes.side(shape)
            geometry = found.geometries[0].tolist()
            body, pose = [0.0] * len(geometry), [0.0] * (rows.FACTOR + 1)
            total = int(found.notes[batch.POWER]) + int(found.powers[0])
            batch.put(found.kind, found.rows, 0, found.notes, 0, total, (1.0, 1.0), found.own, pose)
            offset = tuple(pose[:3])
            rows.place_vertices(geometry, pose, offset, body)
            rows.place_faces(geometry, pose, offset, body)
            placed.append((geometry, pose, body))
        (geometry, _, body), (other_geometry, other_pose, other) = placed
        axes.widest_face(body, other, other_geometry, other_pose, 0, -np.inf)
        first, count = rows.first_edge(geometry), int(geometry[rows.N_EDGES])
        for at in range(first, first + rows.EDGE * count, rows.EDGE):
            start = rows.first_face(body)
            u, v = (
                np.array(axes.three(body, start + rows.FACE * int(geometry[at + side])))
                for side in (rows.LEFT, rows.RIGHT)
            )
            promise = axes._promise(geometry, at, body, other)
            for t in rng.uniform(size=4):
                n = t * u + (1 - t) * v
                n /= np.linalg.norm(n)
                assert rows.gap_along(body, other, tuple(n)) <= promise + 1e-15 * 16


# ---- two kernels, and two ways to run them -----------------------------------------------------------------


@pytest.mark.parametrize("regime", [name for name in REGIMES if name != "models"])
@pytest.mark.parametrize("pair", [(Box, Box), (AABB, Box), (Capsule, Box), (Capsule, AABB)], ids=name_of)
def test_boxes_as_boxes_and_as_polytopes_are_equally_far_apart(pair, regime):
    """The fifteen axes of two boxes, and the search over faces and arcs that any polytopes take."""
    a, b = scenes_of(pair, regime, 40 * effort())
    radius = a.radius if pair[0] is Capsule else 0.0
    as_polytopes = polytopes.separate(a, b).distance
    as_boxes = refimpl.distance(a, b).distance
    size = np.maximum(np.maximum(a.magnitude, b.magnitude), np.abs(as_boxes))
    assert np.max(np.abs(as_boxes - (as_polytopes - radius)) / size) <= ACCURACY / 2


@pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="compiling needs numba")
@pytest.mark.parametrize(
    "pair",
    [(Capsule, Capsule), (Box, Box), (Capsule, Box), (Box, KDOP), (Point, ConvexPolyhedron), (KDOP, ConvexPolyhedron)],
    ids=name_of,
)
def test_compiled_and_plain_kernels_answer_with_the_same_bits(pair, monkeypatch):
    for index, regime in enumerate(["generic", "aligned", "nearly_touching", "deep", "parallel_edges", "sliver"]):
        a, b = REGIMES[regime](NumpyDraws(25, (index, 1), 256), *pair)
        assert is_compiled(module_for("boxes", 256))
        compiled = refimpl.distance(a, b)
        with monkeypatch.context() as patch:
            patch.setattr("refimpl.compiling._compiled_package", lambda: None)
            assert not is_compiled(module_for("boxes", 256))
            plain = refimpl.distance(a[:40], b[:40])
        for name in ("distance", "on_a", "on_b", "normal"):
            assert np.array_equal(getattr(compiled, name)[:40], getattr(plain, name), equal_nan=True)


def test_a_geometry_in_many_poses_is_one_row():
    shape = large_hull(np.random.default_rng(26), 40)
    many = shape.translated(np.random.default_rng(27).normal(size=(100, 3)))
    found = polytopes.side(many)
    assert found.geometries.shape[0] == 1
    assert polytopes.side(many[3:50]).geometries is found.geometries


@pytest.mark.parametrize("b", [SLABS, OCTAHEDRON])
def test_an_empty_batch_has_no_answers(b):
    none = np.zeros((0, 3))
    for a in (
        Point(none),
        Box(none, none, np.ones((0, 4))),
        hull(np.zeros((0, 4, 3))),
        HalfSpace(none + 1, none[:, 0]),
    ):
        assert refimpl.distance(a, b).normal.shape == (0, 3)


# ---- scaling and order, which the kernels do themselves ------------------------------------------------------

WHOLE = [pair for pair, rule in TABLE.items() if rule.whole]


@pytest.mark.parametrize("pair", WHOLE, ids=name_of)
def test_a_power_of_two_scales_every_answer_exactly(pair):
    a, b = scenes_of(pair, "generic", 10)
    found = refimpl.distance(a, b)
    for exponent in (-900, 3, 1010):
        grown = refimpl.distance(a.times_power(np.int64(exponent)), b.times_power(np.int64(exponent)))
        assert np.array_equal(grown.normal, found.normal)
        for name in ("distance", "on_a", "on_b"):
            assert np.array_equal(getattr(grown, name), np.ldexp(getattr(found, name), exponent)), name


def test_what_has_no_size_is_not_scaled():
    for exponent in (-900, 7, 900):
        spot = SPOT.times_power(np.int64(exponent))
        for other in (spot, SPOT, Point((0, 0, 0))):
            assert refimpl.distance(spot, other).distance == 0
        assert refimpl.distance(spot, Point((0, 3, 4))).distance == 5


def test_planes_and_vertices_of_the_same_numbers_are_put_in_order():
    """Two solids with one middle and of about one size, told apart only by what their numbers mean."""
    planes = np.concatenate([0.9 * np.concatenate([np.eye(3), -np.eye(3)]), np.full((6, 1), -0.5)], axis=1)
    a, b = ConvexPolyhedron(planes), hull(planes.reshape(8, 3))
    there, back = refimpl.distance(a, b), refimpl.distance(b, a)
    assert there.distance == back.distance < 0
    assert np.array_equal(there.on_a, back.on_b)
    assert np.array_equal(there.normal, -back.normal)
