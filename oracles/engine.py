"""The engine protocol: what a collision engine says of itself, and the form of its answers.

A *cell* is (query, type A, type B). Its scenes travel as rows of doubles (`Proxy.pack`), its answers come
back as rows of `WIDTH` doubles in the order of `COLUMNS`, NaN where the engine does not say. Every answer is
in the terms of the contract, whatever the engine's own are: the normal points from A to B, depth is a
negative distance, a ray's time counts in units of its direction's length. Converting is the adapter's work.

An impact is two proxies about to touch, with their motion (`oracles.motion`), whose numbers stand behind those of A
in its row; the answer is the velocities after. A sweep is two proxies and their ways (`oracles.course`), whose numbers
stand there too; the answer is the first time from 0 to 1 at which the two touch, the point, and the normal from A to B.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from oracles.impact_stages import STAGED
from oracles.motion import Motion
from oracles.scene import DISTANCE, IMPACT, QUERIES, RAYCAST, SWEEP
from oracles.world import is_flat
from refimpl.shapes import Point, Proxy, Ray

if TYPE_CHECKING:
    from oracles.crowds.engine import BroadPhaseEngine

Array = NDArray[np.float64]
Kind = type[Proxy]
Row = list[float]
AnswerRow = Sequence[float]
Solver = Callable[[Row, Row], AnswerRow]

COLUMNS: Mapping[str, slice] = MappingProxyType(
    {
        "hit": slice(0, 1),
        "distance": slice(1, 2),
        "on_a": slice(2, 5),
        "on_b": slice(5, 8),
        "normal": slice(8, 11),
        "t": slice(11, 12),
        "point": slice(12, 15),
        "velocity_a": slice(15, 18),
        "angular_a": slice(18, 21),
        "velocity_b": slice(21, 24),
        "angular_b": slice(24, 27),
    }
)
WIDTH = 27
VELOCITIES = ("velocity_a", "angular_a", "velocity_b", "angular_b")
"""Columns that answer an impact."""

NOT_STAGED = f"impacts are staged for {', '.join(f'{a.__name__}–{b.__name__}' for a, b in STAGED)}"

NOT_FLAT, NOT_IN_SPACE = (
    "an engine of space, which has no flat shapes",
    "an engine of the plane, all of whose shapes are flat",
)

NAN = float("nan")
NOWHERE = (NAN, NAN, NAN)


def answer_row(
    *,
    hit: float = NAN,
    distance: float = NAN,
    on_a: Sequence[float] = NOWHERE,
    on_b: Sequence[float] = NOWHERE,
    normal: Sequence[float] = NOWHERE,
    t: float = NAN,
    point: Sequence[float] = NOWHERE,
    velocity_a: Sequence[float] = NOWHERE,
    angular_a: Sequence[float] = NOWHERE,
    velocity_b: Sequence[float] = NOWHERE,
    angular_b: Sequence[float] = NOWHERE,
) -> AnswerRow:
    """One answer in the order of `COLUMNS`; what is not given is not said."""
    return (hit, distance, *on_a, *on_b, *normal, t, *point, *velocity_a, *angular_a, *velocity_b, *angular_b)


class EngineUnavailable(RuntimeError):
    """An engine cannot be started here; the text says why and, where it can, what to install."""


class NoAnswer(RuntimeError):
    """An engine returned normally but gave no answer."""


class UnsupportedCell(TypeError):
    """A solver or script was asked for in a cell, or for a part of a composite, that the engine does not support."""


class Status(IntEnum):
    """What became of one scene."""

    ANSWERED = 0
    ERROR = 1
    """The engine raised, or its answer was none; then the text begins with "answered"."""
    CRASHED = 2
    """The engine's process ended."""
    TIMED_OUT = 3
    SKIPPED = 4
    """Never asked: too many scenes of its group had timed out."""
    UNSUPPORTED = 5
    """The engine answers the cell, but cannot hold a shape of this scene: a part of a composite."""


