"""When a triangle mesh bounds a solid, and where it fails to.

The surface must be closed (every edge belongs to two faces), oriented (which run through it in opposite ways),
embedded (faces meet only in the corners and edges that they share) and outward (anticlockwise from outside; a cavity's
faces look into the cavity). Then every point has winding number 0 or 1, and the solid is where it is 1. Every
decision is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array, Bools
from refimpl.proxy import ShapeError
from refimpl.signs import Indices, Points, Signs

Triangles = NDArray[np.int64]
FEW = 64
"""Of no more faces each is compared with each."""
MANY, ASKED, MOST_PAIRS = 10_000, 64, 30_000_000
"""Of more than `MANY` faces it is estimated, by `ASKED` of them, whether more pairs are near than can be compared."""


class MeshError(ShapeError):
    """A mesh bounds no solid; the text says where."""


def require_solid(vertices: Array, triangles: Triangles) -> None:
    """Raise `MeshError` unless a mesh bounds a solid.

    Parameters
    ----------
    vertices : (m, 3), finite
    triangles : (t, 3) int
        Corners of each face, anticlockwise seen from outside.

    Raises
    ------
    MeshError
        Naming the first face, edge or pair of faces that is wrong, with indices and coordinates.
    """
    _require_indices(vertices, triangles)
    points = Points(vertices)
    _require_area(points, vertices, triangles)
    _require_closed(vertices, triangles)
    _require_embedded(points, vertices, triangles)
    _require_outward(points, vertices, triangles)


def _place(vertices: Array, index: int) -> str:
    return f"vertex {index} {tuple(vertices[index].tolist())}"


def _face(vertices: Array, triangles: Triangles, index: int) -> str:
    corners = ", ".join(_place(vertices, i) for i in triangles[index].tolist())
    return f"face {index} [{corners}]"


def _require_indices(vertices: Array, triangles: Triangles) -> None:
    if len(triangles) == 0:
        raise MeshError("the mesh has no faces")
    wrong = np.argwhere((triangles < 0) | (triangles >= len(vertices)))
    if len(wrong):
        face, corner = wrong[0].tolist()
        raise MeshError(f"face {face} names vertex {triangles[face, corner]}, but there are {len(vertices)} vertices")
    unused = np.setdiff1d(np.arange(len(vertices)), triangles)
    if len(unused):
        raise MeshError(f"{_place(vertices, int(unused[0]))} belongs to no face ({len(unused)} such vertices)")


def _require_area(points: Points, vertices: Array, triangles: Triangles) -> None:
    a, b, c = triangles.T
    flat = np.ones(len(triangles), dtype=bool)
    for axis in range(3):
        flat &= points.turn(a, b, c, np.full(len(a), axis)) == 0
    if np.any(flat):
        face = int(np.argmax(flat))
        raise MeshError(f"{_face(vertices, triangles, face)} has no area ({np.sum(flat)} such faces)")


def directed_edges(triangles: Triangles) -> tuple[Indices, Indices]:
    """Edges (from, to), shape (3t, 2), as the faces run through them, and the face of each."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return edges, np.tile(np.arange(len(triangles)), 3)


def _require_closed(vertices: Array, triangles: Triangles) -> None:
    edges, faces = directed_edges(triangles)
    width = len(vertices)
    there, back = edges[:, 0] * width + edges[:, 1], edges[:, 1] * width + edges[:, 0]
    _, inverse, count = np.unique(there, return_inverse=True, return_counts=True)
    twice = np.flatnonzero(count[inverse] > 1)
    alone = np.flatnonzero(~np.isin(back, there))
    for kind, wrong in ((_doubled, twice), (_open, alone)):
        if len(wrong):
            edge = edges[wrong[0]].tolist()
            here = np.unique(faces[np.all(np.sort(edges, axis=1) == np.sort(edge), axis=1)]).tolist()
            ends = f"the edge from {_place(vertices, edge[0])} to {_place(vertices, edge[1])}"
            raise MeshError(kind(ends, here) + f" ({len(wrong)} such edges)")


def _doubled(ends: str, faces: list[int]) -> str:
    named = ", ".join(map(str, faces))
    if len(faces) == 2:
        return f"flipped: {ends} is run through in the same way by its faces {named}; one of them is turned over"
    return f"not a surface: {ends} belongs to {len(faces)} faces: {named}"


def _open(ends: str, faces: list[int]) -> str:
    return f"open: {ends} belongs only to face {faces[0]}"


def _require_embedded(points: Points, vertices: Array, triangles: Triangles) -> None:
    first, second, number = crossings(points, triangles)
    if len(first):
        f, g = (_face(vertices, triangles, int(i[0])) for i in (first, second))
        how = "twice the same face" if number[0] == 3 else "self-intersecting"
        raise MeshError(f"{how}: {f} and {g} meet beyond the corners they share ({len(first)} such pairs)")


