"""Reading what strangers may have written: a ledger's TOML, and the bytes of any file, within limits."""

from __future__ import annotations

import math
import os
import re
import stat
import tomllib
from collections.abc import Callable
from dataclasses import fields
from datetime import date, datetime
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from packaging.specifiers import InvalidSpecifier, SpecifierSet

from oracles import surveys
from oracles.engine import NAME as ENGINE_NAME
from oracles.fault import BROAD_PHASE, survey_query
from oracles.ledger.entry import Entry, FirstSeen
from oracles.scene import QUERIES, cells

MOST_BYTES = 1_000_000
MOST_ENTRIES, MOST_ITEMS = 2_000, 64
LONGEST_TEXT, LONGEST_PATTERN = 4_000, 200
REFERENCE = "refimpl"

NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,99}")
WITNESS = re.compile(r"[0-9a-f]{12}")
LINK = re.compile(r"https?://[!-~]{1,400}")


class LedgerError(ValueError):
    """A ledger, or a witness of it, cannot be used; the text names the file, the place and the reason."""


def read_file(path: Path, most: int = MOST_BYTES) -> bytes:
    """Bytes of a regular file that is not too large; raises `LedgerError`."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # a pipe would never open
    except (OSError, ValueError) as error:
        raise LedgerError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise LedgerError(f"{path} is no ordinary file")
    with os.fdopen(descriptor, "rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise LedgerError(f"{path} is larger than {most} bytes")
    return data


def read_table(path: Path) -> tuple[str, dict[str, Any]]:
    """Text and content of a TOML file; raises `LedgerError`."""
    try:
        text = read_file(path).decode("utf-8")
        return text, tomllib.loads(text)
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise LedgerError(f"{path} is not TOML: {error}") from None
    except RecursionError:
        raise LedgerError(f"{path} is nested too deeply") from None


def entries_in(table: dict[str, Any], path: Path) -> tuple[list[Entry], list[tuple[str, str]]]:
    """Entries of one ledger, and engines and names of the entries of other ledgers that it retires."""
    unknown = set(table) - {"engine", "entry", "retired"}
    if unknown:
        raise LedgerError(f"{path}: unknown {_quoted(unknown)}; a ledger has engine, [[entry]] and [[retired]]")
    engine = _engine(table["engine"], f"{path}: engine") if "engine" in table else None
    found = [
        _entry(item, engine, f"{path}: entry {number}", str(path)) for number, item in _tables(table, "entry", path)
    ]
    names = [entry.key for entry in found]
    for key in names:
        if names.count(key) > 1:
            raise LedgerError(f"{path}: two entries of {key[0]} are named {key[1]!r}")
    retired = [_retired(item, engine, f"{path}: retired {number}") for number, item in _tables(table, "retired", path)]
    return found, retired


def _tables(table: dict[str, Any], name: str, path: Path) -> list[tuple[int, dict[str, Any]]]:
    items = table.get(name, [])
    if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
        raise LedgerError(f"{path}: {name} must be tables, each under [[{name}]]")
    if len(items) > MOST_ENTRIES:
        raise LedgerError(f"{path}: more than {MOST_ENTRIES} tables [[{name}]]")
    return list(enumerate(items, start=1))


def _entry(item: dict[str, Any], engine: str | None, place: str, file: str) -> Entry:
    if isinstance(item.get("name"), str):
        place = f"{place} ({_quoted([item['name']])})"
    unknown = set(item) - set(FIELDS)
    if unknown:
        raise LedgerError(f"{place}: unknown {_quoted(unknown)}; known are {', '.join(FIELDS)}")
    for name in ("name", "cause"):
        if name not in item:
            raise LedgerError(f"{place}: {name} is missing")
    values = {name: FIELDS[name](value, f"{place}: {name}") for name, value in item.items()}
    values.setdefault("engine", engine)
    if values["engine"] is None:
        raise LedgerError(f"{place}: engine is missing, here and at the top of the file")
    return Entry(**values, file=file)


def _retired(item: dict[str, Any], engine: str | None, place: str) -> tuple[str, str]:
    unknown = set(item) - {"engine", "name", "since"}
    if unknown:
        raise LedgerError(f"{place}: unknown {_quoted(unknown)}; known are engine, name, since")
    if "name" not in item:
        raise LedgerError(f"{place}: name is missing")
    if "since" in item:
        _first_seen(item["since"], f"{place}: since")
    by = _engine(item["engine"], f"{place}: engine") if "engine" in item else engine
    if by is None:
        raise LedgerError(f"{place}: engine is missing, here and at the top of the file")
    return by, _name(item["name"], f"{place}: name")


# -- fields ---------------------------------------------------------------------------------------------------


def _text(value: Any, place: str, longest: int = LONGEST_TEXT) -> str:
    if not isinstance(value, str) or not value.strip():
        raise LedgerError(f"{place} must be a text")
    if len(value) > longest:
        raise LedgerError(f"{place} is longer than {longest} characters")
    return " ".join(value.split())


def _matching(pattern: re.Pattern[str], meaning: str) -> Callable[[Any, str], str]:
    def parse(value: Any, place: str) -> str:
        if not isinstance(value, str) or not pattern.fullmatch(value):
            raise LedgerError(f"{place} must be {meaning}, got {repr(value)[:80]}")
        return value

    return parse


_name = _matching(NAME, "small letters, digits and dashes, at most 100")
_engine_name = _matching(ENGINE_NAME, "an engine's name")
_link = _matching(LINK, "a link with http or https")
_witness = _matching(WITNESS, "an id of 12 hexadecimal digits")


def _engine(value: Any, place: str) -> str:
    if value == REFERENCE:
        raise LedgerError(f"{place}: what speaks against the reference can never be listed")
    return _engine_name(value, place)


def _several(parse: Callable[[Any, str], str]) -> Callable[[Any, str], tuple[str, ...]]:
    """Make the parser of one text or a list of them."""

    def of_one_or_more(value: Any, place: str) -> tuple[str, ...]:
        items = value if isinstance(value, list) else [value]
        if len(items) > MOST_ITEMS:
            raise LedgerError(f"{place} has more than {MOST_ITEMS} items")
        return tuple(parse(item, place) for item in items)

    return of_one_or_more


def _pattern(value: Any, place: str) -> str:
    return _text(value, place, LONGEST_PATTERN)


def _query(value: Any, place: str) -> str:
    pattern = _pattern(value, place)
    names = (*QUERIES, BROAD_PHASE, *map(survey_query, surveys.SURVEYS))
    if not any(fnmatchcase(name, pattern) for name in names):
        raise LedgerError(f"{place} {repr(value)[:80]} fits no query; there are {', '.join(names)}")
    return pattern


def _pair(value: Any, place: str) -> str:
    """Pattern of pairs, which may be written with any dash, or of what surveys and crowds ask."""
    pattern = _pattern(value, place)
    dashed = re.sub("[-—]", "–", pattern)
    return dashed if any(fnmatchcase(cell.pair, dashed) for cell in cells()) else pattern


def _number(value: Any, place: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise LedgerError(f"{place} must be a positive number, got {repr(value)[:80]}")
    return float(value)


def _decades(value: Any, place: str) -> tuple[int, int]:
    if not isinstance(value, list) or [type(x) for x in value] != [int, int] or not value[0] <= value[1]:
        raise LedgerError(f"{place} must be the first and the last decade, as in [-3, 0], got {repr(value)[:80]}")
    return value[0], value[1]


def _versions(value: Any, place: str) -> str:
    text = _text(value, place, LONGEST_PATTERN)
    try:
        SpecifierSet(text)
    except InvalidSpecifier:
        raise LedgerError(f"{place} must be as in PEP 440, such as '>=1.2,<2', got {repr(text)[:80]}") from None
    return text


def _first_seen(value: Any, place: str) -> FirstSeen:
    if not isinstance(value, dict) or set(value) != {"date", "version"}:
        raise LedgerError(f"{place} must be {{ date = 2026-01-31, version = '1.0' }}")
    day = value["date"]
    if not isinstance(day, date) or isinstance(day, datetime):
        raise LedgerError(f"{place}.date must be a date, as in 2026-01-31")
    return FirstSeen(day, _text(value["version"], f"{place}.version", LONGEST_PATTERN))


FIELDS: dict[str, Callable[[Any, str], Any]] = {
    "engine": _engine,
    "name": _name,
    "cause": _text,
    "query": _several(_query),
    "pair": _several(_pair),
    **dict.fromkeys(("symptom", "degeneracy", "regime"), _several(_pattern)),
    "decades": _decades,
    **dict.fromkeys(("at_most", "within", "thinner_than", "larger_than", "smaller_than", "slower_than"), _number),
    "versions": _versions,
    "upstream": _several(_link),
    "witnesses": _several(_witness),
    "first_seen": _first_seen,
}
"""What an entry may hold, in the order in which it is written."""

assert set(FIELDS) | {"file"} == {field.name for field in fields(Entry)}


def _quoted(names: Any) -> str:
    """Foreign names in an error's line: in quotes, and not too many."""
    return ", ".join(repr(str(name)[:80]) for name in sorted(names)[:8])
