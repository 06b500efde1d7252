"""The matrix of all pairs: at a glance as a triangle per engine, and pair by pair for every query."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from oracles.outcome import COMPARED, FINDINGS, Kind, Run
from oracles.scene import QUERIES, cells
from oracles.world import SPACE, WORLDS, World
from reports import text
from reports.tables import EMULATED, UNSUPPORTED, CellKey, Column, Entry, Table, engines, grouped, state_of, total

NOTHING_COMPARED = "! nothing compared"

RANKS = (
    "reference-wrong",
    "wrong",
    "inconsistent",
    "crashed",
    "timed-out",
    "problem",
    "convention",
    "undecided",
    "ok",
    "unsupported",
    "none",
)
"""States from the one that a reader should see first; an entry for several queries takes the first of theirs."""

MARKS = {
    "problem": "!",
    "unsupported": "–",
    "none": "",
    "convention": "≈",
    "undecided": "?",
    "ok": "✓",
}


def queries_of_pairs() -> dict[str, tuple[str, ...]]:
    """Queries of each pair, in the order of the pair table."""
    found: dict[str, tuple[str, ...]] = {}
    for cell in cells():
        found[cell.pair] = (*found.get(cell.pair, ()), cell.query)
    return found


def anchor(pair: str) -> str:
    """Anchor of a pair's row."""
    return f"pair-{pair.replace('–', '-')}"


# -- at a glance ---------------------------------------------------------------------------------------------


def overviews(run: Run) -> tuple[Table, ...]:
    """Types against types, a triangle for each engine and world: the worst that its queries on a pair have shown.

    The plane is left out of engines that have been asked nothing there, and space of those of the plane.
    """
    counts = grouped(run, "engine", "query", "pair")
    queries = queries_of_pairs()
    asked = {(key[0], key[2]) for key, note in run.support.items() if note.kind != UNSUPPORTED}

    def table(engine: str, world: World) -> Table:
        found = []
        columns = [kind.__name__ for kind in world.solids]
        for row in (*(kind.__name__ for kind in world.probes), *columns):
            pairs = (f"{row}–{column}" for column in columns)
            cells_of_row = (
                _overview_entry(run, engine, pair, queries[pair], counts) if pair in queries else Entry("")
                for pair in pairs
            )
            found.append((Entry(row), *cells_of_row))
        heading = f"{text.visible(engine)}: the worst over all queries of a pair, with how often it was seen"
        return Table(heading, (Column(""), *map(Column, columns)), tuple(found))

    def worlds(engine: str) -> list[World]:
        names = _pairs_of_worlds()
        return [world for world in WORLDS if any((engine, pair) in asked for pair in names[world])] or [SPACE]

    return tuple(table(engine, world) for engine in engines(run) for world in worlds(engine))


def _pairs_of_worlds() -> dict[World, set[str]]:
    """Names of the pairs of each world."""
    return {world: {f"{a.__name__}–{b.__name__}" for a, b in world.table} for world in WORLDS}


def _overview_entry(
    run: Run, engine: str, pair: str, asked: tuple[str, ...], counts: dict[tuple[str, ...], Counter[Kind]]
) -> Entry:
    keys = [(engine, query, pair) for query in asked]
    entries = {key[1]: matrix_entry(run, key, counts.get(key, Counter()), {}) for key in keys}
    worst = min((entry.state for entry in entries.values()), key=RANKS.index)
    together: Counter[Kind] = sum((counts.get(key, Counter()) for key in keys), Counter())
    bad = text.count(total(together, FINDINGS))
    said = MARKS.get(worst, f"✗{text.THIN}{bad}")
    title = "; ".join(f"{query}: {entry.text}" for query, entry in entries.items())
    return Entry(said, state=worst, title=title, link=anchor(pair) if said else "")


# -- pair by pair --------------------------------------------------------------------------------------------


