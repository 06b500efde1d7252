"""The page of fitted colliders: it has the rows and columns of today, and figures that are found again."""

from __future__ import annotations

import pytest

from tests.benchmarks import construct_fits as fits

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
        assert inside["packed spheres"] == inside["medial spheres"] == 0, heading
