"""What can be done about a mesh that bounds no solid, by name; nothing is done unasked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array
from refimpl.meshes import Triangles, directed_edges
from refimpl.signs import Points

Mesh = tuple[Array, Triangles]


def merged(vertices: Array, triangles: Triangles) -> Mesh:
    """Make corners with the same coordinates one vertex, and leave out vertices of no face."""
    if not len(triangles):
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    corners = vertices[triangles].reshape(-1, 3) + 0.0
    different, index = np.unique(corners, axis=0, return_inverse=True)
    return different, np.asarray(index, dtype=np.int64).reshape(-1, 3)


def _without_degenerate(vertices: Array, triangles: Triangles) -> Mesh:
    a, b, c = triangles.T
    points = Points(vertices)
    flat = np.ones(len(triangles), dtype=bool)
    for axis in range(3):
        flat &= points.turn(a, b, c, np.full(len(a), axis)) == 0
    return vertices, triangles[~flat]


def _without_doubles(vertices: Array, triangles: Triangles) -> Mesh:
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return vertices, triangles[np.sort(first)]


def _turned_outwards(vertices: Array, triangles: Triangles) -> Mesh:
    """Turn faces over until neighbours agree, and then each connected surface that encloses less than nothing."""
    turned = triangles.copy()
    neighbours = _neighbours(triangles)
    label = np.full(len(triangles), -1)
    for start in range(len(triangles)):
        if label[start] >= 0:
            continue
        label[start], waiting = start, [start]
        while waiting:
            face = waiting.pop()
            own = _ways(turned[face])
            for other in neighbours[face]:
                if label[other] < 0:
                    if own & _ways(turned[other]):
                        turned[other] = turned[other][::-1]
                    label[other] = start
                    waiting.append(other)
        mine = label == start
        x = vertices[turned[mine]] - vertices[turned[start, 0]]
        if float(np.sum(x[:, 0] * np.cross(x[:, 1], x[:, 2]))) < 0:
            turned[mine] = turned[mine][:, ::-1]
    return vertices, turned


def _ways(face: NDArray[np.int64]) -> set[tuple[int, int]]:
    a, b, c = face.tolist()
    return {(a, b), (b, c), (c, a)}


def _neighbours(triangles: Triangles) -> list[list[int]]:
    """Faces that share an edge with each face, where no third one does."""
    edges, faces = directed_edges(triangles)
    sides: dict[tuple[int, int], list[int]] = {}
    for (u, v), face in zip(np.sort(edges, axis=1).tolist(), faces.tolist(), strict=True):
        sides.setdefault((u, v), []).append(face)
    found: list[list[int]] = [[] for _ in triangles]
    for pair in sides.values():
        if len(pair) == 2:
            found[pair[0]].append(pair[1])
            found[pair[1]].append(pair[0])
    return found


def _filled_holes(vertices: Array, triangles: Triangles) -> Mesh:
    """Close each hole whose rim is a simple loop by a fan around its first corner."""
    edges, _ = directed_edges(triangles)
    there = set(map(tuple, edges.tolist()))
    rim: dict[int, int] = {v: u for u, v in there if (v, u) not in there}
    added = []
    while rim:
        start, here = next(iter(rim.items()))
        del rim[start]
        loop = [start]
        while here != start and here in rim:
            loop.append(here)
            here = rim.pop(here)
        if here == start:
            added += [[start, loop[i], loop[i + 1]] for i in range(1, len(loop) - 1)]
    return vertices, np.concatenate([triangles, np.array(added, dtype=np.int64).reshape(-1, 3)])


REPAIRS: dict[str, Callable[[Array, Triangles], Mesh]] = {
    "drop_degenerate": _without_degenerate,
    "drop_duplicates": _without_doubles,
    "turn_outwards": _turned_outwards,
    "fill_holes": _filled_holes,
}
"""What can be done about a mesh, by name: faces without area, faces given twice, faces turned over, open rims."""
