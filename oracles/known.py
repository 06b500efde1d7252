"""Known faults of the engines: data with a reason each, so that no bound has to be loosened for them.

An entry of ``oracles/known/ENGINE.toml`` names patterns for query, pair, symptom and regime, how large an error
and in which scenes it excuses, and the reason. What no entry covers is new. Faults of the reference can never
be entered.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from importlib.resources import files
from typing import Any

from oracles.outcome import Kind, Verdict
from oracles.scene import Scene
from refimpl import AABB, Box, Cylinder, Proxy
from refimpl.linear import norm


@dataclass(frozen=True)
class Fault:
    """One known fault; what is not given fits all.

    Attributes
    ----------
    query, pair, symptom, regime
        Shell patterns, of which one has to fit.
    at_most, within
        Largest error that is excused: relative to the scene's size, and as a length.
    thinner_than
        Only scenes in which a box or cylinder has a half extent or radius below this.
    larger_than, smaller_than
        Only scenes whose largest coordinate or extent, of impacts the largest velocity, is at least, at most this.
    slower_than
        Only impacts in which the bodies come nearer along the normal at less than this.
    """

    engine: str
    reason: str
    query: tuple[str, ...] = ("*",)
    pair: tuple[str, ...] = ("*",)
    symptom: tuple[str, ...] = ("*",)
    regime: tuple[str, ...] = ("*",)
    at_most: float = math.inf
    within: float = math.inf
    thinner_than: float = math.inf
    larger_than: float = 0.0
    smaller_than: float = math.inf
    slower_than: float = math.inf

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
        if not all(any(fnmatchcase(text, p) for p in patterns) for patterns, text in texts):
            return False
        if verdict.amount > min(self.at_most * scene.size, self.within):
            return False
        thin = math.isinf(self.thinner_than) or thinnest(scene) < self.thinner_than
        slow = math.isinf(self.slower_than) or approach_of(scene) < self.slower_than
        return thin and slow and self.larger_than <= scene.size <= self.smaller_than


def approach_of(scene: Scene) -> float:
    """Velocity at which two bodies come nearer along the normal; infinite where nothing moves."""
    if scene.motion is None:
        return math.inf
    return -float(scene.motion.closing / norm(scene.motion.normal))


def thinnest(scene: Scene) -> float:
    """Smallest half extent of any box, or of the box around any cylinder; infinite where there is neither."""
    return min(_thickness(shape) for shape in (scene.a, scene.b))


def _thickness(shape: Proxy) -> float:
    if isinstance(shape, AABB):
        shape = shape.to_box()
    if isinstance(shape, Box):
        return float(shape.half_extents.min())
    if isinstance(shape, Cylinder):
        return min(float(shape.radius), float(norm(shape.q - shape.p)) / 2)
    return math.inf


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
        values = {name: _value(value) for name, value in entry.items() if name != "reason"}
        yield Fault(engine, " ".join(entry["reason"].split()), **values)


def _value(value: Any) -> Any:
    """A number, or patterns: one may stand without a list."""
    if isinstance(value, str):
        return (value,)
    return tuple(value) if isinstance(value, list) else float(value)
