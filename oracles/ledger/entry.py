"""An entry of the ledger: one cause, and how far it reaches."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import date
from fnmatch import fnmatchcase
from functools import cached_property

from packaging.specifiers import SpecifierSet
from packaging.version import InvalidVersion, Version

from oracles.degeneracy import degeneracy
from oracles.fault import Fault
from oracles.outcome import Kind, Verdict
from oracles.scene import Scene
from refimpl import AABB, Box, Composite, Cylinder, Proxy
from refimpl.linear import norm

ANY = ("*",)
ANY_DECADE = (-400, 0)
"""First and last decade that the ratio of two doubles can have, errors larger than the scene counted as of its size."""


@dataclass(frozen=True)
class FirstSeen:
    """When a fault was first recorded, and in which version of the engine."""

    date: date
    version: str

    def __str__(self) -> str:
        """Date and version, for people."""
        return f"{self.date}, version {self.version}"


@dataclass(frozen=True)
class Entry:
    """One known fault of one engine; what is not given fits all.

    Attributes
    ----------
    name
        Names the entry among those of its engine.
    cause
        What goes wrong where in the engine, and when.
    query, pair, symptom, degeneracy, regime
        Shell patterns, of which one has to fit; the degeneracy is what is special about the scene itself. Of surveys
        the query is ``survey NAME`` and the pair the question, of crowds ``broad phase`` and ``pairs`` or ``nearest``.
    decades
        First and last decade of the error relative to the scene's size; findings without an amount fit any.
    at_most, within
        Largest error that the cause makes: relative to the scene's size, and as a length.
    thinner_than
        Only scenes in which a box or cylinder, or one that is a part, has a half extent or radius below this.
    larger_than, smaller_than
        Only scenes whose largest coordinate or extent, of impacts the largest velocity, of crowds the larger diagonal
        of the two bounding boxes, is at least, at most this.
    slower_than
        Only impacts in which the bodies come nearer along the normal at less than this.
    versions
        Versions of the engine that have the fault, as in PEP 440: ``>=3.2.6,<4``.
    upstream
        Links to reports of it.
    witnesses
        Ids of its witnesses, which are kept beside the ledger.
    file
        Where the entry stands.
    """

    engine: str
    name: str
    cause: str
    query: tuple[str, ...] = ANY
    pair: tuple[str, ...] = ANY
    symptom: tuple[str, ...] = ANY
    degeneracy: tuple[str, ...] = ANY
    regime: tuple[str, ...] = ANY
    decades: tuple[int, int] = ANY_DECADE
    at_most: float = math.inf
    within: float = math.inf
    thinner_than: float = math.inf
    larger_than: float = 0.0
    smaller_than: float = math.inf
    slower_than: float = math.inf
    versions: str = ""
    upstream: tuple[str, ...] = ()
    witnesses: tuple[str, ...] = ()
    first_seen: FirstSeen | None = None
    file: str = ""

    @property
    def key(self) -> tuple[str, str]:
        """Engine and name."""
        return self.engine, self.name

    def covers(self, engine: str, scene: Scene, verdict: Verdict) -> bool:
        """Whether a finding has this cause, as far as can be told; never one against the reference."""
        return self.explains(fault_in(engine, scene, verdict))

    def explains(self, fault: Fault) -> bool:
        """Whether a failure has this cause, as far as can be told; never one of the reference."""
        if fault.engine != self.engine or fault.against_reference:
            return False
        texts = (
            (self.query, fault.query),
            (self.pair, fault.pair),
            (self.symptom, fault.symptom),
            (self.regime, fault.regime),
        )
        if not all(_fits(text, patterns) for patterns, text in texts):
            return False
        if not (self._has_amount(fault) and self._has_geometry(fault)):
            return False
        return self.degeneracy == ANY or _fits(fault.degeneracy, self.degeneracy)

    def fits_cell(self, query: str, pair: str) -> bool:
        """Whether findings of a cell may have this cause."""
        return _fits(query, self.query) and _fits(pair, self.pair)

    def fits_version(self, version: str) -> bool:
        """Whether this version of the engine has the fault; one that PEP 440 cannot read has any."""
        try:
            return SpecifierSet(self.versions).contains(Version(version), prereleases=True)
        except InvalidVersion:
            return True

    def _has_amount(self, fault: Fault) -> bool:
        decade = fault.decade
        if decade is not None and not self.decades[0] <= decade <= self.decades[1]:
            return False
        return fault.amount <= min(self.at_most * fault.size, self.within)

    def _has_geometry(self, fault: Fault) -> bool:
        thin = math.isinf(self.thinner_than) or fault.thinnest < self.thinner_than
        slow = math.isinf(self.slower_than) or fault.approach < self.slower_than
        return thin and slow and self.larger_than <= fault.size <= self.smaller_than


@dataclass(frozen=True)
class SceneFault(Fault):
    """A failure in a scene; what is special about that is found out when an entry asks for it."""

    scene: Scene = field(kw_only=True)

    @cached_property
    def degeneracy(self) -> str:
        """What is special about the scene."""
        return degeneracy(self.scene)

    @property
    def thinnest(self) -> float:
        """Of boxes and cylinders."""
        return thinnest(self.scene)

    @property
    def approach(self) -> float:
        """Along the normal."""
        return approach_of(self.scene)


def fault_in(engine: str, scene: Scene, verdict: Verdict) -> SceneFault:
    """What the ledger goes by of a finding."""
    asked = scene.query, scene.cell.pair, verdict.symptom, scene.regime
    ours = verdict.kind is Kind.REFERENCE_WRONG
    return SceneFault(engine, *asked, verdict.amount, scene.size, against_reference=ours, scene=scene)


def _fits(text: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(text, pattern) for pattern in patterns)


def approach_of(scene: Scene) -> float:
    """Velocity at which two bodies come nearer along the normal; infinite where nothing moves."""
    if scene.impact is None:
        return math.inf
    return -float(scene.impact.closing / norm(scene.impact.normal))


def thinnest(scene: Scene) -> float:
    """Smallest half extent of any box, or of the box around any cylinder; infinite where there is neither."""
    return min(_thickness(shape) for shape in (scene.a, scene.b))


def _thickness(shape: Proxy) -> float:
    if isinstance(shape, Composite):
        return min(map(_thickness, shape.parts))
    if isinstance(shape, AABB):
        shape = shape.to_box()
    if isinstance(shape, Box):
        return float(shape.half_extents.min())
    if isinstance(shape, Cylinder):
        return min(float(shape.radius), float(norm(shape.q - shape.p)) / 2)
    return math.inf
