"""Corners and faces of a polytope, exactly: which corner lies on which face, and both in whole numbers.

A polytope is given by planes or by vertices; the double description method (`refimpl.cones`) finds the other. What
is redundant is dropped by counting: in d dimensions a corner lies on at least d faces and a face has at least d
corners, and those that do not are none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.cones import Cone, Whole, product
from refimpl.linear import Array
from refimpl.proxy import ShapeError

AT_INFINITY = -1


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
    """Faces of the hull of points (m, 3); any of them may be equal, collinear or coplanar."""
    grid, exponent = on_grid(points)
    rows = [(x, y, z, 1) for x, y, z in grid]
    cone = Cone()
    for i in _in_good_order(points):
        cone.take_in(i, rows[i])
    dimension = 3 - len(cone.lines)
    if dimension == 0:
        return Faces([rows[0]], [], [], 0, [(1, 0, 0), (0, 1, 0), (0, 0, 1)], exponent, [], [0])
    kept = _essential(cone.touching, dimension)
    place = {name: i for i, name in enumerate(kept)}
    rays = sorted(cone.rays)
    incidence = [sorted(place[name] for name in cone.active[ray] if name in place) for ray in rays]
    normals = [line[:3] for line in cone.lines]
    return Faces(
        [rows[i] for i in kept], [cone.rays[r] for r in rays], incidence, dimension, normals, exponent, [], kept
    )


def from_planes(planes: Array) -> Faces:
    """Faces of the set normal·x + k ≤ 0 for every plane (normal, k); shape (f, 4).

    Raises
    ------
    ShapeError
        When the set is empty, or unbounded, and then along which direction.
    """
    rows: list[Whole] = []
    for plane in planes:
        ((x, y, z, k),), _ = on_grid(plane[None])
        rows.append((x, y, z, k))
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
    everywhere = set(cone.rays)
    implied = [rows[i][:3] for i in range(len(rows)) if cone.touching[i] == everywhere]
    normals = _independent(implied)
    dimension = 3 - len(normals)
    proper = {i: cone.touching[i] for i in range(len(rows)) if cone.touching[i] != everywhere}
    kept = _essential(proper, dimension)
    rays = sorted(cone.rays)
    place = {ray: i for i, ray in enumerate(rays)}
    incidence = [sorted(place[ray] for ray in cone.touching[i]) for i in kept]
    corners = [cone.rays[r] for r in rays]
    return Faces(corners, [rows[i] for i in kept], incidence, dimension, normals, 0, kept, [])


def on_grid(numbers: Array) -> tuple[list[list[int]], int]:
    """Whole numbers and the exponent e such that the doubles (n, w) are whole · 2^e."""
    mantissa, exponent = np.frexp(numbers)
    whole = np.ldexp(mantissa, 53).astype(np.int64).tolist()
    present = mantissa != 0
    least = int(np.min(exponent[present])) if np.any(present) else 0
    shifts = np.where(present, exponent - least, 0).tolist()
    return [[w << s for w, s in zip(*row, strict=True)] for row in zip(whole, shifts, strict=True)], least - 53


def _in_good_order(points: Array) -> list[int]:
    """Outermost points first, for what lies within their hull is soon done; then as by chance, but always the same."""
    ways = np.random.default_rng(0).normal(size=(26, 3))
    heights = [points[:, 0] * x + points[:, 1] * y + points[:, 2] * z for x, y, z in ways.tolist()]
    first = [int(np.argmax(h)) for h in heights] if len(points) > len(ways) else []
    rest = np.random.default_rng(1).permutation(len(points)).tolist()
    return list(dict.fromkeys(first + rest))


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
