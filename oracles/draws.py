"""Where random numbers come from: one interface for both hunters.

A regime asks for numbers and does not know who answers: a counter-based generator that fills a whole batch, or
Hypothesis, which draws a single scene and shrinks it (`oracles.strategies`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from refimpl.linear import Array


class Draws(Protocol):
    """Independent random numbers for `n` scenes; every answer has a leading axis of length n.

    Attributes
    ----------
    about
        What a regime says of the scenes that it made of the numbers, such as the names of models; mostly nothing.
    """

    n: int
    about: str

    def uniform(self, low: float, high: float, width: int = 0) -> Array:
        """Numbers between `low` and `high`; shape (n,) or (n, width)."""

    def choice(self, values: Sequence[float], width: int = 0) -> Array:
        """Numbers out of `values`."""


class NumpyDraws:
    """Numbers of a shard: a pure function of (seed, shard), by the Philox counter-based generator."""

    def __init__(self, seed: int, shard: Sequence[int], n: int) -> None:
        self.n = n
        self.about = ""
        self._generator = np.random.Generator(np.random.Philox(np.random.SeedSequence([seed, *shard])))

    def uniform(self, low: float, high: float, width: int = 0) -> Array:
        """Numbers between `low` and `high`."""
        return self._generator.uniform(low, high, (self.n, width) if width else self.n)

    def choice(self, values: Sequence[float], width: int = 0) -> Array:
        """Numbers out of `values`."""
        picked = self._generator.integers(len(values), size=(self.n, width) if width else self.n)
        return np.asarray(np.array(values, dtype=np.float64)[picked])


def log_uniform(draws: Draws, low: float, high: float, width: int = 0) -> Array:
    """Powers of ten with exponents between `low` and `high`."""
    return np.asarray(10.0 ** draws.uniform(low, high, width))


def quaternions(draws: Draws) -> Array:
    """Rotations as quaternions of any length, none of them zero."""
    q = draws.uniform(-1.0, 1.0, 4)
    identity = np.array([0.0, 0.0, 0.0, 1.0])
    return np.where(np.all(np.abs(q) < 1e-3, axis=-1)[:, None], identity, q)
