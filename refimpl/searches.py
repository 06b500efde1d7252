"""Room for the search for ways out of overlapping unions (`refimpl.kernels.ways`)."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from refimpl.compiling import buffer
from refimpl.kernels.escapes import AROUND
from refimpl.kernels.leastmove import PLANE
from refimpl.kernels.tangents import Tangents
from refimpl.kernels.ways import Search


def _whole(size: int, module: ModuleType) -> Any:
    return buffer(size, module, whole=True)


def search_room(pairs: int, module: ModuleType) -> Search:
    """Make room for searches with so many pairs of atoms; what does not fit ends a search early."""
    tangents, planes = 512 + 8 * pairs, 64 + 2 * pairs

    known = Tangents(
        first=_whole(pairs, module),
        next=_whole(tangents, module),
        pair=_whole(tangents, module),
        place=_whole(tangents, module),
        plane=buffer(PLANE * tangents, module),
        touch=buffer(3 * tangents, module),
        used=_whole(1, module),
    )
    return Search(
        known,
        buffer(PLANE * planes, module),
        _whole(planes, module),
        _whole(pairs, module),
        _whole(1, module),
        buffer(AROUND, module),
    )
