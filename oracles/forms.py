"""Which proxies may be in one batch together: those whose numbers mean the same."""

from __future__ import annotations

import numpy as np

from oracles.scene import Scene
from refimpl import Composite, Proxy
from refimpl.shapes import Polyhedron


def form_of(shape: Proxy) -> tuple[object, ...]:
    """What proxies have in common that may be in one batch."""
    if isinstance(shape, Composite):
        return tuple((type(part), form_of(part)) for part in shape.parts)
    return (shape.solid.digest,) if isinstance(shape, Polyhedron) else shape.sizes


def by_form(scenes: list[Scene]) -> list[list[Scene]]:
    """Scenes that may be in one batch together."""
    groups: dict[object, list[Scene]] = {}
    for scene in scenes:
        groups.setdefault((form_of(scene.a), form_of(scene.b)), []).append(scene)
    return list(groups.values())


def batch_of(shapes: list[Proxy]) -> Proxy:
    """Proxies of one form as a batch."""
    rows = np.stack([shape.pack() for shape in shapes])
    first = shapes[0]
    return first[None].rebuilt(rows) if isinstance(first, (Polyhedron, Composite)) else type(first).unpack(rows)
