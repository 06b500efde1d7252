"""What has to be added to the ledger, and taken out, for a run to be as expected: the exact text, and its writing.

What is new goes to the user's last file; where there is none, to the lists of the package, if they are those of a clone
and have the engine, or to a new file. An entry is taken out of the file that it stands in, and one that is shipped is
retired by the user's file. Comments and order stay.
Nothing that speaks against the reference is ever written.
"""

from __future__ import annotations

import os
import re
import tempfile
import textwrap
from collections.abc import Iterable
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Table

from oracles.engines import SHIPPED as ENGINES
from oracles.ledger.entry import ANY, ANY_DECADE, Entry, FirstSeen
from oracles.ledger.files import SHIPPED, Ledger
from oracles.ledger.reading import FIELDS, LONGEST_TEXT, REFERENCE, LedgerError, read_table
from oracles.ledger.witness import Witness, path_of
from oracles.outcome import Bucket, EntryNote, Kind, Run, State

UNEXPLAINED = "Not looked into yet."
"""How the cause of an entry begins that was written by a run and by no one who knows."""
LOST = (Kind.CRASHED, Kind.TIMED_OUT)
"""Witnesses of these are hardly shrunk, for each try costs a process: their geometry tells little."""
WIDTH = 120
MOST_WITNESSES = 3
"""Witnesses of one new entry."""


@dataclass(frozen=True)
class Change:
    """What one ledger file has to gain and to lose.

    Attributes
    ----------
    add
        New entries.
    remove
        Engine and name of entries of this file that go.
    mend
        Witnesses that entries of this file have from now on, by engine and name.
    retire
        Engine and name of entries of lists that cannot be written.
    """

    path: Path
    add: list[Entry] = field(default_factory=list)
    remove: list[tuple[str, str]] = field(default_factory=list)
    mend: dict[tuple[str, str], tuple[str, ...]] = field(default_factory=dict)
    retire: list[tuple[str, str]] = field(default_factory=list)

    def __bool__(self) -> bool:
        """Return whether there is anything to be changed."""
        return bool(self.add or self.remove or self.mend or self.retire)


@dataclass
class Changes:
    """All that would make the run as expected."""

    files: dict[Path, Change] = field(default_factory=dict)
    witnesses: list[tuple[Path, Witness]] = field(default_factory=list)
    """Folder of the ledger, and what is to be kept there."""

    def of(self, path: Path) -> Change:
        """Changes of one file."""
        return self.files.setdefault(path, Change(path))


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
    return found


def _kindred(run: Run) -> list[list[Bucket]]:
    """New buckets of one cell and symptom: an entry for each group is enough."""
    groups: dict[tuple[str, ...], list[Bucket]] = {}
    for bucket in run.buckets:
        if bucket.state is State.NEW and not bucket.against_reference and bucket.engine != REFERENCE:
            key = bucket.engine, bucket.query, bucket.pair, bucket.symptom
            groups.setdefault(key, []).append(bucket)
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


def _refresh(entry: Entry, kept: list[Witness], run: Run, ledger: Ledger, found: Changes) -> None:
    """Let an entry have these witnesses from now on, or without any those of the buckets that it explains."""
    if not kept:
        version = run.engine_versions.get(entry.engine, "")
        explained = [bucket for bucket in run.buckets if (bucket.engine, bucket.entry) == entry.key]
        kept = _witnesses({bucket.pair: bucket for bucket in reversed(explained)}.values(), version)
    if _writable(entry, ledger):
        path = Path(entry.file)
        found.of(path).mend[entry.key] = tuple(witness.id for witness in kept)
        found.witnesses += [(path.parent, witness) for witness in kept]
    else:
        found.of(_file_for(entry.engine, ledger)).retire.append(entry.key)
        _add(entry, kept, ledger, found)


def _writable(entry: Entry, ledger: Ledger) -> bool:
    """Whether the file that an entry stands in is one of those that are written."""
    return Path(entry.file) in ledger.own or (not ledger.own and _shipped_is_source())


def _add(entry: Entry, witnesses: Iterable[Witness], ledger: Ledger, found: Changes) -> None:
    kept = list(witnesses)
    path = _file_for(entry.engine, ledger)
    found.of(path).add.append(replace(entry, witnesses=tuple(w.id for w in kept), file=str(path)))
    found.witnesses += [(path.parent, witness) for witness in kept]


