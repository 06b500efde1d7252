"""Paths: two scenes show the same fault when one turns into the other little by little, and the engine fails all along.

A slight error next to where a fault begins leads to gross ones: with every doubling of the way it grows no more than a
power of the way does. Where a quiet fault ends and a loud one begins, the error leaps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from oracles.forms import form_of
from oracles.likeness import Failing
from oracles.scene import Scene
from oracles.simpler import changeable, rebuilt, with_sides
from refimpl import Proxy

DOUBLINGS, HALVINGS = 30, 8
"""Steps of a path, each twice as far from its start as the one before, and then half as far from its end."""
SHARES = (*(2.0**-k for k in range(DOUBLINGS, 0, -1)), *(1.0 - 2.0**-k for k in range(2, HALVINGS + 1)))
LEAP = 10.0
"""Factor by which an error may grow or fall in such a step: a third power, and some room."""


def path(start: Scene, end: Scene) -> list[Scene]:
    """Scenes between two of one cell, number by number; none where there is no way."""
    if start.motion is not None or not (_are_alike(start.a, end.a) and _are_alike(start.b, end.b)):
        return []
    scenes: list[Scene] = []
    for share in SHARES:
        scenes += with_sides(start, _between(start.a, end.a, share), _between(start.b, end.b, share))
    return scenes if len(scenes) == len(SHARES) else []


def _are_alike(x: Proxy, y: Proxy) -> bool:
    """Whether the numbers of both mean the same."""
    rows = x.pack(), y.pack()
    return form_of(x) == form_of(y) and rows[0].shape == rows[1].shape


def _between(x: Proxy, y: Proxy, share: float) -> Proxy | None:
    first, last = x.pack(), y.pack()
    return rebuilt(x, np.where(changeable(x), (1.0 - share) * first + share * last, first))


def leads(failures: Sequence[Failing]) -> bool:
    """Whether the errors of scenes along a path change step by step, as those of one fault do."""
    errors = [one.amount for one in failures]
    if not all(0 < error < math.inf for error in errors):
        return False
    return all(1 / LEAP <= after / before <= LEAP for before, after in pairwise(errors))
