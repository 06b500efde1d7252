"""Points spread evenly over the surfaces of solids, equally many on equal areas."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from refimpl.atoms import leaves
from refimpl.construct.heights import heights
from refimpl.integrals import surface_of
from refimpl.linear import Array, Bools, apply, cross, dot, norm, perpendicular, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Polyhedron,
    Sphere,
)

STEP = 1.2207440846057596  # the real root of x⁴ = x + 1
OUTWARD = 1e-7  # of its size: so far outside its own part, a point of a union's surface is outside all parts


class Samples(NamedTuple):
    """Points of a surface with the outward normals there, both (n, 3), and its area, [length²]."""

    points: Array
    normals: Array
    area: float


def spread(count: int, seed: int = 0) -> Array:
    """Low-discrepancy points of the unit cube, (count, 3): multiples of irrational numbers, shifted by the seed.

    Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018 (the Kronecker sequence of the powers of a
    generalised golden ratio).
    """
    shift = np.random.default_rng(seed).random(3)
    return np.asarray((np.arange(1, count + 1)[:, None] * STEP ** -np.arange(1.0, 4.0) + shift) % 1.0)


def surface_samples(shape: Proxy, count: int, seed: int = 0) -> Samples:
    """Points of the boundary of a single bounded solid.

    Of a union, what lies within another part, or between two that share a face, is no boundary and left out; so there
    are `count` points or fewer.

    Raises
    ------
    ShapeError
        For a batch, and a solid without area, such as a ball of radius 0.
    UnsupportedOperation
        For a half-space, a point or a ray.
    """
    if shape.batch_shape:
        raise ShapeError(f"expected a single solid, got a batch of shape {shape.batch_shape}")
    parts = leaves(shape)
    areas = [_area(part) for part in parts]
    total = sum(areas)
    if not total > 0:
        raise ShapeError(f"the {type(shape).__name__} has no surface area")
    numbers = np.diff(np.round(count / total * np.cumsum([0.0, *areas]))).astype(int).tolist()
    found = []
    for i, (part, number) in enumerate(zip(parts, numbers, strict=True)):
        if number:
            points, normals = RULES[type(part)].points(part, spread(number, seed))
            free = _uncovered(parts, i, points, normals)
            found.append((points[free], normals[free]))
    points, normals = (np.concatenate(column) for column in zip(*found, strict=True))
    return Samples(points, normals, total * len(points) / count)


def outside_of_all(union: Proxy, points: Array, normals: Array) -> Bools:
    """Which points of the surface of some part of a union are on the union's surface: a bit farther out is outside."""
    step = OUTWARD * float(union.magnitude)
    return np.asarray(heights(union, points + step * normals, 0.0) > 0)


def _uncovered(parts: list[Proxy], own: int, points: Array, normals: Array) -> Bools:
    """Which points of one part's surface are on that of the union; where surfaces coincide, the first part's count."""
    if len(parts) == 1:
        return np.ones(len(points), dtype=bool)
    union = Composite(parts)
    free = outside_of_all(union, points, normals)
    if own:
        rounding = 2.0**-44 * float(union.magnitude)
        free[free] = heights(Composite(parts[:own]), points[free], rounding) > rounding
    return free


class Rule(NamedTuple):
    """Area of a solid, and points of its surface with normals from points of the unit cube."""

    area: Callable[[Any], float]
    points: Callable[[Any, Array], tuple[Array, Array]]


def _area(shape: Proxy) -> float:
    if type(shape) not in RULES:
        raise UnsupportedOperation(f"a {type(shape).__name__} has no surface of finite area: it is no bounded solid")
    return RULES[type(shape)].area(shape)


# ------------------------------------------------------------------------------------------- triangles


def triangles_of(shape: Proxy) -> Array:
    """Outward triangles (t, 3, 3) of a polytope or polyhedron, where it is placed."""
    if isinstance(shape, Polyhedron):
        corners, position, rotation = shape.solid.corners, shape.position, shape.rotation
    elif isinstance(shape, ConvexPolyhedron):
        corners, position, rotation = surface_of(shape.hull), shape.position, shape.rotation
    elif isinstance(shape, Box):
        corners, position, rotation = surface_of(shape.hull), shape.center, shape.rotation
    else:
        return surface_of(shape.hull)  # type: ignore[attr-defined]
    return apply(rotation_matrix(rotation), corners) + position


def _areas(triangles: Array) -> tuple[Array, Array]:
    """Unit normals and areas."""
    normals, twice = unit_or(cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), np.eye(3)[2])
    return normals, twice / 2