def crossings(points: Points, triangles: Triangles) -> tuple[Indices, Indices, Indices]:
    """Pairs of faces that meet beyond the corners they share, and how many corners those are; exact."""
    first, second = _near_faces(points.near[triangles])
    shared = triangles[first][:, :, None] == triangles[second][:, None, :]
    number = shared.sum(axis=(1, 2))
    bad = number == 3
    for rows, test in ((number == 0, _crossing), (number == 1, _crossing_opposite), (number == 2, _folded)):
        chosen = np.flatnonzero(rows)
        if len(chosen):
            bad[chosen] = test(points, triangles[first[chosen]], triangles[second[chosen]], shared[chosen])
    return first[bad], second[bad], number[bad]


def _near_faces(corners: Array) -> tuple[Indices, Indices]:
    """Pairs i < j of faces whose boxes meet, sorted."""
    from refimpl.broadphase import BruteForce, Octree  # noqa: PLC0415  the package needs shapes, and those need meshes

    lower, upper = corners.min(axis=1), corners.max(axis=1)
    if len(corners) > MANY:
        _require_few_pairs(lower, upper)
    structure = BruteForce() if len(corners) <= FEW else Octree()
    first, second = structure.build(lower, upper).pairs().T
    return first, second


def _require_few_pairs(lower: Array, upper: Array) -> None:
    """Refuse boxes that lie on one another by the thousand: their pairs would fill the memory."""
    asked = np.random.default_rng(0).integers(len(lower), size=ASKED)
    met = sum(int(np.sum(np.all((lower <= upper[i]) & (upper >= lower[i]), axis=1))) - 1 for i in asked)
    pairs = met / ASKED * len(lower) / 2
    if pairs > MOST_PAIRS:
        raise MeshError(
            f"crowded: each of the {len(lower)} faces is near about {met // ASKED} others, too many to compare"
        )


def _crossing(points: Points, f: Triangles, g: Triangles, _: Bools) -> Bools:
    """Faces without common corners: they meet when an edge of one meets the other."""
    found = np.zeros(len(f), dtype=bool)
    for one, other in ((f, g), (g, f)):
        for i in range(3):
            rows = np.flatnonzero(~found)
            found[rows] = segment_meets_triangle(points, one[rows, i], one[rows, (i + 1) % 3], other[rows])
    return found


def _crossing_opposite(points: Points, f: Triangles, g: Triangles, shared: Bools) -> Bools:
    """Faces with one common corner: whatever else they share reaches the edge opposite to it in one of them."""
    found = np.zeros(len(f), dtype=bool)
    rows = np.arange(len(f))
    for one, other, corner in (
        (f, g, np.argmax(shared.any(axis=2), axis=1)),
        (g, f, np.argmax(shared.any(axis=1), axis=1)),
    ):
        p, q = one[rows, (corner + 1) % 3], one[rows, (corner + 2) % 3]
        found |= segment_meets_triangle(points, p, q, other)
    return found


def _folded(points: Points, f: Triangles, g: Triangles, shared: Bools) -> Bools:
    """Faces with a common edge: they overlap when one is folded flat onto the other."""
    rows = np.arange(len(f))
    corner = np.argmin(shared.any(axis=2), axis=1)
    apex = g[rows, np.argmin(shared.any(axis=1), axis=1)]
    a, p, q = f[rows, corner], f[rows, (corner + 1) % 3], f[rows, (corner + 2) % 3]
    flat = points.orientation(a, p, q, apex) == 0
    dropped, _ = _seen_along(points, f)
    return np.asarray(flat & (points.turn(p, q, a, dropped) == points.turn(p, q, apex, dropped)))


def _seen_along(points: Points, triangles: Triangles) -> tuple[Indices, Signs]:
    """An axis along which each triangle is seen with some area, and the sign of that area."""
    a, b, c = triangles.T
    x = points.near[triangles]
    normal = np.abs(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))
    axis = np.argmax(normal, axis=1)
    sign = points.turn(a, b, c, axis)
    for other in (1, 2):  # the largest in doubles may in truth be 0
        again = sign == 0
        axis = np.where(again, (np.argmax(normal, axis=1) + other) % 3, axis)
        if np.any(again):
            sign = points.turn(a, b, c, axis)
    return axis, sign


def segment_meets_triangle(points: Points, p: Indices, q: Indices, triangles: Triangles) -> Bools:
    """Whether closed segments pq meet closed triangles, row by row; exact."""
    a, b, c = triangles.T
    side_p, side_q = points.orientation(a, b, c, p), points.orientation(a, b, c, q)
    flat = (side_p == 0) & (side_q == 0)
    found = np.zeros(len(p), dtype=bool)
    rows = np.flatnonzero((side_p * side_q <= 0) & ~flat)
    if len(rows):
        u, v, x, y, z = p[rows], q[rows], a[rows], b[rows], c[rows]
        turns = [points.orientation(u, v, *edge) for edge in ((x, y), (y, z), (z, x))]
        found[rows] = (np.min(turns, axis=0) >= 0) | (np.max(turns, axis=0) <= 0)
    rows = np.flatnonzero(flat)
    if len(rows):
        found[rows] = _meets_in_plane(points, p[rows], q[rows], triangles[rows])
    return found


