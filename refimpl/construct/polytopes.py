"""Convex hulls, and hulls of few planes.

qhull proposes which points are corners. Each of the others is then proven to lie in the hull of those that were
proposed, or is made a corner too.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.extreme import centred, dimension
from refimpl.construct.facets import sides_around
from refimpl.construct.formulas import Polynomial, about_one
from refimpl.construct.outwards import least_above
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.derived import hull_of_planes
from refimpl.hulls import Indices
from refimpl.linear import Array, dot
from refimpl.proxy import ShapeError
from refimpl.shapes import ConvexPolyhedron

CUBE = np.concatenate([np.eye(3), -np.eye(3)])
TETRAHEDRON = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])


def hull(points: ArrayLike) -> ConvexPolyhedron:
    """Convex hull of points (n, 3), by the corners among them: exactly the hull, also of flat sets.

    Raises
    ------
    ConstructionError
        See `points_of`; and for coordinates along one axis that differ by more than a factor of 2^1000.
    """
    cloud = Cloud(points_of(points))
    names = np.array(_proposed(cloud))
    while True:
        try:
            sides, kept = sides_around(cloud.points[names], cloud)
        except ShapeError as error:
            raise ConstructionError(str(error)) from None
        names = names[np.sort(kept)]
        outside = _outside(cloud, names, [formula for side in sides for formula in side.formulas()])
        if not outside:
            return ConvexPolyhedron.from_vertices(cloud.points[names])
        names = np.array(sorted({*names.tolist(), *outside}))


def _outside(cloud: Cloud, corners: Indices, formulas: Sequence[Polynomial]) -> set[int]:
    """For each face the point that is farthest outside of it, where one is; corners are not asked."""
    others = np.setdiff1d(np.arange(len(cloud.points)), corners)
    if not len(others):
        return set()
    rest = Cloud(cloud.points[others], float(np.ldexp(0.5, cloud.exponent)))
    highest = [rest.greatest(formula) for formula in formulas]
    return {int(others[far]) for value, far in highest if value > 0}


def _proposed(cloud: Cloud) -> list[int]:
    """Points of which the hull is likely to be all points' hull."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    inside = centred(cloud)[0]
    extent = np.max(np.abs(inside), axis=0)
    count, frame = dimension(inside / np.where(extent > 0, extent, 1.0))  # stretching along axes keeps the corners
    local = (inside / np.where(extent > 0, extent, 1.0)) @ frame
    ends = {int(i) for axis in range(3) for i in (np.argmin(local[:, axis]), np.argmax(local[:, axis]))}
    if count >= 2 and len(inside) > 4:
        try:
            return sorted({*ends, *ConvexHull(local[:, :count]).vertices.tolist()})
        except QhullError:
            pass
    return sorted(ends)


def simplified_hull(points: ArrayLike, planes: int = 16) -> ConvexPolyhedron:
    """Convex polyhedron of at most so many planes around points (n, 3): the faces of their hull that cut off most.

    One after the other, that face of the hull is taken behind which what there is so far reaches farthest. Each plane
    is then moved outwards by as little as doubles allow.

    Parameters
    ----------
    points : (n, 3)
    planes : int
        At least 4.

    Raises
    ------
    ConstructionError
        See `points_of`; for fewer than 4 planes, which bound nothing; and for a plane beyond the largest double.
    """
    if not isinstance(planes, int) or planes < 4:
        raise ConstructionError(f"planes: a polyhedron has at least 4, got {planes!r}")
    cloud = Cloud(points_of(points))
    inside = centred(cloud)[0]
    corners = inside[_proposed(cloud)]
    chosen = TETRAHEDRON if planes < 6 else CUBE
    normals = _normals(corners)
    while len(chosen) < planes and len(normals):
        bound = hull_of_planes(_touching(chosen, corners)).vertices
        cut = _reach(bound, normals) - _reach(corners, normals)
        best = int(np.argmax(cut))
        if cut[best] <= 1e-9 * float(np.max(np.abs(corners))):
            break
        chosen = np.concatenate([chosen, normals[best : best + 1]])
        normals = np.delete(normals, best, axis=0)
    try:
        return ConvexPolyhedron([[*n, _offset(cloud, n)] for n in chosen.tolist()])
    except ShapeError as error:
        raise ConstructionError(f"planes: {error}") from None


def _normals(corners: Array) -> Array:
    """Unit normals of the faces of a hull; of a flat one none."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    if dimension(corners)[0] < 3:
        return np.zeros((0, 3))
    try:
        return np.unique(ConvexHull(corners).equations[:, :3], axis=0)
    except QhullError:
        return np.zeros((0, 3))


def _reach(points: Array, normals: Array) -> Array:
    return np.asarray(np.max(dot(normals[:, None, :], points[None, :, :]), axis=1))


def _touching(normals: Array, corners: Array) -> Array:
    return np.concatenate([normals, -_reach(corners, normals)[:, None]], axis=1)


def _offset(cloud: Cloud, normal: list[float]) -> float:
    """Greatest double k with normal·x + k ≤ 0 for all points."""
    way, size = about_one([Fraction(v) for v in normal])
    return -least_above(cloud.highest(way) * size, cloud, "plane")
