"""The kernels of unions: pairs of atoms against the pair table, bounds against distances, trees against all pairs."""

import numpy as np
import pytest

from refimpl import Composite, HalfSpace, Point, Polyhedron, Sphere, distance, intersect
from refimpl.kernels import atom_pairs, atoms, nearby
from refimpl.kernels import unions as kernels
from refimpl.scenes import Scenes
from tests.test_unions import KINDS, make, size_of

PARTS = [kind for kind in KINDS if kind not in (Point, Composite)]


def scene_of(a, b, row=0):
    """A scene of plain lists, prepared."""
    there = Scenes(a[row : row + 1], b[row : row + 1])
    scene = kernels.scene_of(there.batch, 0)
    nearby.prepare(scene)
    return scene, 2.0 ** float(there.exponent[0])


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Kernels as Python runs them."""
    monkeypatch.setattr("refimpl.compiling._in_use", set())


def pairs_of_kinds():
    return [(a, b) for a in PARTS for b in PARTS if a is not Polyhedron and b is not Polyhedron]


@pytest.mark.parametrize(("kind_a", "kind_b"), pairs_of_kinds(), ids=lambda kind: kind.__name__)
def test_a_pair_of_atoms_is_answered_as_by_the_table(kind_a, kind_b):
    rng = np.random.default_rng(11)
    a, b = make(kind_a, rng, 1.0, 6), make(kind_b, rng, 1.0, 6)
    moves = rng.normal(size=(6, 3))
    wanted = distance(a, b.translated(moves))
    for row in range(6):
        scene, unit = scene_of(Composite([a]), Composite([b]), row)
        sigma, n, x, y = atom_pairs.answer(scene, 0, 0, tuple(moves[row] / unit), (0.0, 0.0, 0.0))
        size = size_of(a, b)[row] + np.abs(moves[row]).max()
        if np.isinf(wanted.distance[row]):
            assert sigma == wanted.distance[row]
            continue
        assert abs(unit * sigma - wanted.distance[row]) <= 1e-12 * size
        gap = unit * (np.array(y) - np.array(x)) - unit * sigma * np.array(n)
        assert np.all(np.abs(gap) <= 2e-12 * size)
        assert np.all(np.abs(np.array(n) - wanted.normal[row]) <= 1e-6)  # generic pairs have one normal


@pytest.mark.parametrize(("kind_a", "kind_b"), pairs_of_kinds(), ids=lambda kind: kind.__name__)
def test_bounds_are_below_the_distance_and_close(kind_a, kind_b):
    rng = np.random.default_rng(12)
    a, b = make(kind_a, rng, 1.0, 6), make(kind_b, rng, 1.0, 6)
    for row in range(6):
        scene, _ = scene_of(Composite([a]), Composite([b]), row)
        for move in rng.normal(size=(4, 3)).tolist():
            sigma, n, _, _ = atom_pairs.answer(scene, 0, 0, tuple(move), (0.0, 0.0, 0.0))
            assert nearby.box_gap(scene, 0, 0, tuple(move)) <= max(sigma, 0.0)
            for way in rng.normal(size=(4, 3)):
                unit = tuple((way / np.linalg.norm(way)).tolist())
                assert atoms.support_gap(scene, 0, 0, tuple(move), unit) <= sigma + 1e-13
            if np.isfinite(sigma):  # the distance is the widest gap, along its normal
                assert atoms.support_gap(scene, 0, 0, tuple(move), n) == pytest.approx(sigma, abs=1e-12)


def test_half_spaces_that_face_are_told_from_those_that_nearly_do():
    slab = Composite([HalfSpace([1, 2, 3], 1.0), HalfSpace([-1, -2, -3], 4.0)])
    facing, nearly = HalfSpace([-2, -4, -6], 12.0), HalfSpace([-2, -4, np.nextafter(-6, 0)], 12.0)
    scene, unit = scene_of(slab.broadcast_to((1,)), Composite([facing]).broadcast_to((1,)))
    sigma, n, _, _ = atom_pairs.answer(scene, 0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert unit * sigma == pytest.approx(7 / np.sqrt(14), abs=1e-14)
    assert np.allclose(n, np.array([1, 2, 3]) / np.sqrt(14), atol=1e-15)
    assert atom_pairs.answer(scene, 1, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[0] == -np.inf
    scene, _ = scene_of(slab.broadcast_to((1,)), Composite([nearly]).broadcast_to((1,)))
    assert atom_pairs.answer(scene, 0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[0] == -np.inf


def many(rng, count, kinds=(Sphere,)):
    """A union of small parts all over a cube."""
    parts = [make(kinds[i % len(kinds)], rng, 0.1, 1).scaled(0.2) for i in range(count)]
    return Composite([part.translated(rng.uniform(-2, 2, 3)) for part in parts])


@pytest.mark.parametrize(("count_a", "count_b"), [(1, 100), (100, 1), (9, 8), (33, 70), (64, 5)])
def test_trees_find_the_pairs_that_are_near(count_a, count_b):
    rng = np.random.default_rng(13)
    scene, _ = scene_of(many(rng, count_a), many(rng, count_b))
    for within in (0.0, 0.05, 0.3, np.inf):
        move = tuple(rng.uniform(-0.5, 0.5, 3).tolist())
        listed = [0] * (count_a * count_b)
        count = nearby.near(scene, move, within, listed)
        wanted = [
            key
            for key in range(count_a * count_b)
            if nearby.box_gap(scene, key // count_b, key % count_b, move) <= within
        ]
        assert sorted(listed[:count]) == wanted
        short = [-1, -1]
        assert nearby.near(scene, move, within, short) == count


@pytest.mark.parametrize("spread", [0.0, 3.5, 6.0])
@pytest.mark.parametrize("room", [1, 64, 4096])
def test_the_nearest_of_many_atoms(spread, room, monkeypatch):
    monkeypatch.setattr("refimpl.scenes.MOST_PAIRS", room)
    rng = np.random.default_rng(14)
    for _ in range(4):
        a, b = many(rng, 12, PARTS[:2]), many(rng, 15, PARTS[1:2]).translated([spread, 0, 0])
        least = min(float(distance(x[0], y[0]).distance) for x in a.parts for y in b.parts)
        found = distance(a[0], b[0]).distance
        if least > 0:
            assert abs(found - least) <= 1e-14 * size_of(a, b)[0]
        else:
            assert found <= least + 1e-13


def test_empty_batches_have_empty_answers():
    rng = np.random.default_rng(15)
    for kind in PARTS:
        a, b = make(kind, rng, 1.0, 2)[:0], make(Composite, rng, 1.0, 2)[:0]
        assert distance(a, b).distance.shape == (0,)
        assert distance(a, b).normal.shape == (0, 3)
        assert intersect(b, a).shape == (0,)
