"""The tables of a report, as data: terminal, HTML and Markdown only give them their form.

Texts in a `Table` are already harmless to read (`text.visible`), but not yet escaped for any format.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from oracles.outcome import COMPARED, FINDINGS, Kind, Run
from oracles.recipes import AT_REST, is_for, kind_of
from oracles.scene import IMPACT, QUERIES, SWEEP, cells
from reports import text

CellKey = tuple[str, str, str]
"""engine, query, pair"""

FIELDS = ("engine", "query", "pair", "regime")
UNSUPPORTED, EMULATED = "unsupported", "emulated"
AUDITED = "refimpl"
"""In the place of an engine's name: the reference, whose own answers the campaign audits."""

ASIDE = (Kind.CONVENTION, Kind.UNDECIDED, Kind.UNSUPPORTED, Kind.SKIPPED)
"""What an entry says beside the worst."""

LEGEND = (
    ("ok", "✓ 120", "all 120 answers agree with the proven interval"),
    ("convention", "≈ 120", "no answer is wrong, but some are right only by the engine's own convention"),
    ("wrong", "✗ 3 of 120", "3 answers are wrong"),
    ("inconsistent", "✗ inconsistent 3 of 120", "3 answers contradict others of the engine"),
    ("crashed", "✗ crashed 3 of 120", "the engine's process ended, or the engine raised an error"),
    ("timed-out", "✗ timed out 3 of 120", "the engine did not return in time"),
    ("undecided", "? 120", "the proven intervals allow no decision"),
    ("problem", "! nothing compared", "the cell is supported, and nothing was compared: the run is incomplete"),
    ("unsupported", "unsupported", "the engine has no such query for this pair; – where that holds for all queries"),
    ("unsupported", "emulated", "the engine answers by way of another of its queries or shapes"),
)
"""State, example and meaning of the matrix's entries."""


@dataclass(frozen=True)
class Entry:
    """One cell of a table.

    Attributes
    ----------
    note
        A second, quieter line.
    state
        What the entry says, as a word that formats may colour; the text says it too.
    title
        A longer explanation, for formats that can show one on demand.
    link
        Anchor within the report.
    anchor
        The entry's own.
    """

    text: str
    note: str = ""
    state: str = ""
    title: str = ""
    link: str = ""
    anchor: str = ""


@dataclass(frozen=True)
class Column:
    """Heading of a column; neighbours of one `group` share a heading above theirs."""

    title: str
    numeric: bool = False
    group: str = ""


More = tuple[tuple[tuple[str, ...], ...], ...]
"""For each row the rows below it: a heading, and for each group of columns its numbers, as the script reads them."""


@dataclass(frozen=True)
class Table:
    """Rows of entries; the first entry of a row is the row's heading.

    Attributes
    ----------
    more
        What each row opens to where a script can open it.
    """

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Entry, ...], ...]
    more: More = ()


def grouped(run: Run, *names: str) -> dict[tuple[str, ...], Counter[Kind]]:
    """Verdicts on engines' answers, summed over everything but the named fields of their key."""
    positions = [FIELDS.index(name) for name in names]
    sums: dict[tuple[str, ...], Counter[Kind]] = {}
    for key, n in run.counts.items():
        if key[0] == AUDITED:
            continue
        sums.setdefault(tuple(key[p] for p in positions), Counter())[key[4]] += n
    return sums


def audit(run: Run) -> Counter[Kind]:
    """Verdicts on the reference's own answers."""
    verdicts: Counter[Kind] = Counter()
    for key, n in run.counts.items():
        if key[0] == AUDITED:
            verdicts[key[4]] += n
    return verdicts


def total(verdicts: Counter[Kind], kinds: Iterable[Kind]) -> int:
    """How many of the verdicts are of these kinds."""
    return sum(verdicts[kind] for kind in kinds)


def engines(run: Run) -> list[str]:
    """Every engine of the run, in its order."""
    named = dict.fromkeys([*run.engines, *(key[0] for key in run.counts)])
    return [engine for engine in named if engine != AUDITED]


def regimes(run: Run) -> list[str]:
    """Every regime of the run, in its order."""
    return list(dict.fromkeys([*run.regimes, *(key[3] for key in run.counts)]))


def supported(run: Run) -> list[CellKey]:
    """Cells that their engine answers, by engine and then in the order of the pair table."""
    order = [(cell.query, cell.pair) for cell in cells()]
    keys = [(engine, query, pair) for engine in engines(run) for query, pair in order]
    return [key for key in keys if key in run.support and run.support[key].kind != UNSUPPORTED]


def summary(run: Run) -> Table:
    """Verdicts per engine, and per engine and query."""
    kinds = [Kind.AGREES, Kind.CONVENTION, Kind.WRONG, Kind.CRASHED, Kind.TIMED_OUT, Kind.UNDECIDED]
    if run.total(kinds=(Kind.INCONSISTENT,)):
        kinds.insert(3, Kind.INCONSISTENT)
    per_engine, per_query, own = grouped(run, "engine"), grouped(run, "engine", "query"), audit(run)
    if any(verdicts[Kind.REFERENCE_WRONG] for verdicts in (own, *per_engine.values())):
        kinds.append(Kind.REFERENCE_WRONG)
    kinds.append(Kind.SKIPPED)

    def row(heading: str, verdicts: Counter[Kind], note: str = "") -> tuple[Entry, ...]:
        amounts = [Entry(text.count(total(verdicts, COMPARED)))]
        for kind in kinds:
            bad = kind in FINDINGS and verdicts[kind] > 0
            amounts.append(Entry(text.count(verdicts[kind]), state=_state(kind) if bad else ""))
        return (Entry(heading, note), *amounts)

    rows = []
    for engine in engines(run):
        rows.append(row(text.visible(engine), per_engine.get((engine,), Counter())))
        for query in QUERIES:
            if set(per_query.get((engine, query), ())) - {Kind.UNSUPPORTED}:
                rows.append(row(f"{text.visible(engine)} · {query}", per_query[engine, query]))
    if own:
        rows.append(row(AUDITED, own, "audited"))
    columns = (Column("engine · query"), Column("compared", True), *(Column(kind.value, True) for kind in kinds))
    return Table("Verdicts per engine and query", columns, tuple(rows))