@dataclass(frozen=True)
class Answers:
    """What an engine said about n scenes of one cell.

    Attributes
    ----------
    status : (n,) of `Status`
    hit : (n,)
        1 or 0; NaN where not said, here as in all that follows.
    distance : (n,)
        Signed distance; for contacts minus the depth.
    on_a, on_b : (n, 3)
        Witness points.
    normal : (n, 3)
        Unit vector from A to B; for a ray the outward normal of B.
    t : (n,)
        A ray's time in units of its direction's length; the time of a sweep, from 0 to 1; infinite on a miss.
    point : (n, 3)
        A contact's position where the engine gives one and not two; a ray's hit point; where a sweep ends.
    velocity_a, angular_a, velocity_b, angular_b : (n, 3)
        Of both bodies after an impact.
    errors : dict
        Scene's index to the text of its error, crash or time-out.
    """

    status: NDArray[np.int8]
    hit: Array
    distance: Array
    on_a: Array
    on_b: Array
    normal: Array
    t: Array
    point: Array
    velocity_a: Array
    angular_a: Array
    velocity_b: Array
    angular_b: Array
    errors: Mapping[int, str] = field(default_factory=dict)

    @classmethod
    def from_table(cls, status: NDArray[np.int8], table: Array, errors: Mapping[int, str]) -> Self:
        """Split answer rows (n, WIDTH) into columns."""
        columns = {n: table[:, s] if s.stop - s.start > 1 else table[:, s.start] for n, s in COLUMNS.items()}
        return cls(status=status, **columns, errors=errors)

    def __len__(self) -> int:
        """Return the number of scenes."""
        return len(self.status)

    def counts(self) -> dict[Status, int]:
        """How many scenes ended in which status."""
        return {s: int(np.count_nonzero(self.status == s)) for s in Status}


class SupportKind(Enum):
    """How an engine comes to an answer in a cell."""

    NATIVE = "native"
    EMULATED = "emulated"
    UNSUPPORTED = "unsupported"


@dataclass(frozen=True)
class Support:
    """Whether an engine answers a cell, and how it is emulated or why not."""

    kind: SupportKind
    reason: str = ""

    def __bool__(self) -> bool:
        """Return whether the cell can be asked."""
        return self.kind is not SupportKind.UNSUPPORTED


NATIVE = Support(SupportKind.NATIVE)


def emulated(how: str) -> Support:
    """Answered with another of the engine's shapes."""
    return Support(SupportKind.EMULATED, how)


def unsupported(why: str) -> Support:
    """Not answered."""
    return Support(SupportKind.UNSUPPORTED, why)


@dataclass(frozen=True)
class Bound:
    """An error in length units, ``absolute + relative · size``; the size is the scene's largest number.

    Of impacts the error is a velocity, and the size the largest velocity.
    """

    absolute: float
    relative: float

    def at(self, size: Array | float) -> Array:
        """Give the bound for scenes of that size."""
        return np.asarray(self.absolute + self.relative * np.asarray(size, dtype=np.float64))


@dataclass(frozen=True)
class Tolerance:
    """What an engine promises in a cell, against the shapes it effectively uses.

    Attributes
    ----------
    value : Bound
        Error of the signed distance; for a ray: how far from B's surface the point at time t may lie; for an impact:
        by how much velocities would have to change to fulfil the laws; for a sweep: how far the two move in the time
        by which it is off, and no farther than they then are apart, or have got into each other.
    witness : Bound
        How far a witness may lie off its shape, and the two from being |distance| apart.
    boolean : Bound
        Hit and miss are both right where the signed distance is no larger in absolute value; for a ray,
        that of its segment up to beyond B.
    reason : str
        Where the numbers come from.
    """

    value: Bound
    witness: Bound
    boolean: Bound
    reason: str

    @classmethod
    def uniform(cls, absolute: float, relative: float, reason: str) -> Self:
        """Use one bound for everything."""
        bound = Bound(absolute, relative)
        return cls(bound, bound, bound, reason)


class Convention(Enum):
    """Ways of an engine that differ from the contract by design."""

    NO_HIT_FROM_INSIDE = "a ray that starts inside is not said to hit at once"
    TWO_SIDED_PLANE = "a ray from inside a half-space hits its plane"
    DEPTH_OF_ITS_NORMAL = "a depth is that of the reported normal, which need not be the least"
    NO_DEPTH = "an overlap is told (as a distance of minus infinity), but not its depth"
    CLAMPED = "velocities are limited"
    OTHER_FRICTION = "an impact that slides off the line of centres ends at another place of Coulomb's cone"
    OF_ONE_TRIANGLE = "a contact's depth and normal are those of one triangle, not of the solid"


