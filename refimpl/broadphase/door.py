"""The door: which of many proxies can meet, or do."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from refimpl.broadphase.protocol import BroadPhase
from refimpl.broadphase.proxies import Numbered
from refimpl.broadphase.table import structure as class_of
from refimpl.proxy import Proxy
from refimpl.signs import Indices


def pairs(
    proxies: Proxy | Iterable[Proxy],
    structure: str | type[BroadPhase] = "column sweep",
    static: Any = None,
    *,
    narrow: bool = False,
) -> Indices:
    """All pairs of proxies whose bounding boxes have a point in common; or all that themselves have one.

    Parameters
    ----------
    proxies
        One batch, or any number of single proxies and batches, of any types; numbered in this order, batches row by
        row. Boxes of half-spaces and rays are infinite.
    structure
        A name in the table `refimpl.broadphase.STRUCTURES`, or a class.
    static : (N,) bool or a single one, optional
        Of two static ones no pair is made.
    narrow
        Whether `intersect` is to decide about the proxies themselves, type pair by type pair.

    Returns
    -------
    (M, 2) int64
        Numbers i < j, sorted by i, then j.

    Raises
    ------
    UnsupportedOperation
        With `narrow`, for two points or rays whose boxes meet: that cell is not in the pair table.
    """
    numbered = Numbered.of(proxies)
    found = class_of(structure)().build(*numbered.boxes(), static).pairs()
    return found[numbered.meet(found)] if narrow else found