def _on_triangles(shape: Proxy, cube: Array) -> tuple[Array, Array]:
    triangles = triangles_of(shape)
    normals, areas = _areas(triangles)
    bounds = np.cumsum(areas)
    face = np.minimum(np.searchsorted(bounds, cube[:, 0] * bounds[-1], side="right"), np.flatnonzero(areas)[-1])
    root, v = np.sqrt(cube[:, 1]), cube[:, 2]
    a, b, c = (triangles[face, i] for i in range(3))
    return scale(1 - root, a) + scale(root * (1 - v), b) + scale(root * v, c), normals[face]


POLYTOPE = Rule(lambda shape: float(np.sum(_areas(triangles_of(shape))[1])), _on_triangles)


# ------------------------------------------------------------------------------------------- round solids


def _directions(u: Array, v: Array) -> Array:
    """Unit vectors, even over the sphere (Archimedes: its height is uniform)."""
    z = 2 * u - 1
    rim, angle = np.sqrt(np.maximum(1 - z * z, 0.0)), 2 * math.pi * v
    return np.stack([rim * np.cos(angle), rim * np.sin(angle), z], axis=1)


def _on_sphere(s: Sphere, cube: Array) -> tuple[Array, Array]:
    out = _directions(cube[:, 0], cube[:, 1])
    return s.center + s.radius * out, out


def _shaft(shape: Capsule | Cylinder) -> tuple[Array, float, float]:
    """Unit axis, length and radius."""
    axis, length = unit_or(shape.q - shape.p, np.eye(3)[2])
    return axis, float(length), float(shape.radius)


def _around(axis: Array, turn: Array) -> Array:
    """Unit vectors at right angles to an axis."""
    side = perpendicular(axis)
    angle = (2 * math.pi * turn)[:, None]
    return np.asarray(np.cos(angle) * side + np.sin(angle) * cross(axis, side))


def _on_capsule(c: Capsule, cube: Array) -> tuple[Array, Array]:
    axis, length, radius = _shaft(c)
    straight = length / (length + 2 * radius)
    ball = cube[:, 0] >= straight
    out = np.where(ball[:, None], _directions(cube[:, 1], cube[:, 2]), _around(axis, cube[:, 2]))
    along = np.where(ball, (dot(out, axis) >= 0) * 1.0, cube[:, 1])
    return c.p + along[:, None] * (c.q - c.p) + radius * out, out


def _on_cylinder(c: Cylinder, cube: Array) -> tuple[Array, Array]:
    axis, length, radius = _shaft(c)
    straight = length / (length + radius)
    cap = cube[:, 0] >= straight
    top = (cube[:, 0] >= (1 + straight) / 2)[:, None] & cap[:, None]
    around = _around(axis, cube[:, 2])
    side = c.p + cube[:, 1:2] * (c.q - c.p) + radius * around
    lid = np.where(top, c.q, c.p) + radius * np.sqrt(cube[:, 1:2]) * around
    return np.where(cap[:, None], lid, side), np.where(cap[:, None], np.where(top, axis, -axis), around)


def _area_of_ellipsoid(e: Ellipsoid) -> float:
    """Area 4π R_G of the squared products of radii (Carlson's elliptic integral; DLMF 19.33.1)."""
    from scipy.special import elliprg  # noqa: PLC0415  not needed by those who only ask for distances

    a, b, c = e.radii.tolist()
    return 4 * math.pi * float(elliprg((a * b) ** 2, (b * c) ** 2, (c * a) ** 2))


def _on_ellipsoid(e: Ellipsoid, cube: Array) -> tuple[Array, Array]:
    """Images of points of the unit sphere, kept as their surroundings are stretched: half of them at least, on average.

    (The stretch is the length of a vector, so its mean over the sphere is no less than half its largest.)
    """
    a, b, c = e.radii.tolist()
    many = (spread(4 * len(cube) + 64) + cube[0]) % 1.0
    sphere = _directions(many[:, 0], many[:, 1])
    normals, stretch = unit_or(sphere * np.array([b * c, c * a, a * b]), np.eye(3)[2])
    kept = np.flatnonzero(many[:, 2] * max(b * c, c * a, a * b) < stretch)[: len(cube)]
    turn = rotation_matrix(e.rotation)
    return apply(turn, sphere[kept] * e.radii) + e.center, apply(turn, normals[kept])


RULES: dict[type[Proxy], Rule] = {
    Sphere: Rule(lambda s: 4 * math.pi * float(s.radius) ** 2, _on_sphere),
    Capsule: Rule(lambda c: 2 * math.pi * float(c.radius) * float(norm(c.q - c.p) + 2 * c.radius), _on_capsule),
    Cylinder: Rule(lambda c: 2 * math.pi * float(c.radius) * float(norm(c.q - c.p) + c.radius), _on_cylinder),
    Ellipsoid: Rule(_area_of_ellipsoid, _on_ellipsoid),
    AABB: POLYTOPE,
    Box: POLYTOPE,
    KDOP: POLYTOPE,
    ConvexPolyhedron: POLYTOPE,
    Polyhedron: POLYTOPE,
}
