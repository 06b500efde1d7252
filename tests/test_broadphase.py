"""Every broad-phase structure answers what a double loop answers, whatever the boxes, before and after changes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from refimpl.broadphase import (
    STRUCTURES,
    ArrayGrid,
    BroadPhase,
    BruteForce,
    ColumnSweep,
    HashGrid,
    SortAndSweep,
    ranges,
    slabs,
)
from refimpl.broadphase.protocol import Candidates
from refimpl.linear import Array
from refimpl.signs import Indices
from tests.crowds_of_boxes import Model, crowds, pairs_of, ray_meets

MAKES: dict[str, Callable[[], BroadPhase]] = {
    **{name: row.make for name, row in STRUCTURES.items()},
    "array grid, plain": lambda: ArrayGrid(0.7, levels=1),
    "hash grid, plain": lambda: HashGrid(1.3, levels=1),
    "hash grid of small cells": lambda: HashGrid(0.1, levels=3),
    "column sweep of small cells": lambda: ColumnSweep(0.3, levels=4),
}


def all_structures() -> list[BroadPhase]:
    return [make() for make in MAKES.values()]


def check_changes(structures: list[BroadPhase], data: st.DataObject) -> None:
    """Build, move, remove and insert, and hold every step against the model."""
    dimension = data.draw(st.sampled_from([2, 3]))
    some = crowds(dimension)
    lower, upper = data.draw(some)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    model = Model(structures, lower, upper, rng.random(len(lower)) < data.draw(st.sampled_from([0.0, 0.5, 1.0])))
    model.check(*data.draw(crowds(dimension, 3)))
    for _ in range(3):
        ids = sorted(model.boxes)
        moved = [i for i in ids if rng.random() < rng.choice([0.1, 0.9])]
        step = rng.choice([0.0, 0.1, 10.0], (len(moved), 1)) * np.ones(dimension)
        with np.errstate(over="ignore"):
            boxes = [np.array([model.boxes[i][k] for i in moved]).reshape(-1, dimension) + step for k in (0, 1)]
        model.update(moved, *boxes)
        model.check(*data.draw(crowds(dimension, 2)))
        gone = [i for i in ids if rng.random() < 0.2]
        model.remove(gone)
        model.insert(*data.draw(crowds(dimension, 4)), static=bool(rng.integers(2)))
        model.check(*data.draw(crowds(dimension, 2)))


@given(st.data())
def test_every_structure_is_equal_to_a_double_loop_through_all_changes(data: st.DataObject) -> None:
    check_changes(all_structures(), data)


class Open(HashGrid):
    """Wrong: touching does not count along the last axis."""

    def pairs(self) -> Indices:
        found = super().pairs()
        i, j = np.searchsorted(self.ids, found).T
        return found[(self.lower[i, -1] < self.upper[j, -1]) & (self.lower[j, -1] < self.upper[i, -1])]


class Forgetful(SortAndSweep):
    """Wrong: what has moved is looked for where it was."""

    def _updated(self, rows: Indices) -> None:
        """Forget."""


class Narrow(ColumnSweep):
    """Wrong: queries do not look into the column before."""

    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        return super()._near_boxes(np.minimum(lower + 1, upper), upper)


class Twofold(BruteForce):
    """Wrong: ids of removed objects are given again."""

    def remove(self, ids: object) -> None:
        super().remove(ids)
        self._next = int(self.ids[-1]) + 1 if len(self.ids) else 0


@pytest.mark.parametrize("wrong", [Open, Forgetful, Narrow, Twofold])
def test_the_check_tells_what_is_wrong(wrong: type[BroadPhase]) -> None:
    @settings(phases=[Phase.generate])
    @given(st.data())
    def check(data: st.DataObject) -> None:
        check_changes([wrong()], data)

    with pytest.raises(AssertionError):
        check()


# -- rays ------------------------------------------------------------------------------------------------------

TIMES = st.sampled_from([0.0, 0.5, 1.0, 3.0, 1e9, np.inf])
COORDINATES = st.sampled_from([0.0, 1.0, -1.0, 0.5, 1 / 3, 3.0, 1e6, 1e-8, -7.0])


@given(st.data())
def test_rays_meet_what_separating_axes_in_rational_numbers_say(data: st.DataObject) -> None:
    dimension = data.draw(st.sampled_from([2, 3]))
    vectors = st.lists(st.tuples(*[COORDINATES] * dimension), min_size=4, max_size=4)
    a, b, origin = (np.array(data.draw(vectors)) for _ in range(3))
    direction = np.array(data.draw(st.lists(st.tuples(*[COORDINATES] * dimension).filter(any), min_size=4, max_size=4)))
    length = np.array(data.draw(st.lists(TIMES, min_size=4, max_size=4)))
    low, up = np.minimum(a, b), np.maximum(a, b)
    expected = [
        [q, i]
        for q in range(4)
        for i in range(4)
        if ray_meets(origin[q].tolist(), direction[q].tolist(), float(length[q]), low[i].tolist(), up[i].tolist())
    ]
    for structure in all_structures():
        found = structure.build(low, up).query_rays(origin, direction, length)
        assert found.tolist() == expected, type(structure).__name__


def test_grazing_rays_are_decided_exactly() -> None:
    """Through the corner of a box at thirds, and past it by less than a time is rounded."""
    third = 1 / 3
    corner, direction = [third, third, third], [[1.0, 1.0, 1.0]]
    for structure in all_structures():
        structure.build([corner], [[1.0, third, 1.0]])
        assert len(structure.query_rays([[0.0, 0.0, 0.0]], direction)) == 1
        assert len(structure.query_rays([[0.0, 5e-17, 0.0]], direction)) == 0


def test_slabs_alone_would_get_some_of_the_grazing_rays_wrong() -> None:
    rng = np.random.default_rng(7)
    corner, way = rng.random((500, 3)), rng.random((500, 3)) / 3
    origin = corner - way  # rounded: some rays pass the edge by it
    box = corner, corner + np.eye(3)[0]
    length = np.full(500, np.inf)
    exact = slabs.rays_meet(origin, way, length, *box)
    near = np.max((box[0] - origin) / way, axis=1)
    plain = near <= np.min((box[1] - origin) / way, axis=1)
    assert np.all(slabs.rays_may_meet(origin, way, length, *box) | ~exact)
    assert 0 < np.count_nonzero(exact) < 500
    assert np.any(plain != exact)


@pytest.mark.parametrize("name", MAKES)
def test_rays_beyond_the_range_of_doubles(name: str) -> None:
    """Sums and quotients overflow, and answers do not change."""
    huge = 1.7e308
    structure = MAKES[name]().build(
        [[huge, -1, -1], [-huge, 5, 5], [-np.inf, -1, -1]], [[huge, 1, 1], [huge, 6, 6], [1, 1, np.inf]]
    )
    found = structure.query_rays([[-huge, 0, 0]], [[1e-300, 0, 0]])
    assert found.tolist() == [[0, 0], [0, 2]]
    assert structure.query_rays([[-huge, 0, 0]], [[1e300, 0, 0]], 1e5).tolist() == [[0, 2]]


# -- crowds that are no toys -------------------------------------------------------------------------------------


def crowd(kind: str, n: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(11)
    side = (n / 0.75) ** (1 / 3)
    center, half = rng.random((n, 3)) * side, np.full((n, 1), 0.5)
    if kind == "two clusters":
        center[::2] += 1e12
        half = half * (center[:, :1] < 1e6)
    elif kind == "outlier":
        center[0] = 1e12
    elif kind == "sizes":
        half = 10.0 ** -rng.uniform(0.3, 4, (n, 1))
    elif kind == "points":
        half = half * 0
    elif kind == "flat":
        center[:, 2] = 0
        center[:, :2] *= n ** (1 / 6)
    elif kind == "line":
        center *= [n ** (2 / 3), 0, 0]
    elif kind == "few giants":
        half[: n // 50] *= 4 * side
    return center - half, center + half


KINDS = ("even", "two clusters", "outlier", "sizes", "points", "flat", "line", "few giants")
LARGE = 1000


@pytest.fixture(scope="module")
def truths() -> dict[str, set[tuple[int, int]]]:
    """Pairs by intervals of the first axis in a dictionary of sets: neither tiles nor trees nor cells."""
    found = {}
    for kind in KINDS:
        lower, upper = crowd(kind, LARGE)
        by_axis = []
        for k in range(3):
            order = np.argsort(lower[:, k], kind="stable")
            ends = np.searchsorted(lower[order, k], upper[order, k], side="right")
            by_axis.append((ends - np.arange(LARGE), k, order, ends))
        _, k, order, ends = min(by_axis, key=lambda row: int(row[0].sum()))
        pairs = set()
        for place, i in enumerate(order.tolist()):
            run = order[place + 1 : ends[place]]
            met = run[np.all((lower[i] <= upper[run]) & (lower[run] <= upper[i]), axis=1)]
            pairs |= {(min(i, j), max(i, j)) for j in met.tolist()}
        found[kind] = pairs
    return found


@pytest.mark.parametrize("name", STRUCTURES)
def test_large_crowds(name: str, truths: dict[str, set[tuple[int, int]]]) -> None:
    for kind in KINDS:
        lower, upper = crowd(kind, LARGE)
        found = STRUCTURES[name].make().build(lower, upper).pairs()
        assert {tuple(pair) for pair in found.tolist()} == truths[kind], kind
        assert np.all(np.diff(found @ [LARGE, 1]) > 0), "sorted, each once"


@pytest.mark.parametrize("make", [HashGrid, ColumnSweep])
def test_cells_of_their_own_choice_propose_few_candidates(
    make: type[BroadPhase], truths: dict[str, set[tuple[int, int]]]
) -> None:
    """Wherever objects are and whatever their sizes: no more than a constant for each object and each pair."""
    for kind in KINDS:
        structure = make().build(*crowd(kind, LARGE))
        proposed = sum(len(i) for i, _ in structure._near_pairs())
        assert proposed <= 40 * LARGE + 12 * len(truths[kind]), kind


def test_memory_of_grids() -> None:
    """An array has memory for empty cells, a hash for its objects only."""
    lower, upper = crowd("even", LARGE)
    sizes = [2.0, 1.0, 0.5]
    array = [ArrayGrid(size, levels=1).build(lower, upper).memory for size in sizes]
    assert [grid.cell_size for grid in (ArrayGrid().build(lower, upper), HashGrid().build(lower, upper))] == [
        pytest.approx(1.1, 0.05)
    ] * 2
    assert array[0] < array[1] < array[2]
    far = np.array([[1e9], [0.0]]) * np.ones(3)
    assert (
        HashGrid(0.5, levels=1).build(far, far + 1).memory < 4000 < ArrayGrid(0.5, levels=1).build(far, far + 1).memory
    )


@pytest.mark.parametrize("name", STRUCTURES)
def test_candidates_come_in_pieces(name: str) -> None:
    """The memory of a question is that of its answer and of a piece, not of all candidates."""
    lower, upper = crowd("flat", 4000)
    structure = STRUCTURES[name].make().build(lower, upper)
    assert max(len(i) for i, _ in structure._near_pairs()) <= ranges.PIECE


def test_pieces_and_shares_cut_runs_and_lose_nothing() -> None:
    rng = np.random.default_rng(3)
    start, count = rng.integers(0, 100, 50), rng.integers(0, 20, 50) * (rng.random(50) < 0.5)
    whole = [(k, start[k] + t) for k in range(50) for t in range(count[k])]
    assert list(zip(*(x.tolist() for x in ranges.written_out(start, count)), strict=True)) == whole
    for most in (1, 7, 1000):
        parts = list(ranges.pieces(start, count, most))
        assert [pair for a, b in parts for pair in zip(a.tolist(), b.tolist(), strict=True)] == whole
        assert all(0 < len(a) <= most for a, _ in parts)
        cut = list(ranges.shares(count, most))
        assert [s.start for s in cut] == [0, *(s.stop for s in cut[:-1])]
        assert cut[-1].stop == 50
        assert all(count[s].sum() <= most or s.stop - s.start == 1 for s in cut)
        assert all(a.stop == b.start for a, b in pairwise(cut))
    assert list(ranges.pieces(start[:0], count[:0])) == []


# -- the protocol ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MAKES)
def test_touching_counts_and_static_pairs_do_not(name: str) -> None:
    structure = MAKES[name]().build([[0, 0], [1, 1], [2, 0]], [[1, 1], [2, 2], [3, 1]], [True, False, True])
    assert structure.pairs().tolist() == [[0, 1], [1, 2]]
    assert structure.query_points([[1, 1], [9, 9]]).tolist() == [[0, 0], [0, 1]]
    assert structure.dimension == 2
    assert structure.build(np.zeros((2, 3)), np.zeros((2, 3)), True).pairs().tolist() == []
    assert structure.build(np.zeros((2, 3)), np.zeros((2, 3))).pairs().tolist() == [[0, 1]]


@pytest.mark.parametrize("name", MAKES)
def test_none_at_all(name: str) -> None:
    structure = MAKES[name]()
    for empty in (structure, MAKES[name]().build(np.empty((0, 3)), np.empty((0, 3)))):
        assert empty.pairs().shape == (0, 2)
        assert empty.pairs().dtype == np.int64
        assert empty.query_boxes([[0, 0, 0]], [[1, 1, 1]]).shape == (0, 2)
        assert empty.query_rays([[0, 0, 0]], [[1, 1, 1]]).shape == (0, 2)
    assert structure.insert([0, 0], [1, 1]).tolist() == [0]
    structure.remove([0])
    assert structure.insert([0, 0], [1, 1]).tolist() == [1]
    assert structure.query_points([0.5, 1]).tolist() == [[0, 1]]


NAN = float("nan")


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda s: s.build([[0, 0, NAN]], [[1, 1, 1]]), "lower must not be NaN.*index 0"),
        (lambda s: s.build([[0, 0, 0], [0, 2, 0]], [[1, 1, 1]] * 2), "above upper.*2.0.*index 1"),
        (lambda s: s.build([[0, 0, np.inf]], [[1, 1, np.inf]]), "finite point"),
        (lambda s: s.build([[0.0] * 4], [[1.0] * 4]), r"\(N, 2 or 3\)"),
        (lambda s: s.build([[0, 0, 0]], [[1, 1, 1]] * 2), "differ in shape"),
        (lambda s: s.build([["a", 0, 0]], [[1, 1, 1]]), "real numbers"),
        (lambda s: s.build([[0, 0, 0]], [[1, 1, 1]], [1]), "booleans"),
        (lambda s: s.build([[0, 0, 0]], [[1, 1, 1]], [True, False]), "1 flags"),
        (lambda s: s.insert([[0, 0]], [[1, 1]]), r"\(N, 3\)"),
        (lambda s: s.update([0], [[0, 0, 0]] * 2, [[1, 1, 1]] * 2), "1 ids, but 2 boxes"),
        (lambda s: s.update([0, 0], [[0, 0, 0]] * 2, [[1, 1, 1]] * 2), "twice"),
        (lambda s: s.query_points([[0, 0, np.inf]]), "points must be finite"),
        (lambda s: s.query_rays([[0, 0, 0]], [[0, 0, 0]]), "direction must not be zero"),
        (lambda s: s.query_rays([[0, 0, NAN]], [[1, 0, 0]]), "origin must be finite"),
        (lambda s: s.query_rays([[0, 0, 0]], [[1, 0, 0]], -1), "length must be at least 0"),
        (lambda s: s.query_rays([[0, 0, 0]], [[1, 0, 0]], NAN), "length must be at least 0"),
        (lambda s: s.query_rays([[0, 0, 0]], [[1, 0, 0]], [1, 2]), "length: expected 1"),
        (lambda _: HashGrid(0.0), "cell must lie between"),
        (lambda _: ArrayGrid(levels=0), "levels must be at least 1"),
    ],
)
def test_bad_input_is_named(call: Callable[[BroadPhase], object], says: str) -> None:
    for make in (BruteForce, HashGrid, SortAndSweep):
        structure = make().build([[0, 0, 0]], [[1, 1, 1]])
        with pytest.raises(ValueError, match=says):
            call(structure)
        assert structure.lower.tolist() == [[0, 0, 0]], "unchanged"


def test_ids_that_are_not_there() -> None:
    structure = HashGrid().build([[0, 0]] * 3, [[1, 1]] * 3)
    structure.remove([1])
    for call in (structure.remove, lambda ids: structure.update(ids, [[0, 0]], [[1, 1]])):
        for gone in (1, 3, -1):
            with pytest.raises(LookupError, match=f"no object with id {gone}"):
                call([gone])
    with pytest.raises(TypeError, match="integers"):
        structure.remove([0.5])


def test_the_table_has_every_structure() -> None:
    rows = {row.make for row in STRUCTURES.values()}
    assert len(rows) == len(STRUCTURES)
    assert rows >= {BruteForce, ArrayGrid, HashGrid, SortAndSweep, ColumnSweep}
    assert all(row.idea and row.when and row.cost for row in STRUCTURES.values())


def test_pairs_of_the_plain_loop_on_a_case_done_by_hand() -> None:
    lower = np.array([[0.0, 0], [1, 1], [5, 5], [-np.inf, 5]])
    upper = np.array([[1.0, 1], [2, 2], [5, 5], [np.inf, 6]])
    assert pairs_of(lower, upper, [False] * 4) == [(0, 1), (2, 3)]