class Effective:
    """The shapes an engine effectively uses for one side of n scenes: those of `rows`, grown by `margin`.

    Attributes
    ----------
    kind : type of proxy
        Need not be the scene's own: a mesh that is a surface is the union of its triangles.
    rows : (n, width)
    margin : (n,)
        At least 0. Signed distances of grown shapes are σ(A ⊕ r, B ⊕ s) = σ(A, B) − r − s.
    made
        The shapes themselves, where the adapter has made them, and rows are only their numbers.
    """

    def __init__(self, kind: Kind, rows: Array | None, margin: Array, made: Proxy | None = None) -> None:
        self.kind, self.margin, self.made = kind, margin, made
        self._rows = rows

    @classmethod
    def exactly(cls, kind: Kind, rows: Array) -> Self:
        """Use the shapes as they were given."""
        return cls(kind, rows, np.zeros(len(rows)))

    @classmethod
    def of(cls, shapes: Proxy, margin: Array) -> Self:
        """Use shapes that were made already; adapters that keep them save what is derived of them."""
        return cls(type(shapes), None, margin, shapes)

    @property
    def rows(self) -> Array:
        """Numbers of the shapes."""
        if self._rows is None:
            assert self.made is not None
            self._rows = self.made.pack()
        return self._rows


ADAPTER_SCRIPT = """from oracles.engine import COLUMNS
from {module} import {name}
from refimpl.shapes import {kinds}

answer = {name}().solver({query!r}, {A.__name__}, {B.__name__})(
    {row_a!r},
    {row_b!r},
)
for name, columns in COLUMNS.items():
    values = list(answer[columns])
    if all(value == value for value in values):
        print(name, "=", values[0] if len(values) == 1 else values)
"""
"""Asks the adapter of an engine; see `Engine.repro`."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,99}")
"""Names that an engine may have."""
FILES: dict[str, str] = {}
"""Modules that were loaded as files, under names of their own: the names by which they are imported where they lie."""


class Engine(ABC):
    """A collision engine as the harness sees it: what it supports, promises and answers.

    Making one imports nothing: an adapter imports its engine in `warm`, `solver` and the functions that come
    from it, so that support, tolerances and scripts can be had without running the engine's code.
    """

    name: ClassVar[str]
    """What `NAME` fits: reports, ledgers and their folders of witnesses are named by it."""
    flat: ClassVar[bool] = False
    """Whether it is an engine of the plane, and not of space."""
    velocity_limit: ClassVar[float] = float("inf")
    """Largest coordinate of a velocity, where the convention CLAMPED says that there is one."""
    thresholds: ClassVar[Mapping[str, float]] = MappingProxyType({})
    """Lengths at which the engine takes another way, each with what it is: a margin, a tolerance of its solver. Scenes
    are made with gaps, overlaps and sizes about them."""
    speed_thresholds: ClassVar[Mapping[str, float]] = MappingProxyType({})
    """Speeds at which it does so in impacts: from which on bodies bounce, for instance."""

    @abstractmethod
    def versions(self) -> dict[str, str]:
        """Names and versions of the packages that answer."""

    @abstractmethod
    def warm(self) -> None:
        """Import what solving needs; raise `EngineUnavailable` when that fails."""

    def support(self, query: str, A: Kind, B: Kind) -> Support:
        """Whether and how the engine answers a cell."""
        if query not in QUERIES:
            raise ValueError(f"no query {query!r}; there are {', '.join(QUERIES)}")
        if senseless := self._senseless(query, A, B):
            return unsupported(senseless)
        if query == IMPACT:
            return self._impact_support(A, B) if (A, B) in STAGED else unsupported(NOT_STAGED)
        if query == SWEEP:
            return self._sweep_support(A, B)
        return self._support(query, A, B)

    def _senseless(self, query: str, A: Kind, B: Kind) -> str:
        """Why a query on two types makes no sense, or none of this engine's world; empty where it does."""
        if not is_flat(A) == is_flat(B) == self.flat:
            return NOT_IN_SPACE if self.flat else NOT_FLAT
        if query == RAYCAST:
            return "" if issubclass(A, Ray) and B.is_solid else "a raycast is a Ray against a solid"
        if issubclass(A, Ray) or issubclass(B, Ray):
            return "a Ray is for raycast"
        return "two points are no pair of the table" if issubclass(A, Point) and issubclass(B, Point) else ""

    def _impact_support(self, A: Kind, B: Kind) -> Support:
        """Support of impacts, in a cell that makes sense; none, unless an adapter says so."""
        del A, B
        return unsupported(f"{self.name} is asked about shapes at rest: there are no impacts")

    def _sweep_support(self, A: Kind, B: Kind) -> Support:
        """Support of sweeps, in a cell that makes sense; none, unless an adapter says so."""
        del A, B
        return unsupported(f"{self.name} is asked about shapes at rest: there are no sweeps")

    @abstractmethod
    def _support(self, query: str, A: Kind, B: Kind) -> Support:
        """Support in a cell that makes sense."""

    @abstractmethod
    def says(self, query: str, A: Kind, B: Kind) -> frozenset[str]:
        """Names of the columns that an answer fills; those that describe a hit are empty on a miss."""

    @abstractmethod
    def tolerance(self, query: str, A: Kind, B: Kind) -> Tolerance:
        """Give what the engine promises in a supported cell."""

    def effective(self, query: str, A: Kind, rows_a: Array, B: Kind, rows_b: Array) -> tuple[Effective, Effective]:
        """Give the shapes that the engine effectively uses for scenes of a cell."""
        del query
        return Effective.exactly(A, rows_a), Effective.exactly(B, rows_b)

    def effective_motion(self, A: Kind, B: Kind, motion: Motion, rows: tuple[Array, Array]) -> Motion:
        """Give the motion with which the engine effectively calculates: with its own inertia, for instance.

        Parameters
        ----------
        motion
            Of a batch.
        rows
            Packed proxies of both sides.
        """
        del A, B, rows
        return motion

    def conventions(self, query: str, A: Kind, B: Kind) -> Mapping[Convention, str]:
        """Departures from the contract by design, each with the engine's own sentence."""
        del query, A, B
        return {}

    def broad_phase(self) -> BroadPhaseEngine | None:
        """Give what asks the engine which boxes of many overlap; None: it is not asked."""
        return None

    @abstractmethod
    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        """Return a function that answers one scene, given as two rows of floats."""

    def repro(self, query: str, A: Kind, B: Kind, row_a: Row, row_b: Row) -> str:
        """Return a Python script that asks the engine alone for one scene.

        It needs the engine's own package, makes the calls that `solver` makes, and prints the answer as lines
        ``name = value`` in full precision, in the terms of the contract. By default it asks this adapter, and needs
        its module and this project as well.
        """
        self.require(query, A, B)
        kind, kinds = type(self), ", ".join(sorted({A.__name__, B.__name__}))
        module = FILES.get(kind.__module__, kind.__module__)
        return ADAPTER_SCRIPT.format(
            module=module, name=kind.__name__, kinds=kinds, query=query, A=A, B=B, row_a=row_a, row_b=row_b
        )

    def require(self, query: str, A: Kind, B: Kind) -> None:
        """Raise `UnsupportedCell` unless the cell can be asked."""
        support = self.support(query, A, B)
        if not support:
            raise UnsupportedCell(f"{self.name} {query} {A.__name__} {B.__name__}: {support.reason}")


