"""Points and triangle surfaces: nearest points, and whether a point is inside."""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.nearest import nearest_on_segment
from refimpl.boxtree import BoxTree, near_pairs
from refimpl.linear import Array, cross, dot, norm, scale, unit_or
from refimpl.meshes import winding_number
from refimpl.solids import Solid

STILL = np.eye(3)
BATCH = 32  # triangles that are looked at together


def nearest_on_triangles(p: Array, corners: Array) -> Array:
    """Points of triangles nearest to `p`.

    The foot on the plane is found in a frame along the longest side, so that it errs, where a triangle is thin, only
    by what costs nothing in distance; outside of the triangle one of the sides is nearest. Ericson, Real-Time
    Collision Detection, 5.1.5, tells the same by regions.

    Parameters
    ----------
    p : (n, 3)
    corners : (n, 3, 3)
    """
    sides = np.stack([corners[:, (i + 1) % 3] - corners[:, i] for i in range(3)], axis=1)
    first = np.argmax(norm(sides), axis=1)
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (first + i) % 3] for i in range(3))
    along, length = unit_or(b - a, STILL[0])
    rise = c - a
    for _ in range(2):  # the second time takes away what rounding left of the first
        rise = rise - scale(dot(rise, along), along)
    up, height = unit_or(rise, STILL[1])
    x, y, apex = dot(p - a, along), dot(p - a, up), dot(c - a, along)
    share = y / np.where(height > 0, height, 1.0)
    inside = (y >= 0) & (x >= apex * share) & (length - x >= (length - apex) * share) & (y <= height) & (height > 0)
    best = a + scale(x, along) + scale(y, up)
    least = np.where(inside, norm(p - best), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        foot = nearest_on_segment(p, u, v)
        gap = norm(p - foot)
        nearer = gap < least
        best, least = np.where(nearer[:, None], foot, best), np.where(nearer, gap, least)
    return np.asarray(best)


def point_surface(solid: Solid, p: Array) -> tuple[float, Array, Array]:
    """Signed distance of a point from a solid, the nearest point of its surface, and the unit normal there.

    Inside, the nearest point of the surface is where the shortest way out ends, so this is exact on both sides. Where
    the point is on the surface, the normal is its face's.

    Parameters
    ----------
    solid : Solid
    p : (3,)
        In the solid's frame.
    """
    faces, _, bounds = near_pairs(solid.surface, BoxTree(p[None], p[None]), STILL, np.zeros(3), np.inf)
    gap, foot, face, start = np.inf, p, 0, 0
    while start < len(faces) and bounds[start] <= gap:
        some = faces[start : start + BATCH]
        feet = nearest_on_triangles(np.broadcast_to(p, (len(some), 3)), solid.corners[some])
        gaps = norm(p - feet)
        i = int(np.argmin(gaps))
        if gaps[i] < gap:
            gap, foot, face = float(gaps[i]), feet[i], int(some[i])
        start += BATCH
    outward = _outward(solid.corners[face])
    if gap == 0:
        return 0.0, foot, outward
    inside = winding_number(solid.corners, p, solid.face_bounds) > 0
    away, _ = unit_or((foot - p) if inside else (p - foot), outward)
    if abs(float(dot(away, outward))) > 1 - 1e-8:  # over a face: its own normal has fewer roundings
        away = outward
    return (-gap if inside else gap), foot, away


def _outward(corners: Array) -> Array:
    return unit_or(cross(corners[1] - corners[0], corners[2] - corners[0]), STILL[2])[0]
