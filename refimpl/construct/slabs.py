"""Boxes along the axes and k-DOPs: the extent of points along directions, rounded outwards once.

Ericson, Real-Time Collision Detection, 4.2 and 4.6; Klosowski et al., Efficient Collision Detection Using Bounding
Volume Hierarchies of k-DOPs, 1998.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.formulas import about_one
from refimpl.construct.outwards import least_above
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.linear import Array, as_floats
from refimpl.proxy import ShapeError
from refimpl.shapes import AABB, KDOP
from refimpl.shapes.polytopes import USUAL_DIRECTIONS


def aabb(points: ArrayLike) -> AABB:
    """Smallest box along the axes around points (n, 3): nothing is rounded, each side touches a point.

    Raises
    ------
    ConstructionError
        See `points_of`.
    """
    given = points_of(points)
    columns = [np.ascontiguousarray(given[:, i]) for i in range(3)]  # strided columns take three times as long
    return AABB([c.min() for c in columns], [c.max() for c in columns])


def kdop(points: ArrayLike, directions: int | ArrayLike = 26) -> KDOP:
    """Smallest k-DOP of given directions around points: each bound is the exact one, rounded outwards once.

    Parameters
    ----------
    points : (n, 3)
    directions : {6, 14, 18, 26} or (k, 3)
        The usual ones, two planes for each, or any that are finite, not zero, and together bound all of space.

    Raises
    ------
    ConstructionError
        For directions that are none, or that leave a way without end, and a bound beyond the largest double.
    """
    ways = _directions(directions)
    cloud = Cloud(points_of(points))
    lower, upper = zip(*(_extent(cloud, way) for way in ways.tolist()), strict=True)
    try:
        return KDOP(ways, lower, upper)
    except ShapeError as error:
        raise ConstructionError(f"directions: {error}") from None


def _extent(cloud: Cloud, way: list[float]) -> tuple[float, float]:
    """Greatest double that is not above way·x for any of the points, and least that is not below."""
    level, size = about_one([Fraction(v) for v in way])
    low, high = cloud.extent(level)
    what = "bound along a direction"
    return -least_above(-low * size, cloud, what), least_above(high * size, cloud, what)


def _directions(directions: int | ArrayLike) -> Array:
    if isinstance(directions, int):
        if directions not in USUAL_DIRECTIONS:
            known = ", ".join(map(str, USUAL_DIRECTIONS))
            raise ConstructionError(f"directions: the usual k are {known}, got {directions}; or give an array (k, 3)")
        return USUAL_DIRECTIONS[directions]
    ways = as_floats(directions)
    if ways.ndim != 2 or ways.shape[1] != 3 or not np.all(np.isfinite(ways)) or np.any(np.all(ways == 0, axis=1)):
        raise ConstructionError(f"directions: expected finite vectors (k, 3), none zero, got {ways.tolist()!r}")
    return ways
