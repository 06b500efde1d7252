"""The matrix as the page filters and sorts it: a row per pair and query, a view of each engine's cell in it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from oracles.outcome import COMPARED, FINDINGS, Bucket, Kind, Run, State
from oracles.scene import cells
from reports import text
from reports.matrix import MARKS, RANKS, matrix_entry
from reports.tables import CellKey, engines, grouped, total

NEW, STALE, WRONG, UNSUPPORTED, DIFFER = "new", "stale", "wrong", "unsupported", "differ"
SHOWS = (
    (NEW, "new findings"),
    (STALE, "stale or changed entries"),
    (WRONG, "wrong"),
    (UNSUPPORTED, "unsupported"),
    (DIFFER, "engines differ"),
)
"""What the page can be asked to show alone."""

RARE = 0.01
"""Findings below this share of all answers are rare."""

SPOKEN = {
    "ok": "agrees",
    "convention": "right by convention",
    "problem": "nothing compared",
    "timed-out": "timed out",
    "reference-wrong": "reference wrong",
    "none": "not asked",
} | {state: state for state in ("wrong", "inconsistent", "crashed", "undecided", "unsupported")}
"""What a screen reader says for a state's sign."""


@dataclass(frozen=True)
class CellView:
    """One cell: a query on a pair, by one engine.

    Attributes
    ----------
    mark, words, state
        What happened: as a sign with a number, in words, and as a state of the matrix.
    rank
        Place of the state among all, the first that a reader should see 0.
    compared
        How many answers; None where there are none.
    worst
        Largest error, a length or of impacts a velocity; None where none was measured.
    flags
        What of `SHOWS` holds for it.
    link
        Anchor of its first finding.
    """

    anchor: str
    mark: str
    words: str
    state: str
    rank: int
    compared: int | None
    worst: float | None
    flags: tuple[str, ...]
    link: str

    @property
    def worst_text(self) -> str:
        """The largest error, as people read it."""
        if self.worst is None:
            return ""
        at_least = f"≥{text.THIN}" if WRONG in self.flags else ""
        return "not a number" if math.isinf(self.worst) else f"{at_least}{text.short(self.worst)}"


@dataclass(frozen=True)
class Row:
    """A query on a pair, by all engines."""

    pair: str
    query: str
    cells: tuple[CellView, ...]
    anchor: str
    """Of the pair, in the first of its rows."""

    @property
    def differ(self) -> bool:
        """Whether some engine is right throughout where another is not."""
        states = {WRONG in cell.flags for cell in self.cells if cell.compared}
        return len(states) > 1


def slug(name: str) -> str:
    """Letters and digits of a name, for an address."""
    return "-".join(re.findall(r"[A-Za-z0-9]+", name))[:40].strip("-") or "engine"


def slugs(names: Iterable[str]) -> dict[str, str]:
    """Names to slugs, each with a number behind it that another has already."""
    found: dict[str, str] = {}
    for name in names:
        own = slug(name)
        found[name] = f"{own}-{len(found)}" if own in found.values() else own
    return found


def rows(run: Run) -> tuple[Row, ...]:
    """All cells that any engine was asked for, or that it does not support; the pair table's order."""
    counts, names = grouped(run, "engine", "query", "pair"), slugs(engines(run))
    buckets: dict[CellKey, list[Bucket]] = {}
    for bucket in run.buckets:
        buckets.setdefault((bucket.engine, bucket.query, bucket.pair), []).append(bucket)
    stale = {(note.engine, *cell) for note in run.ledger for cell in note.cells}
    known = {key[1:] for key in (*run.support, *counts)}
    measured = {
        errors.cell: errors.absolute.worst for errors in run.accuracy.errors if errors.absolute and not errors.regime
    }
    found: list[Row] = []
    seen: set[str] = set()
    for cell in cells():
        if (cell.query, cell.pair) not in known:
            continue
        views = []
        for engine in engines(run):
            key = (engine, cell.query, cell.pair)
            address = f"c-{names[engine]}-{cell.query}-{slug(cell.pair)}"
            its = buckets.get(key, [])
            worst = _worst(its, measured.get(key))
            views.append(_view(run, key, address, counts.get(key, Counter()), its, worst, key in stale))
        found.append(Row(cell.pair, cell.query, tuple(views), "" if cell.pair in seen else f"pair-{slug(cell.pair)}"))
        seen.add(cell.pair)
    return tuple(found)


def rare(run: Run) -> set[tuple[str, str]]:
    """Engine and pair where findings are rare among all answers to any query."""
    counts = grouped(run, "engine", "pair")
    return {
        (text.visible(engine), pair)
        for (engine, pair), verdicts in counts.items()
        if total(verdicts, FINDINGS) < RARE * total(verdicts, COMPARED)
    }


def _worst(its: list[Bucket], measured: float | None) -> float | None:
    """The largest error of a cell: of its findings, or of all answers, where their errors were measured."""
    known = [bucket.worst for bucket in its if bucket.worst > 0]
    return max([*known, measured] if measured is not None else known, default=None)


def places(run: Run, rows: tuple[Row, ...]) -> dict[CellKey, str]:
    """Anchors of the cells in the matrix."""
    named = ((row, zip(engines(run), row.cells, strict=True)) for row in rows)
    return {(engine, row.query, row.pair): cell.anchor for row, its in named for engine, cell in its}


def _mark(state: str, verdicts: Counter[Kind]) -> str:
    """A sign, and how many answers it is about where it is not all of them."""
    found = total(verdicts, FINDINGS)
    sign = MARKS.get(state, "✗")
    about = {"ok": 0, "convention": verdicts[Kind.CONVENTION], "undecided": verdicts[Kind.UNDECIDED]}.get(state, found)
    return f"{sign}{text.THIN}{text.count(about)}" if about else sign


def _view(
    run: Run, key: CellKey, address: str, verdicts: Counter[Kind], its: list[Bucket], worst: float | None, stale: bool
) -> CellView:
    entry = matrix_entry(run, key, verdicts, {})
    holds = {
        NEW: any(bucket.state is State.NEW for bucket in its),
        STALE: stale,
        WRONG: total(verdicts, FINDINGS) > 0,
        UNSUPPORTED: entry.state == UNSUPPORTED,
    }
    return CellView(
        anchor=address,
        mark=_mark(entry.state, verdicts),
        words="; ".join(filter(None, (SPOKEN.get(entry.state, ""), entry.note))),
        state=entry.state,
        rank=RANKS.index(entry.state),
        compared=total(verdicts, COMPARED) or None,
        worst=worst,
        flags=tuple(flag for flag, holding in holds.items() if holding),
        link=f"b-{its[0].id}" if its else "",
    )
