"""Every kind of proxy that can be built from a solid: by name, what it is called and for, and how it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from refimpl.construct.bounding import bounding
from refimpl.construct.decomposition import decomposed
from refimpl.construct.fitting import fitted_boxes, fitted_capsules, fitted_spheres, packed_spheres
from refimpl.construct.sources import points_of
from refimpl.proxy import Proxy
from refimpl.shapes import Polyhedron

MODEL, BOUNDING, COLLIDER = "model", "bounding volume", "collider"
PARTS = 8
"""Parts of a fitted collider."""


class Kind(NamedTuple):
    """How one kind of proxy is made.

    Attributes
    ----------
    title
        What people call it.
    use
        `BOUNDING` where it contains the solid, proven in exact arithmetic; `COLLIDER` where it stands for it.
    make
        Builds it from a solid.
    """

    title: str
    use: str
    make: Callable[[Polyhedron], Proxy]


def _around(title: str, name: str) -> Kind:
    return Kind(title, BOUNDING, lambda model: bounding(points_of(model), name))


def _like(title: str, fit: Callable[[Any, int], Proxy]) -> Kind:
    return Kind(f"{PARTS} {title}", COLLIDER, lambda model: fit(model, PARTS))


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        MODEL: Kind("the model itself", MODEL, lambda model: model),
        "aabb": _around("axis-aligned box", "aabb"),
        "sphere": _around("smallest sphere", "sphere"),
        "fast_sphere": _around("quick sphere", "fast_sphere"),
        "box": _around("box along principal axes", "box"),
        "least_box": _around("box of least volume", "least_box"),
        "capsule": _around("capsule", "capsule"),
        "cylinder": _around("cylinder", "cylinder"),
        "ellipsoid": _around("ellipsoid of least volume", "ellipsoid"),
        "kdop14": _around("14-DOP", "kdop14"),
        "kdop18": _around("18-DOP", "kdop18"),
        "kdop26": _around("26-DOP", "kdop26"),
        "hull16": _around("hull of 16 planes", "hull16"),
        "hull": _around("convex hull", "hull"),
        "packed_spheres": _like("packed spheres", packed_spheres),
        "spheres": _like("fitted spheres", fitted_spheres),
        "capsules": _like("fitted capsules", fitted_capsules),
        "boxes": _like("fitted boxes", fitted_boxes),
        "decomposition": Kind("convex decomposition", COLLIDER, decomposed),
    }
)
"""In the order in which a scorecard has them."""
