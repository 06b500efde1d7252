"""A batch: scenes of one pair of types and of one form, named so that they can be had again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oracles.draws import NumpyDraws
from oracles.impact_regimes import IMPACT_REGIMES
from oracles.impact_stages import TARGETS
from oracles.motion import Motion
from oracles.regimes import REGIMES
from oracles.scene import IMPACT, RAYCAST, Scene, packed_rows
from refimpl.linear import Array
from refimpl.shapes import Composite, Polyhedron, Proxy, Ray

PairKey = tuple[type[Proxy], type[Proxy]]


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
    motion: Motion | None = None
    """How the two move; of batches of impacts."""

    @classmethod
    def draw(cls, pair: PairKey, seed: int, shard: tuple[int, ...], each: int) -> list[Batch]:
        """`each` scenes of every regime: a pure function of the seed, the shard and the number."""
        made: dict[object, list[tuple[int, Proxy, Proxy]]] = {}
        about: dict[int, str] = {}
        for index, make in enumerate(REGIMES.values()):
            draws = NumpyDraws(seed, (*shard, index), each)
            a, b = make(draws, *pair)
            about[index] = draws.about
            made.setdefault((_form(a, index), _form(b, index)), []).append((index, a, b))
        source, names = f"bulk {seed}/{'/'.join(map(str, shard))}", list(REGIMES)
        found = []
        for parts in made.values():
            groups = np.repeat([index for index, _, _ in parts], each)
            numbers = groups * each + np.tile(np.arange(each), len(parts))
            a, b = _joined([a for _, a, _ in parts]), _joined([b for _, _, b in parts])
            found.append(cls(a, b, [names[i] for i in groups], groups, numbers, source, about))
        return found

    @classmethod
    def draw_impacts(cls, pair: PairKey, seed: int, shard: tuple[int, ...], each: int) -> list[Batch]:
        """`each` scenes of every regime of impacts; none of a pair that is not staged."""
        if pair not in TARGETS:
            return []
        made = [
            make(NumpyDraws(seed, (*shard, index, 1), each), *pair)
            for index, make in enumerate(IMPACT_REGIMES.values())
        ]
        names = [name for name in IMPACT_REGIMES for _ in range(each)]
        groups = np.repeat(np.arange(len(made)), each)
        numbers = groups * each + np.tile(np.arange(each), len(made))
        a, b = _joined([a for a, _, _ in made]), _joined([b for _, b, _ in made])
        motion = Motion.unpack(np.concatenate([motion.pack() for _, _, motion in made]))
        source = f"bulk of impacts {seed}/{'/'.join(map(str, shard))}"
        return [cls(a, b, names, groups, numbers, source, dict.fromkeys(range(len(made)), ""), motion)]

    def is_of(self, query: str) -> bool:
        """Whether its scenes are for this query."""
        if self.motion is not None or query == IMPACT:
            return self.motion is not None and query == IMPACT
        return isinstance(self.a, Ray) == (query == RAYCAST)

    @property
    def rows(self) -> tuple[Array, Array]:
        """Numbers of both sides."""
        return packed_rows(self.a, self.b, self.motion)

    @property
    def sizes(self) -> Array:
        """Size of each scene, as `Scene.size`."""
        largest = np.maximum(self.a.magnitude, self.b.magnitude) if self.motion is None else self.motion.speed
        return np.asarray(np.broadcast_to(largest, len(self)))

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


def _joined(shapes: list[Proxy]) -> Proxy:
    """Batches of one form as one batch."""
    if len(shapes) == 1:
        return shapes[0]
    return type(shapes[0]).unpack(np.concatenate([shape.pack() for shape in shapes]))
