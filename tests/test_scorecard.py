"""The scorecard: known solids, transformations held against supports, and what could not be built."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from refimpl import (
    AABB,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Polyhedron,
    Proxy,
    ShapeError,
    Sphere,
    intersect,
    support,
)
from refimpl.construct import contains
from refimpl.construct.kinds import BOUNDING, COLLIDER, KINDS, MODEL, Kind
from refimpl.construct.scorecard import Score, Scorecard, scorecard, time_of_test
from refimpl.construct.survival import STRETCH, TRANSFORMATIONS, TURN, survives
from refimpl.linear import apply_inverse, norm, rotation_matrix
from reports import scorecards
from tests.solids import L_SHAPE, box, prism

CHEAP = (MODEL, "aabb", "sphere", "fast_sphere", "box", "capsule", "cylinder", "ellipsoid", "kdop18", "hull")
WAYS = np.random.default_rng(5).normal(size=(50, 3))


@pytest.fixture(scope="module", autouse=True)
def hurried() -> Iterator[None]:
    """Times are of few pairs here: how long they take is not asked."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("refimpl.construct.scorecard.ENOUGH", 1e-4)
        yield


@pytest.fixture(scope="module")
def cube() -> Scorecard:
    return scorecard(Polyhedron(*box()), CHEAP, name="cube")


@pytest.fixture(scope="module")
def bracket() -> Scorecard:
    return scorecard(Polyhedron(*prism(L_SHAPE)), ("aabb", "hull", "sphere"), name="bracket")


def of(card: Scorecard) -> Iterator[tuple[str, Score]]:
    return ((score.kind, score) for score in card.scores)


def test_a_cube_has_the_scores_that_a_calculation_gives(cube: Scorecard) -> None:
    by = dict(of(cube))
    assert cube.volume == 1
    assert cube.diagonal == pytest.approx(math.sqrt(3))
    for kind in ("aabb", "kdop18", "hull"):
        assert by[kind].volume_ratio == pytest.approx(1, rel=1e-9), kind
        assert max(by[kind].out, by[kind].back) < 1e-9
    ball = math.pi / 6 * 3**1.5
    assert by["sphere"].volume_ratio == pytest.approx(ball, rel=1e-9)
    assert by["ellipsoid"].volume_ratio == pytest.approx(ball, rel=1e-3)  # of a cube the least ellipsoid is the ball
    from_ball = ball_to_cube()
    assert by["sphere"].out == pytest.approx(from_ball, rel=0.02)
    assert [by[kind].numbers for kind in ("aabb", "sphere", "box", "capsule")] == [6, 4, 10, 7]
    assert all(score.test > 0 for score in cube.scores)
    assert all(score.build > 0 for score in cube.scores if score.kind != MODEL)


def ball_to_cube() -> float:
    """Mean distance of the points of the ball around the unit cube from the cube, by a grid of equal areas."""
    count = 40_000
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (1 + math.sqrt(5)) * np.arange(count)
    flat = np.sqrt(1 - z * z)
    points = math.sqrt(3) / 2 * np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1)
    return float(np.mean(norm(np.maximum(np.abs(points) - 0.5, 0))))


def test_what_is_around_a_dent_is_larger(bracket: Scorecard) -> None:
    by = dict(of(bracket))
    assert 1 < by["hull"].volume_ratio < by["aabb"].volume_ratio < by["sphere"].volume_ratio
    assert by["hull"].back > 0.01 * bracket.diagonal


@pytest.mark.parametrize("kind", [*CHEAP[1:], "union"])
def test_what_survives_is_the_set_that_it_should_be(cube: Scorecard, kind: str) -> None:
    """Supports of images: h(R A, n) = h(A, Rᵀ n), h(s A, n) = h(A, s n) by components, h(A + t, n) = h(A, n) + t·n."""
    proxy = (cube.proxies | SIMPLE)[kind]
    back = {
        "translation": support(proxy, WAYS) + WAYS @ [1.0, 2.0, 3.0],
        "rotation": support(proxy, apply_inverse(rotation_matrix(np.array(TURN)), WAYS)),
        "scaling": support(proxy, 2 * WAYS),
        "stretching": support(proxy, WAYS * STRETCH),
    }
    for name, why in survives(proxy).items():
        if not why:
            image = TRANSFORMATIONS[name](proxy)
            assert type(image) is type(proxy)
            assert support(image, WAYS) == pytest.approx(back[name], rel=1e-9), name
        else:
            assert {"union": "Box"}.get(kind, type(proxy).__name__) in why


