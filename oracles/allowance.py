"""How many scenes may be put before an engine to make one finding simpler, by what each of them costs."""

from __future__ import annotations

from oracles.outcome import Kind
from oracles.reference import is_quick
from oracles.scene import Cell

TRIES = 1600
"""Scenes that are put before an engine for one finding; for each further one of the same symptom half as many."""
TRIES_SEARCHED = 300
"""Where the judge has to search for each answer."""
TRIES_FORMED = 180
"""Where making a proxy takes time as well: hulls, slabs, meshes, composites."""
TRIES_RELATED = 100
"""Where a relation between two scenes is broken: each try asks the engine twice, on its own."""
TRIES_LOST = 6
"""Where the engine was lost, or ran out of time, on the scene: each try may cost as much again."""
TRIES_LEAST = 200
LOST = (Kind.CRASHED, Kind.TIMED_OUT)


def is_formed(cell: Cell) -> bool:
    """Whether a proxy of the cell has a form besides its numbers: vertices, slabs, faces, parts."""
    return any(kind.header for kind in (cell.type_a, cell.type_b))


def tries_for(cell: Cell, kind: Kind, *, related: bool, again: bool) -> int:
    """How many scenes may be tried for a finding; `again` where an engine was asked already for another like it."""
    if related:
        return TRIES_RELATED
    if kind in LOST:
        return 0 if again else TRIES_LOST
    if is_formed(cell):
        return TRIES_FORMED
    return TRIES if is_quick(cell.type_a, cell.type_b) else TRIES_SEARCHED


def tries_of_next(allowed: int, number: int) -> int:
    """How many of them are left for a finding after so `number` many others."""
    return max(min(TRIES_LEAST, allowed // 3), allowed >> number)
