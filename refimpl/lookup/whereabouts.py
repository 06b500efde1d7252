"""Where things are: the proxies of a scene around a point, and those that a frustum shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from refimpl.bounds import aabb
from refimpl.lookup.culling import culled_by, planes_of, shows
from refimpl.lookup.scene import Scene, require_scene
from refimpl.queries import intersect
from refimpl.shapes import AABB, ConvexPolyhedron, Point, ShapeError
from refimpl.signs import Indices


def containing(scene: Scene, points: ArrayLike) -> Indices:
    """All proxies that contain each of some points (n, 3); their surfaces belong to them.

    For one mesh and many points, `refimpl.broadphase.SolidTree.locate` tells inside from surface, exactly.

    Returns
    -------
    (K, 2) int64
        Number of the point and of the proxy, sorted.

    Raises
    ------
    ShapeError
        For points that are no finite (n, 3).
    """
    where = Point(points)
    if len(where.batch_shape) != 1:
        raise ShapeError(f"points: expected shape (n, 3), got {where.position.shape}")
    near = require_scene(scene).boxes.query_points(where.position)
    inside = np.zeros(len(near), dtype=bool)
    for some, proxies in scene.by_type(near[:, 1]):
        inside[some] = intersect(where[near[some, 0]], proxies)
    return near[inside]


def in_view(scene: Scene, frustum: ConvexPolyhedron) -> Indices:
    """Numbers of the proxies that have a point in a frustum, ascending; where rounding leaves a doubt, they are in it.

    First the boxes that meet the frustum's own, then those of them that are beyond no plane, and then the proxies.
    Raises ShapeError for a frustum that `culled_by` refuses.
    """
    planes_of(frustum)
    around = aabb(frustum)
    near = require_scene(scene).boxes.query_boxes(around.lower[None], around.upper[None])[:, 1]
    low, high = scene.boxes.lower[near], scene.boxes.upper[near]
    bounded = np.all(np.isfinite(low) & np.isfinite(high), axis=-1)
    kept = np.ones(len(near), dtype=bool)
    kept[bounded] = culled_by(frustum, AABB(low[bounded], high[bounded])) < 0
    near = near[kept]
    seen = np.zeros(len(near), dtype=bool)
    for some, proxies in scene.by_type(near):
        seen[some] = shows(frustum, proxies)
    return near[seen]
