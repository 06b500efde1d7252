"""Corners and faces of a polytope, exactly: which corner lies on which face, and both in whole numbers.

A polytope is given by planes or by vertices; qhull (`refimpl.proposals`) or the double description method
(`refimpl.cones`) finds the other. What is redundant is dropped by counting: in d dimensions a corner lies on at least d
faces and a face has at least d corners, and those that do not are none.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from operator import lshift
from typing import Any

import numpy as np

from refimpl.cones import Cone, Whole, product
from refimpl.linear import Array
from refimpl.proposals import Ray, proposed_rays
from refimpl.proxy import ShapeError

AT_INFINITY = -1

Normal = tuple[int, int, int]
Touching = dict[int, set[int]]


@dataclass(frozen=True)
class Faces:
    """A polytope's corners and proper faces of the highest dimension.

    Attributes
    ----------
    corners : whole vectors (X, Y, Z, T), T > 0
        The points (X, Y, Z) / T, in units of 2^exponent.
    planes : whole vectors (N, K)
        The set lies in N·x + K ≤ 0, in the same units. Without a meaning where `dimension` is less than 3.
    incidence : for each face the indices of its corners
    dimension : 3 for a solid, 2, 1, 0 for a polygon, a segment, a point
    normals : whole vectors
        A basis of the directions at right angles to the set: 3 − dimension of them.
    kept_planes, kept_vertices
        Which of the given planes or vertices these are; empty for what was not given.
    """

    corners: list[Whole]
    planes: list[Whole]
    incidence: list[list[int]]
    dimension: int
    normals: list[tuple[int, int, int]]
    exponent: int
    kept_planes: list[int]
    kept_vertices: list[int]


def from_vertices(points: Array) -> Faces:
    """Faces of the hull of points (m, 3); any of them may be equal, collinear or coplanar.

    Coordinates up to 1.
    """
    grid, exponent = on_grid(points)
    rows: list[Whole] = [(x, y, z, 1) for x, y, z in grid]
    near = np.concatenate([points, np.ones((len(points), 1))], axis=1)
    rays = proposed_rays(rows, near, upwards=False)
    if rays is not None:
        return _of_points(rows, _touching(rays), dict(enumerate(ray for ray, _ in rays)), [], exponent)
    cone = Cone()
    for i in _in_good_order(points):
        cone.take_in(i, rows[i])
    return _of_points(rows, cone.touching, cone.rays, [line[:3] for line in cone.lines], exponent)


def _of_points(
    rows: list[Whole], touching: Touching, rays: dict[int, Whole], normals: list[Normal], exponent: int
) -> Faces:
    """Faces from the rays, which are planes, and from the points that each of them touches."""
    dimension = 3 - len(normals)
    if dimension == 0:
        return Faces([rows[0]], [], [], 0, [(1, 0, 0), (0, 1, 0), (0, 0, 1)], exponent, [], [0])
    kept = _essential(touching, dimension)
    names, incidence = _in_order(kept, touching, rays)
    return Faces([rows[i] for i in kept], [rays[r] for r in names], incidence, dimension, normals, exponent, [], kept)


def from_planes(planes: Array) -> Faces:
    """Faces of the set normal·x + k ≤ 0 for every plane (normal, k); shape (f, 4), numbers up to 1.

    Raises
    ------
    ShapeError
        When the set is empty, or unbounded, and then along which direction.
    """
    rows: list[Whole] = [(x, y, z, k) for x, y, z, k in rows_on_grid(planes)]
    proposed = proposed_rays(rows, planes, upwards=True)
    if proposed is not None:
        return _of_rays(rows, _touching(proposed), dict(enumerate(ray for ray, _ in proposed)))
    cone = Cone()
    cone.take_in(AT_INFINITY, (0, 0, 0, -1))
    for i, row in enumerate(rows):
        cone.take_in(i, row)
    if not any(z[3] > 0 for z in cone.rays.values()):
        raise ShapeError("no point lies behind all planes: the set is empty")
    endless = cone.lines + [z for z in cone.rays.values() if z[3] == 0]
    if endless:
        size = max(abs(n) for n in endless[0])
        raise ShapeError(f"the set is unbounded along {tuple(n / size for n in endless[0][:3])}")
    return _of_rays(rows, cone.touching, cone.rays)


def _of_rays(rows: list[Whole], touching: Touching, rays: dict[int, Whole]) -> Faces:
    """Faces from the rays, which are corners, and from those that touch each plane."""
    everywhere = set(rays)
    proper = {i: touching[i] for i in range(len(rows)) if i in touching and touching[i] != everywhere}
    implied = [rows[i][:3] for i in range(len(rows)) if i in touching and touching[i] == everywhere]
    normals = _independent(implied)
    kept = _essential(proper, 3 - len(normals))
    names, meeting = _in_order(kept, touching, rays)
    incidence: list[list[int]] = [[] for _ in kept]
    for corner, faces in enumerate(meeting):
        for face in faces:
            incidence[face].append(corner)
    corners = [rays[r] for r in names]
    return Faces(corners, [rows[i] for i in kept], incidence, 3 - len(normals), normals, 0, kept, [])


def _touching(rays: list[Ray]) -> Touching:
    """For each row the numbers of the rays that lie on it."""
    found: Touching = {}
    for number, (_, names) in enumerate(rays):
        for name in names:
            found.setdefault(name, set()).add(number)
    return found


def _in_order(kept: list[int], touching: Touching, rays: Iterable[int]) -> tuple[list[int], list[list[int]]]:
    """Rays and the places in `kept` of what they touch, sorted by these: the same, whichever method has found them."""
    lists: dict[int, list[int]] = {ray: [] for ray in rays}
    for place, name in enumerate(kept):
        for ray in touching[name]:
            lists[ray].append(place)
    names = sorted(lists, key=lambda ray: lists[ray])
    return names, [lists[name] for name in names]


def on_grid(numbers: Array) -> tuple[list[list[int]], int]:
    """Whole numbers and the exponent e such that the doubles (n, w) are whole · 2^e."""
    mantissa, exponent = np.frexp(numbers)
    present = mantissa != 0
    least = int(np.min(exponent[present])) if np.any(present) else 0
    return _shifted_left(mantissa, np.where(present, exponent - least, 0)), least - 53


def rows_on_grid(numbers: Array) -> list[list[int]]:
    """Whole numbers in the ratios of each row of doubles (n, w)."""
    mantissa, exponent = np.frexp(numbers)
    present = mantissa != 0
    least = np.min(np.where(present, exponent, np.iinfo(np.int32).max), axis=1)
    return _shifted_left(mantissa, np.where(present, exponent - least[:, None], 0))


def _shifted_left(mantissa: Array, shifts: Any) -> list[list[int]]:
    whole, width = np.ldexp(mantissa, 53).astype(np.int64), mantissa.shape[1]
    flat = list(map(lshift, whole.ravel().tolist(), shifts.ravel().tolist()))
    return [flat[start : start + width] for start in range(0, len(flat), width)]


def _in_good_order(points: Array) -> list[int]:
    """Outermost points first, for what lies within their hull is soon done; then as by chance, but always the same."""
    ways = _ways()
    first = []
    if len(points) > len(ways):
        first = [int(np.argmax(points[:, 0] * x + points[:, 1] * y + points[:, 2] * z)) for x, y, z in ways]
    return list(dict.fromkeys(first + _shuffled(len(points))))


@lru_cache(maxsize=1)
def _ways() -> list[list[float]]:
    found: list[list[float]] = np.random.default_rng(0).normal(size=(26, 3)).tolist()
    return found


@lru_cache(maxsize=64)
def _shuffled(count: int) -> list[int]:
    found: list[int] = np.random.default_rng(1).permutation(count).tolist()
    return found


def _essential(touching: dict[int, set[int]], dimension: int) -> list[int]:
    """Names with at least `dimension` neighbours of the other kind, one of those with the same."""
    found: dict[frozenset[int], int] = {}
    for name in sorted(touching):
        if len(touching[name]) >= dimension and name != AT_INFINITY:
            found.setdefault(frozenset(touching[name]), name)
    return list(found.values())


def _independent(vectors: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """As many of the vectors as are linearly independent, the first ones."""
    basis: list[tuple[int, int, int]] = []
    for v in vectors:
        if len(basis) == 0 or (len(basis) == 1 and any(whole_cross(basis[0], v))):
            basis.append(v)
        elif len(basis) == 2 and product((*whole_cross(*basis), 0), (*v, 0)) != 0:
            return [*basis, v]
    return basis


def whole_cross(u: Any, v: Any) -> tuple[int, int, int]:
    """Vector product of whole vectors, exactly."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def edges_of(faces: Faces) -> list[tuple[int, int, int, int]]:
    """Edges of a solid: two corners, and the faces to the left and to the right when walking from one to the other.

    Two faces that share two corners share the edge between them.
    """
    around: list[list[int]] = [[] for _ in faces.corners]
    for face, corners in enumerate(faces.incidence):
        for corner in corners:
            around[corner].append(face)
    shared: dict[tuple[int, int], int] = {}
    edges = []
    for corner, meeting in enumerate(around):
        for i, left in enumerate(meeting):
            for right in meeting[i + 1 :]:
                other = shared.setdefault((left, right), corner)
                if other != corner:
                    edges.append(_directed(faces, other, corner, left, right))
    return edges


def _directed(faces: Faces, v: int, w: int, left: int, right: int) -> tuple[int, int, int, int]:
    """Walk so that the first face lies to the left: outward normals turn about the edge's direction, left to right."""
    way = whole_cross(faces.planes[left][:3], faces.planes[right][:3])
    start, end = faces.corners[v], faces.corners[w]
    step = product((*way, 0), end) * start[3] - product((*way, 0), start) * end[3]
    return (v, w, left, right) if step > 0 else (w, v, left, right)
