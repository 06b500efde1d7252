"""Volumes of sets that no formula gives, and how much of its volume a proxy shares with a mesh.

Boxes that are wholly inside count in full; in each of those with the boundary in it, one random point is asked. These
points are independent, and each changes the sum by one small box at most, so that Hoeffding's inequality bounds what
chance can do to it (Probability Inequalities for Sums of Bounded Random Variables, 1963).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from refimpl.bounds import aabb
from refimpl.construct.heights import heights
from refimpl.construct.partition import Field, partition
from refimpl.linear import Array
from refimpl.mass import mass_properties
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.shapes import Composite, Polyhedron

BOXES = 32_768
DOUBT = 1e-9
"""How probable it is that a volume is farther off than its stated error."""


@dataclass(frozen=True)
class Volume:
    """A volume, [length³], and how far off it may be.

    Attributes
    ----------
    value : float
    error : float
        With probability 1 − 1e-9 it is off by no more than this; 0 for what a formula gave, which is off by rounding.
    """

    value: float
    error: float

    @property
    def lower(self) -> float:
        """Least volume within the error."""
        return max(self.value - self.error, 0.0)

    @property
    def upper(self) -> float:
        """Largest volume within the error."""
        return self.value + self.error


@dataclass(frozen=True)
class Overlap:
    """How much of its volume a proxy has in common with a mesh.

    Attributes
    ----------
    mesh, proxy, common : Volume
        Of the mesh, of the proxy, and of what both contain.
    """

    mesh: Volume
    proxy: Volume
    common: Volume

    @property
    def iou(self) -> float:
        """Intersection over union (Jaccard index), 0 to 1: 1 for equal sets."""
        return _over_union(self.common.value, self.mesh.value, self.proxy.value)

    @property
    def iou_bounds(self) -> tuple[float, float]:
        """Least and largest intersection over union that the volumes' errors allow."""
        most = min(self.common.upper, self.mesh.upper, self.proxy.upper)
        low = _over_union(self.common.lower, self.mesh.upper, self.proxy.upper)
        return low, _over_union(most, max(self.mesh.lower, most), max(self.proxy.lower, most))

    @property
    def ratio(self) -> float:
        """Volume of the proxy over that of the mesh: the tightness of bounding volumes."""
        return self.proxy.value / self.mesh.value

    @property
    def covered(self) -> float:
        """Part of the mesh that the proxy covers, 0 to 1."""
        return self.common.value / self.mesh.value

    @property
    def outside(self) -> float:
        """Volume of the proxy outside the mesh, over that of the mesh."""
        return max(self.proxy.value - self.common.value, 0.0) / self.mesh.value


def _over_union(common: float, mesh: float, proxy: float) -> float:
    """Intersection over union from what can be measured; rounding and chance may not lead beyond 1."""
    common = min(common, mesh, proxy)
    return common / (mesh + proxy - common)


def volume_overlap(proxy: Proxy, mesh: Polyhedron, *, boxes: int = BOXES, seed: int = 0) -> Overlap:
    """Volumes of a proxy, of a mesh, and of what they have in common.

    The mesh's volume is that of its surface integral; the proxy's is exact too, unless it has parts that overlap.

    Parameters
    ----------
    proxy : a single bounded solid
    mesh : a single Polyhedron
    boxes : int
        Boxes around the boundary, at most; errors fall as their inverse.
    seed : int
        The same seed gives the same numbers.

    Raises
    ------
    ShapeError
        For a batch.
    UnsupportedOperation
        For a half-space, a point or a ray.
    """
    for name, shape in (("proxy", proxy), ("mesh", mesh)):
        if shape.batch_shape:
            raise ShapeError(f"{name}: expected a single solid, got a batch of shape {shape.batch_shape}")
    whole = Volume(float(mass_properties(mesh).volume), 0.0)
    around, other = aabb(proxy), aabb(mesh)
    lower, upper = np.maximum(around.lower, other.lower), np.minimum(around.upper, other.upper)
    if np.any(lower >= upper):
        common = Volume(0.0, 0.0)
    else:
        common = measured(lambda at, reach: _in_both(proxy, mesh, at, reach), lower, upper, boxes, seed)
    return Overlap(whole, proxy_volume(proxy, boxes=boxes, seed=seed), common)


def proxy_volume(proxy: Proxy, *, boxes: int = BOXES, seed: int = 0) -> Volume:
    """Volume of a single bounded solid: by its formula, or measured where parts overlap."""
    try:
        return Volume(float(mass_properties(proxy).volume), 0.0)
    except UnsupportedOperation:
        if not isinstance(proxy, Composite):
            raise
    around = aabb(proxy)
    return measured(lambda at, reach: heights(proxy, at, reach), around.lower, around.upper, boxes, seed)


def _in_both(proxy: Proxy, mesh: Polyhedron, at: Array, reach: float) -> Array:
    """The larger of two heights; the mesh's, which costs more, only where the proxy's does not decide."""
    found = heights(proxy, at, reach)
    near = np.flatnonzero(found <= reach)
    found[near] = np.maximum(found[near], heights(mesh, at[near], reach))
    return found


def measured(field: Field, lower: Array, upper: Array, boxes: int, seed: int) -> Volume:
    """Volume of the set in a box where a field is negative or 0."""
    parts = partition(field, lower, upper, boxes)
    mixed = parts.mixed
    inside = float(np.sum(parts.volume[~mixed & (parts.value < 0)]))
    doubtful = parts[mixed]
    if not len(doubtful.value):
        return Volume(inside, 0.0)
    random = np.random.default_rng(seed).uniform(-1.0, 1.0, doubtful.center.shape)
    hit = field(doubtful.center + random * doubtful.half, 0.0) <= 0
    error = math.sqrt(math.log(2 / DOUBT) / 2 * float(np.sum(doubtful.volume**2)))
    return Volume(inside + float(np.sum(doubtful.volume[hit])), error)
