"""The record of a run: a manifest, and a Parquet file for each task that is done, so that a run can go on.

A file has one row for each answer; what else the task brought home is JSON in its metadata, under ``outcome``. It is
written beside, and moved to a name that ends in the digest of its content: what has that name is whole.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import duckdb

from oracles.outcome import Outcome
from oracles.records import outcome_from_json, outcome_to_json
from oracles.screening import KINDS
from oracles.sheets import Sheet, joined
from oracles.tasks import Task

FORMAT = "proxyproof-record-2"
FOLDER = "answers"
LARGEST_FILE, LARGEST_MANIFEST = 1 << 29, 1 << 20
"""Bytes of a file that is read back."""
DIGITS = 16
OWN = re.compile(rf"[A-Za-z0-9_.+-]+\.[0-9a-f]{{{DIGITS}}}\.parquet(\.damaged)?|.*\.part")


class RecordError(Exception):
    """A record cannot be gone on with; the text says why."""


@dataclass
class Store:
    """Record of one run in a folder.

    Attributes
    ----------
    problems
        What was damaged, and whether the record had to end before the run.
    samples
        Files of the tasks that are done and whose answers are a sample of the regimes.
    """

    folder: Path
    problems: list[str] = field(default_factory=list)
    failed: bool = False
    samples: list[Path] = field(default_factory=list)
    _recorded: dict[str, Path] = field(default_factory=dict)

    # -- beginning -------------------------------------------------------------------------------------------

    @classmethod
    def begin(cls, folder: Path, manifest: dict[str, Any]) -> Store:
        """Begin a record in place of an older one; raises `OSError`."""
        answers = folder / FOLDER
        answers.mkdir(parents=True, exist_ok=True)
        for path in answers.iterdir():
            if OWN.fullmatch(path.name):
                path.unlink()
        _replace(folder / "manifest.json", json.dumps({"format": FORMAT, **manifest}, indent=1).encode())
        return cls(folder)

    @classmethod
    def go_on(cls, folder: Path, manifest: dict[str, Any]) -> Store:
        """Go on with a record.

        Raises
        ------
        RecordError
            When there is none, or it is of another run; names what differs.
        """
        old = read_manifest(folder)
        differing = list(_differences(old, manifest))
        if differing:
            raise RecordError(f"{str(folder)!r} is of another run: {'; '.join(differing)}")
        store = cls(folder)
        for path in sorted((folder / FOLDER).iterdir()):
            if path.name.endswith(".part"):
                store.problems.append(f"{FOLDER}/{path.name} is half written, and its task is done again")
                path.unlink()
            elif path.suffix == ".parquet":
                store._recorded[path.name.rsplit(".", 2)[0]] = path
        return store

    @property
    def waiting(self) -> int:
        """How many recorded tasks have not been recalled yet."""
        return len(self._recorded)

    # -- single tasks ----------------------------------------------------------------------------------------

    def recall(self, task: Task) -> Outcome | None:
        """Return the outcome of a task that is recorded; a damaged file is set aside and named."""
        path = self._recorded.pop(file_stem(task), None)
        if path is None:
            return None
        try:
            outcome = _read(path, task)
        except (ValueError, OSError, RecursionError, duckdb.Error) as error:
            reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
            self.problems.append(f"{FOLDER}/{path.name} is damaged ({reason}), and its task is done again")
            path.rename(path.with_name(path.name + ".damaged"))
            return None
        self._count(path, task)
        return outcome

    def _count(self, path: Path, task: Task) -> None:
        if task.samples:
            self.samples.append(path)

    def record(self, task: Task, outcome: Outcome) -> bool:
        """Write down what a task brought home, if possible; the first failure ends the record, not the run."""
        if self.failed:
            return False
        part = self.folder / FOLDER / f"{file_stem(task)}.part"
        try:
            _write(part, task, outcome)
            digest = sha256(part.read_bytes()).hexdigest()[:DIGITS]
            path = part.with_name(f"{file_stem(task)}.{digest}.parquet")
            os.replace(part, path)
            self._count(path, task)
        except (OSError, duckdb.Error) as error:
            self.failed = True
            reason = getattr(error, "strerror", None) or str(error).splitlines()[0][:300]
            self.problems.append(f"the record ends before the run, which went on in memory: {reason}")
        finally:
            if self.failed:
                part.unlink(missing_ok=True)
        return not self.failed


def file_stem(task: Task) -> str:
    """Beginning of the name of a task's file: an engine of one's own may have any name."""
    plain = re.sub(r"[^A-Za-z0-9_+-]", "_", task.name)[:100]
    return plain if plain == task.name else f"{plain}-{sha256(task.name.encode()).hexdigest()[:8]}"


# -- manifests -----------------------------------------------------------------------------------------------


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read what a folder's record is of; raises `RecordError` where there is none."""
    path = folder / "manifest.json"
    try:
        if path.stat().st_size > LARGEST_MANIFEST:
            raise RecordError(f"{path} is too large")
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordError(f"{str(folder)!r} holds no record of a run: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise RecordError(f"{path} is damaged: {error}") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise RecordError(f"{path} is not of the format {FORMAT}")
    return data


def _differences(old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """What keeps two runs from being one, by name."""
    for name, wanted in new.items():
        found = old.get(name)
        if isinstance(wanted, dict):
            found = found if isinstance(found, dict) else {}
            for key in sorted({*wanted, *found}):
                if found.get(key) != wanted.get(key):
                    yield f"{name} {key} was {found.get(key)!r:.200}, is {wanted.get(key)!r:.200}"
        elif found != wanted:
            yield f"{name} was {found!r:.200}, is {wanted!r:.200}"


# -- Parquet -------------------------------------------------------------------------------------------------

WORD = "($words::VARCHAR[])[{0} + 1] AS {0}"
"""A code as its word; the type is named, for a task without answers has no words, and its columns are texts as well."""
SELECT = f"""
SELECT {", ".join(map(WORD.format, ("engine", "query", "pair", "regime")))},
       number, status, $kinds[kind + 1] AS verdict, {WORD.format("symptom")}, amount, pressure,
       CASE WHEN NOT isnan(error) THEN error END AS error, size, CASE WHEN NOT isnan(gap) THEN gap END AS gap, aspect,
       proven
FROM answers
"""


def answers_of(database: duckdb.DuckDBPyConnection, sheets: Sequence[Sheet]) -> tuple[str, dict[str, Any]]:
    """Query, with what it is to be given, for all rows of some sheets; what is not known is NULL."""
    words, answers = joined(sheets)
    database.register("answers", answers)
    return SELECT, {"words": words, "kinds": [kind.value for kind in KINDS]}


def _write(path: Path, task: Task, outcome: Outcome) -> None:
    said = json.dumps({"format": FORMAT, "task": task.name, **outcome_to_json(outcome)})
    options = "FORMAT parquet, COMPRESSION zstd, KV_METADATA {outcome: $outcome}"
    with duckdb.connect(config={"threads": 1}) as database:
        select, given = answers_of(database, outcome.sheets)
        database.execute(f"COPY ({select}) TO $path ({options})", given | {"path": str(path), "outcome": said})


def _read(path: Path, task: Task) -> Outcome:
    """Read a task's file; raises `ValueError` when it is not what was written."""
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError("it is too large")
    if sha256(path.read_bytes()).hexdigest()[:DIGITS] != path.name.split(".")[-2]:
        raise ValueError("its content is not what was written")
    with duckdb.connect(config={"threads": 1}) as database:
        query = "SELECT value FROM parquet_kv_metadata($path) WHERE key = 'outcome'::BLOB"
        found = database.execute(query, {"path": str(path)}).fetchall()
    if len(found) != 1:
        raise ValueError("it names no outcome")
    data = json.loads(found[0][0])
    if data.get("format") != FORMAT or data.get("task") != task.name:
        raise ValueError(f"it is not of the task {task.name}")
    return outcome_from_json(data)


def _replace(path: Path, content: bytes) -> None:
    part = path.with_name(path.name + ".part")
    part.write_bytes(content)
    os.replace(part, path)
