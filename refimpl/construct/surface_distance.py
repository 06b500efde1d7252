"""How far the surfaces of a proxy and a mesh are from each other: the means, and the largest (Hausdorff) distances.

Cignoni, Rocchini and Scopigno, Metro: Measuring Error on Simplified Surfaces, 1998: the distance of each of many
points, evenly spread over one surface, from the other surface; which is not the same in the other direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.atoms import leaves
from refimpl.bounds import bounding_sphere
from refimpl.construct.heights import heights
from refimpl.construct.surfaces import Samples, outside_of_all, surface_samples
from refimpl.linear import Array, norm
from refimpl.proxy import Proxy
from refimpl.queries import distance
from refimpl.shapes import Point, Polyhedron

POINTS = 4096
FINER = 4
"""Points of a union's surface, for each one that is measured."""


@dataclass(frozen=True)
class OneSided:
    """Distances of the points of one surface from another surface, [length].

    Attributes
    ----------
    mean, largest : float
        Over all points; the largest is the one-sided Hausdorff distance, from below.
    over : float
        Mean, where a point inside the other solid counts 0: what stands out.
    """

    mean: float
    largest: float
    over: float


@dataclass(frozen=True)
class SurfaceDistance:
    """Distances of the surfaces of a proxy and a mesh, [length].

    Attributes
    ----------
    of_proxy : OneSided
        From points of the proxy's surface to the mesh's.
    of_mesh : OneSided
        From points of the mesh's surface to the proxy's.
    """

    of_proxy: OneSided
    of_mesh: OneSided

    @property
    def mean(self) -> float:
        """Two-sided: the mean of both means."""
        return (self.of_proxy.mean + self.of_mesh.mean) / 2

    @property
    def hausdorff(self) -> float:
        """Two-sided: the larger of both largest distances."""
        return max(self.of_proxy.largest, self.of_mesh.largest)


def surface_distance(proxy: Proxy, mesh: Polyhedron, *, points: int = POINTS, seed: int = 0) -> SurfaceDistance:
    """Distances between the surfaces of a proxy and a mesh.

    Each point's distance is exact up to rounding, except for points in a union from which the shortest way out of the
    part in which they are deepest ends in another part: there it is that to the nearest of many points of the union's
    surface, too large by as much as these are apart, at most.

    Parameters
    ----------
    proxy : a single bounded solid
    mesh : a single Polyhedron
    points : int
        On each surface.
    seed : int
        The same seed gives the same numbers.

    Raises
    ------
    ShapeError
        For a batch, and for a proxy without surface area.
    UnsupportedOperation
        For a half-space, a point or a ray.
    """
    of_proxy, of_mesh = (surface_samples(shape, points, seed) for shape in (proxy, mesh))
    return SurfaceDistance(_one_sided(of_proxy, mesh, points), _one_sided(of_mesh, proxy, points))


def _one_sided(samples: Samples, other: Proxy, points: int) -> OneSided:
    height = heights(other, samples.points)
    away = np.abs(height) if len(leaves(other)) == 1 else _ways_out(other, samples.points, height, points)
    over = np.where(height > 0, height, 0.0)
    return OneSided(float(np.mean(away)), float(np.max(away)), float(np.mean(over)))


def _ways_out(union: Proxy, points: Array, height: Array, number: int) -> Array:
    """Distances from a union's surface; from outside, they are the heights.

    Inside, the way out of any part ends on the union's surface unless it ends in another part, and no way out is
    shorter than that of the part in which the point is deepest.
    """
    away = np.abs(height)
    inside = np.flatnonzero(height < 0)
    if not len(inside):
        return away
    least, free = away[inside], np.full(len(inside), np.inf)
    for part in leaves(union):
        ball = bounding_sphere(part)
        rows = np.flatnonzero(norm(points[inside] - ball.center) < ball.radius)
        if not len(rows):
            continue
        found = distance(Point(points[inside[rows]]), part)
        depth = -found.distance
        ends = (depth > 0) & outside_of_all(union, found.on_b, -found.normal)
        free[rows] = np.where(ends, np.minimum(free[rows], depth), free[rows])
    open_ = np.flatnonzero(free > least)
    if len(open_):
        from scipy.spatial import cKDTree  # noqa: PLC0415  not needed by those who only ask for distances

        surface = surface_samples(union, FINER * number)
        nearest = cKDTree(surface.points).query(points[inside[open_]])[0]
        free[open_] = np.minimum(free[open_], nearest)
    away[inside] = free
    return away
