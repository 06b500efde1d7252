"""What a run makes of the ledger of known faults, as a table and as a sentence."""

from __future__ import annotations

from oracles.outcome import EntryNote, Run, State
from reports import text
from reports.tables import Column, Entry, Table

WORDS = {
    State.NEW: "new",
    State.CHANGED: "changed",
    State.STALE: "stale",
    State.EXPECTED: "expected",
    State.UNMATCHED: "unmatched",
}
COLOURS = {State.NEW: "wrong", State.CHANGED: "problem", State.STALE: "problem", State.UNMATCHED: "unsupported"}
"""States of the matrix whose colours these share."""


def table(run: Run) -> Table:
    """One row per entry of the ledger: those that ask for something to be done first."""
    notes = sorted(run.ledger, key=lambda note: list(State).index(note.state))
    columns = (
        Column("entry"),
        Column("state"),
        Column("seen", numeric=True),
        Column("witnesses", numeric=True),
        Column("cause"),
    )
    return Table("The ledger of known faults", columns, tuple(_row(note) for note in notes))


def _row(note: EntryNote) -> tuple[Entry, ...]:
    failing = f"{len(note.holding)} of {note.witnesses} fail" if note.witnesses else "none"
    return (
        Entry(f"{text.visible(note.engine)} · {text.visible(note.name)}"),
        Entry(note.state.value, note=_note(note.why), state=COLOURS.get(note.state, "")),
        Entry(text.count(note.seen)),
        Entry(failing),
        Entry(text.visible(note.cause, limit=4000), note="; ".join(map(_note, note.upstream))),
    )


def _note(words: str) -> str:
    """Foreign words in an entry's note, whose parts are set apart by semicolons."""
    return text.visible(words).replace("; ", ", ")


def in_words(run: Run) -> str:
    """How many buckets are in each state, and how many entries are stale or changed: "3 new, 40 expected"."""
    counts = run.unsettled
    counts[State.EXPECTED] = sum(bucket.state is not State.NEW for bucket in run.buckets)
    said = [f"{text.count(counts[state])} {word}" for state, word in WORDS.items() if counts[state]]
    return ", ".join(said)