def test_the_lecture_on_what_survives() -> None:
    lost = {kind: {name for name, why in survives(proxy).items() if why} for kind, proxy in SIMPLE.items()}
    assert lost == {"aabb": {"rotation"}, "sphere": {"stretching"}, "union": {"stretching"}}


SIMPLE = {
    "aabb": AABB([0, 0, 0], [1, 1, 1]),
    "sphere": Sphere([1, 2, 3], 1),
    "union": Composite([AABB([0, 0, 0], [1, 1, 1]).to_box(), Sphere([0, 0, 0], 1)]),
}


def test_bounding_volumes_contain_and_every_kind_is_for_something(cube: Scorecard) -> None:
    assert {kind.use for kind in KINDS.values()} == {MODEL, BOUNDING, COLLIDER}
    for kind, proxy in cube.proxies.items():
        if KINDS[kind].use == BOUNDING:
            assert contains(proxy, cube.model.vertices).all(), kind


def test_what_cannot_be_built_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Polyhedron) -> Sphere:
        raise ShapeError("there is none today")

    kinds = {MODEL: KINDS[MODEL], "broken": Kind("broken", BOUNDING, refuse)}
    monkeypatch.setattr("refimpl.construct.scorecard.KINDS", kinds)
    card = scorecard(Polyhedron(*box()), ("broken",))
    assert card.proxies == {}
    assert scorecards.table(card).rows[0][0].note == "there is none today"


def test_only_single_solids_of_moderate_size_are_scored() -> None:
    solid = Polyhedron(*box())
    with pytest.raises(ShapeError, match="there is no kind 'teapot'; there are model, aabb"):
        scorecard(solid, ("teapot",))
    with pytest.raises(ShapeError, match="a batch of shape"):
        scorecard(solid.broadcast_to((2,)), ())
    for exponent in (-400, 400):
        with pytest.raises(ShapeError, match="scale it first"):
            scorecard(solid.times_power(exponent), ())


def test_each_score_is_told_at_once() -> None:
    told: list[str] = []
    scorecard(Polyhedron(*box()), ("aabb", "sphere", "aabb"), each=lambda score: told.append(score.kind))
    assert told == ["aabb", "sphere"]


def test_the_time_is_that_of_one_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time is that of one pair, however many are asked together; of those, one in two meets, whatever the shape."""
    clock, answered = iter(range(1000)), []

    def counted(a: Proxy, b: Proxy) -> np.ndarray:
        answered.append(intersect(a, b))
        return answered[-1]

    monkeypatch.setattr("refimpl.construct.scorecard.time.process_time", lambda: float(next(clock)))
    monkeypatch.setattr("refimpl.construct.scorecard.intersect", counted)
    needle = Capsule([0, 0, 0], [100, 0, 0], 0.5)
    for proxy in (*SIMPLE.values(), needle, ConvexPolyhedron.from_vertices(WAYS), Polyhedron(*prism(L_SHAPE))):
        answered.clear()
        spent = time_of_test(proxy)
        drawn, first, second = answered
        assert spent == 1 / len(first)
        assert 8 <= len(first) == len(second) == 2 * np.sum(first) <= len(drawn) / 2


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(2.5, "2.5 s"), (0.0123, "12.3 ms"), (4.56e-6, "4.56 µs"), (3.1e-7, "310 ns"), (math.nan, "–")],
)
def test_times_have_their_unit(seconds: float, said: str) -> None:
    assert scorecards.time_in_words(seconds).replace("\u202f", " ") == said
