"""A few models made in code, for where there are no files: thin, toothed, hollow and round in places."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from oracles.meshfiles import Mesh
from oracles.models import MeshPiece, Piece
from refimpl.linear import Array
from refimpl.shapes import Box, Capsule, Cylinder, Sphere


def _extruded(outline: Array, cap: Sequence[tuple[int, int, int]], height: float) -> Mesh:
    """Prism over an anticlockwise outline (m, 2), whose triangles are `cap`."""
    m = len(outline)
    vertices = np.concatenate([np.column_stack([outline, np.full(m, z)]) for z in (0.0, height)])
    faces = [(i + m, j + m, k + m) for i, j, k in cap] + [(i, k, j) for i, j, k in cap]
    for i in range(m):
        j = (i + 1) % m
        faces += [(i, j, j + m), (i, j + m, i + m)]
    return Mesh(vertices, np.array(faces, dtype=np.int64))


def bracket() -> Sequence[Piece]:
    """An L of sheet metal, 2 mm thick."""
    outline = np.array([(0, 0), (60, 0), (60, 2), (2, 2), (2, 40), (0, 40)]) * 1e-3
    return [MeshPiece(_extruded(outline, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)], 0.03))]


def gear(teeth: int = 12) -> Sequence[Piece]:
    """A gear wheel with pointed teeth; its bore is a polygon with a corner for each tooth and each gap."""
    angles = np.arange(2 * teeth) * math.pi / teeth
    radii = np.where(np.arange(2 * teeth) % 2 == 0, 0.05, 0.04)
    rim = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    bore = 0.01 * np.column_stack([np.cos(angles), np.sin(angles)])
    m = 2 * teeth
    low, high = np.zeros(m), np.full(m, 0.012)
    vertices = np.concatenate([np.column_stack(ring) for ring in ((rim, low), (rim, high), (bore, low), (bore, high))])
    faces = []
    for i in range(m):
        j = (i + 1) % m
        a, b, c, d = (k * m for k in range(4))  # starts of the rings: rim below, above; bore below, above
        quads = [
            (a + i, a + j, b + j, b + i),
            (c + j, c + i, d + i, d + j),
            (b + i, b + j, d + j, d + i),
            (a + j, a + i, c + i, c + j),
        ]
        for p, q, r, s in quads:
            faces += [(p, q, r), (p, r, s)]
    return [MeshPiece(Mesh(vertices, np.array(faces, dtype=np.int64)))]


def pebble() -> Sequence[Piece]:
    """A convex stone: points of a spiral on an ellipsoid."""
    k = np.arange(40) + 0.5
    height = 1 - k / 20
    angle = math.pi * (1 + math.sqrt(5)) * k
    ring = np.sqrt(1 - height**2)
    points = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height]) * (0.04, 0.03, 0.015)
    # the hull is asked for, not this triangulation, which is a fan and bounds no solid
    return [MeshPiece(Mesh(points, np.array([(0, i, i + 1) for i in range(1, 39)], dtype=np.int64)))]


def dumbbell() -> Sequence[Piece]:
    """Two balls on a bar: concave, round, and thin in the middle."""
    ends = np.array([[-0.15, 0.0, 0.0], [0.15, 0.0, 0.0]])
    return [Capsule(ends[0], ends[1], 0.012), Sphere(ends[0], 0.05), Sphere(ends[1], 0.05)]


def table() -> Sequence[Piece]:
    """A round top on four legs that end inside it."""
    legs = [Box([x, y, 0.35], [0.03, 0.03, 0.35], [0, 0, 0, 1]) for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    return [Cylinder([0, 0, 0.68], [0, 0, 0.72], 0.6), *legs]


MODELS: dict[str, Callable[[], Sequence[Piece]]] = {
    "bracket": bracket,
    "gear": gear,
    "pebble": pebble,
    "dumbbell": dumbbell,
    "table": table,
}
