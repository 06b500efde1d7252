"""Room for the search for ways out of overlapping unions (`refimpl.kernels.ways`)."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from refimpl.compiling import buffer
from refimpl.kernels.branches import LEVEL, LEVELS, SPOT
from refimpl.kernels.leastmove import PLANE
from refimpl.kernels.tangents import Tangents
from refimpl.kernels.ways import Search

CHAINS = 1 << 16
"""So many lists of tangents at most; more pairs share them."""


def _whole(size: int, module: ModuleType) -> Any:
    return buffer(size, module, whole=True)


def search_room(pairs: int, room: int, module: ModuleType) -> Search:
    """Make room for searches.

    Parameters
    ----------
    pairs : int
        How many pairs of atoms there are.
    room : int
        How many of them may be near each other at once, and all answered.
    module
        The kernels' own, which says what they read.
    """
    tangents, planes = 512 + 40 * room, 64 + 2 * room
    known = Tangents(
        first=_whole(min(pairs, CHAINS), module),
        next=_whole(tangents, module),
        pair=_whole(tangents, module),
        place=_whole(tangents, module),
        plane=buffer(PLANE * tangents, module),
        touch=buffer(3 * tangents, module),
        listed=_whole(min(pairs, CHAINS), module),
        used=_whole(1, module),
    )
    return Search(
        known=known,
        planes=buffer(PLANE * planes, module),
        source=_whole(planes, module),
        listed=_whole(room, module),
        places=_whole(1, module),
        short=_whole(1, module),
        levels=_whole(LEVEL * LEVELS, module),
        spots=buffer(SPOT * LEVELS, module),
    )
