"""View frusta: what a camera can show, as a convex polyhedron of six planes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import Array, as_floats, cross, dot, unit_or
from refimpl.shapes import ConvexPolyhedron, ShapeError

PLANES = ("near", "far", "left", "right", "bottom", "top")
"""In this order, of every frustum that is made here."""


def perspective(
    eye: ArrayLike,
    target: ArrayLike,
    up: ArrayLike = (0.0, 0.0, 1.0),
    *,
    angle: float = np.pi / 3,
    aspect: float = 4 / 3,
    near: float = 0.1,
    far: float = 1000.0,
) -> ConvexPolyhedron:
    """Frustum of a camera.

    Parameters
    ----------
    eye, target : (3,)
        Where the camera is, and a point in the middle of its picture.
    up : (3,)
        Any direction that is upwards in the picture, and not along the view.
    angle : float, radians
        Between the lower and the upper plane, below π.
    aspect : float
        Width of the picture by its height.
    near, far : float, length
        Distances of the planes across the view; 0 < near < far.

    Raises
    ------
    ShapeError
        Names what is none of that.

    Notes
    -----
    The planes as they are rounded are the frustum: Akenine-Möller, Haines & Hoffman, Real-Time Rendering, 22.14.
    """
    camera, middle, upwards = (as_floats(x) for x in (eye, target, up))
    for name, value in (("eye", camera), ("target", middle), ("up", upwards)):
        if value.shape != (3,) or not np.all(np.isfinite(value)):
            raise ShapeError(f"perspective: {name} must be three finite numbers, got {value.tolist()}")
    if not 0 < angle < np.pi:
        raise ShapeError(f"perspective: angle must be between 0 and π, got {angle}")
    if not 0 < aspect < np.inf:
        raise ShapeError(f"perspective: aspect must be above 0, got {aspect}")
    if not 0 < near < far < np.inf:
        raise ShapeError(f"perspective: expected 0 < near < far, got {near} and {far}")
    none = np.zeros(3)
    with np.errstate(over="ignore"):
        view = middle - camera
    if not np.all(np.isfinite(view)):
        raise ShapeError("perspective: eye and target are too far apart for a difference")
    ahead, way = unit_or(view, none)
    aside, lean = unit_or(cross(ahead, unit_or(upwards, none)[0]), none)
    if way == 0 or lean == 0:
        raise ShapeError("perspective: target must not be at the eye, and up not along the view")
    above = cross(aside, ahead)
    high = np.tan(angle / 2)
    wide = high * aspect
    normals = (-ahead, ahead, -aside - wide * ahead, aside - wide * ahead, -above - high * ahead, above - high * ahead)
    offsets = (near, -far, 0.0, 0.0, 0.0, 0.0)
    planes = [(*n, k - dot(n, camera)) for n, k in zip(normals, offsets, strict=True)]
    return ConvexPolyhedron(np.array(planes))


def frustum_of_matrix(matrix: ArrayLike, *, nearest: float = -1.0) -> ConvexPolyhedron:
    """Frustum of a view-projection matrix, which takes (x, y, z, 1) to clip space.

    Parameters
    ----------
    matrix : (4, 4)
        It acts on columns: clip = matrix @ (x, y, z, 1).
    nearest : float
        What clip space has as z/w at the near plane: −1 as in OpenGL, or 0 as in Direct3D and Vulkan.

    Raises
    ------
    ShapeError
        For anything that is no such matrix, as one without a far plane.

    Notes
    -----
    A point is shown where −w ≤ x ≤ w, and so on: each is a plane, whose coefficients are sums of rows of the matrix.
    Gribb & Hartmann, Fast Extraction of Viewing Frustum Planes, 2001.
    """
    rows = as_floats(matrix)
    if rows.shape != (4, 4) or not np.all(np.isfinite(rows)):
        raise ShapeError(f"frustum_of_matrix: expected 4 × 4 finite numbers, got shape {rows.shape}")
    x, y, z, w = rows
    if nearest not in (-1, 0):
        raise ShapeError(f"frustum_of_matrix: nearest must be -1 or 0, got {nearest}")
    planes: Array = np.stack([nearest * w - z, z - w, -w - x, x - w, -w - y, y - w])
    for name, plane in zip(PLANES, planes, strict=True):
        if not np.any(plane[:3]):
            raise ShapeError(
                f"frustum_of_matrix: the {name} plane is at infinity or nowhere; a frustum is bounded, so that the "
                "projection needs finite planes"
            )
    return ConvexPolyhedron(planes)
