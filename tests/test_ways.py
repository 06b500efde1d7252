"""The search for ways out of overlapping unions: what it keeps, what it need not ask, and that room changes nothing."""

import importlib
from itertools import product

import numpy as np
import pytest

from refimpl import (
    AABB,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Point,
    Polyhedron,
    Sphere,
    distance,
    scenes,
)
from refimpl.kernels import atom_pairs, tangents, unions, ways
from refimpl.kernels.escapes import RESULT, way_out
from refimpl.kernels.ways import HERE
from refimpl.scenes import scenes as scenes_of
from refimpl.searches import search_room
from tests.solids import L_SHAPE, prism

N = 12
STILL = (0.0, 0.0, 0.0, 1.0)


@pytest.fixture
def plain(monkeypatch):
    """Kernels are run by Python."""
    monkeypatch.setattr(scenes, "module_for", lambda name, rows: importlib.import_module(f"refimpl.kernels.{name}"))


def turned(rng):
    return rng.uniform(-0.6, 0.6, (N, 3)), rng.normal(size=(N, 4))


def unions_of(rng, spread=1.0):
    c, q = turned(rng)
    one = Polyhedron(*prism(L_SHAPE), spread * c, q)
    c, q = turned(rng)
    return one, Composite([Box(c, [0.5, 0.4, 0.3], q), Sphere(c + 0.5, 0.4), Cylinder(c - 0.3, c - 0.7, 0.3)])


def test_tangents_lie_below_the_distance(plain):
    """Of every pair of atoms, wherever they are taken; so what one proves free is free."""
    rng = np.random.default_rng(1)
    (there,) = scenes_of(*unions_of(rng))
    for row in range(N):
        scene = unions.scene_of(there.batch, row)
        unions.nearest(scene, False)
        pairs = len(scene.a) * len(scene.b)
        search = search_room(pairs, pairs, ways)
        moves = [tuple(m) for m in rng.normal(size=(6, 3)).tolist()]
        asked = {(p, i): ways.ask(scene, search, p, m, i + 1) for p in range(pairs) for i, m in enumerate(moves)}
        for i, move in enumerate(moves):
            for pair in range(pairs):
                at = tangents.taken_at(search.known, pair, i + 1)
                assert search.known.pair[at] == pair
                assert tangents.height(search.known, at, move) == pytest.approx(asked[pair, i], abs=1e-13)
                assert tangents.highest(search.known, pair, move)[1] == pytest.approx(asked[pair, i], abs=1e-12)


def test_listed_tangents_tell_the_distance_of_polytopes(plain):
    """Of boxes, a hull, a segment and a point against the boxes and the wedges of a mesh, wherever they overlap."""
    rng = np.random.default_rng(4)
    c, q = turned(rng)
    c = c / 2
    hull = ConvexPolyhedron.from_vertices(rng.normal(size=(9, 3)), c, q)
    others = [Box(c, [0.5, 0.4, 0.3], q), AABB(c - 0.5, c + 0.3), hull, Capsule(c, c + 0.7, 0.0), Point(c)]
    overlapping = np.zeros(len(others), dtype=int)
    meshes = [
        Polyhedron(*prism(outline), 0.2 * rng.normal(size=(N, 3)) - 0.4, STILL)
        for outline in (L_SHAPE, [(0, 0), (2, 0), (0, 1)])
    ]
    for mesh, (k, other) in product(meshes, enumerate(others)):
        (there,) = scenes_of(other, mesh)
        for row in range(N):
            scene = unions.scene_of(there.batch, row)
            pairs = len(scene.b)
            search = search_room(pairs, pairs, ways)
            unions.nearest(scene, False)
            for pair, move in product(range(pairs), [HERE, *map(tuple, 0.2 * rng.normal(size=(4, 3)))]):
                ways.list_tangents(scene, search, pair)
                assert tangents.is_whole(search.known, pair)
                sigma = atom_pairs.answer(scene, 0, pair, move, HERE)[0]
                _, told = tangents.highest(search.known, pair, move)
                assert told <= sigma + 1e-14
                if sigma < 0.0:
                    assert told == pytest.approx(sigma, abs=1e-14)
                    overlapping[k] += 1
    assert np.all(overlapping > 20)


def test_chains_that_pairs_share_keep_them_apart():
    known = search_room(5, 5, ways).known._replace(first=[0, 0])
    for pair in range(5):
        tangents.learn(known, pair, 1, HERE, -1.0 - pair, (1.0, 0.0, 0.0), HERE)
    for pair in range(5):
        assert tangents.highest(known, pair, HERE) == (pair, -1.0 - pair)
        assert tangents.taken_at(known, pair, 1) == pair
        assert tangents.taken_at(known, pair, 2) == -1
        assert tangents.soonest(known, pair, (1.0, 0.0, 0.0), 9.0, 0.0) == 1.0 + pair
    tangents.forget(known)
    assert tangents.highest(known, 0, HERE)[0] == -1


def test_where_the_deepest_pair_decides_nothing_is_asked_again(plain, monkeypatch):
    asked = []
    answer = ways.answer
    monkeypatch.setattr(ways, "answer", lambda *which: asked.append(which) or answer(*which))
    pair = Composite([Sphere([0.0, 0, 0], 1.0), Sphere([1.0, 0, 0], 1.0)])
    found = distance(pair, Sphere([0.0, 1.75, 0], 1.0))
    assert found.distance == -0.25
    assert found.normal.tolist() == [0, 1, 0]
    assert not asked
    notch = distance(pair, Sphere([0.5, 1.5, 0], 1.0))  # left by both at once: √(4 − 1/4) above their centres
    assert notch.distance == pytest.approx(1.5 - np.sqrt(3.75), abs=1e-12)
    assert asked


def test_a_search_tells_where_its_room_is_too_small(plain):
    """For tangents, for planes, and for pairs near each other."""
    rng = np.random.default_rng(3)
    (there,) = scenes_of(*unions_of(rng, 0.3))
    told = np.zeros(3, dtype=int)
    for row in range(N):
        scene = unions.scene_of(there.batch, row)
        _, answered = unions.nearest(scene, False)
        pairs = len(scene.a) * len(scene.b)
        whole, less = [0.0] * RESULT, [0.0] * RESULT
        assert way_out(scene, search_room(pairs, pairs, ways), answered, 1e-12, whole)
        few, one, single = (search_room(pairs, pairs, ways) for _ in range(3))
        few = few._replace(known=few.known._replace(pair=[0] * (answered + 1)))
        small = [few, one._replace(source=[0]), single._replace(listed=[0])]
        for i, search in enumerate(small):
            if way_out(scene, search, answered, 1e-12, less):
                assert less == whole
            else:
                told[i] += 1
    assert np.all(told > 0)


def test_too_little_room_is_made_larger_and_changes_nothing(plain, monkeypatch):
    rng = np.random.default_rng(2)
    a, b = unions_of(rng)
    enough = distance(a, b)
    assert np.sum(enough.distance < 0) > N // 2
    monkeypatch.setattr(scenes, "MOST_PAIRS", 1)
    rooms = []
    room = scenes.search_room
    monkeypatch.setattr(scenes, "search_room", lambda p, n, m: rooms.append(n) or room(p, n, m))
    again = distance(a, b)
    assert max(rooms) > 1
    for name in ("distance", "on_a", "on_b", "normal"):
        assert np.array_equal(getattr(enough, name), getattr(again, name), equal_nan=True)
