"""What changed between two runs: faults, cells, the ledger, the engines' accuracy.

A fault is a symptom in a cell. Its findings, each with an id, tell it apart further by what is special about their
scenes, which the scenes that were drawn and the shrinking decide on: two runs of one engine with different seeds agree
in faults and in how often they are met, and not in ids. So faults are compared, and their findings are named.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from oracles.outcome import COMPARED, Kind, Run, Severity, State
from reports import text
from reports.diff_accuracy import Shift, shifts
from reports.reading import DAMAGE, NoReport, in_words, name_of, read_report, run_from_data
from reports.tables import CellKey, grouped, total

SIGMAS, FACTOR = 4.0, 3.0
"""A rate has changed when it is so many standard deviations off, and so many times as high or low."""

CHANCE = 0.01
"""What was not met before is new where it would have been missed more seldom than that."""

NOT_ASKED = "not asked"


@dataclass
class Fault:
    """What one report says of a symptom in a cell.

    Attributes
    ----------
    severity
        The gravest of its findings'.
    amount
        The largest proven.
    compared
        Answers that were compared in the cell.
    findings
        Ids, to what tells a finding apart from the fault's others.
    """

    cell: CellKey
    symptom: str
    compared: int
    severity: str = ""
    amount: float = 0.0
    count: int = 0
    states: set[str] = field(default_factory=set)
    findings: dict[str, str] = field(default_factory=dict)

    @property
    def state(self) -> str:
        """What the ledger says: NEW where any of its findings is."""
        return next((state.value for state in State if state.value in self.states), "")

    @property
    def name(self) -> str:
        """Engine, query, pair and symptom."""
        return " · ".join((*self.cell, self.symptom))


FaultKey = tuple[CellKey, str]


@dataclass(frozen=True)
class Report:
    """A report that is compared with another: its run, its faults, and the ids of all findings."""

    run: Run
    faults: dict[FaultKey, Fault]
    findings: frozenset[str]


@dataclass(frozen=True)
class Change:
    """A fault that is new, or that both runs have: what is different, and whether it is worse and no chance."""

    fault: Fault
    what: tuple[str, ...]
    worse: bool


@dataclass(frozen=True)
class Comparison:
    """All differences of two runs."""

    before: Report
    after: Report
    new: tuple[Change, ...]
    gone: tuple[tuple[Fault, str], ...]
    """Each with what speaks for its being gone, or for its not having been asked."""
    changed: tuple[Change, ...]
    same: int
    errors: tuple[Shift, ...]
    cells: tuple[tuple[CellKey, str, str], ...]
    entries: tuple[tuple[str, str, str], ...]

    @property
    def worse(self) -> bool:
        """Whether anything is new or worse that chance does not explain."""
        return any(c.worse for c in (*self.new, *self.changed)) or any(shift.worse for shift in self.errors)


def report_at(place: Path) -> Report:
    """Read the report in a folder; raises `NoReport`."""
    data = read_report(place)
    run = run_from_data(data)
    tallies = grouped(run, "engine", "query", "pair")
    faults: dict[FaultKey, Fault] = {}
    for item in data["buckets"]:
        try:
            _add(faults, item, tallies)
        except DAMAGE as error:
            raise NoReport(f"{name_of(item)} is damaged: {in_words(error)}") from None
    return Report(run, faults, frozenset(name for fault in faults.values() for name in fault.findings))


def _add(faults: dict[FaultKey, Fault], item: dict[str, Any], tallies: dict[tuple[str, ...], Counter[Kind]]) -> None:
    """Add a finding to its fault."""
    names = ("id", "key", "engine", "query", "pair", "symptom", "state")
    name, key, engine, query, pair, symptom, state = (str(item[n]) for n in names)
    cell, severity = (engine, query, pair), str(item["severity"] or item["kind"])
    compared = total(tallies.get(cell, Counter()), COMPARED)
    fault = faults.setdefault((cell, symptom), Fault(cell, symptom, compared))
    fault.severity = min(fault.severity or severity, severity, key=_gravity)
    fault.amount = max(fault.amount, float(item["amount"]))
    fault.count += int(item["count"])
    fault.states.add(state)
    fault.findings[name] = key.removeprefix(f"{fault.name} · ")


def compare(before: Report, after: Report) -> Comparison:
    """Set two reports against each other."""
    both = [(fault, after.faults[key]) for key, fault in before.faults.items() if key in after.faults]
    same_seed = before.run.seed == after.run.seed
    changes = [_change(*pair, same_seed=same_seed) for pair in both]
    new = (_new(fault, before, same_seed=same_seed) for key, fault in after.faults.items() if key not in before.faults)
    gone = ((fault, _missing(fault, after)[0]) for key, fault in before.faults.items() if key not in after.faults)
    return Comparison(
        before,
        after,
        new=tuple(sorted(new, key=lambda change: not change.worse)),
        gone=tuple(gone),
        changed=tuple(sorted((c for c in changes if c.what), key=lambda change: not change.worse)),
        same=sum(not change.what for change in changes),
        errors=tuple(sorted(shifts(before.run.accuracy, after.run.accuracy), key=lambda shift: not shift.worse)),
        cells=tuple(_cells(before.run, after.run)),
        entries=tuple(_entries(before.run, after.run)),
    )


def _new(fault: Fault, before: Report, *, same_seed: bool) -> Change:
    """A fault that the run before did not meet, though it may have been there, unless it asked the same scenes."""
    said, expected = _missing(fault, before)
    certain = same_seed and said != NOT_ASKED and math.isclose(expected, fault.count)
    return Change(fault, (said,), certain or math.exp(-expected) < CHANCE)


def _missing(fault: Fault, other: Report) -> tuple[str, float]:
    """What speaks for a fault's not being in the other run, and how often it would have been met at its rate."""
    engine, query, pair = fault.cell
    asked = other.run.total(engine=engine, query=query, pair=pair, kinds=COMPARED)
    if not asked:
        return NOT_ASKED, 0.0
    expected = fault.count * asked / fault.compared if fault.compared else 0.0
    return f"0 of {text.count(asked)}, {text.short(expected)} at this rate", expected


def _change(before: Fault, after: Fault, *, same_seed: bool) -> Change:
    """What is different in one fault; how grave its worst scene is depends on the scenes, and so on the seed."""
    what, worse = [], False
    if before.severity != after.severity and same_seed:
        what.append(f"severity {before.severity} → {after.severity}")
        worse |= _gravity(after.severity) < _gravity(before.severity)
    if before.state != after.state:
        what.append(f"ledger {before.state} → {after.state}")
    if direction := _rate_changed(before, after):
        rates = (f"{text.count(fault.count)} of {text.count(fault.compared)}" for fault in (before, after))
        what.append(f"{'more' if direction > 0 else 'less'} often: {' → '.join(rates)}")
        worse |= direction > 0
    return Change(after, tuple(what), worse)


def _gravity(severity: str) -> int:
    """Rank of a severity, the gravest first."""
    order = [known.value for known in Severity]
    return order.index(severity) if severity in order else len(order)


def _rate_changed(before: Fault, after: Fault) -> int:
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
