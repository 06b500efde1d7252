"""Accuracy as it is read: tables, plots and data of errors that are known, harmless whatever engines are named."""

from __future__ import annotations

import csv
import io
import json
import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from oracles.accuracy import ASPECT, GAP, SCALE, Accuracy, Errors, Point, Speed, Spread
from oracles.outcome import Run
from oracles.scene import BOOLEAN, CONTACTS, DISTANCE, RAYCAST
from reports import plots as drawing
from reports.accuracy import accuracy, by_pair
from reports.accuracy_data import accuracy_data, accuracy_from, as_csv
from reports.cli import main
from reports.folder import write
from reports.plots import FEWEST, Axis, plots
from reports.summary import schema
from reports.tables import Table

HOSTILE = "=<script>alert(1)</script>\u202e" + "x" * 500
BALLS, BOXES = "Sphere–Sphere", "Box–Box"


def errors(
    engine: str,
    query: str,
    pair: str,
    regime: str = "",
    scale: float = 1.0,
    proven: float | None = None,
    worst_in: str = "",
) -> Errors:
    relative = Spread(1e-9 * scale, 1e-6 * scale, 1e-3 * scale)
    absolute = Spread(2e-9 * scale, 2e-6 * scale, 2e-3 * scale)
    by_length = None if proven is None else 2 * proven
    return Errors(engine, query, pair, regime, 100, 90, 5, 1, absolute, relative, by_length, proven, worst_in)


def nothing(engine: str, query: str, pair: str, regime: str = "") -> Errors:
    return Errors(engine, query, pair, regime, 100, 0, 0, 0, None, None)


ACCURACY = Accuracy(
    (
        errors("one", DISTANCE, "", scale=2),
        errors("one", DISTANCE, "", "generic", scale=0.1),
        errors("one", DISTANCE, "", "tiny"),
        errors("one", DISTANCE, BALLS, proven=1.5e-3, worst_in="tiny"),
        errors("one", DISTANCE, BALLS, "generic", scale=0.1),
        errors("one", DISTANCE, BALLS, "tiny", scale=1),
        errors("one", DISTANCE, BALLS, "turned", scale=0),
        errors("one", DISTANCE, BALLS, "touching", scale=0),
        errors("one", DISTANCE, BOXES, scale=2, worst_in="huge"),
        errors("one", DISTANCE, BOXES, "huge", scale=2),
        nothing("one", BOOLEAN, ""),
        nothing("one", BOOLEAN, BALLS),
        errors("two", DISTANCE, "", scale=4),
        errors("two", DISTANCE, BALLS, scale=math.inf, proven=math.inf),
        errors("two", DISTANCE, BALLS, "generic", scale=math.inf),
        errors("two", DISTANCE, BALLS, "turned", scale=0),
    ),
    (
        *(
            Point("one", DISTANCE, SCALE, 10.0**k, FEWEST, Spread(10.0 ** (k - 9), 10.0 ** (k - 6), 10.0**k))
            for k in (-1, 0, 1)
        ),
        Point("one", DISTANCE, SCALE, 1e2, FEWEST - 1, Spread(1.0, 1.0, 1.0)),
        Point("one", DISTANCE, SCALE, 1e3, FEWEST, Spread(1.0, 1.0, 1.0)),
        Point("two", CONTACTS, SCALE, 1.0, FEWEST, Spread(0.0, 1e-8, 1e-5)),
        Point("two", CONTACTS, GAP, 0.0, FEWEST, Spread(0.0, 0.0, 0.0)),
        Point("two", CONTACTS, GAP, 1e-3, FEWEST, Spread(0.0, 1e-8, math.inf)),
        Point("two", CONTACTS, GAP, 1e-2, FEWEST, Spread(0.0, 1e-8, math.inf)),
        *(Point("one", DISTANCE, ASPECT, x, FEWEST, Spread(1e-3, 1e-2, 1e-1)) for x in (1.0, 1e9, math.inf)),
    ),
    (
        Speed("one", DISTANCE, BALLS, 1000, 0.01),
        Speed("one", DISTANCE, BOXES, 1000, 0.05),
        Speed("one", RAYCAST, "Ray–Sphere", 10, 0.002),
        Speed("two", DISTANCE, BALLS, 500, 0.002),
    ),
)


