"""All regimes by their names: which of them have scenes for which query."""

from __future__ import annotations

from collections.abc import Iterable

from oracles.engine import Engine
from oracles.impact_regimes import IMPACT_REGIMES, SPEEDS_OF, impact_reasons, impact_regimes_for
from oracles.regimes import reasons, regimes_for
from oracles.scene import IMPACT, MOVING, SWEEP
from oracles.sweep_regimes import SWEEP_REGIMES, sweep_reasons

AT_REST = ""
"""Stands for all queries without a motion, which share their regimes."""


def kind_of(query: str) -> str:
    """What regimes a query has: its own, of impacts and sweeps, or those of all scenes at rest."""
    return query if query in MOVING else AT_REST


def is_for(name: str, query: str) -> bool:
    """Whether a regime of this name has scenes for a query."""
    if name in SWEEP_REGIMES:
        return query == SWEEP
    if name in IMPACT_REGIMES or name.startswith(SPEEDS_OF):
        return query == IMPACT
    return query not in MOVING


def regimes_of(query: str, engines: Iterable[Engine] = ()) -> list[str]:
    """Names of the regimes that have scenes for a query; with those of the engines' own thresholds."""
    if query == SWEEP:
        return list(SWEEP_REGIMES)
    return list(impact_regimes_for(engines) if query == IMPACT else regimes_for(engines))


def reasons_of(queries: Iterable[str], engines: Iterable[Engine]) -> dict[str, str]:
    """Why each regime exists: those of scenes at rest, and of impacts and sweeps where these are asked."""
    every, asked = list(engines), set(queries)
    found = reasons(regimes_for(every))
    if IMPACT in asked:
        found |= impact_reasons(impact_regimes_for(every))
    return found | (sweep_reasons() if SWEEP in asked else {})
