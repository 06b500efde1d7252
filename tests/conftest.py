"""Hypothesis profiles, and the scenes that the tests of the reference share."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from mpmath import mp

from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from refimpl import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, Sphere
from refimpl.pairs import TABLE

QUICK = {Point, Ray, Sphere, Capsule, HalfSpace, AABB, Box}
"""Types whose scenes are drawn, answered and proven in a moment."""
TURNS = 4

mp.dps = 50  # of mpmath, in every test alike: whoever needs another number has it for a while only
os.environ.pop("GITHUB_STEP_SUMMARY", None)  # runs within tests are not what a step has to tell

settings.register_profile(
    "quick",
    max_examples=20,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
    database=None,
)
settings.register_profile(
    "random", max_examples=150, deadline=None, suppress_health_check=list(HealthCheck), database=None
)
settings.register_profile("thorough", max_examples=2000, deadline=None, suppress_health_check=list(HealthCheck))
settings.load_profile("quick")


def effort() -> int:
    """Scenes per regime in the tests that draw in bulk: grows with the Hypothesis profile."""
    return max(8, settings.default.max_examples // 2) if settings.default else 8


def scenes_of(pair: tuple[type[Proxy], type[Proxy]], regime: str, n: int, seed: int = 2026) -> tuple[Proxy, Proxy]:
    """`n` scenes of a pair in a regime, the same in every run."""
    shard = (list(REGIMES).index(regime), 77)
    return REGIMES[regime](NumpyDraws(seed, shard, n), *pair)


def regimes_in_turn(pair: tuple[type[Proxy], type[Proxy]]) -> list[str]:
    """All regimes; in the quick profile, of pairs that cost more, one in five, in turn from pair to pair."""
    names = list(REGIMES)
    if set(pair) <= QUICK or effort() > 10:
        return names
    turn = list(TABLE).index(pair if pair in TABLE else pair[::-1])
    return names[turn % TURNS :: TURNS]


def name_of(pair: object) -> str:
    """Readable test ids for pairs of types."""
    if isinstance(pair, tuple):
        return "-".join(kind.__name__ for kind in pair)
    return pair.__name__ if isinstance(pair, type) else str(pair)


@pytest.fixture(autouse=True)
def _strict_floats() -> object:
    """A test may not pass on a number that numpy warns about."""
    with np.errstate(all="warn", under="ignore"):
        yield