def matrices(run: Run, links: dict[CellKey, str]) -> tuple[Table, ...]:
    """Pairs by engine and query, of space and of the plane; rays, which have a query of their own, come last in each.

    Pairs that no engine was asked are left out, and counted in the caption.

    Parameters
    ----------
    links
        Anchor of each cell that has findings.
    """
    counts = grouped(run, "engine", "query", "pair")
    queries = queries_of_pairs()
    known = {pair for _, _, pair in (*run.support, *counts)}

    def table(asked: tuple[str, ...], names: set[str]) -> Table:
        keys = [(engine, query) for engine in _engines_in(run, names) for query in asked]
        every = [pair for pair, its_queries in queries.items() if its_queries == asked and pair in names]
        pairs = [pair for pair in every if pair in known]
        rows = [
            (
                Entry(pair, anchor=anchor(pair)),
                *(matrix_entry(run, (*key, pair), counts.get((*key, pair), Counter()), links) for key in keys),
            )
            for pair in pairs
        ]
        columns = (Column(query, group=text.visible(engine)) for engine, query in keys)
        left_out = (
            f"; {text.plural(len(every) - len(pairs), 'other pair')} not asked" if len(pairs) < len(every) else ""
        )
        caption = f"Pairs by engine: {', '.join(asked)}{left_out}"
        return Table(caption, (Column("pair"), *columns), tuple(rows))

    kinds = sorted(set(queries.values()), key=lambda asked: QUERIES.index(asked[0]))
    tables = (table(asked, names) for names in _pairs_of_worlds().values() for asked in kinds)
    return tuple(table for table in tables if table.rows)


def _engines_in(run: Run, names: set[str]) -> list[str]:
    """Engines that answer anything about some pairs; all, where none does."""
    answering = {
        engine for (engine, _, pair), note in run.support.items() if pair in names and note.kind != UNSUPPORTED
    }
    answering |= {key[0] for key in run.counts if key[2] in names and key[4] is not Kind.UNSUPPORTED}
    return [engine for engine in engines(run) if engine in answering] or list(engines(run))


def matrix_entry(run: Run, key: CellKey, verdicts: Counter[Kind], links: dict[CellKey, str]) -> Entry:
    """State of one cell, in words."""
    note = run.support.get(key)
    link = links.get(key, "")
    reason = text.visible(note.reason) if note else ""
    notes = [EMULATED] if note and note.kind == EMULATED else []
    if note and note.kind == UNSUPPORTED:
        return Entry(UNSUPPORTED, state="unsupported", title=reason, link=link)
    state, words, rest = state_of(verdicts)
    if not total(verdicts, COMPARED):
        if note is None and not verdicts:
            return Entry("not asked", state="none")
        state, words = "problem", NOTHING_COMPARED
    return Entry(words, "; ".join(rest + notes), state, reason, link)


# -- support -------------------------------------------------------------------------------------------------


def support_notes(run: Run) -> Table:
    """Why cells are unsupported or emulated: one row per reason, with all its cells."""
    together: dict[tuple[str, str, str], dict[str, list[str]]] = {}
    for (engine, query, pair), note in run.support.items():
        if note.kind == UNSUPPORTED or note.reason:
            together.setdefault((engine, note.kind, note.reason), {}).setdefault(query, []).append(pair)
    rows = []
    for (engine, kind, reason), queries in sorted(together.items()):
        named = "; ".join(_cells_in_words(queries))
        rows.append((*(Entry(text.visible(words)) for words in (engine, kind, reason)), Entry(named)))
    columns = (Column("engine"), Column("support"), Column("how, or why not"), Column("cells"))
    return Table("What the engines answer, and how", columns, tuple(rows))


def _cells_in_words(queries: dict[str, list[str]]) -> Iterable[str]:
    """Pairs behind the queries that share them."""
    sharing: dict[tuple[str, ...], list[str]] = {}
    for query in sorted(queries, key=lambda name: (*QUERIES, name).index(name)):
        sharing.setdefault(tuple(queries[query]), []).append(text.visible(query))
    for pairs, names in sharing.items():
        yield f"{', '.join(names)}: {text.visible(_pairs_in_words(pairs), limit=2000)}"


def _pairs_in_words(pairs: tuple[str, ...]) -> str:
    """One type with the others where all pairs have it, such as "KDOP with Sphere, Box"."""
    split = [pair.split("–") for pair in pairs]
    common = set.intersection(*map(set, split))
    if len(pairs) < 2 or len(common) != 1 or any(len(parts) != 2 for parts in split):
        return ", ".join(pairs)
    (shared,) = common
    others = [b if a == shared else a for a, b in split]
    return f"{shared} with {', '.join(others)}"
