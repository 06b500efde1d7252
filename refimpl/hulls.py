"""Corners, faces and edges of polytopes, derived once and kept with the shape.

What was given is the shape's meaning; what is derived here is rounded only once, from exact corners and planes. A
polygon, a segment and a point are prisms and boxes of no thickness: they have two sides, and the faces that such a
prism has around them, so that a search over faces and edges need not know that they are flat.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from refimpl.cones import nearest_doubles
from refimpl.faces import Faces, edges_of, from_planes, from_vertices
from refimpl.linear import Array, cross, dot, norm, perpendicular, unit_or
from refimpl.proxy import ShapeError, shifted

Indices = NDArray[np.int64]
KEPT = 4096  # small geometries whose hulls are remembered, at a few kilobytes each
LARGE = 16_384  # bytes from which on only the shape itself keeps its hull


@dataclass(frozen=True, eq=False)
class Hull:
    """A polytope's corners, outward planes and edges, in its own frame.

    Polytopes of a batch that have less of something than others repeat their last.

    Attributes
    ----------
    vertices : (..., m, 3)
        Extreme points only; given ones as they were given, others rounded correctly from the exact corner.
    planes : (..., f, 4)
        Unit outward normal and offset, normal·x + offset ≤ 0; one for each face, and around flat sets the planes of
        a prism without thickness.
    edges : (..., e, 4) int
        Start, end (vertices), face to the left, face to the right (planes), seen from outside.
    active_planes : (..., f) int
        Which of the given planes each is; −1 for planes that were not given.
    active_vertices : (..., m) int
        Which of the given vertices each is; −1 for corners that were not given.
    dimension : (...) int
        3, or 2, 1, 0 for a polygon, a segment, a point.
    """

    vertices: Array
    planes: Array
    edges: Indices
    active_planes: Indices
    active_vertices: Indices
    dimension: Indices

    def mapped(self, change: Callable[[Any, int], Any]) -> Self:
        """Apply one change of batch axes to every array; `change` takes one and its number of trailing axes."""
        ends = (2, 2, 2, 1, 1, 0)
        arrays = (
            self.vertices,
            self.planes,
            self.edges,
            self.active_planes,
            self.active_vertices,
            self.dimension,
        )
        return type(self)(*(change(a, n) for a, n in zip(arrays, ends, strict=True)))

    @cached_property
    def size(self) -> Array:
        """Largest absolute coordinate of a corner (...)."""
        return np.asarray(np.max(np.abs(self.vertices), axis=(-2, -1)))

    @cached_property
    def middle(self) -> Array:
        """Mean of the corners (..., 3), which lies in the hull; a corner repeated to fill up a batch counts once."""
        v = self.vertices
        counts = np.ones(v.shape[:-1])
        counts[..., 1:] = np.any(v[..., 1:, :] != v[..., :-1, :], axis=-1)
        shares = counts / np.sum(counts, axis=-1)[..., None]
        return np.asarray(np.cumsum(shares[..., None] * v, axis=-2)[..., -1, :])

    def broadcast_to(self, batch: tuple[int, ...]) -> Self:
        """Repeat along new batch axes, without copying."""
        return self.mapped(lambda a, ends: np.broadcast_to(a, (*batch, *a.shape[a.ndim - ends :])))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent, exactly."""
        power = np.asarray(exponent)
        vertices = shifted(self.vertices, power, 2)
        offsets = np.ldexp(self.planes[..., 3], power[..., None])
        normals = np.broadcast_to(self.planes[..., :3], (*offsets.shape, 3))
        planes = np.concatenate([normals, offsets[..., None]], axis=-1)
        rest = self.broadcast_to(offsets.shape[:-1])
        return type(self)(vertices, planes, rest.edges, rest.active_planes, rest.active_vertices, rest.dimension)


def solid_of_planes(content: bytes, count: int) -> Hull:
    """Hull of one set of planes, which are named by the bytes of their numbers.

    Raises
    ------
    ShapeError
        Where the set is empty or unbounded.
    """
    return _kept(content, count, 4) if len(content) <= LARGE else _solid(content, count, 4)


def solid_of_vertices(content: bytes, count: int) -> Hull:
    """Hull of one set of vertices, which are named by the bytes of their numbers."""
    return _kept(content, count, 3) if len(content) <= LARGE else _solid(content, count, 3)


def _solid(content: bytes, count: int, width: int) -> Hull:
    numbers = np.frombuffer(content).reshape(count, width)
    if width == 4:
        return _derived(from_planes(numbers), planes=numbers)
    return _derived(from_vertices(numbers), points=numbers)


_kept = lru_cache(maxsize=KEPT)(_solid)


