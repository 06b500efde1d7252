"""How many scenes may be put before an engine to make one finding simpler, by what each of them costs."""

from __future__ import annotations

from oracles.outcome import Kind
from oracles.reference import is_quick
from oracles.scene import Cell
from oracles.screening import RAISED

TRIES = 2400
"""Scenes that are put before an engine for one finding; for each further one of the same symptom half as many."""
TRIES_SEARCHED = 300
"""Where the judge has to search for each answer."""
TRIES_FORMED = 180
"""Where making a proxy takes time as well: hulls, slabs, meshes, composites."""
TRIES_RELATED = 100
"""Where a relation between two scenes is broken: each try asks the engine twice, on its own."""
TRIES_LOST = 150
"""Where the engine was lost, or ran out of time, on the scene: each try may cost as much again."""
MOST_LOST, MOST_LOST_AGAIN = 8, 3
"""How often it may, for the first finding and for each further one."""
TRIES_LEAST = 300


def is_formed(cell: Cell) -> bool:
    """Whether a proxy of the cell has a form besides its numbers: vertices, slabs, faces, parts."""
    return any(kind.header for kind in (cell.type_a, cell.type_b))


def is_lost(kind: Kind, symptom: str) -> bool:
    """Whether an answer of this kind cost the engine's process, or the time that it is given."""
    return kind in (Kind.CRASHED, Kind.TIMED_OUT) and symptom != RAISED


def tries_for(cell: Cell, *, lost: bool, related: bool) -> int:
    """How many scenes may be tried for a finding."""
    if related:
        return TRIES_RELATED
    if lost:
        return TRIES_LOST
    if is_formed(cell):
        return TRIES_FORMED
    return TRIES if is_quick(cell.type_a, cell.type_b) else TRIES_SEARCHED


def tries_of_next(allowed: int, number: int) -> int:
    """How many of them are left for a finding after so `number` many others."""
    return max(min(TRIES_LEAST, allowed // 3), allowed >> number)