def _file_for(engine: str, ledger: Ledger) -> Path:
    """File to which is added: the user's last; without one the package's where that may be written, else a new one."""
    if ledger.own:
        return ledger.own[-1]
    folder = SHIPPED if engine in ENGINES and _shipped_is_source() else Path()
    return folder / (re.sub(r"[^\w.+-]", "_", engine) + ".toml")


def _shipped_is_source() -> bool:
    """Whether the shipped lists are those of a clone, and not of an installed package."""
    return (SHIPPED.parent.parent / "pyproject.toml").exists()


def _witnesses(buckets: Iterable[Bucket], version: str) -> list[Witness]:
    """Record the witnesses of a few buckets; one that does not come again would be of no use."""
    repeating = [bucket for bucket in buckets if bucket.witness.repeats]
    return [Witness(bucket.witness, bucket.key, version) for bucket in repeating[:MOST_WITNESSES]]


def _entry(group: list[Bucket], version: str, today: date, was: Entry | None, taken: set[str]) -> Entry:
    """Make the entry of new buckets; where a witness has changed, it keeps the cause and history of its old one."""
    first = group[0]
    decades = [bucket.decade for bucket in group if bucket.decade is not None]
    told = all(b.witness.repeats and b.witness.verdict.kind not in LOST for b in group)
    claim = f"{UNEXPLAINED} {first.witness.verdict.claim}"[: LONGEST_TEXT - 1]
    return Entry(
        first.engine,
        _free_name(first, taken),
        was.cause if was else " ".join(claim.split()),
        query=(first.query,),
        pair=(first.pair,),
        symptom=(first.symptom,),
        degeneracy=tuple(dict.fromkeys(b.degeneracy for b in group)) if told else ANY,
        decades=(min(decades), max(decades)) if decades else ANY_DECADE,
        versions=was.versions if was else f">={version}" if version else "",
        upstream=was.upstream if was else (),
        first_seen=was.first_seen if was else FirstSeen(today, version or "unknown"),
    )


def _free_name(bucket: Bucket, taken: set[str]) -> str:
    words = re.findall(r"[a-z0-9]+", f"{bucket.query} {bucket.pair} {bucket.symptom}".lower())
    name = "-".join(words)[:90]
    return next(free for n in range(1, 10_000) if (free := name if n == 1 else f"{name}-{n}") not in taken)


# -- text -----------------------------------------------------------------------------------------------------


def described(found: Changes) -> str:
    """Text to add and to take out, file by file, as it stands in the files."""
    parts = []
    for path, change in found.files.items():
        document = _document(path)
        engine = _engine_of(document)
        items = {_key(item, engine): item for item in _tables(document, "entry", path)}
        gone = [_alone(item) for key, item in items.items() if key in change.remove or key in change.mend]
        if gone:
            parts.append(f"# take out of {path}:\n\n" + "\n".join(gone))
        mended = [_alone(_mended(items[key], ids)) for key, ids in change.mend.items()]
        fresh = tomlkit.document()
        _append(fresh, change, engine, path)
        if mended or fresh:
            parts.append(f"# add to {path}:\n\n" + "\n".join([*mended, tomlkit.dumps(fresh)]))
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def _alone(item: Table) -> str:
    """Text of one entry, as it stands in its file."""
    return "[[entry]]\n" + item.as_string().strip("\n") + "\n"


def _mended(item: Table, ids: tuple[str, ...]) -> Table:
    copied = deepcopy(item)
    copied["witnesses"] = list(ids)
    return copied


def _document(path: Path) -> Any:
    if not path.exists():
        return tomlkit.document()
    try:
        return tomlkit.parse(read_table(path)[0])
    except TOMLKitError as error:
        raise LedgerError(f"{path} is not TOML: {error}") from None


def _tables(document: Any, name: str, path: Path) -> AoT:
    """The tables of one kind, which must not stand in a list in brackets: that could not be edited."""
    found = document.get(name)
    if found is None:
        return tomlkit.aot()
    if not isinstance(found, AoT):
        raise LedgerError(f"{path}: each {name} must stand under a line [[{name}]]")
    return found


