"""A batch: scenes of one pair of types and of one form, named so that they can be had again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from oracles.aspect import aspect_of
from oracles.course import Course
from oracles.draws import NumpyDraws
from oracles.impact_regimes import IMPACT_REGIMES, ImpactRegime
from oracles.impact_stages import STAGED
from oracles.keeping import rows_of
from oracles.motion import Motion
from oracles.placements import Draft
from oracles.regimes import COMBINED, REGIMES, Regime, is_drawn
from oracles.scene import IMPACT, MOVING, RAYCAST, SWEEP, Scene, packed_rows, size_of
from oracles.sweep_regimes import SWEEP_REGIMES
from refimpl.linear import Array
from refimpl.shapes import Composite, Polyhedron, Proxy, Ray

PairKey = tuple[type[Proxy], type[Proxy]]

COMBINATIONS_EACH = 4
"""Combinations that a shard draws, of pairs of which all scenes go in one batch; of others it draws one."""


@dataclass(frozen=True)
class Batch:
    """Scenes of one pair of types: of all regimes, where the types have one form, or of those with equal forms.

    Attributes
    ----------
    groups : (n,) int
        Number of each scene's regime.
    numbers : (n,) int
        Number of each scene within its shard.
    about
        What each regime says of its scenes.
    """

    a: Proxy
    b: Proxy
    regimes: list[str]
    groups: NDArray[np.int_]
    numbers: NDArray[np.int_]
    source: str
    about: dict[int, str]
    motion: Motion | Course | None = None
    """How the two move; of batches of impacts and sweeps."""

    @classmethod
    def draw(
        cls,
        pair: PairKey,
        seed: int,
        shard: tuple[int, ...],
        each: int,
        regimes: Mapping[str, Regime] = REGIMES,
    ) -> list[Batch]:
        """`each` scenes of every regime: a pure function of the seed, the shard, the regime's name and the number.

        Regimes of one form are settled at once: a call of the reference costs as much as a dozen pairs.
        """
        asked = list(_asked(pair, regimes))
        made: dict[object, list[tuple[int, Draft]]] = {}
        about: dict[int, str] = {}
        for index, (name, turn) in enumerate(asked):
            draws = NumpyDraws(seed, (*shard, crc32(name.encode()), turn), each)
            draft = regimes[name].draft(draws, *pair)
            about[index] = draws.about
            made.setdefault((_form(draft.a, index), _form(draft.b, index)), []).append((index, draft))
        found = []
        for parts in made.values():
            groups, numbers = _numbered([index for index, _ in parts], each)
            a, b = _joined([draft for _, draft in parts]).settled()
            names = [asked[i][0] for i in groups]
            found.append(cls(a, b, names, groups, numbers, _source("bulk", seed, shard), about))
        return found

    @classmethod
    def draw_impacts(
        cls,
        pair: PairKey,
        seed: int,
        shard: tuple[int, ...],
        each: int,
        regimes: Mapping[str, ImpactRegime] = IMPACT_REGIMES,
    ) -> list[Batch]:
        """`each` scenes of every regime of impacts; none of a pair that is not staged."""
        if pair not in STAGED:
            return []
        drawn = {name: make(cls._draws(seed, shard, name, each), *pair) for name, make in regimes.items()}
        motion = Motion.unpack(np.concatenate([motion.pack() for _, _, motion in drawn.values()]))
        parts = [(index, a, b) for index, (a, b, _) in enumerate(drawn.values())]
        return [cls._together(list(drawn), parts, motion, each, _source("bulk of impacts", seed, shard))]

    @classmethod
    def draw_sweeps(cls, pair: PairKey, seed: int, shard: tuple[int, ...], each: int) -> list[Batch]:
        """`each` scenes of every regime of sweeps; what has one form is in one batch."""
        names, made = list(SWEEP_REGIMES), dict[object, list[tuple[int, Proxy, Proxy, Course]]]()
        for index, name in enumerate(names):
            a, b, course = SWEEP_REGIMES[name](cls._draws(seed, shard, name, each), *pair)
            made.setdefault((_form(a, index), _form(b, index)), []).append((index, a, b, course))
        source, found = _source("bulk of sweeps", seed, shard), []
        for group in made.values():
            course = Course.unpack(np.concatenate([course.pack() for *_, course in group]))
            found.append(cls._together(names, [(i, a, b) for i, a, b, _ in group], course, each, source))
        return found

    @staticmethod
    def _draws(seed: int, shard: tuple[int, ...], name: str, each: int) -> NumpyDraws:
        return NumpyDraws(seed, (*shard, crc32(name.encode())), each)

    @classmethod
    def _together(
        cls, names: list[str], parts: list[tuple[int, Proxy, Proxy]], motion: Motion | Course, each: int, source: str
    ) -> Batch:
        """One batch of parts of several regimes, each named by its number."""
        groups, numbers = _numbered([index for index, _, _ in parts], each)
        a, b = _one_batch([a for _, a, _ in parts]), _one_batch([b for _, _, b in parts])
        regimes = [names[i] for i in groups]
        return cls(a, b, regimes, groups, numbers, source, dict.fromkeys(range(len(names)), ""), motion)

    def is_of(self, query: str) -> bool:
        """Whether its scenes are for this query."""
        if self.motion is not None or query in MOVING:
            return isinstance(self.motion, Motion) == (query == IMPACT) and isinstance(self.motion, Course) == (
                query == SWEEP
            )
        return isinstance(self.a, Ray) == (query == RAYCAST)

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Numbers of both sides; those of the motion stand behind A's."""
        if self.motion is not None:
            return packed_rows(self.a, self.b, self.motion)
        return rows_of(self.a), rows_of(self.b)

    @cached_property
    def sizes(self) -> Array:
        """Size of each scene, as `Scene.size`."""
        return np.asarray(np.broadcast_to(size_of(self.a, self.b, self.motion), len(self)))

    @cached_property
    def aspects(self) -> Array:
        """Aspect ratio of the longer proxy of each scene."""
        return np.maximum(aspect_of(self.a), aspect_of(self.b))

    def __len__(self) -> int:
        """Return the number of scenes."""
        return len(self.groups)

    def scene(self, query: str, i: int) -> Scene:
        """One scene of the batch."""
        source = f"{self.source}[{self.numbers[i]}]{self.about[int(self.groups[i])]}"
        motion = None if self.motion is None else self.motion[i]
        return Scene(query, self.a[i], self.b[i], self.regimes[i], source, motion)


