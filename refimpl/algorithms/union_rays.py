"""The first time at which a ray meets a union: of a polyhedron by its faces, of a composite by its parts."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.algorithms.surfaces import point_surface
from refimpl.atoms import leaves
from refimpl.boxtree import SLACK
from refimpl.linear import Array, apply, apply_inverse, cross, dot, rotation_matrix, unit_or
from refimpl.proxy import Proxy
from refimpl.shapes import Polyhedron, Ray
from refimpl.signs import ROUNDING, TINY, Indices, Signs, on_grid
from refimpl.solids import Solid

Entry = tuple[Array, Array]


def union_ray(ray: Ray, b: Proxy) -> Entry:
    """Time (inf on a miss, 0 from inside) and outward unit normal of the first point of a union on a ray.

    Parameters
    ----------
    ray, b : with one batch axis, of the same length
        `b` a `Polyhedron` or a `Composite`. Finite for polyhedra: the faces that the ray passes are told apart by exact
        signs, so that no ray slips through between two of them. For composites the first entry into any part.
    """
    found = [_first(ray[i], b[i]) for i in range(len(ray))]
    times = np.array([t for t, _ in found])
    return times, np.array([n for _, n in found]).reshape(len(found), 3)


def _first(ray: Ray, b: Proxy) -> tuple[float, Array]:
    from refimpl.queries import raycast  # noqa: PLC0415  the door needs the pair table, which names this module

    best, normal = np.inf, np.full(3, np.nan)
    for part in leaves(b):
        if isinstance(part, Polyhedron):
            t, n = _enter_polyhedron(ray, part)
        else:
            hit = raycast(ray, part)
            t, n = float(hit.t), hit.normal
        if t < best:
            best, normal = t, n
    return best, normal


def _enter_polyhedron(ray: Ray, mesh: Polyhedron) -> tuple[float, Array]:
    turn = rotation_matrix(mesh.rotation)
    origin, direction = apply_inverse(turn, ray.origin - mesh.position), apply_inverse(turn, ray.direction)
    if point_surface(mesh.solid, origin)[0] <= 0:
        return 0.0, np.full(3, np.nan)
    faces = _on_the_way(mesh.solid, origin, direction)
    corners = mesh.solid.corners[faces]
    signs, sizes = _sides(origin, direction, corners)
    through = ((signs.min(axis=1) >= 0) | (signs.max(axis=1) <= 0)) & np.any(signs != 0, axis=1)
    if not np.any(through):
        return np.inf, np.full(3, np.nan)
    corners, sizes = corners[through], np.abs(sizes[through])
    shares = sizes / np.sum(sizes, axis=1)[:, None]
    point = sum(shares[:, i, None] * (corners[:, i] - origin) for i in range(3))
    along, _ = unit_or(direction, direction)
    times = dot(np.asarray(point), along[None]) / float(dot(direction, along))
    outward = unit_or(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), np.eye(3)[2])[0]
    times = np.where(times >= 0, times, np.inf)
    first = np.flatnonzero(times <= np.min(times) * (1 + 4 * ROUNDING))
    row = first[int(np.argmin(dot(outward[first], along[None])))]  # of several, the one that faces the ray most
    return float(times[row]), apply(turn, outward[row])


def _on_the_way(solid: Solid, origin: Array, direction: Array) -> Indices:
    """Faces whose boxes, a little widened, the ray passes."""
    low, high = solid.face_bounds
    slack = SLACK * (solid.extent + np.max(np.abs(origin)))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        one, other = (low - slack - origin) / direction, (high + slack - origin) / direction
    enter, leave = np.minimum(one, other), np.maximum(one, other)
    still = direction == 0
    beside = still & ((low - slack > origin) | (high + slack < origin))
    enter, leave = np.where(still, -np.inf, enter), np.where(still, np.inf, leave)
    widen = 1 + 2 * SLACK
    passed = (enter.max(axis=1) <= leave.min(axis=1) * widen) & (leave.min(axis=1) >= 0) & ~np.any(beside, axis=1)
    return np.flatnonzero(passed)


def _sides(origin: Array, direction: Array, corners: Array) -> tuple[Signs, Array]:
    """On which side of the sides opposite to each corner a ray passes, exactly, and the volumes that tell."""
    value, size = _volumes(origin, direction, corners)
    signs: Signs = np.sign(value).astype(np.int8)
    unsure = np.flatnonzero(np.any(np.abs(value) <= 32 * ROUNDING * size + TINY, axis=1))
    if len(unsure):
        grid, _ = on_grid(np.concatenate([origin[None], corners[unsure].reshape(-1, 3)]))
        way, _ = on_grid(direction)
        exact, _ = _volumes(grid[0], way, grid[1:].reshape(-1, 3, 3))
        signs[unsure] = [[(v > 0) - (v < 0) for v in row] for row in exact.tolist()]
    return signs, np.where(signs == 0, 0.0, value)


def _volumes(origin: Any, direction: Any, corners: Any) -> tuple[Any, Any]:
    """det(direction, b − origin, c − origin) for each corner's opposite side bc, and the sum of its absolute terms."""
    from_origin = corners - origin
    b, c = from_origin[:, [1, 2, 0]], from_origin[:, [2, 0, 1]]
    value, size = 0, 0
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = b[..., j] * c[..., k], b[..., k] * c[..., j]
        value = value + direction[i] * (left - right)
        size = size + abs(direction[i]) * (abs(left) + abs(right))
    return value, size
