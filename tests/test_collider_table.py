"""The page of fitted colliders: it has the rows and columns of today, and figures that are found again."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.benchmarks import construct_fits as fits
from tests.solids import box
from tests.test_loading import obj

pytest.importorskip("pybullet_data")
pytest.importorskip("trimesh")
AGAIN = "stale: run python -m tests.benchmarks.construct_fits --write"
CHEAP = ("enclosing ball", "packed spheres", "medial spheres")


@pytest.fixture(scope="module")
def tables() -> dict[str, list[list[str]]]:
    """Cells of each model's table, by its heading."""
    page = (fits.HERE / fits.PAGE).read_text(encoding="utf-8")
    assert fits.TEXT.format(count=fits.COUNT) in page, AGAIN
    sections = (section.splitlines() for section in page.split("\n## ")[1:])
    return {
        lines[0]: [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in lines if line.startswith("|")]
        for lines in sections
    }


def test_the_page_has_the_models_ways_and_measures_of_today(tables: dict[str, list[list[str]]]) -> None:
    assert [heading.partition(":")[0] for heading in tables] == list(fits.MODELS), AGAIN
    for head, _, *rows in tables.values():
        assert head == list(fits.COLUMNS), AGAIN
        assert [row[0] for row in rows] == list(fits.WAYS), AGAIN


def test_the_figures_are_found_again(tables: dict[str, list[list[str]]]) -> None:
    """Those of fast ways; others could only be wrong if they were written by hand."""
    name = fits.MODELS[0]
    mesh = fits.model_of(name)
    heading = next(heading for heading in tables if heading.startswith(name))
    assert heading == f"{name}: {len(mesh.triangles)} faces", AGAIN
    known = {row[0]: row[1:] for row in tables[heading][2:]}
    for way in CHEAP:
        old, new = ([float(x) for x in cells[:-1]] for cells in (known[way], fits.row_of(way, mesh, fits.COUNT)[1:]))
        assert old[:4] == pytest.approx(new[:4], abs=0.0021), (way, AGAIN)
        assert old[4:] == pytest.approx(new[4:], abs=0.11), (way, AGAIN)


def test_fits_beat_the_simple_ways_and_each_other_where_they_should(tables: dict[str, list[list[str]]]) -> None:
    for heading, (_, _, *rows) in tables.items():
        overlap = {row[0]: float(row[2]) for row in rows}
        beaten = max(overlap["enclosing ball"], overlap["k-means, balls inside"], overlap["packed spheres"])
        assert overlap["fitted spheres"] > overlap["medial spheres"], heading
        assert min(overlap["fitted spheres"], overlap["fitted capsules"], overlap["fitted boxes"]) > beaten, heading
        inside = {row[0]: float(row[4]) for row in rows}
        assert max(inside["packed spheres"], inside["medial spheres"]) < 0.002, heading


def test_the_command_prints_and_writes_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fits, "MODELS", ("cube.obj",))
    monkeypatch.setattr(fits, "WAYS", {way: fits.WAYS[way] for way in CHEAP[:2]})
    (tmp_path / "cube.obj").write_text(obj(box()))
    fits.main(["--count", "2", "--write", str(tmp_path), str(tmp_path / "cube.obj")])
    said, page = capsys.readouterr().out, (tmp_path / fits.PAGE).read_text(encoding="utf-8")
    assert "cube.obj: 12 faces" in said
    assert "cube.obj: 12 faces" in page
    (row,) = [line for line in page.splitlines() if line.startswith("| enclosing ball")]
    parts, overlap, covered = row.split("|")[2:5]
    assert int(parts) == 1
    assert float(overlap) == pytest.approx(2 / math.sqrt(3) / math.pi, abs=2e-3)  # 1 over the volume of the ball
    assert float(covered) == pytest.approx(1, abs=2e-3)
