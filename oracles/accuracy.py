"""How accurate and how quick the engines of a run were, as its reports have it.

Errors are those of the bulk hunter's scenes, which are drawn from the regimes whatever comes of them; scenes that a
search has steered towards errors would tell of the search. An error is what is beyond doubt: the distance of the
answered value from the reference's, less what the reference may err by. It is a length, of impacts a velocity;
relative to the scene's size, which is its largest coordinate, extent or velocity.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from oracles.scene import Scene

ABSOLUTE, RELATIVE = "absolute", "relative"
SCALE, GAP, ASPECT = "scale", "gap", "aspect"
AXES = (SCALE, GAP, ASPECT)
"""What errors are plotted against: the scene's size, its gap or overlap relative to that, the longer aspect ratio."""

CellKey = tuple[str, str, str]
"""engine, query, pair"""

ExtremeKey = tuple[str, str, str, str]
"""engine, query, pair, and whether it is the worst absolute or relative error"""


@dataclass(frozen=True)
class Spread:
    """Errors by rank: so many are no larger. The worst is the largest of all."""

    median: float
    p99: float
    worst: float


@dataclass(frozen=True)
class Errors:
    """Errors of one engine: in a cell and regime, in all regimes where that is empty, in all pairs likewise.

    Attributes
    ----------
    answers
        How many scenes were answered.
    valued
        How many of these have a finite value whose error is known: no booleans, misses, or depths left open.
    by_convention
        How many of the valued ones are right only by the engine's own convention.
    lost
        How many scenes have no answer: the engine crashed, raised or took too long.
    absolute, relative
        None where no answer has a value.
    proven_absolute, proven_relative
        The worst error that a certificate proves, of cells as a whole; None where none was tried, or needed.
    worst_in
        Regime of a cell's worst relative error; empty where there is no error at all.
    """

    engine: str
    query: str
    pair: str
    regime: str
    answers: int
    valued: int
    by_convention: int
    lost: int
    absolute: Spread | None
    relative: Spread | None
    proven_absolute: float | None = None
    proven_relative: float | None = None
    worst_in: str = ""

    @property
    def cell(self) -> CellKey:
        """Engine, query and pair."""
        return self.engine, self.query, self.pair


@dataclass(frozen=True)
class Point:
    """Errors of one engine and query, over all pairs, where the scenes lie in one bin of an axis.

    Attributes
    ----------
    x
        Median of the bin's scenes: the least and the greatest bin may be at 0 (touching) and at infinity (flat).
    errors
        As lengths against the scale, and relative to it against the others.
    """

    engine: str
    query: str
    axis: str
    x: float
    count: int
    errors: Spread


@dataclass(frozen=True)
class Speed:
    """Processor seconds that an engine took for some answers of a cell, with its adapter, and without its guards."""

    engine: str
    query: str
    pair: str
    answers: int
    seconds: float


@dataclass(frozen=True)
class Accuracy:
    """All of it; queries as a whole stand before their cells, each of these before its regimes."""

    errors: tuple[Errors, ...] = ()
    points: tuple[Point, ...] = ()
    speeds: tuple[Speed, ...] = ()


@dataclass(frozen=True)
class Extreme:
    """The scene with the largest error so far."""

    scene: Scene
    error: float

    def amount(self, measure: str) -> float:
        """The error as it is measured."""
        if measure == ABSOLUTE or not self.error:
            return self.error
        return self.error / self.scene.size if self.scene.size > 0 else float("inf")


def keep_worst(known: dict[ExtremeKey, Extreme], found: Iterable[tuple[ExtremeKey, Extreme]]) -> None:
    """Keep what was found where it is worse than what is known; the first of equals stays."""
    for key, extreme in found:
        if key not in known or extreme.amount(key[3]) > known[key].amount(key[3]):
            known[key] = extreme
