"""Extreme rays of a cone in general position: qhull proposes them in doubles, and they are proven or dropped.

A proposal is three rows. It is right when all other rows are clearly negative on the ray that the three meet in, and
all is found when the rays close: each two rows that meet at one ray meet at exactly one other. Where doubles leave a
sign in doubt, nothing is proposed, and the double description method (`refimpl.cones`) decides exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.cones import Whole, primitive
from refimpl.linear import Array, cross, dot

FEWEST = 9
"""Rows below which the exact method is as quick."""

DOUBT = 2e-13
"""More than rounding does to a 4 × 4 determinant of numbers up to 1: some 400 units in the last place of 1."""

ROOM = 1e-6
"""Least depth of an interior point; thinner sets are left to the exact method."""

Ray = tuple[Whole, tuple[int, int, int]]


def proposed_rays(rows: list[Whole], near: Array, *, upwards: bool) -> list[Ray] | None:
    """All extreme rays of {z : a·z ≤ 0 for every row a}, each with the three rows that it lies on.

    Parameters
    ----------
    rows : whole vectors
    near : (f, 4)
        The same rows, each times some power of two, in doubles up to 1.
    upwards
        The rows are planes, and z_3 ≥ 0 is one more row; else they are points (v, 1).

    Returns
    -------
    list of rays and triples, or None
        None where rays lie on more than three rows, signs are in doubt, or the set is thin, flat, empty or unbounded.
    """
    if len(rows) < FEWEST:
        return None
    points = _dual_points(near) if upwards else near[:, :3]
    triples = None if points is None else _faces_by_qhull(points)
    signs = None if triples is None else _proven(near, triples, upwards)
    if triples is None or signs is None or not _closed(triples, signs, len(rows)):
        return None
    return [
        (_exact_product([rows[i] for i in triple], sign), (triple[0], triple[1], triple[2]))
        for triple, sign in zip(triples.tolist(), signs.tolist(), strict=True)
    ]


def _dual_points(planes: Array) -> Array | None:
    """Points normal / depth, whose hull has a face for each corner of the planes: depths from an interior point."""
    length = np.sqrt(dot(planes, planes))
    normals, offsets = planes[:, :3] / length[:, None], planes[:, 3] / length
    center, best, step = np.zeros(3), np.zeros(3), 0.5
    deepest = -np.inf
    for _ in range(40):  # away from the nearest plane, by ever smaller steps (Agmon 1954; Motzkin and Schoenberg 1954)
        depths = -(dot(normals, center) + offsets)
        nearest = int(np.argmin(depths))
        if depths[nearest] > deepest:
            best, deepest = center, depths[nearest]
        center = center - (step + max(-depths[nearest], 0.0)) * normals[nearest]
        step *= 0.8
    if not deepest > ROOM:
        return None
    return normals / -(dot(normals, best) + offsets)[:, None]


def _faces_by_qhull(points: Array) -> Any:
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  a fifth of a second that only polytopes need

    try:
        return np.sort(ConvexHull(points).simplices.astype(np.int64), axis=1)
    except QhullError:
        return None


def _proven(rows: Array, triples: Any, upwards: bool) -> Any:
    """Sign by which each triple's vector product in four dimensions is an extreme ray; None where one is in doubt."""
    a, b, c = (rows[triples[:, i]] for i in range(3))
    ab, bc, ac = (cross(u[:, :3], v[:, :3]) for u, v in ((a, b), (b, c), (a, c)))
    z = b[:, 3:] * ac - a[:, 3:] * bc - c[:, 3:] * ab
    last = dot(a, bc)
    values = z @ rows[:, :3].T + last[:, None] * rows[:, 3]
    up = np.max(values, axis=1) <= DOUBT
    down = np.min(values, axis=1) >= -DOUBT
    close = np.count_nonzero(np.abs(values) <= DOUBT, axis=1)
    sure = (up ^ down) & (close == 3)
    if upwards:
        sure &= np.where(up, last, -last) > DOUBT
    return np.where(up, 1, -1) if np.all(sure) else None


def _closed(triples: Any, signs: Any, count: int) -> bool:
    """Whether each pair of rows that meets at a ray meets at exactly two, in opposite senses."""
    a, b, c = triples.T
    keys = np.concatenate([a * count + b, b * count + c, a * count + c])
    senses = np.concatenate([signs, signs, -signs])
    order = np.argsort(keys, kind="stable")
    keys, senses = keys[order], senses[order]
    if (
        len(triples) < 4
        or len(keys) % 2
        or not np.array_equal(keys[::2], keys[1::2])
        or np.any(keys[2::2] == keys[1:-1:2])
    ):
        return False
    return bool(np.all(senses[::2] + senses[1::2] == 0))


def _exact_product(rows: list[Whole], sign: int) -> Whole:
    """Vector product of three whole rows in four dimensions, times a sign, in smallest numbers."""
    (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3) = rows
    bc0, bc1, bc2 = b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0
    ac0, ac1, ac2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
    ab0, ab1, ab2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    return primitive(
        (
            sign * (b3 * ac0 - a3 * bc0 - c3 * ab0),
            sign * (b3 * ac1 - a3 * bc1 - c3 * ab1),
            sign * (b3 * ac2 - a3 * bc2 - c3 * ab2),
            sign * (a0 * bc0 + a1 * bc1 + a2 * bc2),
        )
    )
