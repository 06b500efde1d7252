"""Turned boxes: along the principal axes, and of least volume among those that touch edges of the hull.

Ericson, Real-Time Collision Detection, 4.4. A box of least volume has two adjacent faces that each contain an edge of
the hull (O'Rourke, Finding Minimal Enclosing Boxes, 1985). For two edges these are the boxes whose first normal is at
right angles to one, and the second to the other and to the first: a family of one parameter, that is searched.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.cloud import Cloud
from refimpl.construct.extreme import (
    centred,
    different_ways,
    dimension,
    few_corners,
    principal_frame,
    rotation_of,
    solid_hull,
)
from refimpl.construct.formulas import columns_of, inner
from refimpl.construct.outwards import least_above, nearest
from refimpl.construct.sources import points_of
from refimpl.linear import Array
from refimpl.shapes import Box

MOST_EDGES = 64  # of which all pairs are searched; more are thinned out evenly over their directions
STEPS = 24  # into which a family is divided before its best places are refined
THIN = 1e-9  # a box of flat points may be so thick, in units of its length
REFINED = 32  # so many of the best


def box(points: ArrayLike) -> Box:
    """Box along the principal axes of points (n, 3), each of its six sides as near as doubles allow.

    Flat points give a flat box, of half extents 0.

    Raises
    ------
    ConstructionError
        See `points_of`; and for a box beyond the largest double.
    """
    cloud = Cloud(points_of(points))
    return around(cloud, rotation_of(principal_frame(centred(cloud)[0])))


def least_box(points: ArrayLike) -> Box:
    """Box of the least volume found over pairs of the hull's edges, refined; for flat points, of the least area.

    Of a hull with more than 512 corners so many of them, and of one with edges in more than 64 directions the longest
    of these are searched, so that a smaller box may exist.

    Raises
    ------
    ConstructionError
        See `points_of`; and for a box beyond the largest double.
    """
    cloud = Cloud(points_of(points))
    inside = centred(cloud)[0]
    corners = few_corners(inside)
    count, frame = dimension(inside)
    candidates = [frame, np.eye(3)]
    if count == 3:
        candidates += _along_edges(corners)
    elif count == 2:
        candidates += _in_plane(corners, frame)
    found = [around(cloud, rotation_of(c)) for c in _smallest(corners, np.stack(candidates), count)]
    return min(found, key=lambda b: float(np.prod(b.half_extents / np.max(b.half_extents, initial=1e-300))))


def around(cloud: Cloud, rotation: Array) -> Box:
    """Smallest box of a given rotation around a cloud, its centre rounded and the extents then the least."""
    columns, size = columns_of(rotation)
    low, high = zip(*(cloud.extent(way) for way in columns), strict=True)
    middle = [(a + b) / (2 * size) for a, b in zip(low, high, strict=True)]
    center = [
        sum((m * column[i] for m, column in zip(middle, columns, strict=True)), Fraction(0)) / size for i in range(3)
    ]
    place = nearest(center, cloud, "centre")
    exact = [cloud.inwards(v) for v in place.tolist()]
    extents = []
    for way, a, b in zip(columns, low, high, strict=True):
        at = inner(way, exact)
        extents.append(least_above(max(b - at, at - a) / size, cloud, "box"))
    return Box(place, extents, rotation)


def extents_of(corners: Array, frames: Array) -> Array:
    """Extents (k, 3) of points along the columns of frames (k, 3, 3)."""
    heights = corners @ frames.transpose(1, 0, 2).reshape(3, -1)
    return np.asarray(heights.max(axis=0) - heights.min(axis=0)).reshape(-1, 3)


def _volumes(corners: Array, frames: Array) -> Array:
    parts = [np.prod(extents_of(corners, frames[i : i + 256]), axis=1) for i in range(0, len(frames), 256)]
    return np.concatenate(parts)


def _smallest(corners: Array, frames: Array, count: int) -> list[Array]:
    """Two of the candidates that are best by volume, of flat points by area, of collinear ones by length."""
    extents = np.sort(extents_of(corners, frames), axis=1)[:, ::-1]
    size = np.prod(extents[:, : max(count, 1)], axis=1)
    if count < 3:
        size = np.where(extents[:, max(count, 1)] <= THIN * extents[:, 0], size, np.inf)
    return [frames[i] for i in np.argsort(size, kind="stable")[:2]]


def _in_plane(corners: Array, frame: Array) -> list[Array]:
    """Frames with an axis along an edge of a polygon, whose corners come in order (Freeman and Shapira 1975)."""
    edges = np.roll(corners, 1, axis=0) - corners
    return [f for f in (_frame(frame[:, 2], edge) for edge in edges) if f is not None]


def _frame(normal: Array, way: Array) -> Array | None:
    """Right-handed frame with a normal and a direction near `way`; None where they are parallel."""
    beside = np.cross(normal, way)
    length = float(np.linalg.norm(beside))
    if length <= 1e-14 * float(np.linalg.norm(way)):
        return None
    beside /= length
    return np.stack([np.cross(beside, normal), beside, normal], axis=1)


def _along_edges(corners: Array) -> list[Array]:
    """The best frames of all families of pairs of edges."""
    ways = _edge_directions(corners)
    if not len(ways):
        return []
    first, second = np.triu_indices(len(ways), k=0)
    angles = np.arange(STEPS) * (np.pi / STEPS)
    frames = np.concatenate([_family(ways[first], ways[second], t) for t in angles])
    pair, angle = np.tile(np.arange(len(first)), STEPS), np.repeat(angles, len(first))
    volumes = _volumes(corners, frames)
    best = np.argsort(volumes, kind="stable")[:REFINED]
    width = np.pi / STEPS
    low, high = angle[best] - width, angle[best] + width
    one, other = ways[first[pair[best]]], ways[second[pair[best]]]
    for _ in range(40):  # golden section, all at once
        a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        left = _volumes(corners, _family(one, other, a)) < _volumes(corners, _family(one, other, b))
        low, high = np.where(left, low, a), np.where(left, b, high)
    refined = _family(one, other, (low + high) / 2)
    return [*frames[best], *refined]


GOLDEN = (np.sqrt(5) - 1) / 2


def _family(one: Array, other: Array, angle: Any) -> Array:
    """Frames (k, 3, 3) with a normal at right angles to edges `one`, the next at right angles to it and to `other`."""
    least = np.eye(3)[np.argmin(np.abs(one), axis=1)]
    u = np.cross(one, least)
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(one, u)
    t = np.broadcast_to(angle, (len(one),))[:, None]
    normal = np.cos(t) * u + np.sin(t) * v
    second = np.cross(other, normal)
    length = np.linalg.norm(second, axis=1)[:, None]
    second = np.where(length > 1e-9, second / np.where(length > 1e-9, length, 1.0), -np.sin(t) * u + np.cos(t) * v)
    return np.stack([normal, second, np.cross(normal, second)], axis=2)


def _edge_directions(corners: Array) -> Array:
    """Directions of the hull's edges, one of each pair of parallel ones, at most `MOST_EDGES`."""
    hull = solid_hull(corners)
    if hull is None:
        return np.zeros((0, 3))
    triangles = hull.simplices
    normals = hull.equations[:, :3]
    found = []
    for i in range(3):  # edge opposite to corner i, towards neighbour i; flat ones are no edges
        keep = np.sum(normals * normals[hull.neighbors[:, i]], axis=1) < 1 - 1e-12
        ends = corners[triangles[keep][:, [(i + 1) % 3, (i + 2) % 3]]]
        found.append(ends[:, 1] - ends[:, 0])
    ways = np.concatenate(found)
    lengths = np.linalg.norm(ways, axis=1)
    return different_ways(ways / lengths[:, None], lengths)[:MOST_EDGES]