@pytest.fixture
def run() -> Run:
    return Run(0, 1.0, "2026-01-01T00:00:00+00:00", engines=["one", "two"], accuracy=ACCURACY)


def texts(table: Table) -> list[list[str]]:
    return [[entry.text for entry in row] for row in table.rows]


# -- tables --------------------------------------------------------------------------------------------------


def test_a_run_without_errors_has_no_tables() -> None:
    assert accuracy(Run(0, 1.0, "", engines=["one"])) == ()
    assert plots(Run(0, 1.0, "", engines=["one"])) == ()


def test_the_overview_has_a_row_for_each_engine_and_query(run: Run) -> None:
    assert texts(accuracy(run)[0]) == [
        ["one · distance", "2.0e-09", "2.0e-06", "2.0e-03", "100", "90", "5", "1"],
        ["one · boolean", "–", "–", "–", "100", "0", "0", "0"],
        ["two · distance", "4.0e-09", "4.0e-06", "4.0e-03", "100", "90", "5", "1"],
    ]


def test_the_worst_cells_stand_first_with_the_regime_in_which_they_are_so(run: Run) -> None:
    one, two = accuracy(run)[1:3]
    assert [row[0] for row in texts(one)] == ["Box–Box · distance", "Sphere–Sphere · distance"]
    assert [row[4] for row in texts(one)] == ["huge", "tiny"]
    assert [row[3] for row in texts(two)] == ["∞"]


def test_engines_stand_side_by_side_and_what_is_proven_is_told_from_what_is_not(run: Run) -> None:
    table = accuracy(run)[4]
    assert [column.group for column in table.columns] == ["", *["one"] * 3, *["two"] * 3]
    assert texts(table) == [
        ["Sphere–Sphere · distance", "1.0e-09", "1.0e-06", "1.5e-03", "∞", "∞", "∞"],
        ["Box–Box · distance", "2.0e-09", "2.0e-06", "≥ 2.0e-03", "–", "–", "–"],
    ]
    assert table.rows[0][3].note == "3.0e-03"


def test_errors_are_told_by_regime_over_all_pairs(run: Run) -> None:
    table = accuracy(run)[3]
    assert [column.group for column in table.columns] == ["", *["one"] * 3, *["two"] * 3]
    assert texts(table) == [
        ["generic · distance", "1.0e-10", "1.0e-07", "1.0e-04", "–", "–", "–"],
        ["tiny · distance", "1.0e-09", "1.0e-06", "1.0e-03", "–", "–", "–"],
    ]
    assert [entry.note for entry in table.rows[1]][:4] == ["", "2.0e-09", "2.0e-06", "2.0e-03"]


def test_a_pair_opens_to_the_regimes_in_which_somebody_errs(run: Run) -> None:
    balls, boxes = accuracy(run)[4].more
    assert balls == (
        ("generic", "10-10|10-7|10-4|20-10|20-7|20-4", "∞|∞|∞|∞|∞|∞"),
        ("tiny", "10-9|10-6|10-3|20-9|20-6|20-3", ""),
        ("no error in 2 regimes",),
    )
    assert [row[0] for row in boxes] == ["huge"]


@pytest.mark.parametrize(
    ("proven", "shown"), [(None, "≥ 1.0e-03"), (1e-5, "≥ 1.0e-03"), (0.9999e-3, "1.0e-03"), (1.1e-3, "1.1e-03")]
)
def test_a_worst_error_counts_as_proven_only_where_the_proof_is_of_all_of_it(proven: float | None, shown: str) -> None:
    table = by_pair(Accuracy((errors("one", DISTANCE, BALLS, proven=proven),)), ["one"])
    assert texts(table)[0][3] == shown


