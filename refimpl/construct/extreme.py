"""The points that matter for a bounding volume's shape: those on the hull, as far as doubles tell.

They only steer a search. What it proposes is enlarged until it contains all points, so nothing here has to be exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.construct.cloud import Cloud
from refimpl.linear import Array
from refimpl.principal import quaternion_of

MOST = 512  # points of a hull by which a shape is searched
SAMPLE = 2000
FLAT = 1e-12  # points that spread less along an axis than this share of their size are searched in fewer dimensions


def centred(cloud: Cloud) -> tuple[Array, Array]:
    """Points (n, 3) about the middle of their box, in a cloud's units, and that middle."""
    low, high = cloud.columns.min(axis=1), cloud.columns.max(axis=1)
    middle = low / 2 + high / 2
    return np.ascontiguousarray((cloud.columns - middle[:, None]).T), middle


def principal_frame(points: Array) -> Array:
    """Right-handed frame (3, 3), in its columns, along which points about the origin spread most to least."""
    size = float(np.max(np.abs(points), initial=0.0))
    if size == 0:
        return np.eye(3)
    scaled = points / size
    triangle = np.linalg.qr(scaled - scaled.mean(axis=0), mode="r")  # its squares would drown what is thin
    axes = np.linalg.svd(triangle)[2]
    return np.stack([axes[0], axes[1], np.cross(axes[0], axes[1])], axis=1)


def dimension(points: Array) -> tuple[int, Array]:
    """How many dimensions points about the origin spread in, as doubles tell, and their principal frame."""
    frame = principal_frame(points)
    extents = np.ptp(points @ frame, axis=0)
    least = FLAT * float(np.max(np.abs(points), initial=0.0))
    return min(int(np.sum(extents > least)), len(points) - 1), frame


def on_hull(points: Array) -> Array:
    """Corners (m, 3) of the hull of points, in whatever dimension they spread; all points where qhull gives up."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    count, frame = dimension(points)
    if count == 0 or len(points) <= 4:
        return points[:4]
    local = (points @ frame)[:, :count]
    if count == 1:
        return points[[int(np.argmin(local)), int(np.argmax(local))]]
    try:
        return np.asarray(points[ConvexHull(local).vertices])
    except QhullError:
        return points


def few_corners(points: Array) -> Array:
    """Corners of the hull by which a shape is searched, at most `MOST`.

    Where nearly all of very many points are corners, some of them tell the shape as well.
    """
    some = points[:: max(1, len(points) // SAMPLE)]
    dense = len(points) > 8 * SAMPLE and len(on_hull(some)) > len(some) // 2
    return thinned(on_hull(points[:: len(points) // (4 * SAMPLE)] if dense else points))


def thinned(points: Array) -> Array:
    """At most `MOST` of the points, those that reach farthest along directions all around; all, where they are few."""
    if len(points) <= MOST:
        return points
    step = np.arange(MOST) + 0.5
    height, angle = 1 - 2 * step / MOST, np.pi * (1 + np.sqrt(5)) * step  # a spiral of Fibonacci's angle
    across = np.sqrt(1 - height * height)
    ways = np.stack([np.cos(angle) * across, np.sin(angle) * across, height])
    best, which = np.full(MOST, -np.inf), np.zeros(MOST, dtype=np.int64)
    for start in range(0, len(points), 1 << 14):
        reach = points[start : start + (1 << 14)] @ ways
        most = np.argmax(reach, axis=0)
        value = reach[most, np.arange(MOST)]
        which = np.where(value > best, most + start, which)
        best = np.maximum(value, best)
    return np.asarray(points[np.unique(which)])


def solid_hull(corners: Array) -> Any:
    """The hull that qhull finds; None where corners are too flat for it."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    try:
        return ConvexHull(corners)
    except QhullError:
        return None


def face_normals(corners: Array, most: int) -> Array:
    """Unit normals (k, 3) of the largest faces of a solid hull, one of each pair of parallel ones."""
    hull = solid_hull(corners)
    if hull is None:
        return np.zeros((0, 3))
    a, b, c = (corners[hull.simplices[:, i]] for i in range(3))
    return different_ways(hull.equations[:, :3], np.linalg.norm(np.cross(b - a, c - a), axis=1))[:most]


def different_ways(ways: Array, sizes: Array) -> Array:
    """Unit vectors that differ by more than their sign and rounding, those of the greatest sizes in sum first."""
    sign = np.sign(ways[np.arange(len(ways)), np.argmax(np.abs(np.round(ways, 9)), axis=1)])
    _, first, which = np.unique(np.round(ways * sign[:, None], 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    total = np.bincount(which.ravel(), weights=sizes)
    return np.asarray(ways[first[np.argsort(-total, kind="stable")]])


def rotation_of(frame: Array) -> Array:
    """Quaternion of a right-handed frame."""
    return np.asarray(quaternion_of(frame))
