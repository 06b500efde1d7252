"""The benchmark of the broad phase: its tables have the rows and columns that they should, its fits are right."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import reports.studies
from refimpl.broadphase import STRUCTURES
from tests.benchmarks import broadphase, broadphase_page, rivals
from tests.benchmarks.broadphase import RADIUS, Course, Results

pytest.importorskip("matplotlib")
HERE = Path(str(reports.studies.__file__)).parent


@pytest.fixture(scope="module")
def results() -> Results:
    return Results(
        broadphase.measure((30, 100), repeats=1),
        broadphase.measure_moves(100, repeats=1),
        broadphase.measure_cells(100, (0.5, 2.0), repeats=1),
    )


def rows_of(table: str) -> list[list[str]]:
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]


def test_all_structures_and_libraries_find_the_same_pairs(results: Results) -> None:
    """Those of boxes; of balls there are fewer."""
    center = broadphase.crowd(100)
    apart = np.abs(center[:, None] - center)
    boxes = np.count_nonzero(np.triu(np.max(apart, axis=-1) <= 2 * RADIUS, 1))
    balls = np.count_nonzero(np.triu(np.linalg.norm(center[:, None] - center, axis=-1) <= 2 * RADIUS, 1))
    assert balls < boxes
    assert {course.name for course in results.courses} == set(STRUCTURES) | set(rivals.available())
    for course in results.courses:
        assert course.pairs[100] == (balls if course.name.endswith("balls") else boxes), course.name


def test_exponents_are_fitted() -> None:
    course = Course("some")
    for n in (10, 10_000, 100_000, 1_000_000):
        course.note("pairs", n, 3e-9 * n**1.5)
        course.note("pairs", n, 1.0 * n**1.5)
    assert course.exponent("pairs") == pytest.approx(1.5)
    assert course.exponent("pairs", least=10) == pytest.approx(1.5)
    assert math.isnan(course.exponent("build"))
    assert course.total(10) == math.inf


def test_who_takes_too_long_is_not_asked_again() -> None:
    assert all(set(course.pairs) == {20} for course in broadphase.measure((20, 40), patience=0.0, repeats=1))


def test_the_page_has_its_tables_and_plots(results: Results, tmp_path: Path) -> None:
    broadphase_page.write(results, tmp_path)
    text = (tmp_path / broadphase_page.PAGE).read_text(encoding="utf-8")
    for picture in re.findall(r"\((\w+\.svg)\)", text):
        root = ElementTree.parse(tmp_path / picture).getroot()
        assert root.tag.endswith("svg")
        assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 20
    compared, growth, moving, cells = (part for part in text.split("\n\n") if part.startswith("|"))
    names = [row[0].strip("*") for row in rows_of(compared)[2:]]
    assert sorted(names) == sorted(course.name for course in results.courses)
    both = [float(row[3]) for row in rows_of(compared)[2:]]
    assert both == sorted(both)
    assert [row[0] for row in rows_of(growth)[2:]] == [course.name for course in results.courses]
    assert rows_of(growth)[0][4:] == ["3e+01", "1e+02"]
    assert [row[0] for row in rows_of(moving)[2:]] == list(STRUCTURES)
    assert len(rows_of(cells)) == 2 + 2 * (2 + 1)
    assert all(
        len(row) == len(rows_of(table)[0]) for table in (compared, growth, moving, cells) for row in rows_of(table)
    )


def test_small_cells_take_memory(results: Results) -> None:
    for name in ("array grid", "hash grid"):
        small, large, chosen = (row for row in results.cells if row.name == name)
        assert small.memory > large.memory
        assert (small.size, large.size, chosen.chosen) == (0.5, 2.0, True)


def test_the_page_that_is_kept_knows_every_structure() -> None:
    """Its numbers are those of the machine on which it was made."""
    text = (HERE / broadphase_page.PAGE).read_text(encoding="utf-8")
    again = "stale: run python -m tests.benchmarks.broadphase --write"
    compared, growth, moving, _ = (part for part in text.split("\n\n") if part.startswith("|"))
    assert {row[0] for row in rows_of(moving)[2:]} == set(STRUCTURES), again
    assert {row[0].strip("*") for row in rows_of(compared)[2:]} <= set(STRUCTURES) | set(rivals.RIVALS), again
    assert set(STRUCTURES) <= {row[0] for row in rows_of(growth)[2:]}, again
    for picture in re.findall(r"\((\w+\.svg)\)", text):
        assert ElementTree.parse(HERE / picture).getroot().tag.endswith("svg")
