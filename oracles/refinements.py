"""Finer meshes with the same surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.images import sum_error
from refimpl.linear import Array
from refimpl.shapes import Composite, ConvexPolyhedron, Polyhedron

MOST_REFINED = 400
"""Triangles of the largest mesh that is refined."""


@dataclass(frozen=True)
class Refinement:
    """A mesh with more triangles and the same surface.

    Attributes
    ----------
    vertices, triangles
        Of the finer mesh.
    sources
        Number of the triangle from which each one comes.
    """

    vertices: Array
    triangles: list[tuple[int, int, int]]
    sources: list[int]


def refinement(vertices: Array, triangles: Any) -> Refinement | None:
    """Cut triangles at those middles of their edges that doubles can hold; None where they can hold none."""
    points, middles = [*vertices], {}
    edges = {(min(e), max(e)) for t in triangles.tolist() for e in zip(t, (*t[1:], t[0]), strict=True)}
    for a, b in sorted(edges):
        total = vertices[a] + vertices[b]
        if np.all(sum_error(vertices[a], vertices[b]) == 0) and np.all(2 * (total / 2) == total):
            middles[a, b] = len(points)
            points.append(total / 2)
    if not middles or len(triangles) > MOST_REFINED:
        return None
    found: list[tuple[int, int, int]] = []
    sources: list[int] = []
    for number, corners in enumerate(triangles.tolist()):
        pieces = list(_cut(corners, middles))
        found += pieces
        sources += [number] * len(pieces)
    return Refinement(np.array(points), found, sources)


def _cut(corners: list[int], middles: dict[tuple[int, int], int]) -> list[tuple[int, int, int]]:
    """Triangles of one triangle, whose outline has a corner more for each middle."""
    for turn in range(3):
        a, b, c = corners[turn:] + corners[:turn]
        ab, bc, ca = (middles.get((min(e), max(e))) for e in ((a, b), (b, c), (c, a)))
        if ab is not None and bc is not None and ca is not None:
            return [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        if ab is not None and bc is not None:
            return [(ab, b, bc), (a, ab, bc), (a, bc, c)]
        if ab is not None and ca is None:
            return [(a, ab, c), (ab, b, c)]
    return [(corners[0], corners[1], corners[2])]


def refined(mesh: Polyhedron) -> tuple[Polyhedron, Refinement] | None:
    """The same solid with a finer surface, where there is one."""
    finer = refinement(mesh.vertices, mesh.triangles)
    if finer is None:
        return None
    return Polyhedron(finer.vertices, finer.triangles, mesh.position, mesh.rotation), finer


def refined_surface(surface: Composite, finer: Refinement) -> Composite | None:
    """What an engine takes for the solid, the union of its triangles, cut as the mesh was."""
    first = surface.parts[0]
    if len(surface.parts) != max(finer.sources) + 1 or not isinstance(first, ConvexPolyhedron):
        return None
    corners = [finer.vertices[list(triangle)] for triangle in finer.triangles]
    return Composite([ConvexPolyhedron.from_vertices(c, first.position, first.rotation) for c in corners])