def state_of(verdicts: Counter[Kind]) -> tuple[str, str, list[str]]:
    """The worst that happened in a cell, in words, and what else happened."""
    compared = text.count(total(verdicts, COMPARED))
    bad = [kind for kind in (Kind.REFERENCE_WRONG, *FINDINGS[:-1]) if verdicts[kind]]
    rest = [f"{kind.value} {text.count(verdicts[kind])}" for kind in bad[1:]]
    rest += [f"{kind.value} {text.count(verdicts[kind])}" for kind in ASIDE if verdicts[kind]]
    if bad:
        said = "" if bad[0] is Kind.WRONG else f"{bad[0].value} "
        return _state(bad[0]), f"✗ {said}{text.count(verdicts[bad[0]])} of {compared}", rest
    if verdicts[Kind.CONVENTION]:
        return "convention", f"≈ {compared}", rest
    if verdicts[Kind.AGREES]:
        return "ok", f"✓ {compared}", rest
    return "undecided", f"? {compared}", rest


def _state(kind: Kind) -> str:
    return kind.value.replace(" ", "-")


def regime_table(run: Run) -> Table:
    """Why each regime exists, and what was asked in it."""
    counts = grouped(run, "regime")
    rows = []
    for regime in regimes(run):
        verdicts = counts.get((regime,), Counter())
        found, compared = total(verdicts, FINDINGS), total(verdicts, COMPARED)
        amounts = (Entry(text.count(compared), state="" if compared else "problem"), Entry(text.count(found)))
        rows.append((Entry(text.visible(regime)), Entry(text.visible(run.regimes.get(regime, ""))), *amounts))
    columns = (Column("regime"), Column("why"), Column("compared", True), Column("findings", True))
    return Table("Regimes: the recipes for scenes", columns, tuple(rows))


def coverage(run: Run) -> tuple[Table, ...]:
    """Answers compared per pair, query, engine and regime, with the findings among them; of impacts and sweeps apart.

    Impacts and sweeps have regimes of their own.
    """
    asked, tables = supported(run), []
    for which, kind in (("", AT_REST), ("Impacts: ", IMPACT), ("Sweeps: ", SWEEP)):
        cells = [cell for cell in asked if kind_of(cell[1]) == kind]
        if cells or kind == AT_REST:
            tables.append(_coverage(which, run, cells))
    return tuple(tables)


def regimes_for(query: str, names: Iterable[str]) -> list[str]:
    """Of these regimes the ones that have scenes for a query."""
    return [name for name in names if is_for(name, query)]


def _coverage(which: str, run: Run, cells: list[CellKey]) -> Table:
    counts, whole = grouped(run, *FIELDS), grouped(run, *FIELDS[:3])
    names = regimes_for(cells[0][1] if cells else "", regimes(run))
    rows = []
    for cell in cells:
        row = [Entry(" · ".join(map(text.visible, cell))), _coverage_entry(whole.get(cell, Counter()))]
        row += [_coverage_entry(counts.get((*cell, regime), Counter())) for regime in names]
        rows.append(tuple(row))
    columns = [Column(text.visible(regime), True) for regime in names]
    return Table(
        f"{which}Answers compared per engine, query, pair and regime; ✗ counts the findings among them",
        (Column("engine · query · pair"), Column("all", True), *columns),
        tuple(rows),
    )


def _coverage_entry(verdicts: Counter[Kind]) -> Entry:
    compared, found = total(verdicts, COMPARED), total(verdicts, FINDINGS)
    state = "wrong" if found else "" if compared else "problem"
    told = [f"{kind.value} {text.count(verdicts[kind])}" for kind in Kind if verdicts[kind]]
    details = "" if compared == verdicts[Kind.AGREES] else ", ".join(told)
    return Entry(text.count(compared), f"✗ {text.count(found)}" if found else "", state, details)


def time_split(run: Run) -> str:
    """Where the time went, in a line; empty where none was spent."""
    whole = sum(run.timing.values())
    parts = sorted(run.timing.items(), key=lambda item: -item[1])
    said = ", ".join(f"{text.visible(name)} {text.share(spent, whole)}" for name, spent in parts)
    return f"time: {said}" if whole else ""


def timing(run: Run) -> Table:
    """Where the time went, of all workers together."""
    whole = sum(run.timing.values())
    rows = [
        (Entry(text.visible(name)), Entry(text.seconds(spent)), Entry(text.share(spent, whole)))
        for name, spent in sorted(run.timing.items(), key=lambda item: -item[1])
    ]
    return Table(
        f"Time that all workers together have spent; the run took {text.seconds(run.seconds)} by the clock",
        (Column("on"), Column("time", True), Column("share", True)),
        tuple(rows),
    )
