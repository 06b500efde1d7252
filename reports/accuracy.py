"""Accuracy and speed of engines as tables: by query, the worst cells, by pair with the engines side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from oracles.accuracy import Accuracy, CellKey, Errors, Speed
from oracles.outcome import Run
from oracles.scene import QUERIES, cells
from reports import text
from reports.tables import Column, Entry, More, Table, engines

NOTE = (
    "An error is what is beyond doubt: the distance of the answer from the reference's, less what the reference may "
    "err by (1e-14 to 1e-12 of the scene's size); 0 is below that. It is relative to the scene's largest coordinate, "
    "extent or velocity. Below it stands the error itself, a length, of impacts a velocity, of rays how far the hit is "
    "from the surface. The worst errors of each cell are proven by certificates; of "
    "those after ≥ floats alone are certain. A row of a pair opens to its regimes; accuracy.csv has them to the last "
    "bit. Times are what an engine and its adapter take in their own process for a "
    "call from Python that makes both shapes anew; what guards them is left out."
)
RANKS = ("median", "99\u202f%", "worst")
UNPROVEN = "≥"
"""Before a worst error that is certain by floats, and was not proven one by one."""
NEARLY_ALL = 0.99
"""A proof of less than this share of an error is not that of the error."""
MICRO = 1e6
MOST_WORST = 12
"""Cells of an engine in the table of the worst."""


def accuracy(run: Run) -> tuple[Table, ...]:
    """Errors by query, the worst cells of each engine, errors by regime and by pair, and speeds."""
    found = run.accuracy
    named = engines(run)
    if not found.errors:
        return ()
    return (
        by_query(found, named),
        *(worst_cells(found, engine) for engine in named if _valued(found, engine)),
        by_regime(found, named),
        by_pair(found, named),
        speeds(found, named),
    )


EACH_CELL = 3
"""So many tables, the last ones, have a row for each regime or pair."""


# -- errors --------------------------------------------------------------------------------------------------


def by_query(found: Accuracy, named: Sequence[str]) -> Table:
    """Errors over all pairs of a query, and how many answers have one."""
    columns = [Column("engine · query"), *(Column(rank, numeric=True) for rank in RANKS), *_COUNTS]
    rows = [
        (Entry(f"{text.visible(row.engine)} · {row.query}"), *_entries(row), *_counted(row))
        for row in found.errors
        if not row.pair and not row.regime and row.engine in named
    ]
    return Table(
        "Errors of each engine and query, over all pairs and regimes: relative, and below as lengths",
        tuple(columns),
        tuple(rows),
    )


_COUNTS = tuple(Column(title, numeric=True) for title in ("answers", "with a value", "by convention", "no answer"))


def _counted(row: Errors) -> Iterator[Entry]:
    for number in (row.answers, row.valued, row.by_convention, row.lost):
        yield Entry(text.count(number))


def worst_cells(found: Accuracy, engine: str) -> Table:
    """The cells in which an engine errs most, the worst relative error first."""
    rows = sorted(_valued(found, engine), key=lambda row: -_worst(row, relative=True)[0])[:MOST_WORST]
    columns = [Column("pair · query"), *(Column(rank, numeric=True) for rank in RANKS), Column("worst in"), *_COUNTS]
    return Table(
        f"{text.visible(engine)}: the pairs with the largest errors relative to the scene's size",
        tuple(columns),
        tuple(
            (
                Entry(f"{row.pair} · {row.query}"),
                *_entries(row),
                Entry(row.worst_in),
                *_counted(row),
            )
            for row in rows
            if _worst(row, relative=True)[0] > 0
        ),
    )


def by_regime(found: Accuracy, named: Sequence[str]) -> Table:
    """Every query and regime over all pairs, with the engines side by side."""
    known = {(row.engine, row.query, row.regime): row for row in found.errors if not row.pair and row.absolute}
    order = sorted({(QUERIES.index(query), query, regime) for _, query, regime in known if regime})
    return Table(
        "Errors in each regime, over all pairs: relative to the scene's size, and below as lengths",
        _rank_columns("regime · query", named),
        tuple(
            (Entry(f"{regime} · {query}"), *_side_by_side(known, named, query, regime)) for _, query, regime in order
        ),
    )


def by_pair(found: Accuracy, named: Sequence[str]) -> Table:
    """Every pair and query, with the engines side by side; each row opens to its regimes."""
    known = {row.cell: row for row in found.errors if row.pair and not row.regime and row.absolute}
    order = [(cell.query, cell.pair) for cell in cells()]
    asked = [(query, pair) for query, pair in order if any((engine, query, pair) in known for engine in named)]
    return Table(
        "Errors of each pair and query: relative to the scene's size, and below as lengths",
        _rank_columns("pair · query", named),
        tuple((Entry(f"{pair} · {query}"), *_side_by_side(known, named, query, pair)) for query, pair in asked),
        more=_regimes_of(found, named, asked),
    )


def _rank_columns(first: str, named: Sequence[str]) -> tuple[Column, ...]:
    ranks = (Column(rank, numeric=True, group=text.visible(engine)) for engine in named for rank in RANKS)
    return Column(first), *ranks


def _side_by_side(known: Mapping[CellKey, Errors], named: Sequence[str], query: str, part: str) -> Iterator[Entry]:
    for engine in named:
        row = known.get((engine, query, part))
        yield from _entries(row) if row else [Entry("–")] * len(RANKS)


def _regimes_of(found: Accuracy, named: Sequence[str], asked: Sequence[tuple[str, str]]) -> More:
    """Rows below those of the pairs: each regime in which an engine errs; and how many there are in which none does."""
    known: dict[tuple[str, str], dict[str, dict[str, Errors]]] = {}
    for row in found.errors:
        if row.pair and row.regime and row.relative:
            known.setdefault((row.query, row.pair), {}).setdefault(row.regime, {})[row.engine] = row
    more = []
    for cell in asked:
        rows, clean = [], 0
        for regime, rows_of in known.get(cell, {}).items():
            if any(_worst(row, relative=False)[0] > 0 for row in rows_of.values()):
                rows.append((text.visible(regime), *(_in_short(rows_of.get(name)) for name in named)))
            else:
                clean += 1
        if clean:
            rows.append((f"no error in {text.plural(clean, 'regime')}",))
        more.append(tuple(rows))
    return tuple(more)


def _in_short(row: Errors | None) -> str:
    """Median, 99th percentile and worst, relative and as lengths, as the page's script takes them apart.

    An error of 1.2e-09 is 12-9, for there are thousands; nothing stands where there is no value, one 0 for no error.
    """
    if row is None or row.absolute is None or row.relative is None:
        return ""
    ranks = [value for spread in (row.relative, row.absolute) for value in (spread.median, spread.p99, spread.worst)]
    return "0" if not any(ranks) else "|".join(map(_coded, ranks))


def _coded(value: float) -> str:
    shown = _short(value)
    digits, e, power = shown.partition("e")
    return f"{digits.replace('.', '')}{int(power):+d}" if e else shown


def _entries(row: Errors) -> list[Entry]:
    """Median, 99th percentile and worst."""
    if row.absolute is None or row.relative is None:
        return [Entry("–")] * len(RANKS)
    return [
        Entry(_short(row.relative.median), _short(row.absolute.median)),
        Entry(_short(row.relative.p99), _short(row.absolute.p99)),
        Entry(_shown_worst(row, relative=True), _shown_worst(row, relative=False)),
    ]


def _worst(row: Errors, *, relative: bool) -> tuple[float, bool]:
    """The worst error, and whether a certificate proves it; else floats are certain of more than is proven."""
    spread, proven = (row.relative, row.proven_relative) if relative else (row.absolute, row.proven_absolute)
    by_floats = spread.worst if spread else 0.0
    if proven is None or proven < NEARLY_ALL * by_floats:
        return by_floats, not by_floats
    return proven, True


def _shown_worst(row: Errors, *, relative: bool) -> str:
    worst, proven = _worst(row, relative=relative)
    return _short(worst) if proven or not row.pair else f"{UNPROVEN} {_short(worst)}"


def _short(value: float) -> str:
    """Two significant digits: errors are told by their decade."""
    if value == math.inf:
        return "∞"
    return f"{value:.1e}" if value > 0 else "0"


def _valued(found: Accuracy, engine: str) -> list[Errors]:
    return [row for row in found.errors if row.engine == engine and row.pair and not row.regime and row.relative]


# -- speeds --------------------------------------------------------------------------------------------------


def speeds(found: Accuracy, named: Sequence[str]) -> Table:
    """Time for an answer in each cell, with the engines side by side; first over the pairs that all of them answer."""
    known = {(speed.engine, speed.query, speed.pair): speed for speed in found.speeds}
    queries = [query for query in QUERIES if any(key[1] == query for key in known)]
    asked = [(engine, query) for query in queries for engine in named if _any_of(known, engine, query)]
    pairs = [pair for pair in dict.fromkeys(cell.pair for cell in cells()) if any(key[2] == pair for key in known)]
    columns = [Column("pair"), *(Column(text.visible(engine), numeric=True, group=query) for engine, query in asked)]
    rows = [(Entry("all that each engine answers"), *(_overall(known, named, *key) for key in asked))]
    rows += [(Entry(pair), *(_speed(known.get((*key, pair))) for key in asked)) for pair in pairs]
    caption = "Speed: microseconds of processor time for an answer"
    return Table(caption, tuple(columns), tuple(rows))


def _any_of(known: Mapping[CellKey, Speed], engine: str, query: str) -> bool:
    return any(key[:2] == (engine, query) for key in known)


def _overall(known: Mapping[CellKey, Speed], named: Sequence[str], engine: str, query: str) -> Entry:
    """Mean over the pairs that every engine of the query answers: each pair counts alike."""
    others = [name for name in named if _any_of(known, name, query)]
    common = [
        speed
        for (name, asked, pair), speed in known.items()
        if name == engine and asked == query and all((other, query, pair) in known for other in others)
    ]
    if not common:
        return Entry("–")
    mean = sum(speed.seconds / speed.answers for speed in common) / len(common)
    return Entry(_micro(mean), note=text.plural(len(common), "pair"))


def _speed(speed: Speed | None) -> Entry:
    if speed is None:
        return Entry("–")
    return Entry(_micro(speed.seconds / speed.answers))


def _micro(seconds: float) -> str:
    value = MICRO * seconds
    return f"{value:.1f}" if value < 100 else text.count(round(value))
