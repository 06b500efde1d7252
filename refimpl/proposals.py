"""Extreme rays of a cone: qhull proposes them in doubles, and they are proven or dropped.

A proposal is three rows. It is right when no other row is positive on the ray that the three meet in: most are clearly
negative, and where doubles leave a sign in doubt, whole numbers tell it. More than three rows may meet in one ray,
which then is proposed several times: the triples are triangles of one face. All is found when the triangles close:
each two rows that are side by side in one are so in exactly one other, the other way round. For then the triangles of
a face, all of one sense, can only end where those of other faces begin, at the face's own edges; so they fill it, and
each face beside it is found as well. Where this fails, the double description method (`refimpl.cones`) decides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.cones import Whole, primitive, product
from refimpl.linear import Array, cross, dot

FEWEST = 9
"""Rows below which the exact method is as quick."""

DOUBT = 2e-13
"""More than rounding does to a 4 × 4 determinant of numbers up to 1: some 400 units in the last place of 1."""

ROOM = 1e-6
"""Least depth of an interior point; thinner sets are left to the exact method."""
PLENTY = 0.05
"""Depth from which on an interior point is not looked for any further."""

Ray = tuple[Whole, list[int]]


def proposed_rays(rows: list[Whole], near: Array, *, upwards: bool) -> list[Ray] | None:
    """All extreme rays of {z : a·z ≤ 0 for every row a}, each with the rows that it lies on.

    Parameters
    ----------
    rows : whole vectors
    near : (f, 4)
        The same rows, each times some power of two, in doubles up to 1.
    upwards
        The rows are planes, and z_3 ≥ 0 is one more row; else they are points (v, 1).

    Returns
    -------
    list of rays and rows, or None
        None where there are too few rows to be worth it, where the set is thin, flat, empty or unbounded, or nothing
        is proven.
    """
    if len(rows) < FEWEST:
        return None
    points = _dual_points(near) if upwards else near[:, :3]
    triples = None if points is None else _faces_by_qhull(points)
    known = None if triples is None else _signs(near, triples, upwards)
    if triples is None or known is None or not _closed(triples, known[0], len(rows)):
        return None
    signs, close = known
    found: dict[Whole, list[int]] = {}
    several = (np.count_nonzero(close, axis=1) > 3).tolist()
    for number, (triple, sign) in enumerate(zip(triples.tolist(), signs.tolist(), strict=True)):
        ray = _exact_product([rows[i] for i in triple], sign)
        if not several[number]:
            found[ray] = triple
        elif ray not in found:
            values = {i: product(rows[i], ray) for i in np.flatnonzero(close[number]).tolist()}
            if max(values.values()) > 0:
                return None
            found[ray] = [i for i, value in values.items() if value == 0]
    return list(found.items())


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
        if deepest > PLENTY:
            break
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


def _signs(rows: Array, triples: Any, upwards: bool) -> tuple[Any, Any] | None:
    """Sign by which each triple's vector product in four dimensions may be an extreme ray, and the rows in doubt.

    None where some are positive on a ray and others negative, or one may be 0 on all: then the set is flat.
    """
    a, b, c = (rows[triples[:, i]] for i in range(3))
    ab, bc, ac = (cross(u[:, :3], v[:, :3]) for u, v in ((a, b), (b, c), (a, c)))
    z = b[:, 3:] * ac - a[:, 3:] * bc - c[:, 3:] * ab
    last = dot(a, bc)
    values = z @ rows[:, :3].T + last[:, None] * rows[:, 3]
    up = np.max(values, axis=1) <= DOUBT
    down = np.min(values, axis=1) >= -DOUBT
    close = np.abs(values) <= DOUBT
    sure = up ^ down
    if upwards:
        sure &= np.where(up, last, -last) > DOUBT
    return None if np.any(np.all(close, axis=0)) or not np.all(sure) else (np.where(up, 1, -1), close)


def _closed(triples: Any, signs: Any, count: int) -> bool:
    """Whether each pair of rows that is side of a triangle is so of exactly two, in opposite senses."""
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
