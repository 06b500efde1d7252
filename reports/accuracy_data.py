"""Accuracy as data: in `report.json`, read back from it, and by regime in `accuracy.csv`."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import astuple, fields
from typing import Any

from oracles.accuracy import Accuracy, Errors, Point, Speed, Spread
from oracles.outcome import Run
from reports import text

ERROR_FIELDS = ("engine", "query", "pair", "regime", "answers", "valued", "by_convention", "lost")
SPREAD_FIELDS = tuple(field.name for field in fields(Spread))
POINT_FIELDS = ("engine", "query", "axis", "x", "count")
PROVEN = ("proven_absolute", "proven_relative")
MOST_ROWS = 100_000
"""Of a kind, that are read back."""


def accuracy_data(run: Run) -> dict[str, object]:
    """Return what `report.json` says under `accuracy`: all but the single regimes, which `accuracy.csv` has."""
    found = run.accuracy
    errors = [
        {
            **{name: getattr(row, name) for name in ERROR_FIELDS if name != "regime"},
            "absolute": row.absolute and dict(vars(row.absolute)),
            "relative": row.relative and dict(vars(row.relative)),
            **{name: getattr(row, name) for name in (*PROVEN, "worst_in")},
        }
        for row in found.errors
        if not row.regime
    ]
    points = [{**{name: getattr(point, name) for name in POINT_FIELDS}, **vars(point.errors)} for point in found.points]
    data = {"errors": errors, "points": points, "speeds": [dict(vars(speed)) for speed in found.speeds]}
    plain: dict[str, object] = text.plain(data)
    return plain


def accuracy_from(data: Any) -> Accuracy:
    """Read what `accuracy_data` gave; the single regimes are not there.

    Raises
    ------
    ValueError
        For anything else.
    """
    try:
        if any(len(data[name]) > MOST_ROWS for name in ("errors", "points", "speeds")):
            raise ValueError(f"not accuracy: more than {MOST_ROWS} rows")
        return Accuracy(
            tuple(map(_errors_from, data["errors"])),
            tuple(
                Point(*_names(row, "engine", "query", "axis"), float(row["x"]), int(row["count"]), _spread_from(row))
                for row in data["points"]
            ),
            tuple(
                Speed(*_names(row, "engine", "query", "pair"), int(row["answers"]), float(row["seconds"]))
                for row in data["speeds"]
            ),
        )
    except (LookupError, TypeError, OverflowError) as error:
        raise ValueError(f"not accuracy: {error!r:.200}") from None


def _errors_from(row: Any) -> Errors:
    engine, query, pair = _names(row, "engine", "query", "pair")
    answers, valued, by_convention, lost = (int(row[name]) for name in ERROR_FIELDS[4:])
    absolute, relative = (None if row[name] is None else _spread_from(row[name]) for name in ("absolute", "relative"))
    by_length, by_size = (None if row[name] is None else float(row[name]) for name in PROVEN)
    counts = answers, valued, by_convention, lost
    return Errors(
        engine, query, pair, "", *counts, absolute, relative, by_length, by_size, text.visible(row["worst_in"])
    )


def _spread_from(row: Any) -> Spread:
    return Spread(*(float(row[name]) for name in SPREAD_FIELDS))


def _names(row: Any, *fields: str) -> tuple[str, str, str]:
    first, second, third = (text.visible(row[name]) for name in fields)
    return first, second, third


def as_csv(run: Run) -> str:
    """Return the text of `accuracy.csv`: every query, cell and regime, errors in full precision."""
    measures = ("absolute", "relative")
    head = [*ERROR_FIELDS, *(f"{measure}_{name}" for measure in measures for name in (*SPREAD_FIELDS, "proven"))]
    written = io.StringIO()
    sheet = csv.writer(written, lineterminator="\n")
    sheet.writerow(head)
    for row in run.accuracy.errors:
        names = [_cell(getattr(row, name)) for name in ERROR_FIELDS]
        errors = [*_spread(row.absolute), row.proven_absolute, *_spread(row.relative), row.proven_relative]
        sheet.writerow([*names, *("" if value is None else repr(value) for value in errors)])
    return written.getvalue()


def _spread(spread: Spread | None) -> Sequence[float | None]:
    return (None,) * len(SPREAD_FIELDS) if spread is None else astuple(spread)


def _cell(value: object) -> object:
    """A name as a spreadsheet shall take it: as a text, and never as a formula."""
    if not isinstance(value, str):
        return value
    shown = text.visible(value)
    return f"'{shown}" if shown.startswith(("=", "+", "-", "@")) else shown
