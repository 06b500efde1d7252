"""What has to be added to the ledger, and taken out, for a run to be as expected; `writing` has the text of it.

What is new goes to the user's last file; where there is none, to the lists of the package, if they are those of a clone
and have the engine, or to a new file. An entry is taken out of the file that it stands in, and one that is shipped is
retired by the user's file. Comments and order stay.
Nothing that speaks against the reference is ever written.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from datetime import date
from pathlib import Path

from oracles.engines import SHIPPED as SHIPPED_ENGINES
from oracles.ledger.entry import ANY, ANY_DECADE, Entry, FirstSeen
from oracles.ledger.files import SHIPPED, Ledger
from oracles.ledger.reading import LONGEST_TEXT, REFERENCE
from oracles.ledger.studies import Failed, failed_in
from oracles.ledger.witness import AnyWitness, Witness
from oracles.ledger.writing import Changes, is_source
from oracles.outcome import Bucket, EntryNote, Kind, Run, State
from oracles.surveys import surveyed

UNEXPLAINED = "Not looked into yet."
"""How the cause of an entry begins that was written by a run and by no one who knows."""
LOST = (Kind.CRASHED, Kind.TIMED_OUT)
"""Witnesses of these are hardly shrunk, for each try costs a process: their geometry tells little."""
MOST_WITNESSES = 3
"""Witnesses of one new entry."""


def changes(run: Run, ledger: Ledger, *, fill: bool = False) -> Changes:
    """Find out what has to be added and taken out after a run.

    Parameters
    ----------
    fill
        Also give witnesses to entries that have none and explain findings of this run.
    """
    found = Changes()
    today = date.fromisoformat(run.started[:10])
    entries = {entry.key: entry for entry in ledger.entries}
    outdated: dict[str, Entry] = {}
    for note in run.ledger:
        if note.state in (State.STALE, State.CHANGED):
            entry = entries[note.engine, note.name]
            outdated |= {name: entry for name in entry.witnesses if note.state is State.CHANGED}
            _outdate(entry, note, run, ledger, found)
        elif fill and note.seen and not note.witnesses:
            _refresh(entries[note.engine, note.name], [], run, ledger, found)
    taken = {name for _, name in entries}
    for group in _kindred(run):
        version = run.engine_versions.get(group[0].engine, "")
        was = next((outdated[b.witness.scene.id] for b in group if b.witness.scene.id in outdated), None)
        entry = _entry(group, version, today, was, taken)
        taken.add(entry.name)
        _add(entry, _witnesses(group, version), ledger, found)
    for those in _new_of_studies(run):
        version = run.engine_versions.get(those[0].engine, "")
        was = next((outdated[f.witness.id] for f in those if f.witness.id in outdated), None)
        regimes = tuple(dict.fromkeys(regime for failed in those for regime in failed.regimes))
        entry = replace(_fresh(those[0], those[0].claim, version, today, was, taken), regime=regimes)
        taken.add(entry.name)
        _add(entry, [failed.witness for failed in those[:MOST_WITNESSES]], ledger, found)
    return found


def _kindred(run: Run) -> list[list[Bucket]]:
    """New buckets of one cell and symptom: an entry for each group is enough."""
    groups: dict[tuple[str, ...], list[Bucket]] = {}
    for bucket in run.buckets:
        if bucket.state is State.NEW and not bucket.against_reference and bucket.engine != REFERENCE:
            key = bucket.engine, bucket.query, bucket.pair, bucket.symptom
            groups.setdefault(key, []).append(bucket)
    return list(groups.values())


def _new_of_studies(run: Run) -> list[list[Failed]]:
    """The same of surveys and crowds."""
    groups: dict[tuple[str, ...], list[Failed]] = {}
    for failed in failed_in(run):
        if not failed.entry:
            groups.setdefault((failed.engine, failed.query, failed.pair, failed.symptom), []).append(failed)
    return list(groups.values())


def _outdate(entry: Entry, note: EntryNote, run: Run, ledger: Ledger, found: Changes) -> None:
    """Take out an entry, or give it the witnesses that hold where it still explains findings."""
    kept = [ledger.witnesses[entry.engine, name] for name in note.holding]
    if kept or (note.state is State.CHANGED and note.seen):
        _refresh(entry, kept, run, ledger, found)
    elif _writable(entry, ledger):
        found.of(Path(entry.file)).remove.append(entry.key)
    else:
        found.of(_file_for(entry.engine, ledger)).retire.append(entry.key)


def _refresh(entry: Entry, kept: list[AnyWitness], run: Run, ledger: Ledger, found: Changes) -> None:
    """Let an entry have these witnesses from now on, or without any those of the buckets that it explains."""
    if not kept:
        version = run.engine_versions.get(entry.engine, "")
        explained = [bucket for bucket in run.buckets if (bucket.engine, bucket.entry) == entry.key]
        kept = _witnesses({bucket.pair: bucket for bucket in reversed(explained)}.values(), version)
        kept += [f.witness for f in failed_in(run) if (f.engine, f.entry) == entry.key]
        kept = kept[:MOST_WITNESSES]
    if _writable(entry, ledger):
        path = Path(entry.file)
        found.of(path).mend[entry.key] = tuple(witness.id for witness in kept)
        found.witnesses += [(path.parent, witness) for witness in kept]
    else:
        found.of(_file_for(entry.engine, ledger)).retire.append(entry.key)
        _add(entry, kept, ledger, found)


def _writable(entry: Entry, ledger: Ledger) -> bool:
    """Whether the file that an entry stands in is one of those that are written."""
    return Path(entry.file) in ledger.own or (not ledger.own and is_source())


def _add(entry: Entry, witnesses: Iterable[AnyWitness], ledger: Ledger, found: Changes) -> None:
    kept = list(witnesses)
    path = _file_for(entry.engine, ledger)
    found.of(path).add.append(replace(entry, witnesses=tuple(w.id for w in kept), file=str(path)))
    found.witnesses += [(path.parent, witness) for witness in kept]


def _file_for(engine: str, ledger: Ledger) -> Path:
    """File to which is added: the user's last; without one the package's where that may be written, else a new one."""
    if ledger.own:
        return ledger.own[-1]
    folder = SHIPPED if engine in {*SHIPPED_ENGINES, *surveyed()} and is_source() else Path()
    return folder / (re.sub(r"[^\w.+-]", "_", engine) + ".toml")


def _witnesses(buckets: Iterable[Bucket], version: str) -> list[AnyWitness]:
    """Record the witnesses of a few buckets; one that does not come again would be of no use."""
    repeating = [bucket for bucket in buckets if bucket.witness.repeats]
    return [Witness(bucket.witness, bucket.key, version) for bucket in repeating[:MOST_WITNESSES]]


def _entry(group: list[Bucket], version: str, today: date, was: Entry | None, taken: set[str]) -> Entry:
    """Make the entry of new buckets; where a witness has changed, it keeps the cause and history of its old one."""
    first = group[0]
    decades = [bucket.decade for bucket in group if bucket.decade is not None]
    told = all(b.witness.repeats and b.witness.verdict.kind not in LOST for b in group)
    return replace(
        _fresh(first, first.witness.verdict.claim, version, today, was, taken),
        degeneracy=tuple(dict.fromkeys(b.degeneracy for b in group)) if told else ANY,
        decades=(min(decades), max(decades)) if decades else ANY_DECADE,
    )


def _fresh(new: Bucket | Failed, claim: str, version: str, today: date, was: Entry | None, taken: set[str]) -> Entry:
    """An entry for a cell and symptom, with the cause and history of an old one where there is one."""
    words = " ".join(f"{UNEXPLAINED} {claim}"[: LONGEST_TEXT - 1].split())
    return Entry(
        new.engine,
        _free_name(new, taken),
        was.cause if was else words,
        query=(new.query,),
        pair=(new.pair,),
        symptom=(new.symptom,),
        versions=was.versions if was else f">={version}" if version else "",
        upstream=was.upstream if was else (),
        first_seen=was.first_seen if was else FirstSeen(today, version or "unknown"),
    )


def _free_name(new: Bucket | Failed, taken: set[str]) -> str:
    words = re.findall(r"[a-z0-9]+", f"{new.query} {new.pair} {new.symptom}".lower())
    name = "-".join(words)[:90]
    return next(free for n in range(1, 10_000) if (free := name if n == 1 else f"{name}-{n}") not in taken)
