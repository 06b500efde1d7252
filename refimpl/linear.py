"""Vectors, rotations and segments in broadcasting numpy.

Every sum over the three coordinates is written out: a reduction (``einsum``, ``matmul``, ``np.sum``) may add
in another order for another batch size, and then one row of a batch would differ from the same pair alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEW = 16
"""So many columns are gone through one by one."""


def dot(u: Array, v: Array) -> Array:
    """Scalar product over the last axis, of three coordinates, or of two in the plane."""
    flat = u[..., 0] * v[..., 0] + u[..., 1] * v[..., 1]
    return np.asarray(flat if u.shape[-1] == 2 else flat + u[..., 2] * v[..., 2])


def cross(u: Array, v: Array) -> Array:
    """Vector product over the last axis."""
    ux, uy, uz = u[..., 0], u[..., 1], u[..., 2]
    vx, vy, vz = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=-1)


def scale(factor: Array, v: Array) -> Array:
    """Each vector times its own factor."""
    return np.asarray(np.asarray(factor)[..., None] * v)


def largest(v: Array) -> Array:
    """Largest absolute coordinate over the last axis.

    Of a few coordinates, column by column: a reduction over a short axis takes ten times as long.
    """
    sizes = np.abs(v)
    if not 0 < sizes.shape[-1] <= FEW:
        return np.asarray(np.max(sizes, axis=-1))
    most = sizes[..., 0]
    for i in range(1, sizes.shape[-1]):
        most = np.maximum(most, sizes[..., i])
    return np.asarray(most)


def norm(v: Array) -> Array:
    """Euclidean length over the last axis; neither overflows nor underflows."""
    size = largest(v)
    u = v / np.where(size > 0, size, 1.0)[..., None]
    return np.asarray(size * np.sqrt(dot(u, u)))


def unit_or(v: Array, fallback: Array) -> tuple[Array, Array]:
    """Direction and length of `v`; the direction is `fallback` where `v` is zero."""
    size = largest(v)
    u = v / np.where(size > 0, size, 1.0)[..., None]
    length = np.sqrt(dot(u, u))
    direction = u / np.where(size > 0, length, 1.0)[..., None]
    return np.where((size > 0)[..., None], direction, fallback), np.asarray(size * length)


def perpendicular(v: Array) -> Array:
    """Some unit vector at right angles to `v`; any unit vector where `v` is zero.

    The axis along which `v` is shortest is crossed with `v`, so nothing cancels (Hughes and Möller 1999). In the plane
    it is the one to the left.
    """
    if v.shape[-1] == 2:
        return unit_or(np.stack([-v[..., 1], v[..., 0]], axis=-1), np.eye(2)[0])[0]
    shortest = np.argmin(np.abs(v), axis=-1)
    axis = np.eye(3)[shortest]
    return unit_or(cross(axis, v), np.eye(3)[(shortest + 1) % 3])[0]


def rotation_matrix(quaternion: Array) -> Array:
    """Rotation matrix of a quaternion (x, y, z, w) of any non-zero length; shape (..., 3, 3).

    The homogeneous form: dividing by |q|² once keeps the matrix exactly rational in the stored numbers.
    """
    q = quaternion / largest(quaternion)[..., None]
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    entries = (
        ((ww + xx) - (yy + zz), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), (ww + yy) - (xx + zz), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), (ww + zz) - (xx + yy)),
    )
    square = (xx + yy) + (zz + ww)
    matrix = np.empty((*square.shape, 3, 3), dtype=q.dtype)
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            np.divide(entry, square, out=matrix[..., i, j])
    return matrix


def apply(matrix: Array, v: Array) -> Array:
    """Matrix times vector, both over their last axes."""
    return (
        scale(v[..., 0], matrix[..., :, 0]) + scale(v[..., 1], matrix[..., :, 1]) + scale(v[..., 2], matrix[..., :, 2])
    )


def apply_inverse(matrix: Array, v: Array) -> Array:
    """Transposed matrix times vector: the inverse of a rotation."""
    return (
        scale(v[..., 0], matrix[..., 0, :]) + scale(v[..., 1], matrix[..., 1, :]) + scale(v[..., 2], matrix[..., 2, :])
    )


def quaternion_product(q: Array, p: Array) -> Array:
    """Hamilton product of quaternions (x, y, z, w): the rotation p first, then q."""
    a, b = q[..., :3], p[..., :3]
    vector = scale(q[..., 3], b) + scale(p[..., 3], a) + cross(a, b)
    return np.concatenate([vector, (q[..., 3] * p[..., 3] - dot(a, b))[..., None]], axis=-1)


def power_of_two(magnitude: Array) -> Array:
    """Exponent e such that ``ldexp(magnitude, -e)`` lies in [0.5, 1); 0 for a magnitude of 0."""
    return np.asarray(np.frexp(magnitude)[1])


def as_floats(value: Any) -> Array:
    """Copy `value` into an array of doubles of its own."""
    array = np.array(value)
    if array.dtype.kind not in "iufO" and array.size:
        raise TypeError(f"expected real numbers, got {array.dtype}")
    return np.array(array, dtype=np.float64) + 0.0  # there is one zero: −0 and 0 are the same number
