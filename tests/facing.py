"""Shapes that touch a given plane at a given point, of every type."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from oracles.engine import Array, Kind
from refimpl.linear import rotation_matrix
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)


def rows(*shapes: Any) -> Array:
    return np.array([shape.pack() for shape in shapes])


def support_in(kind: Kind, u: Array, at: Array) -> Any:  # noqa: PLR0911  one for each type
    """Shape of some type that lies in u·x ≤ u·at and touches that plane at `at`, away from its edges."""
    if kind is Point:
        return Point(at)
    if kind is Sphere:
        return Sphere(at - 0.75 * u, 0.75)
    if kind is Capsule:
        side = np.cross(u, [0.6, 0.0, 0.8])
        return Capsule(at - 0.5 * u + 0.7 * side, at - 0.5 * u - 0.4 * side, 0.5)
    if kind is HalfSpace:
        return HalfSpace(2.5 * u, -2.5 * float(u @ at))
    if kind is AABB:
        axis = int(np.argmax(np.abs(u)))
        half = np.array([0.9, 1.1, 1.3])
        middle = at - half[axis] * u + np.array([0.2, 0.1, -0.3]) * (np.arange(3) != axis)
        return AABB(middle - half, middle + half)
    aside, side = np.cross(u, [0.3, 0.2, -0.1]), np.cross(u, [0.6, 0.0, 0.8])
    if kind is Cylinder:
        return Cylinder(at - 1.6 * u + aside, at + aside, 0.9)
    if kind is Ellipsoid:
        return ellipsoid_below(u, at)
    if kind is KDOP:
        directions = np.array([2.0 * u, side, np.cross(u, side), side - u])
        middle = directions @ (at - 0.8 * u + aside)
        return KDOP(directions, middle - [1.6, 1.2, 0.9, 2.5], np.where([1, 0, 0, 0], directions @ at, middle + 1.5))
    face = [at + aside + x * side + y * np.cross(u, side) for x, y in ((-2, -2), (2, -2), (2, 2), (-2, 2))]
    pyramid = np.array([*face, at - 3.0 * u])
    if kind is ConvexPolyhedron:
        return ConvexPolyhedron.from_vertices(pyramid - at, at)
    if kind is Polyhedron:
        return Polyhedron(pyramid - at, [(0, 1, 2), (0, 2, 3), (1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4)], at)
    if kind is Composite:
        parts = [support_in(part, u, at - deeper * u) for part, deeper in ((Sphere, 0.0), (Cylinder, 0.5), (Box, 1.0))]
        return Composite([*parts, support_in(ConvexPolyhedron, u, at - 0.7 * u)])
    w = np.array([*np.cross([0.0, 0.0, 1.0], u), 1.0 + u[2]])
    return Box(at - 0.8 * u + aside, [1.2, 1.4, 0.8], 3 * (w if np.any(w) else np.array([1.0, 0.0, 0.0, 0.0])))


def ellipsoid_below(u: Array, at: Array) -> Ellipsoid:
    """Ellipsoid whose point of support along u is `at`: its matrix takes u there from the centre."""
    turn, radii = [0.1, -0.3, 0.2, 0.9], np.array([0.9, 1.1, 1.3])
    rotation = rotation_matrix(np.array(turn))
    stretched = rotation @ np.diag(radii**2) @ rotation.T
    return Ellipsoid(at - stretched @ u / math.sqrt(u @ stretched @ u), radii, turn)


def facing_pair(A: Kind, B: Kind, gap: float, turn: int) -> tuple[Any, Any, Array]:
    """Shapes whose signed distance is `gap` along the unit vector that is also returned."""
    directions = [
        np.array(v, dtype=float) for v in ([1, 0, 0], [0, -1, 0], [0, 0, 1], [2 / 3, -1 / 3, 2 / 3], [-0.6, 0.0, 0.8])
    ]
    u = directions[turn % (3 if AABB in (A, B) else 5)]
    at = np.array([0.3, -0.2, 0.5])
    return support_in(A, u, at), support_in(B, -u, at + gap * u), u
