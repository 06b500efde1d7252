"""The ledger's files: the exact text of what has to be added and taken out, and its writing; comments stay."""

from __future__ import annotations

import os
import tempfile
import textwrap
from collections.abc import Iterable
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Table

from oracles.ledger.entry import Entry, FirstSeen
from oracles.ledger.files import SHIPPED, Ledger
from oracles.ledger.reading import FIELDS, LedgerError, read_table
from oracles.ledger.witness import AnyWitness, path_of, text_of

WIDTH = 120


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
    witnesses: list[tuple[Path, AnyWitness]] = field(default_factory=list)
    """Folder of the ledger, and what is to be kept there."""

    def of(self, path: Path) -> Change:
        """Changes of one file."""
        return self.files.setdefault(path, Change(path))


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


def is_source() -> bool:
    """Whether the shipped lists are those of a clone, and not of an installed package."""
    return (SHIPPED.parent.parent / "pyproject.toml").exists()


def require_writable(ledger: Ledger) -> None:
    """Raise `LedgerError` unless what is new could be written."""
    path = ledger.own[-1] if ledger.own else SHIPPED
    if not ledger.own and not is_source():
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
        _replace(path_of(folder, witness.engine, witness.id), text_of(witness))
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
