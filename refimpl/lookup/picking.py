"""Picking: the first of many proxies on a ray, as under a pointer or on the way of a shot.

The hierarchy gives the boxes on each ray, which are sorted by the time at which the ray enters them; proxies are asked
in that order, a few at once, until the next box is entered later than what was hit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.broadphase.slabs import clipped
from refimpl.linear import Array
from refimpl.lookup.scene import Scene, require_scene
from refimpl.queries import raycast
from refimpl.results import RayHit
from refimpl.shapes import Point, Ray, ShapeError
from refimpl.signs import Indices

NOTHING = -1


@dataclass(frozen=True)
class Pick:
    """What rays hit first.

    Attributes
    ----------
    number : (...) int64
        Of the proxy in the scene; of several at the same time the first, −1 where nothing is hit.
    hit : RayHit
        As `refimpl.raycast` gives it for that proxy.
    """

    number: Indices
    hit: RayHit


def pick(scene: Scene, ray: Ray) -> Pick:
    """Find the first proxy on each ray (...).

    An answer is proven by `certify(ray, scene[number])`, which encloses its time, and by the same of the others that
    the ray may meet (`scene.near_ways`), which come no sooner.

    Raises
    ------
    ShapeError
        For anything but rays of space, and for scenes with points, which have no surface.
    """
    if not isinstance(ray, Ray):
        raise ShapeError(f"ray: expected a Ray, got {type(ray).__name__}")
    if any(isinstance(batch, Point) for batch in require_scene(scene).solids.batches):
        raise ShapeError("scene: rays are not cast at points; pick in a scene of the solids alone")
    rays = ray.flattened()
    near = scene.near_ways(rays.origin, rays.direction, np.inf)
    entry = _entries(scene, rays, near)
    order = np.lexsort((near[:, 1], entry, near[:, 0]))
    near, entry = near[order], entry[order]
    start = np.searchsorted(near[:, 0], np.arange(len(rays)))
    end = np.searchsorted(near[:, 0], np.arange(len(rays)), side="right")
    best = _Best(len(rays))
    many = 1
    while True:
        left = start < end
        left[left] = entry[start[left]] <= best.time[left]
        rows = np.flatnonzero(left)
        if not len(rows):
            break
        counts = np.minimum(end[rows] - start[rows], many)
        asked = np.repeat(start[rows] - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())
        best.ask(scene, rays, near[asked])
        start[rows] += counts
        many *= 2
    return best.found(ray.batch_shape)


def _entries(scene: Scene, rays: Ray, near: Indices) -> Array:
    """Times at which rays enter boxes, or a little sooner."""
    row, number = near.T
    low, high = scene.boxes.lower[number], scene.boxes.upper[number]
    with np.errstate(over="ignore", invalid="ignore"):
        first, _, lost = clipped(rays.origin[row], rays.direction[row], np.full(len(row), np.inf), low, high)
    return np.where(lost, -np.inf, first)


class _Best:
    """The first hit of each ray so far."""

    def __init__(self, count: int) -> None:
        self.number = np.full(count, NOTHING)
        self.time = np.full(count, np.inf)
        self.point, self.normal = np.full((2, count, 3), np.nan)

    def ask(self, scene: Scene, rays: Ray, near: Indices) -> None:
        """Cast rays at proxies, and keep what comes sooner; of what comes at once, the lower number."""
        for some, proxies in scene.by_type(near[:, 1]):
            row, number = near[some].T
            hit = raycast(rays[row], proxies)
            first = np.lexsort((number, hit.t, row))
            first = first[np.unique(row[first], return_index=True)[1]]  # the soonest of each ray
            row, number, time = row[first], number[first], hit.t[first]
            tied = (time == self.time[row]) & (number < self.number[row])  # of a miss the number so far is −1
            sooner = (time < self.time[row]) | tied
            row, first = row[sooner], first[sooner]
            self.number[row], self.time[row] = number[sooner], time[sooner]
            self.point[row], self.normal[row] = hit.point[first], hit.normal[first]

    def found(self, batch: tuple[int, ...]) -> Pick:
        """Everything, in the shape of the batch."""
        hit, time = np.reshape(self.number != NOTHING, batch)[()], self.time.reshape(batch)[()]
        point, normal = self.point.reshape(*batch, 3), self.normal.reshape(*batch, 3)
        return Pick(self.number.reshape(batch)[()], RayHit(hit, time, point, normal))
