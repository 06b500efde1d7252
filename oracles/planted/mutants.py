"""All engines that are wrong on purpose."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from oracles.planted import (  # importing a module registers its engines
    wrong_balls,
    wrong_booleans,
    wrong_bricks,
    wrong_contacts,
    wrong_impacts,
    wrong_rays,
    wrong_states,
)
from oracles.planted.mutant import MUTANTS as _REGISTERED
from oracles.planted.mutant import Mutant

SOURCES = (wrong_balls, wrong_bricks, wrong_booleans, wrong_contacts, wrong_rays, wrong_impacts, wrong_states)
MUTANTS: Mapping[str, Mutant] = MappingProxyType(_REGISTERED)
"""By name, in the order of the modules that they stand in."""