def _meets_in_plane(points: Points, p: Indices, q: Indices, triangles: Triangles) -> Bools:
    """The same, for a segment in the triangle's plane: no line along any of the four sides parts them."""
    dropped, around = _seen_along(points, triangles)
    apart = np.zeros(len(p), dtype=bool)
    corners = list(triangles.T)
    for i in range(3):
        a, b = corners[i], corners[(i + 1) % 3]
        apart |= (points.turn(a, b, p, dropped) * around < 0) & (points.turn(a, b, q, dropped) * around < 0)
    sides = [points.turn(p, q, corner, dropped) for corner in corners]
    return np.asarray(~(apart | (np.min(sides, axis=0) > 0) | (np.max(sides, axis=0) < 0)))


def shells(triangles: Triangles, vertices: int) -> NDArray[np.int64]:
    """Number of the connected surface that each face belongs to, by edges; shape (t,)."""
    edges, faces = directed_edges(triangles)
    key = np.minimum(edges[:, 0], edges[:, 1]) * vertices + np.maximum(edges[:, 0], edges[:, 1])
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    one, other = faces[order][:-1][same], faces[order][1:][same]
    label = np.arange(len(triangles))
    while True:  # every face takes the least label of its neighbours, and labels follow labels
        before = label.copy()
        np.minimum.at(label, one, label[other])
        np.minimum.at(label, other, label[one])
        label = label[label]
        if np.array_equal(before, label):
            return np.asarray(np.unique(label, return_inverse=True)[1])


def _require_outward(points: Points, vertices: Array, triangles: Triangles) -> None:
    shell = shells(triangles, len(vertices))
    number = int(shell.max()) + 1
    for i in range(number):
        own = triangles[shell == i]
        outward = six_volumes(points, own) > 0
        others = triangles[shell != i]
        start = int(own[0, 0])
        if number > 1 and np.any(others == start):  # surfaces may touch in a corner; all corners in common is a defect
            free = np.setdiff1d(own, others)
            start = int(free[0]) if len(free) else start
        around = int(winding_numbers(points.near[others], points.near[start][None])[0])
        if around == (0 if outward else 1):
            continue
        face = _face(vertices, triangles, int(np.argmax(shell == i)))
        if around not in {0, 1}:
            raise MeshError(f"nested: {face} lies where the other surfaces already count {around} times")
        way = "looks inwards" if not outward else "looks outwards, but lies inside another surface"
        raise MeshError(f"flipped: the closed surface of {np.sum(shell == i)} faces around {face} {way}")


def six_volumes(points: Points, triangles: Triangles) -> int:
    """Six times the enclosed volume in units of the grid's cube; exact."""
    g = points.grid
    total = 0
    for i, j, k in triangles.tolist():
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = g[i], g[j], g[k]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total


def winding_numbers(corners: Array, at: Array, bounds: tuple[Array, Array] | None = None) -> NDArray[np.int64]:
    """How often a closed surface winds around points that are not on it; exact.

    Counts the faces above each point, by their orientation. A point is taken as if shifted by (ε, ε², 0), so that no
    edge or corner is right above it.

    Parameters
    ----------
    corners : (t, 3, 3)
        Corners of the faces.
    at : (n, 3)
    bounds : pair of (t, 3), optional
        Lower and upper corners of the faces' boxes, where they are known.
    """
    low, high = (corners.min(axis=1), corners.max(axis=1)) if bounds is None else bounds
    x, y, z = (at[:, None, i] for i in range(3))
    over = (low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 1] <= y) & (y <= high[:, 1]) & (high[:, 2] >= z)
    point, face = np.nonzero(over)
    points = Points(np.concatenate([corners[face].reshape(-1, 3), at]))
    a, b, c = (np.arange(len(face)) * 3 + i for i in range(3))
    here = 3 * len(face) + point
    turns = [_shifted_turn(points, u, v, here) for u, v in ((a, b), (b, c), (c, a))]
    inside = (turns[0] == turns[1]) & (turns[1] == turns[2])
    below = points.orientation(a, b, c, here) * turns[0] < 0
    found = np.zeros(len(at), dtype=np.int64)
    np.add.at(found, point[inside & below], turns[0][inside & below].astype(np.int64))
    return found


def _shifted_turn(points: Points, a: Indices, b: Indices, p: Indices) -> Signs:
    """Sign of the area of abp seen from above, for p shifted by (ε, ε²); 0 only where a and b are one."""
    x, y = points.near[:, 0], points.near[:, 1]
    turn = points.turn(a, b, p, np.full(len(a), 2))
    turn = np.where(turn != 0, turn, np.sign(y[a] - y[b]).astype(np.int8))
    return np.asarray(np.where(turn != 0, turn, np.sign(x[b] - x[a]).astype(np.int8)))
