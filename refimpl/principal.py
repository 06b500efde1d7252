"""Principal axes of an ellipsoid, and the quaternion of a frame."""

from __future__ import annotations

import numpy as np

from refimpl.linear import Array, cross, dot, perpendicular, scale, unit_or

SWEEPS = 12  # quadratic convergence: six suffice in practice, and a further sweep changes nothing


def principal_axes(matrix: Array) -> tuple[Array, Array]:
    """Axes and radii of the image of the unit ball under a regular matrix.

    One-sided Jacobi rotations: the columns are turned against each other, two at a time, until they are at right
    angles. Where the columns of a well-conditioned matrix were scaled, as radii scale them, even the smallest radius
    is good to rounding (Demmel and Veselić, Jacobi's Method is More Accurate than QR, 1992).

    Parameters
    ----------
    matrix : (..., 3, 3)
        Maps the unit ball to the ellipsoid about the origin.

    Returns
    -------
    axes : (..., 3, 3)
        A right-handed frame; the columns are the principal axes. Not unique where radii are equal.
    radii : (..., 3)
    """
    columns = [matrix[..., :, i] for i in range(3)]
    for _ in range(SWEEPS):
        for i, j in ((0, 1), (0, 2), (1, 2)):
            columns[i], columns[j] = _at_right_angles(columns[i], columns[j])
    lengths = np.stack([np.sqrt(dot(c, c)) for c in columns], axis=-1)
    order = np.argsort(-lengths, axis=-1, kind="stable")
    stacked = np.take_along_axis(np.stack(columns, axis=-1), order[..., None, :], axis=-1)
    first = unit_or(stacked[..., :, 0], np.eye(3)[0])[0]
    beside = stacked[..., :, 1] - scale(dot(first, stacked[..., :, 1]), first)
    second = unit_or(beside, perpendicular(first))[0]
    axes = np.stack([first, second, cross(first, second)], axis=-1)
    return axes, np.take_along_axis(lengths, order, axis=-1)


def _at_right_angles(u: Array, v: Array) -> tuple[Array, Array]:
    """Turn two columns in their common plane of combinations until they are at right angles."""
    mixed = dot(u, v)
    zeta = (dot(v, v) - dot(u, u)) / np.where(mixed == 0, 1.0, 2 * mixed)
    huge = np.abs(zeta) > 1e150
    safe = np.where(huge, 1.0, zeta)
    tangent = np.where(huge, 0.0, np.where(zeta < 0, -1.0, 1.0) / (np.abs(safe) + np.sqrt(1 + safe * safe)))
    tangent = np.where(mixed == 0, 0.0, tangent)
    cosine = 1 / np.sqrt(1 + tangent * tangent)
    sine = cosine * tangent
    return scale(cosine, u) - scale(sine, v), scale(sine, u) + scale(cosine, v)


def quaternion_of(axes: Array) -> Array:
    """Quaternion (x, y, z, w) of a right-handed orthonormal frame, given by its columns; shape (..., 4).

    Of the four equivalent formulas, the one whose divisor is largest (Shepperd, Quaternion from Rotation Matrix, 1978).
    """
    m = [[axes[..., i, j] for j in range(3)] for i in range(3)]
    trace = m[0][0] + m[1][1] + m[2][2]
    choices = [
        [1 + 2 * m[0][0] - trace, m[0][1] + m[1][0], m[0][2] + m[2][0], m[2][1] - m[1][2]],
        [m[0][1] + m[1][0], 1 + 2 * m[1][1] - trace, m[1][2] + m[2][1], m[0][2] - m[2][0]],
        [m[0][2] + m[2][0], m[1][2] + m[2][1], 1 + 2 * m[2][2] - trace, m[1][0] - m[0][1]],
        [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1], 1 + trace],
    ]
    table = np.stack([np.stack(row, axis=-1) for row in choices], axis=-2)
    best = np.argmax(np.stack([choices[i][i] for i in range(4)], axis=-1), axis=-1)
    picked = np.take_along_axis(table, best[..., None, None], axis=-2)[..., 0, :]
    return np.asarray(picked)