def test_speeds_are_compared_over_what_all_engines_of_a_query_answer(run: Run) -> None:
    table = accuracy(run)[-1]
    assert [(column.title, column.group) for column in table.columns[1:]] == [
        ("one", DISTANCE),
        ("two", DISTANCE),
        ("one", RAYCAST),
    ]
    assert texts(table) == [
        ["all that each engine answers", "10.0", "4.0", "200"],
        ["Ray–Sphere", "–", "–", "200"],
        ["Sphere–Sphere", "10.0", "4.0", "–"],
        ["Box–Box", "50.0", "–", "–"],
    ]


# -- data ----------------------------------------------------------------------------------------------------


def test_what_is_written_is_read_back_without_the_single_regimes(run: Run) -> None:
    back = accuracy_from(json.loads(json.dumps(accuracy_data(run), allow_nan=False)))
    assert back == replace(ACCURACY, errors=tuple(row for row in ACCURACY.errors if not row.regime))


@pytest.mark.parametrize(
    "data",
    [None, [], {}, {"errors": 1, "points": [], "speeds": []}, {"errors": [{}], "points": [], "speeds": []},
     {"errors": [], "points": [{"engine": 1}], "speeds": []}, {"errors": [], "points": [], "speeds": [0] * 100_001}],
    ids=str,
)  # fmt: skip
def test_other_data_is_refused(data: object) -> None:
    with pytest.raises(ValueError, match="accuracy"):
        accuracy_from(data)


def test_the_csv_has_every_row_to_the_bit_and_no_formula(run: Run) -> None:
    rows = list(csv.DictReader(io.StringIO(as_csv(run))))
    assert len(rows) == len(ACCURACY.errors)
    for row, known in zip(rows, ACCURACY.errors, strict=True):
        assert [row[name] for name in ("engine", "query", "pair", "regime")] == [
            known.engine, known.query, known.pair, known.regime
        ]  # fmt: skip
        assert int(row["valued"]) == known.valued
        if known.relative is not None:
            assert float(row["relative_p99"]) == known.relative.p99
        assert row["relative_proven"] == ("" if known.proven_relative is None else repr(known.proven_relative))
    run.accuracy = Accuracy((errors(HOSTILE, DISTANCE, BALLS),))
    (row,) = csv.DictReader(io.StringIO(as_csv(run)))
    assert row["engine"].startswith("'=")
    assert "\u202e" not in row["engine"]


# -- plots ---------------------------------------------------------------------------------------------------


def test_an_axis_is_logarithmic_with_room_for_nothing_and_for_infinity() -> None:
    axis = Axis.over([1e-3, 1.0, 1e3], 0.0, 600.0)
    assert [axis.at(value) for value in (1e-3, 1.0, 1e3)] == [0.0, 300.0, 600.0]
    ends = Axis.over([0.0, 1.0, 1e3, math.inf], 100.0, 700.0)
    places = [ends.at(value) for value in (0.0, 1.0, 10.0, 100.0, 1e3, math.inf)]
    assert places == sorted(places)
    assert (places[0], places[-1]) == (100.0, 700.0)
    assert places[2] - places[1] == pytest.approx(places[4] - places[3])
    for some in (Axis.over([5.0], 0.0, 10.0), Axis.over([0.0], 0.0, 10.0), Axis.over([math.inf, 0.0], 0.0, 10.0)):
        assert all(math.isfinite(place) for place, _ in some.labels())


def lines(svg: str, series: int) -> list[str]:
    """Paths of a series that are lines, in its first panel."""
    root = ET.fromstring(svg)
    groups = [g for g in root.iter("{http://www.w3.org/2000/svg}g") if g.get("class") == f"series-{series}"]
    return [path.get("d", "") for path in groups[1] if path.get("fill") == "none"]


