"""The ledger of a run: the lists that come with the package and those of the user, with their witnesses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path

from oracles.fault import Fault
from oracles.ledger.entry import Entry, fault_in
from oracles.ledger.reading import LedgerError, entries_in, read_table
from oracles.ledger.witness import AnyWitness, load_witness
from oracles.outcome import Verdict
from oracles.scene import Scene

__all__ = ["SHIPPED", "Ledger", "LedgerError"]

SHIPPED = Path(str(files("oracles"))) / "known"
"""Folder of the lists that come with the package: a file for each engine."""


@dataclass(frozen=True)
class Ledger:
    """Entries, the first of which that covers a finding explains it: those of the user before those that are shipped.

    Attributes
    ----------
    witnesses
        By engine and id.
    versions
        Of the engines asked; entries for other versions match nothing. Empty until `at` names them.
    own
        The user's files; what is new is written to the last of them.
    """

    entries: tuple[Entry, ...] = ()
    witnesses: Mapping[tuple[str, str], AnyWitness] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    own: tuple[Path, ...] = ()

    @classmethod
    def load(cls, own: Sequence[Path] = (), *, shipped: bool = True, create: bool = False) -> Ledger:
        """Read the user's files and, unless told otherwise, those that are shipped.

        Parameters
        ----------
        create
            Take a file that is not there for an empty one: it is to be written.

        Raises
        ------
        LedgerError
            When a file, an entry of it or a witness is not as it should be.
        """
        paths = [path for path in own if path.exists() or not create]
        found: list[Entry] = []
        retired: set[tuple[str, str]] = set()
        for path in [*paths, *(sorted(SHIPPED.glob("*.toml")) if shipped else [])]:
            entries, gone = entries_in(read_table(path)[1], path)
            retired |= set(gone)
            found += entries
        left = tuple(entry for entry in found if entry.key not in retired or Path(entry.file) in paths)
        _require_names(left)
        witnesses = _Kept(left)
        for entry in left:
            if Path(entry.file) in paths:  # what a user has written is read at once, so that mistakes are told at once
                for name in entry.witnesses:
                    witnesses[entry.engine, name]
        return cls(left, witnesses, own=tuple(own))

    def at(self, versions: Mapping[str, str]) -> Ledger:
        """Return the same ledger for these versions of the engines."""
        return replace(self, versions=dict(versions))

    @cached_property
    def _live(self) -> dict[str, list[Entry]]:
        live: dict[str, list[Entry]] = {}
        for entry in self.entries:
            if self.applies(entry):
                live.setdefault(entry.engine, []).append(entry)
        return live

    def applies(self, entry: Entry) -> bool:
        """Whether an entry is about the version of its engine that is asked."""
        version = self.versions.get(entry.engine)
        return version is None or entry.fits_version(version)

    def match(self, engine: str, scene: Scene, verdict: Verdict) -> Entry | None:
        """Entry that explains a finding; None when it is new, and for any finding against the reference."""
        return self.explaining(fault_in(engine, scene, verdict))

    def explaining(self, fault: Fault) -> Entry | None:
        """Entry that explains a failure, of whatever was asked; None when it is new."""
        return next((entry for entry in self._live.get(fault.engine, ()) if entry.explains(fault)), None)

    def name_of(self, fault: Fault) -> str:
        """Name of that entry; empty when it is new."""
        entry = self.explaining(fault)
        return entry.name if entry else ""

    def live(self, engine: str) -> tuple[Entry, ...]:
        """Entries that apply to an engine as it is."""
        return tuple(self._live.get(engine, ()))


def _require_names(entries: Iterable[Entry]) -> None:
    files: dict[tuple[str, str], str] = {}
    for entry in entries:
        if entry.key in files:
            raise LedgerError(f"{entry.file}: {entry.engine} has an entry {entry.name!r} in {files[entry.key]}, too")
        files[entry.key] = entry.file


class _Kept(Mapping[tuple[str, str], AnyWitness]):
    """Witnesses in their files, each read and proven when it is first asked for: most runs need one engine's."""

    def __init__(self, entries: Iterable[Entry]) -> None:
        self._folders = {(entry.engine, name): Path(entry.file).parent for entry in entries for name in entry.witnesses}
        self._read: dict[tuple[str, str], AnyWitness] = {}

    def __getitem__(self, key: tuple[str, str]) -> AnyWitness:
        """Return the witness; raises `LedgerError` when its file holds none."""
        if key not in self._read:
            self._read[key] = load_witness(self._folders[key], *key)
        return self._read[key]

    def __contains__(self, key: object) -> bool:
        """Whether there is one by this engine and name, which reads nothing."""
        return key in self._folders

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Iterate over engines and names."""
        return iter(self._folders)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._folders)
