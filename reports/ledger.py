"""What a run makes of the ledger of known faults, as a table and as a sentence."""

from __future__ import annotations

import re
from dataclasses import dataclass
from hashlib import sha256

from oracles.ledger.states import state_by
from oracles.ledger.studies import failed_in
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

ADDRESS = re.compile(r"https?://[A-Za-z0-9][\w.~/#?=&%+:@-]{3,300}", re.ASCII)
"""What is taken for a link."""

FIRST_SENTENCE = re.compile(r".{40,400}?[.](?=\s)|.{1,400}", re.DOTALL)


@dataclass(frozen=True)
class History:
    """What the ledger knows of a fault.

    Attributes
    ----------
    anchor
        Of the entry, within the report.
    cause
        First sentence of it.
    since
        When it was first recorded, and in which versions it is.
    upstream
        Reports of it.
    """

    entry: str
    anchor: str
    state: str
    cause: str
    since: str
    upstream: tuple[str, ...]


def history(note: EntryNote) -> History:
    """What an entry of the ledger tells of the buckets that it explains."""
    since = [f"first seen {note.first_seen}"] if note.first_seen else []
    since += [f"in versions {note.versions}"] if note.versions else []
    first = FIRST_SENTENCE.match(note.cause)
    return History(
        text.visible(note.name),
        anchor(note),
        note.state.value,
        text.visible(first[0] if first else ""),
        text.visible("; ".join(since)),
        tuple(map(text.visible, note.upstream)),
    )


def is_address(words: str) -> bool:
    """Whether foreign words are an address that a reader may follow, and nothing else."""
    return ADDRESS.fullmatch(words) is not None


def anchor(note: EntryNote) -> str:
    """Anchor of an entry's row, the same in every report."""
    return f"l-{sha256(f'{note.engine} {note.name}'.encode(errors='replace')).hexdigest()[:12]}"


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


def told(run: Run, engine: str, entry: str) -> Entry:
    """State of what an entry explains of surveys and crowds, and by which entry; what has none is new."""
    note = next((note for note in run.ledger if (note.engine, note.name) == (engine, entry)), None)
    state = state_by(note)
    by = None if note is None else history(note)
    return Entry(state.value, note=_note(f"{by.entry}: {by.cause}") if by else "", state=COLOURS.get(state, ""))


def _row(note: EntryNote) -> tuple[Entry, ...]:
    failing = f"{len(note.holding)} of {note.witnesses} fail" if note.witnesses else "none"
    return (
        Entry(f"{text.visible(note.engine)} · {text.visible(note.name)}", anchor=anchor(note)),
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
    others = sum(not failed.entry for failed in failed_in(run))
    said += [f"{text.count(others)} {WORDS[State.NEW]} in surveys and crowds"] * bool(others)
    return ", ".join(said)
