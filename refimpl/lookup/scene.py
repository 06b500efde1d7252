"""A scene: proxies of any types in a bounding volume hierarchy, by which they are found."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from refimpl.broadphase import BVH, Numbered
from refimpl.linear import Array
from refimpl.proxy import Proxy, ShapeError
from refimpl.shapes import Ray
from refimpl.signs import Indices

GROWN = 2.0**-46
"""Share of the largest coordinate by which boxes are larger than need be, as what is asked is rounded."""
REACH = 16.0
"""Ways that are longer than so many sizes of the scene are rounded by more than that; they are asked as boxes."""


class Scene:
    """Proxies, numbered through.

    Parameters
    ----------
    proxies : Proxy or iterable of Proxy
        Solids and points, alone or in batches, which are counted through row by row. There may be none.

    Attributes
    ----------
    solids : Numbered
    boxes : BVH
        Of their bounding boxes; those of half-spaces are infinite.
    """

    def __init__(self, proxies: Proxy | Iterable[Proxy]) -> None:
        self.solids = Numbered.of(proxies)
        if any(isinstance(batch, Ray) or batch.dimension != 3 for batch in self.solids.batches):
            raise ShapeError("Scene: expected solids and points of space, not rays or proxies of the plane")
        lower, upper = self.solids.boxes()
        ends = np.concatenate([lower, upper])
        self.size = float(np.max(np.abs(ends), where=np.isfinite(ends), initial=np.finfo(float).tiny))
        grown = GROWN * self.size
        self.boxes = BVH().build(lower - grown, upper + grown)

    def __len__(self) -> int:
        return len(self.solids)

    def __getitem__(self, number: int) -> Proxy:
        """Give one of the proxies."""
        return self.solids[number]

    def near_ways(self, start: Array, way: Array, length: float) -> Indices:
        """Rows and numbers (K, 2), sorted, of the ways start + t·way (n, 3), 0 ≤ t ≤ length, and what they may meet."""
        far = np.max(np.abs(way), axis=-1) * length if np.isfinite(length) else 0.0
        with np.errstate(over="ignore"):
            size = np.max(np.abs(start), axis=-1) + far
        moving = np.any(way != 0, axis=-1)
        cast = moving & np.isfinite(size) & (size <= REACH * self.size)
        found = [np.empty((0, 2), dtype=np.int64)]
        rows = np.flatnonzero(cast)
        if len(rows):
            near = self.boxes.query_rays(start[rows], way[rows], length)
            found.append(np.stack([rows[near[:, 0]], near[:, 1]], axis=-1))
        rows = np.flatnonzero(~cast)
        if len(rows):
            with np.errstate(over="ignore", invalid="ignore"):
                ends = np.where(way[rows] == 0, start[rows], start[rows] + length * way[rows])
                off = (GROWN if np.isfinite(length) else 0.0) * size[rows, None]  # a finite end is rounded
                low, high = np.minimum(start[rows], ends) - off, np.maximum(start[rows], ends) + off
            near = self.boxes.query_boxes(low, high)
            found.append(np.stack([rows[near[:, 0]], near[:, 1]], axis=-1))
        every = np.concatenate(found)
        return every[np.lexsort((every[:, 1], every[:, 0]))]

    def by_type(self, numbers: Indices) -> Iterator[tuple[Indices, Proxy]]:
        """Places in a list of numbers, and their proxies as a batch, type by type."""
        batch, place = self.solids.batch[numbers], self.solids.place[numbers]
        for which in np.unique(batch).tolist():
            some = np.flatnonzero(batch == which)
            yield some, self.solids.batches[which][place[some]]


def require_scene(scene: Scene) -> Scene:
    """Check that something is a scene; raises `ShapeError`."""
    if not isinstance(scene, Scene):
        raise ShapeError(f"scene: expected a Scene, got {type(scene).__name__}: Scene(proxies) makes one")
    return scene