def _form(shape: Proxy, index: int) -> tuple[object, ...]:
    """What proxies have in common that may be in one batch; meshes stay as a regime made them, for they share one."""
    if isinstance(shape, Composite):
        return tuple((type(part), _form(part, index)) for part in shape.parts)
    return (-1, index) if isinstance(shape, Polyhedron) else shape.sizes


def _asked(pair: PairKey, regimes: Mapping[str, Regime]) -> Iterator[tuple[str, int]]:
    """Names of the regimes, each once, but that of combinations more often where this makes no batches of their own."""
    often = COMBINATIONS_EACH if not (pair[0].header or pair[1].header) else 1
    for name in (name for name in regimes if is_drawn(name, pair)):
        for turn in range(often if name == COMBINED else 1):
            yield name, turn


def _numbered(indices: Iterable[int], each: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Group of each scene, and its number within the shard."""
    groups = np.repeat(list(indices), each)
    return groups, groups * each + np.arange(len(groups)) % each


def _source(hunter: str, seed: int, shard: tuple[int, ...]) -> str:
    return f"{hunter} {seed}/{'/'.join(map(str, shard))}"


def _one_batch(shapes: list[Proxy]) -> Proxy:
    """Batches of one form as one batch."""
    if len(shapes) == 1:
        return shapes[0]
    return type(shapes[0]).unpack(np.concatenate([shape.pack() for shape in shapes]))


def _joined(drafts: list[Draft]) -> Draft:
    """Drafts of one form as one."""
    a, b = _one_batch([draft.a for draft in drafts]), _one_batch([draft.b for draft in drafts])
    return Draft(a, b, np.concatenate([draft.gap for draft in drafts]), np.concatenate([d.moved for d in drafts]))
