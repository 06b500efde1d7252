"""Known faults of the engines: data with a reason each, so that no bound has to be loosened for them.

An entry of ``oracles/known/ENGINE.toml`` names patterns (shell wildcards) for query, pair, symptom and regime, the
largest error relative to the scene's size that it excuses, and the reason in a sentence. What no entry covers
is new. Faults of the reference can never be entered.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from importlib.resources import files
from typing import Any

from oracles.outcome import Kind, Verdict
from oracles.scene import Scene


@dataclass(frozen=True)
class Fault:
    """One known fault; an empty list of patterns would fit nothing, so the default fits all."""

    engine: str
    reason: str
    query: tuple[str, ...] = ("*",)
    pair: tuple[str, ...] = ("*",)
    symptom: tuple[str, ...] = ("*",)
    regime: tuple[str, ...] = ("*",)
    at_most: float = float("inf")

    def covers(self, engine: str, scene: Scene, verdict: Verdict) -> bool:
        """Whether this entry explains the finding."""
        if engine != self.engine or verdict.kind is Kind.REFERENCE_WRONG:
            return False
        texts = (
            (self.query, scene.query),
            (self.pair, scene.cell.pair),
            (self.symptom, verdict.symptom),
            (self.regime, scene.regime),
        )
        fits = all(any(fnmatchcase(text, p) for p in patterns) for patterns, text in texts)
        return fits and not verdict.amount > self.at_most * scene.size


@dataclass(frozen=True)
class KnownFaults:
    """The list of known faults."""

    faults: tuple[Fault, ...] = ()

    @classmethod
    def shipped(cls) -> KnownFaults:
        """Load the lists that come with the package."""
        tables = sorted(
            (f for f in files("oracles").joinpath("known").iterdir() if f.name.endswith(".toml")),
            key=lambda f: f.name,
        )
        return cls(
            tuple(
                fault for table in tables for fault in parse(table.name.removesuffix(".toml"), table.read_text("utf-8"))
            )
        )

    def reason(self, engine: str, scene: Scene, verdict: Verdict) -> str | None:
        """Why this finding is expected; None when it is new."""
        return next((f.reason for f in self.faults if f.covers(engine, scene, verdict)), None)


def parse(engine: str, text: str) -> Iterable[Fault]:
    """Entries of one engine's list; raises `ValueError` that names a wrong entry."""
    names = {f.name for f in fields(Fault)} - {"engine"}
    for number, entry in enumerate(tomllib.loads(text).get("fault", []), start=1):
        unknown = set(entry) - names
        if unknown or not str(entry.get("reason", "")).strip():
            raise ValueError(f"known faults of {engine}, entry {number}: needs a reason; unknown: {sorted(unknown)}")
        values: dict[str, Any] = {
            k: tuple([v] if isinstance(v, str) else v) for k, v in entry.items() if k not in ("reason", "at_most")
        }
        yield Fault(engine, " ".join(entry["reason"].split()), at_most=float(entry.get("at_most", "inf")), **values)
