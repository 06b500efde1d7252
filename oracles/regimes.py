"""Regimes: named recipes that turn random numbers into scenes.

Random poses alone do not find what matters: engines fail where things touch, line up, degenerate or leave the
middle scale. A regime is put together from three parts: a build (what the bodies are like), a placement (how they
stand to each other) and a frame (at what scale, where and how turned the scene is). Each idea has a regime in which
it stands alone; the regime `combined` draws any other combination, so that in time all of them are had. Each works
for every pair of types.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from oracles.bodies import Body
from oracles.builds import (
    Build,
    Kind,
    aligned,
    at_thresholds,
    degenerate,
    generic,
    half_aligned,
    siblings,
    size_ratio,
    sliver,
)
from oracles.draws import Draws
from oracles.engine import Engine
from oracles.frames import FRAMES, Frame
from oracles.library import current
from oracles.placed import placed_pair
from oracles.placements import FREE, NEAR, PLACEMENTS, Draft, Pair, Placement, facing
from oracles.world import is_flat
from refimpl.shapes import Polyhedron

BUILDS: dict[str, Build] = {
    build.__name__: build for build in (generic, aligned, sliver, size_ratio, degenerate, siblings)
}
COMBINED, MODELS, THRESHOLDS_OF = "combined", "models", "thresholds_of_"


@dataclass(frozen=True)
class Regime:
    """A recipe for scenes: call it for pairs of proxies, or draft them first and settle many drafts at once.

    Attributes
    ----------
    reason
        Why it exists.
    """

    reason: str
    draft: Callable[[Draws, Kind, Kind], Draft]

    def __call__(self, draws: Draws, kind_a: Kind, kind_b: Kind) -> Pair:
        """Make pairs of proxies of these types."""
        return self.draft(draws, kind_a, kind_b).settled()


@dataclass(frozen=True)
class Recipe:
    """A build, a placement and a frame."""

    build: Build = generic
    placement: Placement = FREE
    frame: Frame = FRAMES["unit"]

    def draft(self, draws: Draws, kind_a: Kind, kind_b: Kind) -> Draft:
        """Bodies, arranged, in their frame, and made into proxies; with the gap that they are to have."""
        bodies = self.build(draws, kind_a, kind_b)
        if self.placement.arrange is not None:
            bodies = self.placement.arrange(draws, *(_of_one_mesh(body, kind_a, kind_b) for body in bodies))
        gap, moved = np.zeros(draws.n), np.zeros(draws.n, dtype=bool)
        if self.placement.gap is not None:
            gap, moved = self.placement.gap(draws)
        a, b, length = self.frame(draws, bodies, (kind_a, kind_b))
        pair = a.make(kind_a), b.make(kind_b)
        return Draft(*(facing(*pair) if self.placement.faces else pair), gap * length, moved)


def _of_one_mesh(body: Body, *kinds: Kind) -> Body:
    """Bodies of one size, where they share a mesh."""
    if Polyhedron not in kinds:
        return body
    return replace(body, extents=np.broadcast_to(body.extents[:1], body.extents.shape))


def _first_line(function: object) -> str:
    return (function.__doc__ or "").strip().splitlines()[0]


def combination_name(build: str, placement: str, frame: str) -> str:
    """Name the parts that are not plain: ``touching · sliver · far away``."""
    parts = [part for part in (placement, build, frame) if part not in ("free", "generic", "unit")]
    return " · ".join(part.replace("_", " ") for part in parts) or "generic"


COMBINATIONS: dict[str, Recipe] = {
    combination_name(build, placement, frame): Recipe(BUILDS[build], PLACEMENTS[placement], FRAMES[frame])
    for frame in FRAMES
    for build in BUILDS
    for placement in PLACEMENTS
}
"""Every build in every placement in every frame; the plainest first."""


def _combined(draws: Draws, kind_a: Kind, kind_b: Kind) -> Draft:
    """Several ideas at once, touching slivers far away for instance: faults that need two of them to show."""
    name = list(COMBINATIONS)[int(draws.choice(range(len(COMBINATIONS)))[0])]
    draws.about = f": {name}"
    return COMBINATIONS[name].draft(draws, kind_a, kind_b)


def _models(draws: Draws, kind_a: Kind, kind_b: Kind) -> Draft:
    """Meshes of robots, tools and toys, touching and overlapping: many faces, no two alike, as users have them."""
    a, b, gap, moved = placed_pair(draws, current(), kind_a, kind_b)
    return Draft(*facing(a, b), gap, moved)


def _of_build(build: Build, placement: Placement = FREE) -> Regime:
    return Regime(_first_line(build), Recipe(build, placement).draft)


def _of_placement(name: str, build: Build = generic) -> Regime:
    return Regime(PLACEMENTS[name].reason, Recipe(build, PLACEMENTS[name]).draft)


def _of_frame(name: str, build: Build = generic, placement: Placement = FREE) -> Regime:
    return Regime(_first_line(FRAMES[name]), Recipe(build, placement, FRAMES[name]).draft)


REGIMES: dict[str, Regime] = {
    "generic": _of_build(generic),
    "aligned": _of_build(aligned),
    "touching": _of_placement("touching"),
    "nearly_touching": _of_placement("nearly_touching"),
    "deep": _of_placement("deep"),
    "concentric": _of_placement("concentric", half_aligned),
    "on_surface": _of_placement("on_surface", aligned),
    "parallel_edges": _of_placement("parallel_edges"),
    "face_on_face": _of_placement("face_on_face", aligned),
    "sliver": _of_build(sliver, NEAR),
    "size_ratio": _of_build(size_ratio, NEAR),
    "degenerate": _of_build(degenerate, NEAR),
    "siblings": _of_build(siblings),
    "turned": _of_frame("turned", aligned, PLACEMENTS["face_on_face"]),
    "huge": _of_frame("huge"),
    "tiny": _of_frame("tiny"),
    "far_away": _of_frame("far_away"),
    "single_precision": _of_frame("single_precision", generic, PLACEMENTS["nearly_touching"]),
    COMBINED: Regime(_first_line(_combined), _combined),
    MODELS: Regime(_first_line(_models), _models),
}
"""The regimes that every pass asks: each idea alone or nearly so, and some combination. Counts are kept by these names;
a scene of `combined` names its parts in its source."""


def thresholds_of(engine: Engine) -> Regime:
    """Gaps, overlaps and sizes about the lengths at which an engine, as it declares, takes another way."""
    lengths = engine.thresholds

    def draft(draws: Draws, kind_a: Kind, kind_b: Kind) -> Draft:
        a, b, gap = at_thresholds(draws, lengths)
        return Draft(a.make(kind_a), b.make(kind_b), gap, np.ones(draws.n, dtype=bool))

    named = ", ".join(f"{what} {length:g}" for what, length in lengths.items())
    return Regime(f"Gaps, overlaps and sizes about the thresholds of {engine.name}: {named}.", draft)


def regimes_for(engines: Iterable[Engine]) -> dict[str, Regime]:
    """The regimes that every pass asks, and one more for each engine that declares thresholds."""
    own = {f"{THRESHOLDS_OF}{engine.name}": thresholds_of(engine) for engine in engines if engine.thresholds}
    return REGIMES | own


def is_drawn(name: str, kinds: Iterable[Kind]) -> bool:
    """Whether a regime has scenes of these types: models are of space."""
    return name != MODELS or not any(map(is_flat, kinds))


def reasons(regimes: Mapping[str, Regime] = REGIMES) -> dict[str, str]:
    """Why each regime exists."""
    return {name: regime.reason for name, regime in regimes.items()}
