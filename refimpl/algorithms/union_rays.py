"""The first time at which a ray meets a union: of a polyhedron by its faces, of a composite by its parts."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.algorithms.surfaces import faces_on_the_way, points_surface
from refimpl.atoms import leaves
from refimpl.linear import Array, apply, apply_inverse, cross, dot, largest, norm, rotation_matrix, scale, unit_or
from refimpl.meshes import segment_meets_triangle
from refimpl.proxy import Proxy
from refimpl.shapes import Polyhedron, Ray
from refimpl.signs import ROUNDING, TINY, Indices, Points, Signs, on_grid
from refimpl.solids import Solid

Entry = tuple[Array, Array]
NEAR = 2.0**-40  # so near the surface, in lengths of the scene, it is decided exactly whether a ray starts on it
STEEP = 0.05  # sine between ray and face from which on the face's plane tells the time best


def union_ray(ray: Ray, b: Proxy) -> Entry:
    """Time (inf on a miss, 0 from inside) and outward unit normal of the first point of a union on a ray.

    Parameters
    ----------
    ray, b : with one batch axis, of the same length
        `b` a `Polyhedron` or a `Composite`. Finite for polyhedra: the faces that the ray passes are told apart by exact
        signs, so that no ray slips through between two of them. For composites the first entry into any part.
    """
    from refimpl.queries import raycast  # noqa: PLC0415  the door needs the pair table, which names this module

    best, normal = np.full(len(ray), np.inf), np.full((len(ray), 3), np.nan)
    for part in leaves(b):
        if isinstance(part, Polyhedron):
            t, n = ray_polyhedron(ray, part)
        else:
            hit = raycast(ray, part)
            t, n = hit.t, hit.normal
        first = t < best
        best, normal = np.where(first, t, best), np.where(first[:, None], n, normal)
    return best, normal


def ray_polyhedron(ray: Ray, mesh: Polyhedron) -> Entry:
    """Time and outward normal of the first point of a polyhedron on a ray."""
    turn = rotation_matrix(mesh.rotation)
    origin, direction = apply_inverse(turn, ray.origin - mesh.position), apply_inverse(turn, ray.direction)
    times, normals = _enter(mesh.solid, origin, direction)
    return times, apply(turn, normals)


def _enter(solid: Solid, origin: Array, direction: Array) -> Entry:
    """The same in the mesh's frame."""
    return first_entry(solid, origin, direction, *faces_on_the_way(solid, origin, direction))


def first_entry(solid: Solid, origin: Array, direction: Array, row: Indices, face: Indices) -> Entry:
    """Times and outward normals of the first points of a solid on rays (n, 3), in its frame.

    Parameters
    ----------
    row, face : (k,)
        Rays, by their places, and the faces that they may meet; all others they miss.
    """
    near = row, face
    row, face, reached, outward = crossings(solid, origin, direction, row, face)
    times, normals = np.full(len(origin), np.inf), np.full((len(origin), 3), np.nan)
    np.minimum.at(times, row, reached)
    first = np.flatnonzero(reached <= times[row] * (1 + 4 * ROUNDING))
    facing = dot(outward[first], unit_or(direction, direction)[0][row[first]])
    order = first[np.lexsort((facing, row[first]))]  # of several, the face that faces the ray most
    rows, begin = np.unique(row[order], return_index=True)
    normals[rows], times[rows] = outward[order[begin]], reached[order[begin]]
    times[_begun(solid, origin, *near)] = 0.0
    return times, normals


def _begun(solid: Solid, origin: Array, row: Indices, face: Indices) -> Indices:
    """Rays that start in the solid; where their height above the surface may be rounding, it is decided exactly."""
    gap = points_surface(solid, origin)[0]
    doubtful = (gap > 0) & (gap <= NEAR * (largest(origin) + solid.extent))
    if not doubtful.any():
        return np.flatnonzero(gap <= 0)
    some = np.flatnonzero(doubtful[row])
    points = Points(np.concatenate([solid.corners[face[some]].reshape(-1, 3), origin[row[some]]]))
    start = 3 * len(some) + np.arange(len(some))
    on = segment_meets_triangle(points, start, start, np.arange(3 * len(some)).reshape(-1, 3))
    return np.append(np.flatnonzero(gap <= 0), row[some[on]])


def crossings(
    solid: Solid, origin: Array, direction: Array, row: Indices, face: Indices
) -> tuple[Indices, Indices, Array, Array]:
    """Rays that go through faces, from one side to the other, at a time that is not negative.

    Parameters as for `first_entry`.

    Returns
    -------
    rays, faces, times, outward normals
        Of the pairs given, those that do. A ray along a face's plane goes through the faces around it.
    """
    corners = solid.corners[face]
    signs, sizes = _sides(origin[row], direction[row], corners)
    through = ((signs.min(axis=1) >= 0) | (signs.max(axis=1) <= 0)) & np.any(signs != 0, axis=1)
    row, face, corners, sizes = row[through], face[through], corners[through], np.abs(sizes[through])
    shares = sizes / np.sum(sizes, axis=1)[:, None]
    offset = np.zeros((len(row), 3))
    for i in range(3):
        offset = offset + scale(shares[:, i], corners[:, i] - origin[row])
    along, _ = unit_or(direction, direction)
    reached = dot(offset, along[row]) / dot(direction, along)[row]
    outward = unit_or(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), np.eye(3)[2])[0]
    reached = reached + _rest(origin[row] + scale(reached, direction[row]), direction[row], corners[:, 0], outward)
    kept = reached >= 0
    return row[kept], face[kept], reached[kept], outward[kept]


def _rest(spot: Array, direction: Array, corner: Array, outward: Array) -> Array:
    """Time from a place on a ray to a face's plane; 0 where the ray goes along the face rather than through it.

    From far away the shares of a face's corners cancel, and the time that they tell errs by more than rounding.
    """
    fall = dot(outward, direction)
    steep = np.abs(fall) > STEEP * norm(direction)
    return np.asarray(np.where(steep, dot(outward, corner - spot) / np.where(steep, fall, 1.0), 0.0))


def _sides(origin: Array, direction: Array, corners: Array) -> tuple[Signs, Array]:
    """On which side of the sides opposite to each corner a ray passes, exactly, and the volumes that tell."""
    value, size = _volumes(origin, direction, corners)
    signs: Signs = np.sign(value).astype(np.int8)
    unsure = np.flatnonzero(np.any(np.abs(value) <= 32 * ROUNDING * size + TINY, axis=1))
    if len(unsure):
        grid, _ = on_grid(np.concatenate([origin[unsure][:, None], corners[unsure]], axis=1))
        way, _ = on_grid(direction[unsure])
        exact, _ = _volumes(grid[:, 0], way, grid[:, 1:])
        signs[unsure] = [[(v > 0) - (v < 0) for v in row] for row in exact.tolist()]
    return signs, np.where(signs == 0, 0.0, value)


def _volumes(origin: Any, direction: Any, corners: Any) -> tuple[Any, Any]:
    """det(direction, b − origin, c − origin) for each corner's opposite side bc, and the sum of its absolute terms."""
    from_origin = corners - origin[:, None]
    b, c = from_origin[:, [1, 2, 0]], from_origin[:, [2, 0, 1]]
    value, size = 0, 0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = b[..., j] * c[..., k], b[..., k] * c[..., j]
        value = value + direction[:, i, None] * (left - right)
        size = size + abs(direction[:, i, None]) * (abs(left) + abs(right))
    return value, size