def test_lines_go_through_the_points(run: Run) -> None:
    found = plots(run)
    assert [plot.title for plot in found] == [drawing.TITLES[axis][0] for axis in (SCALE, GAP, ASPECT)]
    assert "contacts" not in found[0].svg  # a single point is no plot
    median, most = lines(found[0].svg, 1)
    line, dot = median[1:].split("M")
    points = [tuple(map(float, point.split())) for point in line.split("L")]
    assert len(points) == 3
    assert dot.endswith("h0")  # across too few scenes there is no line
    (x0, y0), (x1, y1), (x2, y2) = points
    assert x1 - x0 == pytest.approx(x2 - x1, abs=0.11)
    assert y0 - y1 == pytest.approx(y1 - y2, abs=0.11)
    assert y0 > y2  # upwards
    assert [path.count("h0") for path in lines(found[1].svg, 2)] == [1, 1]  # nor to what touches
    assert [path.count("h0") for path in lines(found[2].svg, 1)] == [3, 3]  # nor from what is long to what is flat
    assert float(most[1:].split()[1].partition("L")[0]) < y0


def test_plots_are_small_well_formed_and_without_styles_or_scripts(run: Run) -> None:
    run.engines = [HOSTILE, "one", "two", "three", "four", "five"]
    run.accuracy = replace(
        ACCURACY, points=(*ACCURACY.points, *(replace(point, engine=HOSTILE) for point in ACCURACY.points))
    )
    for plot in plots(run):
        root = ET.fromstring(plot.svg)
        tags = {element.tag.rpartition("}")[2] for element in root.iter()}
        assert tags <= {"svg", "title", "desc", "g", "path", "text"}
        assert all(name in ALLOWED for element in root.iter() for name in element.attrib)
        assert root.get("role") == "img"
        places = [element.get(name, "") for element in root.iter() for name in ("d", "transform", "x", "y")]
        assert not any("∞" in place or "nan" in place for place in places)
        assert "\u202e" not in plot.svg
        assert len(plot.svg) < 50_000


ALLOWED = {
    *("class", "viewBox", "width", "height", "role", "font-family", "font-size", "font-weight", "fill", "fill-opacity"),
    *(
        "stroke",
        "stroke-opacity",
        "stroke-width",
        "stroke-dasharray",
        "stroke-linecap",
        "transform",
        "x",
        "y",
        "d",
        "text-anchor",
    ),
}


# -- the command ---------------------------------------------------------------------------------------------


@pytest.fixture
def report(run: Run, tmp_path: Path) -> Path:
    write(run, tmp_path)
    return tmp_path


def test_the_command_prints_the_worst_and_on_demand_every_pair(
    report: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["accuracy", str(report)]) == 0
    brief = capsys.readouterr().out
    assert "one · distance" in brief
    assert "huge" in brief
    assert "Speed: microseconds" not in brief
    assert main(["accuracy", str(report), "--all", "--markdown"]) == 0
    full = capsys.readouterr().out
    assert "| Box–Box · distance " in full
    assert "Speed: microseconds" in full
    assert main(["accuracy", str(report / "report.json"), "--pair", "box-box", "--markdown"]) == 0
    one = capsys.readouterr().out
    assert "| Box–Box · distance " in one
    assert BALLS not in one


def test_the_command_says_in_a_line_that_there_is_nothing(
    tmp_path: Path, report: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place, arguments in ((tmp_path / "none", []), (report, ["--pair", "Ray-Box"])):
        assert main(["accuracy", str(place), *arguments]) == 2
        told = capsys.readouterr().err
        assert told.startswith("proxyproof: ")
        assert told.count("\n") == 1
    (report / "report.json").write_text('{"format": "proxyproof-report-1", "buckets": [], "accuracy": {"errors": 5}}')
    assert main(["accuracy", str(report)]) == 2
    assert "not accuracy" in capsys.readouterr().err


def test_the_report_holds_accuracy_by_its_schema_and_as_csv(report: Path) -> None:
    data = json.loads((report / "report.json").read_text(encoding="utf-8"))
    jsonschema.validate(data, json.loads(schema()))
    assert len(data["accuracy"]["errors"]) == sum(not row.regime for row in ACCURACY.errors)
    assert (report / "accuracy.csv").read_text(encoding="utf-8").count("\n") == 1 + len(ACCURACY.errors)
