"""What a run makes of the ledger: each entry's state, and each bucket's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from oracles.ledger.entry import Entry
from oracles.ledger.files import Ledger
from oracles.ledger.replay import Fate, Replayed, fate
from oracles.ledger.studies import asked_of, seen_in
from oracles.outcome import Bucket, EntryNote, Run, State

UNSETTLED = (State.NEW, State.STALE, State.CHANGED)
"""States that ask for an entry to be added or taken out: a run that has one is not as expected."""


def settle(run: Run, ledger: Ledger, replays: Sequence[Replayed]) -> None:
    """Give each entry of the engines that were asked its state, and each bucket that of its entry, or NEW."""
    engines = {*run.engines, *(count.engine for count in run.surveys if not count.absent)}
    asked = [entry for entry in ledger.entries if entry.engine in engines]
    run.ledger = [_note(entry, ledger, run, replays) for entry in asked]
    states = {(note.engine, note.name): note for note in run.ledger}
    for bucket in run.buckets:
        note = states.get((bucket.engine, bucket.entry or ""))
        bucket.state = state_by(note)
        bucket.cause = "" if note is None else note.cause
    run.buckets.sort(key=_order)


def state_by(note: EntryNote | None) -> State:
    """State of what an entry explains; NEW without one."""
    if note is None:
        return State.NEW
    return State.CHANGED if note.state is State.CHANGED else State.EXPECTED


def _order(bucket: Bucket) -> tuple[bool, int]:
    """Reference faults first, then what is new; otherwise the order stays."""
    return not bucket.against_reference, list(State).index(bucket.state)


def _note(entry: Entry, ledger: Ledger, run: Run, replays: Sequence[Replayed]) -> EntryNote:
    mine = [r for r in replays if r.witness.engine == entry.engine and r.witness.id in entry.witnesses]
    by_id = {replayed.witness.id: fate(replayed, entry) for replayed in mine}
    fates = Counter(by_id.values())
    seen = sum(b.count for b in run.buckets if (b.engine, b.entry) == entry.key) + seen_in(run, *entry.key)
    state, why = _state(entry, ledger, run, fates, seen)
    return EntryNote(
        entry.engine,
        entry.name,
        entry.cause,
        state,
        why,
        seen,
        len(entry.witnesses),
        tuple(name for name, met in by_id.items() if met is Fate.FAILS),
        entry.upstream,
        entry.file,
        entry.versions,
        str(entry.first_seen or ""),
        _cells(entry, run) if state in UNSETTLED else (),
    )


def _cells(entry: Entry, run: Run) -> tuple[tuple[str, str], ...]:
    """Cells of its engine that an entry is about."""
    return tuple(cell for cell in _asked(run, entry.engine) if entry.fits_cell(*cell))


def _asked(run: Run, engine: str) -> list[tuple[str, str]]:
    """Cells of an engine that were asked, and what surveys and crowds have asked it."""
    cells = [(query, pair) for name, query, pair in run.support if name == engine]
    return cells + asked_of(run, engine)


def _state(entry: Entry, ledger: Ledger, run: Run, fates: Counter[Fate], seen: int) -> tuple[State, str]:
    """State of an entry, and why, where that needs words."""
    passing, changed = fates[Fate.PASSES], fates[Fate.CHANGED]
    if changed:
        return State.CHANGED, f"{_witnesses(changed)} beyond what the entry says: another symptom, or another amount"
    if passing and not fates[Fate.FAILS]:
        if seen:
            return State.CHANGED, f"{_witnesses(passing, 'passes', 'pass')} now, but other findings have its cause"
        return State.STALE, f"{_witnesses(passing, 'passes', 'pass')} now"
    if fates[Fate.FAILS] or seen:
        return State.EXPECTED, f"{_witnesses(passing, 'passes', 'pass')} now" if passing else ""
    return State.UNMATCHED, _unmatched(entry, ledger, run, fates)


def _witnesses(count: int, one: str = "fails", more: str = "fail") -> str:
    return f"1 witness {one}" if count == 1 else f"{count} witnesses {more}"


def _unmatched(entry: Entry, ledger: Ledger, run: Run, fates: Counter[Fate]) -> str:
    """Why nothing that was found fits an entry."""
    if not ledger.applies(entry):
        return f"it is about versions {entry.versions}, not {ledger.versions[entry.engine]}"
    if not any(entry.fits_cell(query, pair) for query, pair in _asked(run, entry.engine)):
        return "none of its cells was asked"
    if fates[Fate.NOT_ASKED]:
        return "the engine does not answer its witnesses' cells"
    return "its witnesses were not replayed" if entry.witnesses else "it has no witness, and no finding fits it"
