"""Crowds for broad phases: boxes and balls whose bounding boxes are exactly known, in regimes of their own.

A body is its centre and its half extents, as engines take them; it may have been registered elsewhere and then moved.
What a broad phase promises is: every pair of bodies whose closed bounding boxes have a point in common.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array, Bools, largest, norm
from refimpl.shapes import AABB, Box, Proxy, Sphere

Pair = tuple[int, int]
Ids = NDArray[np.int64]

ROUNDING = 2.0**-48
"""Share of the largest coordinate by which an engine may round a box's sides."""
STILL = (0.0, 0.0, 0.0, 1.0)
MOST_BODIES = 10_000
"""Of a crowd that is read."""


@dataclass(frozen=True, eq=False)
class BoxCrowd:
    """Bodies whose bounding boxes are center ± half.

    Attributes
    ----------
    regime : str
    balls : (n,) bool
        Balls; their half extents are all the radius. The others are boxes that are not turned.
    center, half : (n, 3)
    before : (n, 3)
        Where the centres were when the engine was given the bodies; it is then told to move them.
    """

    regime: str
    balls: Bools
    center: Array
    half: Array
    before: Array

    def __len__(self) -> int:
        return len(self.center)

    def some(self, ids: Ids) -> BoxCrowd:
        """Some of the bodies, in this order."""
        return BoxCrowd(self.regime, self.balls[ids], self.center[ids], self.half[ids], self.before[ids])

    @property
    def moved(self) -> bool:
        """Whether any body was registered elsewhere."""
        return not np.array_equal(self.before, self.center)

    def proxy(self, number: int) -> Proxy:
        """Body of this number, where it is in the end."""
        if self.balls[number]:
            return Sphere(self.center[number], self.half[number, 0])
        return Box(self.center[number], self.half[number], STILL)

    def box(self, number: int) -> Box:
        """Its bounding box."""
        return Box(self.center[number], self.half[number], STILL)

    def depths(self) -> Array:
        """By how much (n, n) the bounding boxes overlap along the axis on which they do least; negative for a gap."""
        room = self.half[:, None] + self.half[None]
        return np.asarray(np.min(room - np.abs(self.center[:, None] - self.center[None]), axis=-1))

    def slack(self) -> Array:
        """By how much (n, n) that may be rounded, here and in an engine."""
        size = largest(np.maximum(np.maximum(np.abs(self.center), np.abs(self.before)), self.half))
        return np.asarray(ROUNDING * np.maximum(size[:, None], size[None]))

    def thinned(self) -> BoxCrowd:
        """The same with an eighth of the sizes, so that few overlap and there is a nearest pair to be found."""
        return replace(self, half=self.half / 8)

    def gaps(self) -> Array:
        """Distances (n, n) of the bounding boxes, 0 where they overlap."""
        apart = np.abs(self.center[:, None] - self.center[None]) - (self.half[:, None] + self.half[None])
        return norm(np.maximum(apart, 0.0))

    def exact(self) -> Bools:
        """Whether (n, n) the sides of both boxes are doubles, so that nothing needs to be rounded."""
        up, down = self.center + self.half, self.center - self.half
        own = np.all((up - self.center == self.half) & (self.center - down == self.half), axis=-1)
        return np.asarray(own[:, None] & own[None])

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        columns = {name: getattr(self, name).tolist() for name in ("balls", "center", "half", "before")}
        return {"regime": self.regime, **columns}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> BoxCrowd:
        """Read it back; raises ValueError for anything else."""
        balls = np.array(data["balls"], dtype=bool)
        if balls.ndim != 1 or len(balls) > MOST_BODIES:
            raise ValueError(f"expected a list of at most {MOST_BODIES} bodies")
        columns = [
            np.array(data[name], dtype=np.float64).reshape(len(balls), 3) for name in ("center", "half", "before")
        ]
        if not all(np.all(np.isfinite(column)) for column in columns) or np.any(columns[1] <= 0):
            raise ValueError("bodies need finite numbers, and half extents above 0")
        return cls(str(data["regime"])[:100], balls, *columns)


