"""Moving triangles: the exact decider against 50 digits, known answers, brute force, and itself in other frames."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from mpmath import mp  # type: ignore[import-untyped]

from refimpl.proof.triangles import EdgeEdge, check_edge_edge, check_vertex_face
from refimpl.sweeps.triangles import Touch, edge_edge, vertex_face
from tests.moving import FAMILIES, Query, planar, whole
from tests.truth.moving import DIGITS, ZERO, distance, first_contact, placed
from tests.truth.rationals import real

DECIDE = {"vertex-face": vertex_face, "edge-edge": edge_edge}
CHECK = {"vertex-face": check_vertex_face, "edge-edge": check_edge_edge}
KINDS = tuple(DECIDE)
F = Fraction
TINY = F(1, 10**12)
FACE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def proven(kind: str, query: Query) -> Touch:
    """The answer, which its certificate proves."""
    found = DECIDE[kind](*query)
    low, high = CHECK[kind](found.certificate, *query)
    if found.hit:
        assert (low, high) == (found.low, found.high)
        assert 0 <= low <= high <= 1
        assert high - low <= TINY
    else:
        assert low == high == found.t == math.inf
    return found


def agrees(found: Touch, true: Any) -> bool:
    """Whether an answer is that of 50 digits."""
    if true is None or not found.hit:
        return (true is None) == (not found.hit)
    assert found.low is not None
    assert found.high is not None
    with mp.workdps(DIGITS):
        return bool(real(found.low) - ZERO <= true <= real(found.high) + ZERO)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("family", FAMILIES)
def test_the_answer_is_that_of_fifty_digits(kind: str, family: str) -> None:
    rng = np.random.default_rng([len(kind), *map(ord, family)])
    hits = []
    for _ in range(12 if family in ("planar", "carried", "in_line") else 30):  # where many more times are candidates
        query = FAMILIES[family](rng)
        found, true = proven(kind, query), first_contact(kind, *query)
        assert agrees(found, true), (query, found.t, true)
        hits.append(found.hit)
    assert any(hits)
    assert not all(hits)


@pytest.mark.parametrize("kind", KINDS)
def test_looking_at_many_times_finds_the_same(kind: str) -> None:
    rng = np.random.default_rng(8)
    seen = 0
    for name in ("small", "whole", "planar", "carried", "in_line", "at_rest", "meeting") * 2:
        start, end = FAMILIES[name](rng)
        found = DECIDE[kind](start, end)
        for time in (F(k, 16) for k in range(17)):
            touching = distance(kind, [placed(p, q, time) for p, q in zip(start, end, strict=True)]) < ZERO
            seen += touching
            assert not touching or (found.hit and time >= found.low)  # type: ignore[operator]
            if found.hit and found.low == found.high == time:
                assert touching
    assert seen > 20


def test_an_answer_without_one_kind_of_exclusion_is_seen_to_be_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EdgeEdge, "count", 4)  # only the volume and the axes
    rng = np.random.default_rng(1)
    queries = [whole(rng) for _ in range(40)]
    assert not all(agrees(edge_edge(*q), first_contact("edge-edge", *q)) for q in queries)


def permuted(query: Query, order: tuple[int, ...]) -> Query:
    start, end = query
    return [start[i] for i in order], [end[i] for i in order]


ORDERS = {
    "vertex-face": [(0, *order) for order in permutations((1, 2, 3))],
    "edge-edge": [(1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0)],
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_points_the_frame_and_the_direction_of_time_do_not_matter(kind: str) -> None:
    rng = np.random.default_rng(2)
    for draw in list(FAMILIES.values()) * 3:
        query = draw(rng)
        found = DECIDE[kind](*query)
        start, end = query
        reverse = DECIDE[kind](end, start)
        assert reverse.hit == found.hit
        if reverse.hit and found.hit:
            assert found.low <= 1 - reverse.low  # type: ignore[operator]  # the last contact is not before the first
        moved = [[[F(x) * F(3, 7) + F(1, 3) for x in p] for p in points] for points in query]
        stretched = [[[F(x) * F(2) ** n for x, n in zip(p, (-300, 0, 400), strict=True)] for p in q] for q in query]
        others = [permuted(query, order) for order in ORDERS[kind]]
        others += [
            (moved[0], moved[1]),
            (stretched[0], stretched[1]),
            ([p[::-1] for p in start], [p[::-1] for p in end]),
        ]
        for other in map(DECIDE[kind], *zip(*others, strict=True)):
            assert other.hit == found.hit
            if found.hit:
                assert max(found.low, other.low) <= min(found.high, other.high)  # type: ignore[type-var]


@pytest.mark.parametrize("kind", KINDS)
def test_a_motion_cut_in_two_has_the_contact_in_one_of_its_parts(kind: str) -> None:
    rng = np.random.default_rng(3)
    for draw in list(FAMILIES.values()) * 3:
        start, end = draw(rng)
        cut = F(int(rng.integers(1, 8)), 8)
        middle = [
            [F(x) + cut * (F(y) - F(x)) for x, y in zip(p, q, strict=True)] for p, q in zip(start, end, strict=True)
        ]
        found, early, late = (DECIDE[kind](*part) for part in ((start, end), (start, middle), (middle, end)))
        assert found.hit == (early.hit or late.hit)
        if early.hit:
            assert found.low <= cut * early.high  # type: ignore[operator]
            assert cut * early.low <= found.high  # type: ignore[operator]
        elif found.hit:
            assert found.high >= cut  # type: ignore[operator]
            assert found.low <= cut + (1 - cut) * late.high  # type: ignore[operator]


KNOWN: dict[str, tuple[str, list[list[float]], list[list[float]], float]] = {
    "straight through": ("vertex-face", [[0.25, 0.25, 1], *FACE], [[0.25, 0.25, -2], *FACE], 1 / 3),
    "at the very end": ("vertex-face", [[0.25, 0.25, 1], *FACE], [[0.25, 0.25, 0], *FACE], 1),
    "a little too short": ("vertex-face", [[0.25, 0.25, 1], *FACE], [[0.25, 0.25, 5e-324], *FACE], math.inf),
    "from the start": ("vertex-face", [[0.25, 0.25, 0], *FACE], [[0.25, 0.25, 1], *FACE], 0),
    "from a hair above the start": ("vertex-face", [[0.25, 0.25, 5e-324], *FACE], [[0.25, 0.25, 1], *FACE], math.inf),
    "through an edge": ("vertex-face", [[0.25, 0.75, 1], *FACE], [[0.25, 0.75, -1], *FACE], 0.5),
    "beside it by one ulp": (
        "vertex-face",
        [[math.nextafter(0.25, 1), 0.75, 1], *FACE],
        [[math.nextafter(0.25, 1), 0.75, -1], *FACE],
        math.inf,
    ),
    "through a corner": ("vertex-face", [[1, 0, 1], *FACE], [[1, 0, -3], *FACE], 0.25),
    "in the face's plane": ("vertex-face", [[-1, 0.5, 0], *FACE], [[1, 0.5, 0], *FACE], 0.5),
    "in the plane, along a side": ("vertex-face", [[-1, 0, 0], *FACE], [[3, 0, 0], *FACE], 0.25),
    "in the plane, past it": ("vertex-face", [[-1, 1.5, 0], *FACE], [[1, 1.5, 0], *FACE], math.inf),
    "on a face that is a segment": (
        "vertex-face",
        [[1, 1, 1], [0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[1, -1, -1], [0, 0, 0], [1, 0, 0], [2, 0, 0]],
        0.5,
    ),
    "all points one": ("vertex-face", [[1, 0, 0]] * 4, [[2, 0, 0]] * 4, 0),
    # the face turns about its first side; the vertex stays on the cubic's double root
    "a double root": (
        "vertex-face",
        [[0, 1, 1], [0, 0, 0], [4, 0, 0], [0, 4, 0]],
        [[0, 1, 1], [0, 0, 0], [4, 0, 0], [0, 4, 8]],
        0.5,
    ),
    "edges that cross": (
        "edge-edge",
        [[-1, 0, 1], [1, 0, 1], [0, -1, 0], [0, 1, 0]],
        [[-1, 0, -3], [1, 0, -3], [0, -1, 0], [0, 1, 0]],
        0.25,
    ),
    "ends that meet": (
        "edge-edge",
        [[0, 0, 1], [1, 0, 2], [0, 0, 0], [-1, 0, 0]],
        [[0, 0, -1], [1, 0, 0], [0, 0, 0], [-1, 0, 0]],
        0.5,
    ),
    "parallel, onto each other": (
        "edge-edge",
        [[0, 0, 1], [2, 0, 1], [1, 0, 0], [3, 0, 0]],
        [[0, 0, -1], [2, 0, -1], [1, 0, 0], [3, 0, 0]],
        0.5,
    ),
    "parallel, one past the other": (
        "edge-edge",
        [[0, 0, 1], [1, 0, 1], [2, 0, 0], [3, 0, 0]],
        [[0, 0, -1], [1, 0, -1], [2, 0, 0], [3, 0, 0]],
        math.inf,
    ),
    "one line, end to end": (
        "edge-edge",
        [[0, 0, 0], [1, 0, 0], [3, 0, 0], [4, 0, 0]],
        [[4, 0, 0], [5, 0, 0], [3, 0, 0], [4, 0, 0]],
        0.5,
    ),
    "two points": (
        "edge-edge",
        [[0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0]],
        [[3, 0, 0], [3, 0, 0], [0, 0, 0], [0, 0, 0]],
        0.25,
    ),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_answers(name: str) -> None:
    kind, start, end, t = KNOWN[name]
    found = proven(kind, (start, end))
    assert found.t == pytest.approx(t, abs=1e-12)
    for power in (-900, 700):  # of two: the same scene, near the ends of what a double can be
        scale = F(2) ** power
        scaled = [[[scale * F(x) for x in p] for p in q] for q in (start, end)]
        assert proven(kind, (scaled[0], scaled[1])).t == found.t


@pytest.mark.parametrize("power", [1, 2, 3])
def test_roots_of_every_multiplicity(power: int) -> None:
    """The cubic is a multiple of (1 − 2t)ⁿ: n coordinates of the corners, as seen from the vertex, are of 1 − 2t."""
    corners = np.array([[1, 1, 0], [1, 0, 1], [1, -1, -1]])
    signs = np.where(np.arange(3) < power, -1, 1)
    query = [[0, 0, 0], *corners.tolist()], [[0, 0, 0], *(corners * signs).tolist()]
    found = proven("vertex-face", query)
    assert found.t == pytest.approx(0.5, abs=1e-12)
    start, end = query
    early = [[F(99, 200) * (F(y) - x) + x for x, y in zip(p, q, strict=True)] for p, q in zip(start, end, strict=True)]
    assert not proven("vertex-face", (start, early)).hit


WRONG: list[tuple[Any, type[Exception], str]] = [
    ([[0, 0, 0]] * 3, ValueError, "start: must be 4 points"),
    ([[0, 0]] * 4, ValueError, "start: must be 4 points"),
    ([[0, 0, math.nan]] * 4, ValueError, "start: must be finite"),
    ([[0, 0, math.inf]] * 4, ValueError, "start: must be finite"),
    ([[0, 0, "1"]] * 4, TypeError, "start: '1' is not"),
]


@pytest.mark.parametrize(("start", "error", "text"), WRONG)
def test_bad_input_is_named(start: Any, error: type[Exception], text: str) -> None:
    for decide in DECIDE.values():
        with pytest.raises(error, match=text):
            decide(start, [[0, 0, 0]] * 4)


def test_arrays_are_read_as_their_numbers() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        start, end = planar(rng)
        for kind in (np.float64, np.float32, np.int64):
            assert edge_edge(np.array(start, kind), np.array(end, kind)) == edge_edge(start, end)
