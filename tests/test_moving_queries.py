"""The command that decides the literature's queries from files, and the method that it compares with."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks import queries
from tests.benchmarks.conservative import collides
from tests.moving import FAMILIES, Query
from tests.test_moving_triangles import DECIDE, KNOWN


def rows(query: Query, truth: str = "") -> str:
    """A query as rows of the benchmark's files."""
    numbers = [[x.as_integer_ratio() for x in p] for points in query for p in points]
    return "".join(",".join(f"{p},{q}" for p, q in point) + truth + "\n" for point in numbers)


def known(name: str) -> Query:
    _, start, end, _ = KNOWN[name]
    return start, end


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("one/vertex-face", "two/queries", "two/mma_bool"):
        (tmp_path / name).mkdir(parents=True)
    text = rows(known("straight through"), ",1") + rows(known("beside it by one ulp"), ",0")
    (tmp_path / "one/vertex-face/data_0_0.csv").write_text(text)
    (tmp_path / "two/queries/0ee.csv").write_text(rows(known("edges that cross")))
    (tmp_path / "two/mma_bool/0ee_mma_bool.json").write_text(json.dumps([True]))
    return tmp_path


def test_the_queries_of_a_folder_are_decided(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    queries.main([str(folder), "--conservative"])
    total = [word for word in capsys.readouterr().out.splitlines()[-2].split() if word not in "│┃"]
    assert total[:5] == ["all", "3", "2", "0", "0"]
    assert total[6:8] == ["1", "0"]  # the conservative method says "collision" one ulp beside


def test_a_wrong_ground_truth_shows(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "two/mma_bool/0ee_mma_bool.json").write_text(json.dumps([False]))
    queries.main([str(folder)])
    assert "all 3 1 1 0" in " ".join(capsys.readouterr().out.replace("│", " ").split())


BAD = {
    "seven rows": (rows(known("straight through"), ",1").split("\n", 1)[1], "multiple of 8"),
    "half a row": (rows(known("straight through"), ",1")[:-8], "line 8: expected"),
    "a word": ("a" + rows(known("straight through"), ",1"), "line 1: expected 6 whole numbers"),
    "over 0": (rows(known("straight through"), ",1").replace("1,4", "1,0"), "line 1: expected"),
    "too long": ("1" * 401 + rows(known("straight through"), ",1"), "line 1: expected"),
    "two truths": (rows(known("straight through"), ",1")[:-2] + "0\n", "no ground truth"),
    "no truth": (rows(known("straight through")), "no ground truth"),
    "not in ASCII": ("é", "cannot read"),
}


@pytest.mark.parametrize("what", BAD)
def test_a_file_in_another_format_is_named(what: str, tmp_path: Path) -> None:
    (tmp_path / "vertex-face").mkdir()
    text, said = BAD[what]
    (tmp_path / "vertex-face/data.csv").write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit, match=said):
        queries.main([str(tmp_path)])


def test_a_folder_without_queries_is_said(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="no file"):
        queries.main([str(tmp_path)])
    with pytest.raises(SystemExit, match="usage"):
        queries.main([str(tmp_path / "none")])
    (tmp_path / "ee.csv").write_text("")
    with pytest.raises(SystemExit, match="no queries"):
        queries.main([str(tmp_path)])


def test_the_conservative_method_misses_nothing_and_says_too_much() -> None:
    rng = np.random.default_rng(6)
    falsely = 0
    for name in ("small", "whole", "generic", "at_rest", "thirds", *["nudged"] * 5):
        query = FAMILIES[name](rng)
        for kind, decide in DECIDE.items():
            hit, said = decide(*query).hit, collides(kind, *query)
            assert said or not hit
            falsely += said and not hit
    assert 0 < falsely < 8