class Recipe(NamedTuple):
    """How to make a crowd, and why: a function of random numbers and how many, to centres and half extents."""

    why: str
    make: Callable[[np.random.Generator, int], tuple[Array, Array]]
    times: int = 1
    """So many times as many bodies as in other crowds."""


def _thrown(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    side = 1.4 * np.cbrt(count)
    return rng.uniform(-side / 2, side / 2, (count, 3)), rng.uniform(0.1, 0.8, (count, 3))


def _stacked(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Cubes of side 1 on a grid, in no order: each touches up to 26 others in a face, an edge or a corner."""
    across = int(np.ceil(np.cbrt(count)))
    cells = np.stack(np.unravel_index(rng.permutation(across**3)[:count], (across,) * 3), axis=-1)
    return cells.astype(np.float64), np.full((count, 3), 0.5)


def _of_all_sizes(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    size = 10.0 ** rng.uniform(-4, 4, (count, 1))
    return 30 * rng.normal(size=(count, 3)), size * rng.uniform(0.5, 1, (count, 3))


def _flat(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    center, half = _thrown(rng, count)
    half *= 3
    half[np.arange(count), rng.integers(0, 3, count)] = 1e-9
    half[np.arange(count), rng.integers(0, 3, count)] = 1e-3
    return center, half


def _one_place(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Nearly the same body many times: centres differ by the last bits only."""
    steps = 2.0**-50 * np.arange(count)[:, None] * rng.integers(0, 2, (1, 3)).clip([[1, 0, 0]])
    return rng.uniform(0.5, 1, (1, 3)) + steps, np.full((count, 3), 0.25)


def _in_a_row(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Along one axis, each touching the next: along the others nothing can be told apart."""
    center = np.zeros((count, 3))
    center[:, rng.integers(3)] = rng.permutation(count)
    return center, np.full((count, 3), 0.5)


def _scaled(factor: float, shift: float = 0.0) -> Callable[[np.random.Generator, int], tuple[Array, Array]]:
    def make(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
        center, half = _thrown(rng, count)
        return factor * center + shift, factor * half

    return make


REGIMES: Mapping[str, Recipe] = MappingProxyType(
    {
        "thrown": Recipe("random boxes and balls, each overlapping one or two others", _thrown),
        "many": Recipe("the same, many more of them: trees have depth", _thrown, 8),
        "stacked": Recipe("cubes on a grid, touching exactly: closed boxes that touch are a pair", _stacked),
        "in_a_row": Recipe("touching along one axis: nothing can be told apart along the others", _in_a_row),
        "one_place": Recipe("nearly the same body many times: no tree can split them", _one_place),
        "all_sizes": Recipe("sizes over eight decades: no cell size fits", _of_all_sizes),
        "flat": Recipe("slabs and needles", _flat),
        "far_away": Recipe("coordinates of 1e6 with sizes of 1", _scaled(1.0, 1e6)),
        "tiny": Recipe("sizes of 1e-6: below margins", _scaled(1e-6)),
        "large": Recipe("sizes of 1e4: above what margins are made for", _scaled(1e4)),
        "huge": Recipe("sizes of 1e9: beyond what engines think sensible", _scaled(1e9)),
    }
)
"""Recipes for crowds; each is made twice, as it is and with bodies that were moved there."""


def crowds(seed: int, count: int) -> list[BoxCrowd]:
    """Every regime, each with bodies that stay and with bodies that were moved, of so many bodies.

    No two bodies have one centre, by which an engine's answers may have to tell them apart.
    """
    found = []
    for index, (name, recipe) in enumerate(REGIMES.items()):
        for moves in (False, True):
            rng = np.random.default_rng([seed, index, moves])
            size = count * recipe.times
            center, half = recipe.make(rng, size)
            balls = rng.uniform(size=size) < 0.4
            half = np.where(balls[:, None], half[:, :1], half)
            before = center + moves * largest(half)[:, None] * rng.normal(size=(size, 3))
            found.append(BoxCrowd(f"{name}, moved" if moves else name, balls, center, half, before))
    return found


def as_aabb(crowd: BoxCrowd) -> AABB:
    """Bounding boxes of all bodies, rounded."""
    return AABB(crowd.center - crowd.half, crowd.center + crowd.half)
