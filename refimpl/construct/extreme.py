"""The points that matter for a bounding volume's shape: those on the hull, as far as doubles tell.

They only steer a search. What it proposes is enlarged until it contains all points, so nothing here has to be exact.
"""

from __future__ import annotations

import numpy as np

from refimpl.construct.cloud import Cloud
from refimpl.linear import Array
from refimpl.principal import principal_axes, quaternion_of

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
    scaled = scaled - scaled.mean(axis=0)
    spread = scaled.T @ scaled / len(points)
    values, axes = np.linalg.eigh(spread)
    return np.asarray(principal_axes(axes[:, ::-1] * np.sqrt(np.maximum(values[::-1], 1e-300)))[0])


def dimension(points: Array) -> tuple[int, Array]:
    """How many dimensions points about the origin spread in, as doubles tell, and their principal frame."""
    frame = principal_frame(points)
    extents = np.ptp(points @ frame, axis=0)
    least = FLAT * float(np.max(np.abs(points), initial=0.0))
    return int(np.sum(extents > least)), frame


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


def rotation_of(frame: Array) -> Array:
    """Quaternion of a right-handed frame."""
    return np.asarray(quaternion_of(frame))
