"""Broad phases in a report: crowds of N bodies, which pairs an engine had to name, and what it left out."""

from __future__ import annotations

import re
from collections.abc import Iterator

from oracles.crowds.boxes import REGIMES
from oracles.crowds.failing import Witness
from oracles.crowds.judging import CrowdCount
from oracles.outcome import Run
from reports import ledger, text
from reports.tables import Column, Entry, Table

WHAT = (
    "Crowds of boxes and balls, as they are and after bodies were moved. A broad phase has to name every pair whose "
    "bounding boxes overlap; a pair that it leaves out is wrong, proven by a point of both boxes. A pair that it names "
    "though the boxes are apart is no error but costs time: a false alarm, where they are farther apart than the "
    "margin that the engine declares. Where the engine finds nearest pairs, it is asked for one in the same crowd with "
    "bodies of an eighth of the size, and no other may be nearer."
)
COLUMNS: tuple[tuple[str, str], ...] = (
    ("crowds", "crowds"),
    ("bodies", "bodies"),
    ("pairs to name", "pairs"),
    ("missing", "missing"),
    ("known", "known"),
    ("touching", "close"),
    ("named though apart", "extra"),
    ("false alarms", "false_alarms"),
    ("nearest pair asked", "nearest"),
    ("not the nearest", "not_nearest"),
    ("lost", "lost"),
)
LONGEST = 2000
"""Characters of a crowd's bodies that a report shows; `report.json` has them all."""
BROKEN = ("missing", "not_nearest", "lost")
"""What breaks a promise."""


def matrix(run: Run) -> Table:
    """Regimes by engines; no rows where no broad phase was asked."""
    engines = list(dict.fromkeys(count.engine for count in run.crowds))
    found = {(count.regime, count.engine): count for count in run.crowds}
    rows = []
    for regime in dict.fromkeys(count.regime for count in run.crowds):
        why = REGIMES.get(regime.split(",")[0])
        entries = (_state(found.get((regime, engine))) for engine in engines)
        rows.append((Entry(text.visible(regime), title=why.why if why else ""), *entries))
    columns = (Column("crowd"), *(Column(text.visible(engine)) for engine in engines))
    return Table("Broad phase: pairs that had to be named, by regime and engine", columns, tuple(rows))


def _state(count: CrowdCount | None) -> Entry:
    if count is None:
        return Entry("not asked", state="none")
    alarms = f"{text.plural(count.false_alarms, 'false alarm')}" if count.false_alarms else ""
    of_all = text.count(count.pairs)
    if count.lost:
        said = f"✗ {text.count(count.lost)} of {text.plural(count.crowds, 'crowd')} lost"
        return Entry(said, "; ".join(map(text.visible, count.errors)), "crashed")
    if count.not_nearest:
        said = f"✗ {text.count(count.not_nearest)} of {text.plural(count.nearest, 'nearest pair')} wrong"
        return Entry(said, f"{text.count(count.missing)} of {of_all} missing", "wrong")
    if count.missing:
        return Entry(f"✗ {text.count(count.missing)} of {of_all} missing", alarms, "wrong")
    if count.known:
        said = f"{text.count(count.known)} wrong by a known fault"
        entries = "; ".join(map(text.visible, count.explained))
        return Entry(f"≈ {of_all}", "; ".join(filter(None, (said, alarms))), "convention", title=entries)
    return Entry(f"✓ {of_all}", alarms, "ok") if count.pairs else Entry(f"? {text.count(count.close)} touching", alarms)


def counts(run: Run) -> Table:
    """Everything that was counted, one row for each engine."""
    rows = []
    for engine in dict.fromkeys(count.engine for count in run.crowds):
        mine = [count for count in run.crowds if count.engine == engine]
        sums = [sum(getattr(count, name) for count in mine) for _, name in COLUMNS]
        entries = [
            Entry(text.count(n), state="wrong" if n and name in BROKEN else "")
            for (_, name), n in zip(COLUMNS, sums, strict=True)
        ]
        named = mine[0]
        promise = f"{named.calls}; margin {text.short(named.margin)}: {named.margin_why}"
        rows.append((Entry(text.visible(engine)), *entries, Entry(text.visible(promise, 1000))))
    columns = (Column("engine"), *(Column(title, True) for title, _ in COLUMNS), Column("asked by, and what it says"))
    return Table("Broad phase: everything that was counted", columns, tuple(rows))


def witnesses(run: Run) -> Table:
    """Of each engine, regime, symptom and cause a small crowd that shows it, with what is proven."""
    rows = []
    for count in run.crowds:
        for found in count.witnesses:
            which = Entry(f"{text.visible(count.engine)} · {text.visible(count.regime)}")
            what = Entry(found.symptom, state="convention" if found.entry else "wrong")
            script = Entry(script_path(count.engine, count.regime, found.entry) if found.script else "")
            shown = Entry(_proven(found)), Entry(text.visible("; ".join(_bodies(found)), LONGEST))
            rows.append((which, what, ledger.told(run, count.engine, found.entry), *shown, script))
    titles = "engine · crowd", "what", "ledger", "proven", "bodies", "script"
    columns = tuple(Column(title) for title in titles)
    return Table(
        "What is wrong, each in the smallest crowd found; of a missing pair bodies 0 and 1", columns, tuple(rows)
    )


def scripts(run: Run) -> dict[str, str]:
    """Scripts that show the missing pairs, by their paths in the report's folder."""
    shown = ((count, found) for count in run.crowds for found in count.witnesses if found.script)
    return {script_path(count.engine, count.regime, found.entry): found.script for count, found in shown}


def script_path(engine: str, regime: str, entry: str) -> str:
    """Where the script of an engine's missing pair in a regime stands; named by letters and numbers only."""
    words = re.findall("[a-z0-9]+", f"{engine} {regime} {entry}".lower())
    return f"repro/broad-phase-{'-'.join(words)[:80]}.py"


def _proven(witness: Witness) -> str:
    if witness.pair is None:
        return text.visible(witness.said)
    return f"bounding boxes overlap by {text.short(witness.depth)} along every axis, or more"


def _bodies(witness: Witness) -> Iterator[str]:
    """Each body as it is written in Python, and where it was before."""
    crowd = witness.crowd
    for number in range(len(crowd)):
        center, half, before = (column[number].tolist() for column in (crowd.center, crowd.half, crowd.before))
        shape = f"Sphere({center}, {half[0]})" if crowd.balls[number] else f"Box({center}, {half}, [0, 0, 0, 1])"
        yield shape + (f" moved there from {before}" if before != center else "")


def shown(run: Run) -> tuple[Table, ...]:
    """Tables of the section, none where no broad phase was asked."""
    if not run.crowds:
        return ()
    found = witnesses(run)
    return (matrix(run), counts(run), *([found] if found.rows else []))


def failures(run: Run) -> dict[str, str]:
    """Engine to a sentence, where it broke its promise in a way that the ledger does not explain."""
    said = {}
    for engine in dict.fromkeys(count.engine for count in run.crowds if count.wrong):
        mine = [count for count in run.crowds if count.engine == engine]
        missing, wrong, lost = (sum(getattr(count, name) for count in mine) for name in BROKEN)
        pairs = f"{text.plural(missing, 'pair')} missing, {text.plural(wrong, 'nearest pair')} wrong"
        said[engine] = f"broad phase of {engine}: {pairs}, {text.plural(lost, 'crowd')} lost"
    return said
