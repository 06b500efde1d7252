"""Trees of boxes: the same answers as brute force through any history, and what each of them is for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from refimpl.broadphase import BVH, BruteForce, BSPTree, KDTree, Octree
from refimpl.broadphase.hierarchy import Hierarchy
from refimpl.broadphase.parting import Planes

TREES = [BVH, Octree, KDTree, BSPTree]
NUMBERS = st.sampled_from([-np.inf, -1.7e308, -1e9, -3.0, -1.0, -5e-324, 0.0, 1e-12, 0.5, 1.0, 2.0, 7.0, 1e300, np.inf])


def some_boxes(rng, count, dimension):
    """Small and large, flat and pointlike, stacked, far out, without end."""
    low = rng.integers(-8, 8, (count, dimension)) * 2.0 ** rng.integers(-30, 30, (count, 1)) ** rng.integers(0, 2)
    size = rng.integers(0, 3, (count, dimension)) * 2.0 ** rng.integers(-3, 6, (count, 1))
    high = low + size
    low[rng.random(low.shape) < 0.01] = -np.inf
    high[rng.random(low.shape) < 0.01] = np.inf
    return low, high


def agree(structures, rng, dimension):
    brute, *trees = structures
    low, high = some_boxes(rng, 12, dimension)
    origin, way = rng.integers(-9, 9, (4, dimension)) * 1.0, rng.integers(-2, 3, (4, dimension)) * 1.0
    way[~way.any(axis=1), 0] = 1.0
    length = rng.choice([4.0, np.inf], 4)
    pairs, met, held = brute.pairs(), brute.query_boxes(low, high), brute.query_points(origin)
    hit = brute.query_rays(origin, way, length)
    for tree in trees:
        assert np.array_equal(tree.pairs(), pairs), type(tree)
        assert np.array_equal(tree.query_boxes(low, high), met), type(tree)
        assert np.array_equal(tree.query_points(origin), held), type(tree)
        assert np.array_equal(tree.query_rays(origin, way, length), hit), type(tree)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from([0, 1, 2, 5, 60, 180]))
def test_any_history_gives_what_brute_force_gives(seed, dimension, count):
    rng = np.random.default_rng(seed)
    flags = rng.random(count) < rng.choice([0.0, 0.3, 1.0])
    every = [kind().build(*some_boxes(rng, count, dimension), flags) for kind in [BruteForce]]
    every += [kind().build(every[0].lower, every[0].upper, flags) for kind in TREES]
    agree(every, rng, dimension)
    for _ in range(2):  # so that there is a second round on what the first has left
        ids = rng.permutation(every[0].ids)[: rng.integers(0, len(every[0]) + 1)]
        boxes = some_boxes(rng, len(ids), dimension)
        for structure in every:
            structure.update(ids, *boxes)
        agree(every, rng, dimension)
        ids = rng.permutation(every[0].ids)[: rng.integers(0, len(every[0]) + 1)]
        more = rng.integers(0, 50)
        boxes, new = some_boxes(rng, more, dimension), rng.random(more) < 0.3
        for structure in every:
            structure.remove(ids)
            structure.insert(*boxes, new)
        agree(every, rng, dimension)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(*[NUMBERS] * 6), min_size=1, max_size=70))
def test_any_corners_give_what_brute_force_gives(rows):
    corners = np.array(rows).reshape(-1, 2, 3)
    low, high = corners.min(axis=1), corners.max(axis=1)
    low[low == np.inf], high[high == -np.inf] = 0.0, 0.0
    low, high = np.minimum(low, high), np.maximum(low, high)
    expected = BruteForce().build(low, high).pairs()
    for kind in TREES:
        assert np.array_equal(kind().build(low, high).pairs(), expected)


@pytest.mark.parametrize("kind", TREES)
@pytest.mark.parametrize("scene", ["identical", "stacked", "scales", "line"])
def test_hard_scenes(kind, scene):
    """Nothing that a plane could part; plates; sizes and distances over 300 powers of ten; all on a line."""
    k = np.arange(700.0)[:, None]
    low, high = {
        "identical": (np.zeros((700, 3)), np.ones((700, 3))),
        "stacked": (np.hstack([0 * k, 0 * k, k]), np.hstack([0 * k + 99, 0 * k + 99, k + 1])),
        "scales": (2.0 ** (k - 350) * [1, 1, 1], 2.0 ** (k - 350) * [1.5, 2, 2]),
        "line": (np.hstack([k, k, k]), np.hstack([k, k, k]) + 0.5),
    }[scene]
    pairs = kind().build(low, high).pairs()
    assert len(pairs) == {"identical": 350 * 699, "stacked": 699, "scales": 0, "line": 0}[scene]
    assert np.array_equal(pairs, BruteForce().build(low, high).pairs())


@pytest.mark.parametrize("fault", ["touching", "stale boxes", "one side only"])
def test_faults_are_noticed(fault, monkeypatch):
    """Touching taken for apart; boxes that stay behind; objects put on one side of a plane that they reach across."""
    rng = np.random.default_rng(11)
    low = rng.integers(0, 12, (300, 3)) * 1.0
    high = low + rng.integers(1, 3, (300, 3))
    kinds = {"touching": TREES, "stale boxes": [BVH, Octree], "one side only": [KDTree, BSPTree]}[fault]
    trees = [kind().build(low, high) for kind in kinds]
    brute = BruteForce().build(low, high)
    if fault == "touching":
        for tree in trees:
            tree.tree.nodes.high[:] -= 1e-9
            tree.tree.items.high[:] -= 1e-9
    if fault == "stale boxes":
        monkeypatch.setattr(Hierarchy, "refit", lambda *_: None)
        for structure in [brute, *trees]:
            structure.update(np.arange(20), low[20:40], high[20:40])
    if fault == "one side only":
        sides = Planes.sides
        monkeypatch.setattr(Planes, "sides", lambda *at: (sides(*at)[0], ~sides(*at)[0]))
        trees = [kind().build(low, high) for kind in kinds]
    for tree in trees:
        found = set(map(tuple, tree.pairs().tolist()))
        assert found < set(map(tuple, brute.pairs().tolist())), type(tree)


@pytest.fixture(scope="module")
def crowd():
    """Balls of one size, at a density at which each meets a few."""
    low = np.random.default_rng(5).random((6000, 3)) * 18
    return low, low + 1.0


@pytest.mark.parametrize("kind", TREES)
def test_work_grows_with_the_answer(kind, crowd, monkeypatch):
    """Of 18 million pairs, few are ever compared: what is proposed is at most a little more than what is true."""
    compared = []
    import refimpl.broadphase.hierarchy as descent  # noqa: PLC0415
    import refimpl.broadphase.partition as cells  # noqa: PLC0415

    for module in (descent, cells):
        meeting = module.meeting
        monkeypatch.setattr(
            module, "meeting", lambda a, i, b, j, meeting=meeting: (compared.append(len(i)), meeting(a, i, b, j))[1]
        )
    found = len(kind().build(*crowd).pairs())
    assert 20_000 < found < 60_000
    assert found < sum(compared) < 40 * found


@pytest.mark.parametrize("kind", [BVH, Octree])
def test_static_objects_are_not_compared(kind, crowd):
    flags = np.arange(len(crowd[0])) % 50 > 0
    tree = kind().build(*crowd, flags)
    proposed = sum(len(i) for i, _ in tree._near_pairs())
    assert proposed == len(tree.pairs())
    assert np.array_equal(tree.pairs(), BruteForce().build(*crowd, flags).pairs())


@pytest.mark.parametrize("kind", TREES)
def test_nodes_hold_what_is_below_them(kind, crowd):
    tree: Hierarchy = kind().build(*crowd).tree
    for node in np.flatnonzero(tree.arity):
        below = np.arange(tree.first[node], tree.first[node] + tree.arity[node])
        assert np.array_equal(tree.nodes.low[:, node], tree.nodes.low[:, below].min(axis=1))
        assert np.array_equal(tree.nodes.high[:, node], tree.nodes.high[:, below].max(axis=1))
    assert set(tree.order.tolist()) == set(range(len(crowd[0])))
    assert np.all(tree.arity[tree.home] == 0)
    if kind in {BVH, Octree}:
        assert len(tree.order) == len(crowd[0])


def test_surface_area_beats_halves(crowd):
    """Two clouds, one small: the best cut is between them, not in the middle of one; and few levels are needed."""
    rng = np.random.default_rng(1)
    points = np.concatenate([rng.random((900, 3)), rng.random((100, 3)) + 20])
    tree = BVH().build(points, points).tree
    moving = tree.first[0] + np.arange(2)
    sizes = sorted(
        int(np.sum((points >= tree.nodes.low[:, n]).all(axis=1) & (points <= tree.nodes.high[:, n]).all(axis=1)))
        for n in moving
    )
    assert sizes == [100, 900]
    assert len(BVH().build(*crowd).tree.ends) < 3 * np.log2(len(crowd[0]))


def test_small_moves_refit_and_large_ones_rebuild(crowd):
    tree = BVH().build(*crowd)
    shape, cost = tree.tree, tree.cost()
    step = np.random.default_rng(2).normal(scale=0.05, size=crowd[0].shape)
    tree.update(tree.ids, crowd[0] + step, crowd[1] + step)
    assert tree.tree is shape
    assert cost * 0.9 < tree.cost() < cost * 1.3
    order = np.random.default_rng(3).permutation(len(crowd[0]))
    tree.update(tree.ids, crowd[0][order], crowd[1][order])
    assert tree.tree is not shape
    assert tree.cost() < cost * 1.3


@pytest.mark.parametrize("kind", TREES)
def test_objects_put_in_one_place_do_not_fill_one_leaf(kind, crowd):
    tree = kind().build(*crowd)
    low = np.random.default_rng(4).random((2000, 3)) * 12 + 100
    tree.insert(low, low + 1.0)
    assert tree.tree.count.max() < 300


# ------------------------------------------------------------------------------------------ nearest


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [1, 7, 30])
def test_nearest_points_are_those_of_scipy(dimension, count):
    rng = np.random.default_rng(dimension)
    points, asked = rng.random((1500, dimension)) ** 3, rng.random((80, dimension)) * 1.4 - 0.2
    distance, index = cKDTree(points).query(asked, list(range(1, count + 1)))
    for kind in TREES:
        found, ids = kind().build(points, points).nearest(asked, count)
        assert np.array_equal(ids, index)
        assert np.allclose(found, distance, rtol=1e-15, atol=0)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.integers(1, 90), st.integers(1, 12))
def test_nearest_boxes_are_the_first_of_all_by_distance_and_id(seed, dimension, number, count):
    """Whole coordinates: many distances are equal, and the smaller id comes first."""
    rng = np.random.default_rng(seed)
    low = rng.integers(-4, 4, (number, dimension)) * 1.0
    high = low + rng.choice([0.0, 1.0, 2.0, np.inf], low.shape, p=[0.4, 0.3, 0.29, 0.01])
    asked = rng.integers(-5, 6, (6, dimension)) * 1.0
    gone = rng.permutation(number)[: number // 3]
    kept = np.setdiff1d(np.arange(number), gone)
    gap = np.maximum(np.maximum(low - asked[:, None], asked[:, None] - high), 0.0)[:, kept]
    square = np.sum(gap**2, axis=2)
    first = np.argsort(square, axis=1, kind="stable")[:, :count]
    for kind in TREES:
        tree = kind().build(low, high)
        tree.remove(gone)
        found, ids = tree.nearest(asked, count)
        there = min(count, len(kept))
        assert np.array_equal(ids[:, :there], kept[first])
        assert np.allclose(found[:, :there] ** 2, np.take_along_axis(square, first, axis=1), rtol=1e-14, atol=0)
        assert np.all(ids[:, there:] == -1)
        assert np.all(np.isinf(found[:, there:]))


def test_nearest_needs_a_positive_count():
    with pytest.raises(ValueError, match="at least 1"):
        KDTree().build(np.zeros((1, 3)), np.ones((1, 3))).nearest(np.zeros(3), 0)
