"""What can be done about a mesh that bounds no solid, by name; nothing is done unasked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array
from refimpl.meshes import MeshError, Triangles, crossings, directed_edges, shells
from refimpl.signs import Points

Mesh = tuple[Array, Triangles]

NEAR = 1e-5
"""Vertices no farther apart than this share of the mesh's diagonal become one by `merge_near`."""
MOST_PAIRS = 20_000_000
"""Pairs of vertices so near that `merge_near` takes in; more are a mesh that is a speck in its own box."""
SIMPLE = 20_000
"""Faces that `simplify` leaves."""


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
    x = vertices[turned] - vertices[turned[label, 0]][:, None]
    enclosed = np.bincount(label, np.sum(x[:, 0] * np.cross(x[:, 1], x[:, 2]), axis=1), len(triangles))
    inwards = enclosed[label] < 0
    turned[inwards] = turned[inwards][:, ::-1]
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
    """Close each hole by a fan around the first corner of its rim; rims that touch themselves are several holes."""
    edges, _ = directed_edges(triangles)
    there = set(map(tuple, edges.tolist()))
    onwards: dict[int, list[int]] = {}
    for u, v in sorted(there):
        if (v, u) not in there:
            onwards.setdefault(v, []).append(u)
    added = []
    for start in sorted(onwards):
        path, place = [start], {start: 0}
        while onwards.get(path[-1]):
            here = onwards[path[-1]].pop()
            if here in place:  # a loop is closed; what led to it may still belong to another
                loop = path[place[here] :]
                for gone in loop[1:]:
                    del place[gone]
                del path[place[here] + 1 :]
                added += [[loop[0], loop[i], loop[i + 1]] for i in range(1, len(loop) - 1)]
            else:
                place[here] = len(path)
                path.append(here)
    return vertices, np.concatenate([triangles, np.array(added, dtype=np.int64).reshape(-1, 3)])


def _merged_near(vertices: Array, triangles: Triangles) -> Mesh:
    """Make chains of near vertices one, which stays where the first of them is, and leave out faces that collapse."""
    from scipy.sparse import coo_matrix  # noqa: PLC0415  slow to import
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415
    from scipy.spatial import cKDTree  # noqa: PLC0415

    reach = NEAR * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    tree = cKDTree(vertices)
    if tree.count_neighbors(tree, reach) > 2 * MOST_PAIRS:
        raise MeshError(
            f"merge_near: most vertices are within {reach:g} of each other, {NEAR:g} of the mesh's diagonal; something "
            "lies far away from the rest: keep_largest first"
        )
    pairs = tree.query_pairs(reach, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(vertices), len(vertices)))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    made = label[triangles].astype(np.int64)
    whole = (made[:, 0] != made[:, 1]) & (made[:, 1] != made[:, 2]) & (made[:, 2] != made[:, 0])
    return vertices[first], made[whole]


def _without_crossing(vertices: Array, triangles: Triangles) -> Mesh:
    first, second, _ = crossings(Points(vertices), triangles)
    return vertices, np.delete(triangles, np.union1d(first, second), axis=0)


def _largest_surface(vertices: Array, triangles: Triangles) -> Mesh:
    """Keep the connected surface of the largest box."""
    if not len(triangles):
        return vertices, triangles
    label = shells(triangles, len(vertices))
    order = np.argsort(label, kind="stable")
    starts = np.flatnonzero(np.diff(label[order], prepend=-1))
    corners = vertices[triangles[order]]
    lower, upper = np.minimum.reduceat(corners.min(axis=1), starts), np.maximum.reduceat(corners.max(axis=1), starts)
    return vertices, triangles[label == int(np.argmax(np.linalg.norm(upper - lower, axis=1)))]


def _hull(vertices: Array, triangles: Triangles) -> Mesh:
    """Faces of the convex hull; of a mesh that is flat, none."""
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    try:
        found = ConvexHull(vertices[np.unique(triangles)])
    except (QhullError, ValueError):
        return vertices, triangles[:0]
    corners, faces = found.points, found.simplices.astype(np.int64)
    x, y, z = (corners[faces[:, k]] for k in range(3))
    inwards = np.sum(np.cross(y - x, z - x) * found.equations[:, :3], axis=1) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return corners, faces


def _simplified(vertices: Array, triangles: Triangles) -> Mesh:
    """Fewer faces, by collapsing the edges that change the surface least; of faces that fold together, none.

    Garland and Heckbert, Surface Simplification Using Quadric Error Metrics, 1997; by the library fast-simplification.
    """
    try:
        import fast_simplification  # noqa: PLC0415  an extra
    except ImportError:
        raise MeshError("simplify needs fast-simplification: pip install 'proxyproof[simplify]'") from None
    if len(triangles) <= SIMPLE:
        return vertices, triangles
    points, faces = np.array(vertices, order="C"), np.array(triangles, dtype=np.int32, order="C")
    corners, kept = merged(*fast_simplification.simplify(points, faces, target_count=SIMPLE))
    kept = _without_degenerate(corners, kept)[1]
    _, which, times = np.unique(np.sort(kept, axis=1), axis=0, return_inverse=True, return_counts=True)
    return corners, kept[times[which.reshape(-1)] == 1]


REPAIRS: dict[str, Callable[[Array, Triangles], Mesh]] = {
    "merge_near": _merged_near,
    "drop_degenerate": _without_degenerate,
    "drop_duplicates": _without_doubles,
    "drop_crossing": _without_crossing,
    "keep_largest": _largest_surface,
    "turn_outwards": _turned_outwards,
    "fill_holes": _filled_holes,
    "simplify": _simplified,
    "hull": _hull,
}
"""What can be done about a mesh, by name.

Near vertices become one; faces without area, given twice, or crossing others are left out; of several surfaces the
largest stays; faces turned over are turned back; open rims are closed; a mesh of more faces than `SIMPLE` gets so
many; the convex hull takes the mesh's place.
"""
