"""The survey of sprites: its truth is that of pixels one by one, and engines that are wrong are caught and shown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import pytest

from oracles.isolation.children import Said
from oracles.outcome import Run
from oracles.surveys.judging import SurveyCount, judged, question
from oracles.surveys.sprites import REGIMES, Pair, Sprites, common, mask_of, pair_of, rows_of
from oracles.surveys.sprites_engines import Reference
from oracles.surveys.survey import Case, SurveyEngine
from reports import markdown
from reports.reading import run_from_data
from reports.summary import report_data


class Exact(SurveyEngine):
    """Right: where a pixel lies in the other mask is looked up for all of them."""

    calls: ClassVar = "look-up"
    promise: ClassVar = "exact"

    def both(self, pair: Pair) -> np.ndarray[Any, Any]:
        (x, y), (height, width) = pair.offset, pair.b.shape
        rows, columns = (np.arange(n) - moved for n, moved in zip(pair.a.shape, (y, x), strict=True))
        framed = np.pad(pair.b, 1)
        found = framed[np.clip(rows, -1, height)[:, None] + 1, np.clip(columns, -1, width) + 1]
        return np.asarray(pair.a & found)

    def answer(self, case: Case) -> Any:
        both = self.both(pair_of(case.data))
        if case.question == "area":
            return int(both.sum())
        return next(((x, y) for y, x in np.argwhere(both)[-1:].tolist()), None)


class LastBitLost(Exact):
    """Wrong: of each word of 32 columns the last one is not looked at."""

    def both(self, pair: Pair) -> np.ndarray[Any, Any]:
        return super().both(pair) & (np.arange(pair.a.shape[1]) % 32 != 31)


class NegativeOffsets(Exact):
    """Wrong: an offset to the left is taken to be none."""

    def both(self, pair: Pair) -> np.ndarray[Any, Any]:
        return super().both(pair._replace(offset=(max(0, pair.offset[0]), pair.offset[1])))


class BoxesOnly(Exact):
    """Wrong: where boxes overlap, a pixel is claimed that may not be solid."""

    def both(self, pair: Pair) -> np.ndarray[Any, Any]:
        return super().both(Pair(np.ones_like(pair.a), np.ones_like(pair.b), pair.offset))


class Wraps(Exact):
    """Wrong: offsets are counted in 16 bits."""

    def both(self, pair: Pair) -> np.ndarray[Any, Any]:
        x, y = ((n + 2**15) % 2**16 - 2**15 for n in pair.offset)
        return super().both(pair._replace(offset=(x, y)))


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    return [case for case in Sprites().cases(0) if case.regime != "large"]


def pixel_by_pixel(pair: Pair) -> np.ndarray[Any, Any]:
    x, y = pair.offset
    other = {(row + y, column + x) for row, column in np.argwhere(pair.b).tolist()}
    return np.array([[bool(p) and (r, c) in other for c, p in enumerate(row)] for r, row in enumerate(pair.a)])


def verdicts(engine: SurveyEngine, cases: Sequence[Case]) -> list[SurveyCount]:
    def asker(some: Sequence[Case]) -> list[Said]:
        return [Said(engine.answer(case)) for case in some]

    return judged(Sprites(), "planted", engine, cases, asker)


def test_an_exact_engine_is_right_everywhere(cases: list[Case]) -> None:
    found = verdicts(Exact(), cases)
    assert {count.regime for count in found} == set(REGIMES) - {"large"}
    assert all(count.right == count.asked > 0 for count in found)
    small = [pair_of(case.data) for case in cases if case.question == "area"][:12]
    assert all(np.array_equal(common(pair), pixel_by_pixel(pair)) for pair in small)
    areas = [int(np.count_nonzero(common(pair_of(case.data)))) for case in cases]
    assert min(areas) == 0
    assert sum(area > 0 for area in areas) > len(areas) / 3


@pytest.mark.parametrize(
    ("engine", "pixels"), [(LastBitLost(), 2), (NegativeOffsets(), 2), (BoxesOnly(), 2), (Wraps(), 2)]
)
def test_a_wrong_engine_is_caught_and_shown_by_small_masks(
    engine: SurveyEngine, pixels: int, cases: list[Case]
) -> None:
    found = verdicts(engine, cases)
    assert any(count.wrong for count in found)
    assert not any(count.lost for count in found)
    shown = [witness for count in found for witness in count.witnesses]
    assert "area" in {witness.case.question for witness in shown}
    for witness in shown:
        pair = pair_of(witness.case.data)
        assert witness.judgement is not None
        assert witness.judgement.amount >= 1
        assert min(pair.a.size, pair.b.size) <= pixels, (pair.a.shape, pair.b.shape, pair.offset)
    run = Run(0, 1.0, "2026-01-01T00:00:00+00:00", surveys=found)
    again = run_from_data(report_data(run))
    assert report_data(again)["surveys"] == report_data(run)["surveys"]
    assert "b moved by" in markdown.render(run)


def test_masks_are_drawn_in_few_words() -> None:
    mask = np.zeros((600, 600), dtype=bool)
    mask[:300, 5:] = mask[599, :3] = True
    case = Case("area", "large", Pair(mask, np.ones((2, 8), dtype=bool), (3, -4)).data())
    a = "300 rows of .....#{595}, 299 rows of .{600}, ###.{597}"
    assert Sprites().written(case) == f"b moved by (3, -4); a (600 × 600): {a}; b (8 × 2): 2 rows of ########"
    empty = Case("area", "empty", Pair(mask[:0], np.ones((2, 0), dtype=bool), (0, 0)).data())
    assert Sprites().written(empty).endswith("a (600 × 0): no rows; b (0 × 2): 2 rows of nothing")


def test_this_project_s_sprites_and_pygame_s_are_found_right_and_a_report_says_of_what() -> None:
    pytest.importorskip("pygame")
    counts = [count for engine in Sprites.engines for count in question("sprites", engine, 1)[0]]
    assert all(count.right == count.asked > 0 for count in counts)
    said = markdown.render(Run(0, 1.0, "2026-01-01T00:00:00+00:00", surveys=counts))
    assert all(recipe.why in said for recipe in REGIMES.values())


def test_nonsense_is_lost_and_damaged_cases_are_refused(cases: list[Case]) -> None:
    survey = Sprites()
    area = next(case for case in cases if case.question == "area")
    for nonsense in (True, 1.5, "many", None):
        with pytest.raises(TypeError, match="whole number"):
            survey.judge(area, nonsense)
    good = rows_of(np.ones((2, 3), dtype=bool))
    assert np.array_equal(mask_of(good), np.ones((2, 3)))
    assert mask_of(rows_of(np.ones((2, 0), dtype=bool))).shape == (2, 0)
    for bad in ({"width": 2, "rows": ["#"]}, {"width": 1, "rows": ["x"]}, {"width": 9**9, "rows": []}, {"width": -1}):
        with pytest.raises((ValueError, LookupError)):
            survey.check(Case("area", "", {"a": good, "b": {"rows": [], **bad}, "offset": [0, 0]}))
    with pytest.raises(ValueError, match="32 bits"):
        survey.check(Case("area", "", {"a": good, "b": good, "offset": [0, 2**40]}))
    with pytest.raises(ValueError, match="no question"):
        survey.check(Case("perimeter", "", {"a": good, "b": good, "offset": [0, 0]}))


def test_the_reference_is_not_believed_where_its_own_answers_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    data = Pair(np.ones((2, 2), dtype=bool), np.ones((2, 2), dtype=bool), (1, 1)).data()
    monkeypatch.setattr("refimpl.flat.sprites.intersect", lambda a, b: False)
    with pytest.raises(AssertionError, match="first common pixel"):
        Reference().answer(Case("overlap", "", data))
