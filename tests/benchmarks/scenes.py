"""What is timed: generic scenes of every pair, a hull of a thousand faces, and a mesh of ten thousand."""

from __future__ import annotations

from typing import Any

import numpy as np

from oracles.draws import NumpyDraws
from oracles.regimes import REGIMES
from refimpl import KDOP, Composite, ConvexPolyhedron, Polyhedron, Proxy, Sphere
from refimpl.shapes.polytope import Polytope

ROWS = 10_000
DIFFERENT, GEOMETRIES = 2000, 100
"""Scenes that differ in a batch, and those of types that need preparing: few enough for the adapters to keep them.

Corners, hulls and trees are made before the race, on both sides.
"""
PREPARED = (KDOP, ConvexPolyhedron, Polyhedron, Composite)


def batch_of(pair: tuple[type[Proxy], type[Proxy]], rows: int = ROWS, seed: int = 1) -> tuple[Any, Any]:
    """Scenes of a pair in the generic regime, derived data included."""
    different = min(rows, GEOMETRIES if set(pair) & set(PREPARED) else DIFFERENT)
    a, b = REGIMES["generic"](NumpyDraws(seed, (0, 3), different), *pair)
    for shape in (a, b):
        if isinstance(shape, Polytope):
            shape.derived()
    repeated = np.arange(rows) % different
    return a[repeated], b[repeated]


def globe(parallels: int, meridians: int, bumps: float = 0.0) -> tuple[Any, Any]:
    """Vertices and triangles of a closed surface around 0: 2·meridians·(parallels − 1) faces, bumpy or a ball."""
    polar = np.pi * np.arange(1, parallels) / parallels
    azimuth = 2.0 * np.pi * np.arange(meridians) / meridians
    p, q = np.meshgrid(polar, azimuth, indexing="ij")
    ring = np.stack([np.sin(p) * np.cos(q), np.sin(p) * np.sin(q), np.cos(p)], axis=-1)
    radius = 1.0 + bumps * np.sin(5.0 * p) * np.cos(6.0 * q)
    vertices = np.concatenate([(radius[..., None] * ring).reshape(-1, 3), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    top, bottom = len(vertices) - 2, len(vertices) - 1
    triangles = []
    for j in range(meridians):
        after = (j + 1) % meridians
        triangles += [(top, j, after), (bottom, (parallels - 2) * meridians + after, (parallels - 2) * meridians + j)]
        for i in range(parallels - 2):
            low, high = i * meridians, (i + 1) * meridians
            triangles += [(low + j, high + j, high + after), (low + j, high + after, low + after)]
    return vertices, np.array(triangles)


def large_hulls(rows: int, seed: int = 2) -> tuple[Any, Any]:
    """Two hulls of 1 000 faces (corners on a ball, jittered) in poses that overlap or nearly do."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(502, 3))
    corners /= np.linalg.norm(corners, axis=-1, keepdims=True)

    def placed(spread: float) -> ConvexPolyhedron:
        way = rng.normal(size=(rows, 3))
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        position = spread * rng.uniform(1.0, 2.0, (rows, 1)) * way
        return ConvexPolyhedron.from_vertices(corners, position, rng.normal(size=(rows, 4)))

    return placed(0.0), placed(1.3)


def large_mesh() -> Polyhedron:
    """A bumpy ball, not convex, of about 10 000 faces."""
    return Polyhedron(*globe(51, 100, 0.05))


def spheres(rows: int, seed: int = 3) -> Sphere:
    """Balls near the surface of the mesh."""
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(rows, 3))
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    return Sphere(rng.uniform(0.7, 1.6, (rows, 1)) * way, rng.uniform(0.05, 0.3, rows))
