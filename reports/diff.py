"""What changed between two runs: findings by their ids, cells, the ledger, and how often things go wrong.

Two runs ask other scenes where seed, time or models differ, and even the same cause may be shown by another scene.
So a finding that is gone is set against what is new in the same cell with the same symptom: the two are one that
moved. A rate has changed only where chance does not explain it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from oracles.outcome import COMPARED, Run, Severity
from reports import text
from reports.diff_accuracy import Shift, shifts
from reports.reading import DAMAGE, NoReport, in_words, name_of, read_report, run_from_data
from reports.tables import CellKey

SIGMAS, FACTOR = 4.0, 2.0
"""A rate has changed when it is so many standard deviations off, and so many times as high or low."""

NOT_ASKED = "not asked"


@dataclass(frozen=True)
class Told:
    """What one report says of a finding.

    Attributes
    ----------
    compared
        Answers that were compared in its cell.
    """

    id: str
    key: str
    cell: CellKey
    symptom: str
    severity: str
    amount: float
    count: int
    state: str
    compared: int


@dataclass(frozen=True)
class Report:
    """A report that is compared with another: its run, and its findings by id."""

    run: Run
    findings: dict[str, Told]
    data: dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class Change:
    """A finding that both runs have, or that moved: what is different, and whether for the worse."""

    before: Told
    after: Told
    what: tuple[str, ...]
    worse: bool


@dataclass(frozen=True)
class Comparison:
    """All differences of two runs."""

    before: Report
    after: Report
    new: tuple[Told, ...]
    gone: tuple[tuple[Told, str], ...]
    """Each with what speaks for its being gone, or for its not having been asked."""
    changed: tuple[Change, ...]
    same: int
    errors: tuple[Shift, ...]
    cells: tuple[tuple[CellKey, str, str], ...]
    entries: tuple[tuple[str, str, str], ...]

    @property
    def worse(self) -> bool:
        """Whether anything is new or has become worse."""
        return bool(self.new) or any(c.worse for c in self.changed) or any(s.worse for s in self.errors)


def report_at(place: Path) -> Report:
    """Read the report in a folder; raises `NoReport`."""
    data = read_report(place)
    run = run_from_data(data)
    compared: dict[CellKey, int] = {}
    for (engine, query, pair, _, kind), n in run.counts.items():
        if kind in COMPARED:
            compared[engine, query, pair] = compared.get((engine, query, pair), 0) + n
    found = [_told(item, compared) for item in data["buckets"]]
    return Report(run, {told.id: told for told in found}, data)


def _told(item: dict[str, Any], compared: dict[CellKey, int]) -> Told:
    try:
        names = ("id", "key", "engine", "query", "pair", "symptom", "state")
        name, key, engine, query, pair, symptom, state = (str(item[n]) for n in names)
        cell, severity = (engine, query, pair), str(item["severity"] or item["kind"])
        amount, count = float(item["amount"]), int(item["count"])
    except DAMAGE as error:
        raise NoReport(f"{name_of(item)} is damaged: {in_words(error)}") from None
    return Told(name, key, cell, symptom, severity, amount, count, state, compared.get(cell, 0))


def compare(before: Report, after: Report) -> Comparison:
    """Set two reports against each other."""
    only_before = [told for name, told in before.findings.items() if name not in after.findings]
    only_after = [told for name, told in after.findings.items() if name not in before.findings]
    moved = list(_moved(only_before, only_after))
    both = [(told, after.findings[name]) for name, told in before.findings.items() if name in after.findings]
    changes = [_change(*pair) for pair in (*both, *moved)]
    told_moved = {told.id for pair in moved for told in pair}
    return Comparison(
        before,
        after,
        new=tuple(told for told in only_after if told.id not in told_moved),
        gone=tuple((told, _why(told, after)) for told in only_before if told.id not in told_moved),
        changed=tuple(sorted((c for c in changes if c.what), key=lambda change: not change.worse)),
        same=sum(not change.what for change in changes),
        errors=tuple(sorted(shifts(before.run.accuracy, after.run.accuracy), key=lambda shift: not shift.worse)),
        cells=tuple(_cells(before.run, after.run)),
        entries=tuple(_entries(before.run, after.run)),
    )


def _moved(gone: Sequence[Told], new: Sequence[Told]) -> Iterator[tuple[Told, Told]]:
    """Findings of one cell with one symptom that are shown by another scene now, each once."""
    waiting: dict[tuple[CellKey, str], list[Told]] = {}
    for told in new:
        waiting.setdefault((told.cell, told.symptom), []).append(told)
    for told in gone:
        if alike := waiting.get((told.cell, told.symptom)):
            yield told, alike.pop(0)


def _why(told: Told, after: Report) -> str:
    """What speaks for a finding's being gone."""
    engine, query, pair = told.cell
    asked = after.run.total(engine=engine, query=query, pair=pair, kinds=COMPARED)
    if not asked:
        return NOT_ASKED
    expected = told.count * asked / told.compared if told.compared else 0.0
    return f"0 of {text.count(asked)}; {text.short(expected)} at the rate before"


def _change(before: Told, after: Told) -> Change:
    """What is different in one finding."""
    what, worse = [], False
    if before.id != after.id:
        what.append(f"was shown as {before.key.removeprefix(' · '.join((*before.cell, before.symptom)) + ' · ')}")
    if before.severity != after.severity:
        what.append(f"severity {before.severity} → {after.severity}")
        worse |= _gravity(after.severity) < _gravity(before.severity)
    if before.state != after.state:
        what.append(f"ledger {before.state} → {after.state}")
    if direction := _rate_changed(before, after):
        rates = (f"{text.count(told.count)} of {text.count(told.compared)}" for told in (before, after))
        what.append(f"{'more' if direction > 0 else 'less'} often: {' → '.join(rates)}")
        worse |= direction > 0
    return Change(before, after, tuple(what), worse)


def _gravity(severity: str) -> int:
    """Rank of a severity, the gravest first."""
    order = [known.value for known in Severity]
    return order.index(severity) if severity in order else len(order)


def _rate_changed(before: Told, after: Told) -> int:
    """1 where it is seen more often now, -1 where less, and 0 where chance explains the difference."""
    if not (before.compared and after.compared):
        return 0
    rates = before.count / before.compared, after.count / after.compared
    together = (before.count + after.count) / (before.compared + after.compared)
    deviation = math.sqrt(max(0.0, together * (1 - together)) * (1 / before.compared + 1 / after.compared))
    clear = abs(rates[1] - rates[0]) > SIGMAS * deviation and max(rates) >= FACTOR * min(rates)
    return 0 if not clear else 1 if rates[1] > rates[0] else -1


def _cells(before: Run, after: Run) -> Iterator[tuple[CellKey, str, str]]:
    """Cells that an engine answers otherwise than it did."""
    for key in dict.fromkeys([*before.support, *after.support]):
        kinds = [run.support[key].kind if key in run.support else NOT_ASKED for run in (before, after)]
        if kinds[0] != kinds[1]:
            yield key, kinds[0], kinds[1]


def _entries(before: Run, after: Run) -> Iterator[tuple[str, str, str]]:
    """Entries of the ledger in another state."""
    states = [{f"{note.engine} · {note.name}": note.state.value for note in run.ledger} for run in (before, after)]
    for name in dict.fromkeys([*states[0], *states[1]]):
        one, other = (found.get(name, "not there") for found in states)
        if one != other:
            yield name, one, other