def _engine_of(document: Any) -> str:
    """Engine that the entries of a file are about unless they say otherwise."""
    return str(document.get("engine", ""))


def _key(item: Table, engine: str) -> tuple[str, str]:
    return str(item.get("engine", engine)), str(item["name"])


def _append(document: Any, change: Change, engine: str, path: Path) -> None:
    entries = [_table(entry, engine) for entry in change.add]
    retired = [tomlkit.item({"engine": e, "name": name}) for e, name in change.retire]
    for name, tables in (("entry", entries), ("retired", retired)):
        if not tables:
            continue
        if name not in document:
            document.append(name, tomlkit.aot())
        several = _tables(document, name, path)
        for table in tables:
            several.append(table)


def _table(entry: Entry, engine: str) -> Table:
    """Write an entry: what says no more than the default is left out."""
    table = tomlkit.table()
    usual = Entry("", "", "")
    for name in FIELDS:
        value = getattr(entry, name)
        if (name == "engine" and value == engine) or (value == getattr(usual, name) and name != "engine"):
            continue
        table.add(name, _item(name, value))
    table.add(tomlkit.nl())
    return table


def _item(name: str, value: Any) -> Any:
    if name == "cause":
        return tomlkit.string("\n".join(textwrap.wrap(value, WIDTH, break_long_words=False)), multiline=True)
    if isinstance(value, FirstSeen):
        seen = tomlkit.inline_table()
        seen.update({"date": value.date, "version": value.version})
        return seen
    if isinstance(value, tuple):
        return value[0] if len(value) == 1 and name not in ("witnesses", "upstream") else list(value)
    return value


# -- writing --------------------------------------------------------------------------------------------------


def require_writable(ledger: Ledger) -> None:
    """Raise `LedgerError` unless what is new could be written."""
    path = ledger.own[-1] if ledger.own else SHIPPED
    if not ledger.own and not _shipped_is_source():
        raise LedgerError(f"the ledger in {path} is part of an installed package: name a file with --ledger FILE")
    _require(path)


def _require(path: Path) -> None:
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise LedgerError(f"{path} cannot be written: name a file of your own with --ledger FILE")


def write(found: Changes) -> None:
    """Write the witnesses, then the ledgers, each at once; then remove the witnesses that none lists any more.

    Raises
    ------
    LedgerError
        When a file cannot be written; those before it have been.
    """
    for path in found.files:
        _require(path)
    for folder, witness in found.witnesses:
        _replace(path_of(folder, witness.engine, witness.id), witness.to_text())
    for path, change in found.files.items():
        document = _document(path)
        engine = _engine_of(document)
        entries = _tables(document, "entry", path)
        before = _listed(entries, engine)
        for i in reversed(range(len(entries))):
            key = _key(entries[i], engine)
            if key in change.mend:
                entries[i]["witnesses"] = list(change.mend[key])
            elif key in change.remove:
                del entries[i]
        if "entry" in document and not entries:
            del document["entry"]
        _append(document, change, engine, path)
        _replace(path, tomlkit.dumps(document))
        _forget(path.parent, before)


def _replace(path: Path, text: str) -> None:
    """Write a file by renaming, so that it is never there by half."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
            try:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
                os.chmod(file.name, path.stat().st_mode if path.exists() else 0o644)
                os.replace(file.name, path)
            except BaseException:
                os.unlink(file.name)
                raise
    except OSError as error:
        raise LedgerError(f"{path} cannot be written: {error.strerror or error}") from None


def _forget(folder: Path, before: Iterable[tuple[str, str]]) -> None:
    """Remove those witnesses that no ledger of the folder lists any more."""
    listed: set[tuple[str, str]] = set()
    for path in folder.glob("*.toml"):
        document = _document(path)
        listed |= _listed(_tables(document, "entry", path), _engine_of(document))
    for engine, name in set(before) - listed:
        with suppress(OSError):
            path_of(folder, engine, name).unlink()


def _listed(entries: AoT, engine: str) -> set[tuple[str, str]]:
    found = set()
    for item in entries:
        ids = item.get("witnesses", [])
        found |= {(_key(item, engine)[0], str(w)) for w in (ids if isinstance(ids, list) else [ids])}
    return found
