"""Bounding volumes by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from refimpl.construct.balls import fast_sphere, sphere
from refimpl.construct.boxes import box, least_box
from refimpl.construct.ellipsoids import ellipsoid
from refimpl.construct.polytopes import hull, simplified_hull
from refimpl.construct.rods import capsule, cylinder
from refimpl.construct.slabs import aabb, kdop
from refimpl.construct.sources import ConstructionError
from refimpl.proxy import Proxy

KINDS: dict[str, Callable[[Any], Proxy]] = {
    "aabb": aabb,
    "sphere": sphere,
    "fast_sphere": fast_sphere,
    "box": box,
    "least_box": least_box,
    "capsule": capsule,
    "cylinder": cylinder,
    **{f"kdop{k}": partial(kdop, directions=k) for k in (6, 14, 18, 26)},
    "ellipsoid": ellipsoid,
    "hull": hull,
    **{f"hull{k}": partial(simplified_hull, planes=k) for k in (8, 16, 32)},
}
"""Every kind of bounding volume, by its name."""


def bounding(source: Any, kind: str) -> Proxy:
    """Bounding volume of one of `KINDS` around points, a mesh file or a mesh; see `points_of` for what is taken.

    Raises
    ------
    ConstructionError
        For a kind that there is none of, and as the functions themselves.
    """
    if not isinstance(kind, str) or kind not in KINDS:
        raise ConstructionError(f"there is no bounding volume {kind!r:.80}; there are {', '.join(KINDS)}")
    return KINDS[kind](source)
