"""Errors of a run's answers by rank, taken from its record, or from the sheets of a run that keeps none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import duckdb

from oracles.accuracy import (
    ABSOLUTE,
    ASPECT,
    GAP,
    RELATIVE,
    SCALE,
    CellKey,
    Errors,
    ExtremeKey,
    Point,
    Speed,
    Spread,
)
from oracles.engine import Status
from oracles.scene import PAIRS, QUERIES
from oracles.sheets import Sheet
from oracles.store import answers_of

COLUMNS = "engine, query, pair, regime, status, verdict, error, size, gap, aspect"
RANKS = "quantile_disc({0}, 0.5), quantile_disc({0}, 0.99), max({0})"
ANSWERED = f"status = {int(Status.ANSWERED)}"
LOST = f"status IN ({int(Status.ERROR)}, {int(Status.CRASHED)}, {int(Status.TIMED_OUT)})"

ANSWERS = f"""
CREATE TABLE judged AS
SELECT *, CASE WHEN error = 0 THEN 0 ELSE error / size END AS relative
FROM (SELECT {COLUMNS} FROM {{source}})
"""
BY_REGIME = f"""
SELECT engine, query, coalesce(pair, '') AS pair, coalesce(regime, '') AS regime,
       count(*) FILTER ({ANSWERED}), count(error), count(error) FILTER (verdict = 'convention'),
       count(*) FILTER ({LOST}),
       {RANKS.format("error")}, {RANKS.format("relative")}
FROM judged
GROUP BY GROUPING SETS (
    (engine, query), (engine, query, regime), (engine, query, pair), (engine, query, pair, regime)
)
HAVING count(*) FILTER ({ANSWERED} OR {LOST}) > 0
"""
STEPS = 1
"""Bins of a plot to a power of ten."""
BY_BIN = f"""
SELECT engine, query, quantile_disc(x, 0.5) AS middle, count(*), {RANKS.format("y")}
FROM (SELECT engine, query, {{x}} AS x, {{y}} AS y FROM judged WHERE error IS NOT NULL AND {{x}} IS NOT NULL)
GROUP BY engine, query, CASE WHEN x > 0 AND x < 'inf'::DOUBLE THEN floor({STEPS} * log10(x)) ELSE x END
ORDER BY engine, query, middle
"""
AGAINST: Mapping[str, tuple[str, str]] = {
    SCALE: ("size", "error"),
    GAP: ("CASE WHEN size > 0 THEN abs(gap) / size END", "relative"),
    ASPECT: ("aspect::DOUBLE", "relative"),
}
"""What is plotted on either side."""


class Measured:
    """Answers as a table of a database in memory; use as a context manager."""

    def __init__(self, files: Sequence[Path], sheets: Sequence[Sheet]) -> None:
        self._database = duckdb.connect(config={"threads": 1})
        self._there = bool(files or sheets)
        sources = [f"SELECT {COLUMNS} FROM read_parquet($files)"] if files else []
        given: dict[str, Any] = {"files": [str(path) for path in files]} if files else {}
        if sheets:
            select, named = answers_of(self._database, sheets)
            sources.append(f"SELECT {COLUMNS} FROM ({select})")
            given |= named
        if self._there:
            self._database.execute(ANSWERS.format(source=f"({' UNION ALL '.join(sources)})"), given)

    def __enter__(self) -> Measured:
        return self

    def __exit__(self, *_: object) -> None:
        self._database.close()

    def errors(self, proven: Mapping[ExtremeKey, float]) -> tuple[Errors, ...]:
        """Errors of each query and its cells, and of each of their regimes, in the order of the pair table."""
        found = [_errors(row) for row in self._rows(BY_REGIME)]
        found.sort(key=_order)
        worst: dict[CellKey, tuple[float, str]] = {}
        for row in found:
            if row.regime and row.relative:
                worst[row.cell] = max(worst.get(row.cell, (0.0, "")), (row.relative.worst, row.regime))
        return tuple(
            row if row.regime else _as_a_whole(row, worst.get(row.cell, (0.0, ""))[1], proven) for row in found
        )

    def points(self) -> tuple[Point, ...]:
        """Errors against each axis."""
        return tuple(
            Point(engine, query, axis, x, count, Spread(*ranks))
            for axis, (across, up) in AGAINST.items()
            for engine, query, x, count, *ranks in self._rows(BY_BIN.format(x=across, y=up))
        )

    def _rows(self, query: str) -> Iterator[tuple[Any, ...]]:
        if self._there:
            yield from self._database.execute(query).fetchall()


def _errors(row: tuple[Any, ...]) -> Errors:
    absolute, relative = (None if ranks[0] is None else Spread(*ranks) for ranks in (row[8:11], row[11:14]))
    return Errors(*(*row[:8], absolute, relative))


def _as_a_whole(row: Errors, worst_in: str, proven: Mapping[ExtremeKey, float]) -> Errors:
    """A cell with the regime of its worst error, and what is proven of that."""
    return replace(
        row,
        worst_in=worst_in if row.relative and row.relative.worst > 0 else "",
        proven_absolute=proven.get((*row.cell, ABSOLUTE)),
        proven_relative=proven.get((*row.cell, RELATIVE)),
    )


_PLACES = {"": -1} | {f"{a.__name__}–{b.__name__}": place for place, (a, b) in enumerate(PAIRS)}


def _order(row: Errors) -> tuple[object, ...]:
    return row.engine, QUERIES.index(row.query), _PLACES[row.pair], row.regime


def speeds_of(spent: Mapping[CellKey, tuple[int, float]]) -> tuple[Speed, ...]:
    """What was spent, in the order of its names."""
    return tuple(Speed(*cell, answers, seconds) for cell, (answers, seconds) in sorted(spent.items()) if answers)
