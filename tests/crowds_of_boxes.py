"""Crowds of boxes for broad-phase structures, and the plainest answers about them, in Python and rational numbers."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from hypothesis import strategies as st

from refimpl.broadphase import BroadPhase
from refimpl.linear import Array

HUGE = (1e12, -1e12, 1e12 + 1, 1e300, -1e300, 1.7e308, -1.7e308, 5e-324, 1e-300)
FEW = (0.0, 0.5, 1.0, 2.0, -1.0, 3.0)
Pairs = list[tuple[int, int]]


@st.composite
def crowds(draw: st.DrawFn, dimension: int, most: int = 24) -> tuple[Array, Array]:
    """Corners of up to `most` boxes of one kind, or of several: what comes to mind, and what does not."""
    n = draw(st.integers(0, most))
    kind = draw(st.sampled_from(["lattice", "wild", "spread", "stacked", "scales", "clusters", "mixed"]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    if kind == "wild":
        ends = np.array(
            draw(st.lists(st.sampled_from(FEW + HUGE), min_size=2 * n * dimension, max_size=2 * n * dimension))
        )
        a, b = ends.reshape(2, n, dimension)
        return _unbounded(rng, np.minimum(a, b), np.maximum(a, b))
    lower, upper = (np.concatenate(parts) for parts in zip(*(_some(rng, kind, n, dimension)), strict=True))
    return (lower, upper) if draw(st.booleans()) else _unbounded(rng, lower, upper)


def _unbounded(rng: np.random.Generator, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Take away one in eight of the ends."""
    return (
        np.where(rng.random(lower.shape) < 0.125, -np.inf, lower),
        np.where(rng.random(upper.shape) < 0.125, np.inf, upper),
    )


def _some(rng: np.random.Generator, kind: str, n: int, dimension: int) -> list[tuple[Array, Array]]:
    if kind == "mixed":
        return [part for other in ("lattice", "scales", "stacked") for part in _some(rng, other, n // 3, dimension)]
    shape = (n, dimension)
    if kind == "lattice":
        center, half = rng.integers(0, 4, shape).astype(float), rng.integers(0, 3, shape) / 2
    elif kind == "spread":
        center, half = rng.random(shape) * 8, np.full(shape, rng.choice([0.0, 0.5, 3.0]))
    elif kind == "stacked":
        center, half = np.tile(rng.random(dimension), (n, 1)), np.zeros(shape)
        center[:, -1] = rng.integers(0, 3, n)
    elif kind == "scales":
        center, half = (
            rng.normal(size=shape) * 10.0 ** rng.integers(-3, 13, (n, 1)),
            10.0 ** rng.integers(-9, 13, shape),
        )
    else:
        center, half = rng.random(shape) + rng.choice([0.0, 1e6, -1e12], (n, 1)), rng.random(shape) / 4
    return [(center - half, center + half)]


def pairs_of(lower: Array, upper: Array, static: Any) -> Pairs:
    """Pairs in a double loop; comparing doubles is exact."""
    low, up = lower.tolist(), upper.tolist()
    return [
        (i, j)
        for j in range(len(low))
        for i in range(j)
        if not (static[i] and static[j])
        and all(max(a, b) <= min(c, d) for a, b, c, d in zip(low[i], low[j], up[i], up[j], strict=True))
    ]


def ray_meets(
    origin: list[float], direction: list[float], length: float, lower: list[float], upper: list[float]
) -> bool:
    """Separating axes of a ray or segment and a finite box: those of the box, and their products with the ray's."""
    o, d, low, up = ([Fraction(x) for x in row] for row in (origin, direction, lower, upper))
    units = [[Fraction(int(i == k)) for i in range(len(o))] for k in range(len(o))]
    axes = [*units, *([[-d[1], d[0]]] if len(o) == 2 else [_cross(d, unit) for unit in units])]
    for axis in axes:
        sides = [
            sum((n * x for n, x in zip(axis, corner, strict=True)), Fraction(0))
            for corner in product(*zip(low, up, strict=True))
        ]
        start, slope = (sum((n * x for n, x in zip(axis, v, strict=True)), Fraction(0)) for v in (o, d))
        if length == np.inf:
            apart = (start > max(sides) and slope >= 0) or (start < min(sides) and slope <= 0)
        else:
            end = start + Fraction(length) * slope
            apart = min(start, end) > max(sides) or max(start, end) < min(sides)
        if apart:
            return False
    return True


def _cross(u: list[Fraction], v: list[Fraction]) -> list[Fraction]:
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


class Model:
    """Objects by id, in a dictionary: what a structure has to be equal to."""

    def __init__(self, structures: list[BroadPhase], lower: Array, upper: Array, static: Any) -> None:
        self.structures = structures
        self.boxes = dict(enumerate(zip(lower, upper, static, strict=True)))
        self.next = len(self.boxes)
        for structure in structures:
            structure.build(lower, upper, static)

    def update(self, ids: list[int], lower: Array, upper: Array) -> None:
        for i, low, up in zip(ids, lower, upper, strict=True):
            self.boxes[i] = (low, up, self.boxes[i][2])
        for structure in self.structures:
            structure.update(np.array(ids, dtype=int), lower, upper)

    def remove(self, ids: list[int]) -> None:
        for i in ids:
            del self.boxes[i]
        for structure in self.structures:
            structure.remove(np.array(ids, dtype=int))

    def insert(self, lower: Array, upper: Array, static: bool) -> None:
        new = list(range(self.next, self.next + len(lower)))
        self.next += len(lower)
        self.boxes |= {i: (low, up, static) for i, low, up in zip(new, lower, upper, strict=True)}
        for structure in self.structures:
            assert structure.insert(lower, upper, static).tolist() == new

    def check(self, lower: Array, upper: Array) -> None:
        """Hold pairs and box queries of all structures against the plain answers."""
        ids = sorted(self.boxes)
        low, up = (np.array([self.boxes[i][k] for i in ids]).reshape(len(ids), lower.shape[1]) for k in (0, 1))
        pairs = sorted((ids[i], ids[j]) for i, j in pairs_of(low, up, [self.boxes[i][2] for i in ids]))
        met = [
            (q, ids[j - 1])
            for q in range(len(lower))
            for i, j in pairs_of(np.vstack([lower[q], low]), np.vstack([upper[q], up]), [False] * (len(ids) + 1))
            if i == 0
        ]
        for structure in self.structures:
            name = type(structure).__name__
            assert structure.ids.tolist() == ids, name
            assert [tuple(pair) for pair in structure.pairs().tolist()] == pairs, name
            assert [tuple(hit) for hit in structure.query_boxes(lower, upper).tolist()] == met, name