def faults(query: str, says: frozenset[str], table: Array) -> dict[int, str]:
    """Answer rows that are no answers: a promised column is NaN, or a hit is neither 1 nor 0."""
    hit = table[:, 0]
    whole = not len(table) or not any(np.isnan(table[:, run].min()) for run in _runs(says))
    if whole and ("hit" not in says or ((hit == 0) | (hit == 1)).all()):
        return {}
    found: dict[int, str] = {}
    described = np.full(len(table), True) if query == DISTANCE else table[:, 0] != 0
    for name in [n for n in COLUMNS if n in says]:
        columns = table[:, COLUMNS[name]]
        bad = np.isnan(columns).any(axis=1)
        if name == "hit":
            bad |= (columns[:, 0] != 0) & (columns[:, 0] != 1)
        elif name != "t":
            bad &= described
        if name != "distance":  # an overlap without end has neither witnesses nor normal
            bad &= table[:, COLUMNS["distance"]][:, 0] != -np.inf
        if name == "normal" and query in (RAYCAST, SWEEP):  # nor has what starts inside
            bad &= table[:, COLUMNS["t"]][:, 0] != 0
        for i in np.flatnonzero(bad):
            value = columns[i].tolist()
            found.setdefault(int(i), f"answered {name} = {value[0] if len(value) == 1 else value}")
    return found


@cache
def _runs(says: frozenset[str]) -> list[slice]:
    """Columns as runs of neighbours."""
    runs: list[slice] = []
    for name in COLUMNS:
        if name in says:
            begin = runs.pop().start if runs and runs[-1].stop == COLUMNS[name].start else COLUMNS[name].start
            runs.append(slice(begin, COLUMNS[name].stop))
    return runs
