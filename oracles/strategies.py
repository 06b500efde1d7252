"""Hypothesis strategies over the same regimes as the bulk hunter's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st

from oracles.engine import Engine
from oracles.impact_regimes import impact_regimes_for
from oracles.recipes import regimes_of
from oracles.regimes import is_drawn, regimes_for
from oracles.scene import IMPACT, SWEEP, Cell, Scene
from oracles.sweep_regimes import SWEEP_REGIMES
from refimpl.linear import Array


class HypothesisDraws:
    """Numbers of one scene, drawn and shrunk by Hypothesis."""

    n = 1
    about = ""

    def __init__(self, draw: Callable[[st.SearchStrategy[Any]], Any]) -> None:
        self._draw = draw

    def _fill(self, strategy: st.SearchStrategy[float], width: int) -> Array:
        count = max(width, 1)
        values = np.array([self._draw(strategy) for _ in range(count)], dtype=np.float64)
        return values.reshape((1, width) if width else (1,))

    def uniform(self, low: float, high: float, width: int = 0) -> Array:
        """Numbers between `low` and `high`; simple ones first."""
        return self._fill(st.floats(low, high, allow_subnormal=False), width)

    def choice(self, values: Sequence[float], width: int = 0) -> Array:
        """Numbers out of `values`; the first is the simplest."""
        return self._fill(st.sampled_from([float(v) for v in values]), width)


@st.composite
def scenes(draw: st.DrawFn, cell: Cell, regimes: Sequence[str] | None = None, engines: Sequence[Engine] = ()) -> Scene:
    """Scenes of a cell, in any of the regimes (by default all, those of the engines' thresholds included).

    Shrinks to the first regime and simple numbers.
    """
    pair = cell.type_a, cell.type_b
    name = draw(st.sampled_from([n for n in regimes or regimes_of(cell.query, engines) if is_drawn(n, pair)]))
    draws = HypothesisDraws(draw)
    if cell.query == IMPACT:
        a, b, motion = impact_regimes_for(engines)[name](draws, cell.type_a, cell.type_b)
        return Scene(cell.query, a[0], b[0], name, "hypothesis", motion[0])
    if cell.query == SWEEP:
        a, b, course = SWEEP_REGIMES[name](draws, cell.type_a, cell.type_b)
        return Scene(cell.query, a[0], b[0], name, "hypothesis", course[0])
    a, b = regimes_for(engines)[name](draws, cell.type_a, cell.type_b)
    return Scene(cell.query, a[0], b[0], name, "hypothesis" + draws.about)
