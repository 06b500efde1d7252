"""Plain scenes: what the regimes make of round numbers, as the simplest that a witness could be."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from oracles.impact_regimes import IMPACT_REGIMES
from oracles.impact_stages import STAGED
from oracles.plain_bodies import plain_pairs
from oracles.plain_impacts import plain_impacts
from oracles.plain_sweeps import plain_sweeps
from oracles.regimes import MODELS, REGIMES
from oracles.scene import IMPACT, SWEEP, Cell, Scene
from refimpl import ShapeError
from refimpl.linear import Array

ROUND = (0.0, 0.0, 0.0, 1.0, -1.0, 0.5, 2.0, -0.5, -2.0)
"""What is drawn where any number will do; 0 most often, so that much stands along the axes."""
USUAL = ("aligned", "generic", "touching", "face_on_face")
FORMS, EACH = 3, 8
FORMS_OF_IMPACTS = 2
"""Batches of each regime, in each of which all proxies have one form, and scenes in a batch."""


class RoundDraws:
    """Round numbers for `n` scenes, wherever a regime asks for any."""

    def __init__(self, seed: Sequence[int], n: int) -> None:
        self.n = n
        self.about = ""
        self._generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(seed)))

    def uniform(self, low: float, high: float, width: int = 0) -> Array:
        """Round numbers between `low` and `high`; the ends, where there are none."""
        fitting = [x for x in ROUND if low <= x <= high]
        return self.choice(fitting or [low, high], width)

    def choice(self, values: Sequence[float], width: int = 0) -> Array:
        """Numbers out of `values`."""
        picked = self._generator.integers(len(values), size=(self.n, width) if width else self.n)
        return np.asarray(np.array(values, dtype=np.float64)[picked])


@lru_cache(maxsize=64)
def plain_scenes(cell: Cell, regime: str) -> tuple[Scene, ...]:
    """Scenes of a cell, of round numbers, in the usual regimes and in one more; always the same."""
    if cell.query == SWEEP:
        return tuple(plain_sweeps(cell))
    found = list(plain_impacts(cell) if cell.query == IMPACT else plain_pairs(cell))
    impacts = cell.query == IMPACT
    if impacts and (cell.type_a, cell.type_b) not in STAGED:
        return ()
    known: Sequence[str] = tuple(IMPACT_REGIMES if impacts else REGIMES)
    for name in dict.fromkeys((*(() if impacts else USUAL), regime)):
        if name not in known or name == MODELS:
            continue
        for form in range(FORMS_OF_IMPACTS if impacts else FORMS):
            found += _drawn(cell, name, (known.index(name), form))
    return tuple(found)


def _drawn(cell: Cell, name: str, seed: tuple[int, int]) -> list[Scene]:
    draws = RoundDraws(seed, EACH)
    try:
        if cell.query == IMPACT:
            a, b, motion = IMPACT_REGIMES[name](draws, cell.type_a, cell.type_b)
            return [Scene(cell.query, a[i], b[i], name, "plain", motion[i]) for i in range(EACH)]
        a, b = REGIMES[name](draws, cell.type_a, cell.type_b)
        return [Scene(cell.query, a[i], b[i], name, "plain") for i in range(EACH)]
    except ShapeError:  # round numbers may make a body of no size
        return []