def _derived(faces: Faces, planes: Array | None = None, points: Array | None = None) -> Hull:
    """Round the exact faces: to doubles, unit normals, and an orientation for each edge."""
    if points is not None:
        corners, active_vertices = points[faces.kept_vertices], faces.kept_vertices
    else:
        corners, active_vertices = _rounded_corners(faces), [-1] * len(faces.corners)
    if faces.dimension < 3:
        sides, edges = _thin(faces, corners)
        return _hull(corners, sides, edges, [-1] * len(sides), active_vertices, faces.dimension)
    active_planes = faces.kept_planes if planes is not None else [-1] * len(faces.planes)
    return _hull(corners, _unit_planes(faces), edges_of(faces), active_planes, active_vertices, 3)


def _hull(corners: Array, planes: Array, edges: Any, active_planes: Any, active_vertices: Any, dimension: int) -> Hull:
    index = (np.array(a, dtype=np.int64) for a in (active_planes, active_vertices, dimension))
    return Hull(corners, planes, np.array(edges, dtype=np.int64).reshape(-1, 4), *index)


def _rounded_corners(faces: Faces) -> Array:
    """Exact corners to the nearest doubles: Python divides whole numbers with one rounding."""
    try:
        rows = [(x / t, y / t, z / t) for x, y, z, t in faces.corners]
    except OverflowError:
        raise ShapeError("a corner lies beyond the largest float") from None
    return np.asarray(np.ldexp(np.array(rows), faces.exponent))


def _unit_planes(faces: Faces) -> Array:
    """Outward unit normals and offsets of the exact planes."""
    level = []
    for n in faces.planes:
        unit = 1 << max(map(abs, n[:3])).bit_length()
        offset = n[3] / (unit << -faces.exponent) if faces.exponent < 0 else (n[3] << faces.exponent) / unit
        level.append((*nearest_doubles(n[:3]), offset))
    rows = np.array(level)
    return rows / norm(rows[:, :3])[:, None]


def _thin(faces: Faces, corners: Array) -> tuple[Array, list[tuple[int, int, int, int]]]:
    """Planes and edges of a flat set: those of a prism (polygon) or of a box (segment, point) of no thickness."""
    if faces.dimension == 0:
        return _supporting(np.concatenate([np.eye(3), -np.eye(3)]), corners), []
    if faces.dimension == 1:
        way = unit_or(corners[1] - corners[0], np.eye(3)[0])[0]
        u = perpendicular(way)
        around = np.stack([u, cross(way, u), -u, -cross(way, u), way, -way])
        return _supporting(around, corners), [(0, 1, i, (i + 1) % 4) for i in range(4)]
    top = unit_or(np.array(nearest_doubles(faces.normals[0])), np.eye(3)[2])[0]
    first, second = np.array(faces.incidence).T
    side = cross(corners[second] - corners[first], top)
    heights = dot(corners - corners[first][:, None], side[:, None])
    farthest = np.take_along_axis(heights, np.argmax(np.abs(heights), axis=1)[:, None], axis=1)
    inward = farthest > 0
    outward = unit_or(np.where(inward, -side, side), top)[0]
    edges: list[tuple[int, int, int, int]] = []
    for number, (v, w) in enumerate(faces.incidence, 2):
        start, end = (w, v) if inward[number - 2] else (v, w)
        edges += [(start, end, 0, number), (end, start, 1, number)]
    return _supporting(np.concatenate([[top, -top], outward]), corners), edges


def _supporting(normals: Array, corners: Array) -> Array:
    """Planes with these unit normals that touch the corners from outside."""
    heights = dot(normals[:, None, :], corners[None, :, :])
    return np.concatenate([normals, -np.max(heights, axis=1)[:, None]], axis=1)


CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
CUBE_PLANES = np.concatenate([np.eye(3), -np.eye(3)])


@lru_cache(maxsize=1)
def _cube_edges() -> Indices:
    """Edges of a box whose corners are numbered as `CUBE` and whose faces as `CUBE_PLANES`."""
    signed = 2 * CUBE - 1
    planes = [(int(x), int(y), int(z), -1) for x, y, z in CUBE_PLANES]
    incidence = [[i for i, c in enumerate(signed) if int(c @ n) == 1] for n in CUBE_PLANES]
    corners = [(int(x), int(y), int(z), 1) for x, y, z in signed]
    return np.array(edges_of(Faces(corners, planes, incidence, 3, [], 0, [], [])), dtype=np.int64)


def hull_of_box(lower: Array, upper: Array) -> Hull:
    """Hull of the box from `lower` to `upper` (..., 3): always eight corners, also where it is flat."""
    batch = lower.shape[:-1]
    vertices = np.where(CUBE == 1, upper[..., None, :], lower[..., None, :])
    offsets = np.concatenate([-upper, lower], axis=-1)
    planes = np.concatenate([np.broadcast_to(CUBE_PLANES, (*batch, 6, 3)), offsets[..., None]], axis=-1)
    none = np.int64(-1)
    return Hull(
        vertices,
        planes,
        np.broadcast_to(_cube_edges(), (*batch, 12, 4)),
        np.broadcast_to(none, (*batch, 6)),
        np.broadcast_to(none, (*batch, 8)),
        np.broadcast_to(np.int64(3), batch) - np.sum(lower == upper, axis=-1),
    )
