"""Faces of polytopes and meshes, few enough to be drawn."""

from __future__ import annotations

import math

import numpy as np

from refimpl.hulls import Hull
from refimpl.linear import Array
from refimpl.meshes import Triangles

Face = tuple[int, ...]

FINEST = 16
"""Cells along the longest side of a mesh in which vertices become one."""


def polygons(hull: Hull) -> tuple[Array, tuple[Face, ...]]:
    """Corners, and the rings of corners around each face; a segment is a face of two corners, a point one of one."""
    following: dict[int, dict[int, int]] = {}
    for start, end, left, right in hull.edges.tolist():
        if start != end:
            following.setdefault(left, {})[start] = end
            following.setdefault(right, {})[end] = start
    faces = {ring for way in following.values() if len(ring := _ring(way)) > 2 and _spreads(hull.vertices[list(ring)])}
    if not faces:
        return hull.vertices, (tuple(range(len(hull.vertices))),)
    return hull.vertices, tuple(sorted(faces))


def _ring(following: dict[int, int]) -> Face:
    """Follow the edges around a face, from its lowest corner."""
    start = at = min(following)
    ring = [start]
    while (at := following.get(at, start)) != start and len(ring) <= len(following):
        ring.append(at)
    return tuple(ring)


def _spreads(corners: Array) -> bool:
    """Whether a face has more than one place: sides of flat sets have no area, but may have a length."""
    return bool(np.any(corners != corners[0]))


def few_corners(vertices: Array, most: int) -> tuple[Array, int] | None:
    """Corners that are farthest in directions all around, and how many there were; None where there are few."""
    if len(vertices) <= most:
        return None
    middle = vertices.min(axis=0) / 2 + vertices.max(axis=0) / 2
    spread = np.ptp(vertices, axis=0)
    even = (vertices - middle) / np.where(spread > 0, spread, 1.0)
    chosen = np.unique(np.argmax(even @ directions(2 * most).T, axis=0))
    return vertices[chosen[:: math.ceil(len(chosen) / most)]], len(vertices)


def directions(count: int) -> Array:
    """Unit vectors spread evenly by the golden angle (count, 3)."""
    steps = np.arange(count) + 0.5
    z = 1 - 2 * steps / count
    turn = math.pi * (3 - math.sqrt(5)) * steps
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1)


def few_triangles(vertices: Array, triangles: Triangles, most: int) -> tuple[Array, tuple[Face, ...]]:
    """The triangles, or those that remain when the vertices within each cell of a grid become one."""
    if len(triangles) <= most:
        return vertices, tuple(map(tuple, triangles.tolist()))
    for cells in range(FINEST, 1, -1):
        merged = _merged(vertices, triangles, cells)
        if len(merged[1]) <= most:
            break
    return merged


def _merged(vertices: Array, triangles: Triangles, cells: int) -> tuple[Array, tuple[Face, ...]]:
    """Mean vertex of each cell, and the triangles between different ones."""
    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    cell = np.minimum((vertices - low) / size * cells, cells - 1).astype(np.int64)
    _, which = np.unique(cell, axis=0, return_inverse=True)
    which = which.reshape(-1)
    counts = np.bincount(which)
    means = np.stack([np.bincount(which, vertices[:, axis] / size) / counts * size for axis in range(3)], axis=-1)
    found: dict[Face, None] = {}
    for a, b, c in which[triangles].tolist():
        if len({a, b, c}) == 3:
            found[min((a, b, c), (b, c, a), (c, a, b))] = None
    return means, tuple(found)
