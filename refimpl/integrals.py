"""Integrals over solids as sums over their surface (Mirtich 1996; Eberly, Polyhedral Mass Properties (Revisited)).

By the divergence theorem a solid is a sum of signed tetrahedra between the triangles of its surface and the origin. The
same sums are exact on fractions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.hulls import Hull
from refimpl.linear import Array, cross, dot


def surface_integrals(triangles: Any) -> tuple[Any, Any, Any]:
    """Integrals of 1, x and x xᵀ over a solid, from the outward triangles of its surface.

    Parameters
    ----------
    triangles : (..., t, 3, 3)
        Corners, anticlockwise as seen from outside. An object array of fractions gives exact results.

    Returns
    -------
    volume : (...)
    first : (..., 3)
    second : (..., 3, 3)
        About the origin of the coordinates: place it near the solid, or digits cancel.
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    six = dot(a, cross(b, c))  # six times the signed volume of the tetrahedron between triangle and origin
    total = a + b + c
    products = outer(a) + outer(b) + outer(c) + outer(total)
    first = in_order(six[..., None] * total, -2) / 24
    return in_order(six, -1) / 6, first, in_order(six[..., None, None] * products, -3) / 120


def outer(v: Any) -> Any:
    """Products v vᵀ over the last axis."""
    return v[..., :, None] * v[..., None, :]


def in_order(terms: Any, axis: int) -> Any:
    """Sum over an axis, one after the other, so that a row of a batch adds as it would alone."""
    return np.take(np.cumsum(terms, axis=axis), -1, axis=axis)


def surface_of(hull: Hull) -> Array:
    """Outward triangles of a hull: each edge with one fixed corner of the face to its left, and of that to its right.

    Where a batch is filled up with repeated edges, all but one of them become triangles of no size.
    """
    v, w, left, right = (hull.edges[..., i] for i in range(4))
    corner = np.zeros(hull.planes.shape[:-1], dtype=np.int64)
    np.put_along_axis(corner, left, v, axis=-1)
    np.put_along_axis(corner, right, v, axis=-1)
    fans = [
        (np.take_along_axis(corner, left, axis=-1), v, w),
        (np.take_along_axis(corner, right, axis=-1), w, v),
    ]
    repeated = np.zeros(v.shape, dtype=bool)
    repeated[..., 1:] = np.all(hull.edges[..., 1:, :] == hull.edges[..., :-1, :], axis=-1)
    index = np.concatenate([np.where(repeated[..., None], 0, np.stack(fan, axis=-1)) for fan in fans], axis=-2)
    flat = index.reshape((*index.shape[:-2], 3 * index.shape[-2], 1))
    return np.take_along_axis(hull.vertices, flat, axis=-2).reshape((*index.shape, 3))
