"""One impact for the tests: a box that lands flat on the floor, and what may be said of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from oracles.engine import COLUMNS, VELOCITIES, WIDTH, Answers
from oracles.impact_reference import reference_of
from oracles.motion import Motion, Moving
from oracles.scene import IMPACT, Scene
from refimpl import Box, HalfSpace

FLOOR = HalfSpace([0.0, 0.0, 1.0], 0.0)
CRATE = Box([0.25, 0.0, 1.5], [1.5, 1.5, 1.5], [0.0, 0.0, 0.0, 1.0])
STILL = np.zeros(3)
FLAT = Scene(
    IMPACT,
    FLOOR,
    CRATE,
    "head_on",
    "a crate on the floor",
    Motion(
        Moving(STILL, STILL, STILL, np.array(0.0), np.eye(3)),
        Moving(
            np.array([0.25, 0.0, 1.5]),
            np.array([0.5, 0.0, -2.0]),
            STILL,
            np.array(0.5),
            3.0 * np.eye(3),
        ),
        np.array([0.25, 0.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        np.array(0.5),
        np.array(0.0),
    ),
)
"""Its velocity after is (0.5, 0, 1), and it does not spin."""


def answered(scene: Scene, **changes: Any) -> Answers:
    """What the reference says of one impact, with some velocities changed."""
    assert scene.motion is not None
    right = reference_of(scene.motion[None])
    table = np.full((1, WIDTH), np.nan)
    for name in VELOCITIES:
        table[0, COLUMNS[name]] = changes.get(name, getattr(right, name)[0])
    return Answers.from_table(np.zeros(1, dtype=np.int8), table, {})
