"""Pairs of polytopes, and of polytopes with points, segments and half-spaces.

Spheres and capsules are points and segments, widened afterwards. The search itself is a scalar kernel
(`refimpl.kernels.polytopes_batch`); here proxies are turned into the rows that it reads.
"""

from __future__ import annotations

from functools import cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from refimpl.algorithms.halfspaces import lowest_against_plane, unit_plane
from refimpl.algorithms.rounds import grown
from refimpl.compiling import is_compiled, module_for, numbers
from refimpl.derived import Derived
from refimpl.hulls import Hull, hull_of_box
from refimpl.kernels.boxes import ALIGNED, SEGMENT, TURNED
from refimpl.kernels.polytopes import BOX, FACE, FACTOR, FIRST, GRID
from refimpl.kernels.polytopes_batch import NOTE, PLACED, POINT, STANDING, Side
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.kernels.polytopes_pair import FEATURES
from refimpl.kernels.scaling import NOTHING
from refimpl.linear import Array, Bools, apply, apply_inverse, dot, norm, power_of_two, rotation_matrix, unit_or
from refimpl.results import Separation
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, HalfSpace, Point, Proxy, Sphere
from refimpl.signs import Indices

STILL = np.eye(3)
KINDS: dict[type[Proxy], int] = {
    Point: POINT, Sphere: POINT, Capsule: SEGMENT, AABB: ALIGNED, Box: TURNED
}  # fmt: skip
MANY = 32
"""A polytope with more vertices gets a directory of them."""
MIDDLES = (np.arange(GRID) + 0.5) * (2.0 / GRID) - 1.0
CORNERS = np.arange(8)[:, None] >> np.arange(3) & 1
"""Corner number i of a box lies ahead along those of its edges of which i has the bit."""
SKEW = 2.0**-50
"""Part of the coordinates by which the corners of a box may miss their places."""
LARGE = 1000
"""A row of so many numbers makes one pair as much work as two small ones, and worth compiling for accordingly."""


def geometry_rows(hulls: Hull) -> tuple[Array, Array]:
    """Rows of a table of hulls, relative to the middles of their bounding boxes, and those middles.

    A face's offset is that of the farthest rounded vertex, so that both tell of the same polytope. What a hull
    repeats to be as long as others of its table is not counted.
    """
    vertices, edges, are_boxes = _boxes_first(hulls)
    middle = np.min(vertices, axis=1) / 2 + np.max(vertices, axis=1) / 2
    inner, normals = vertices - middle[:, None, :], hulls.planes[..., :3]
    offsets = np.stack([np.max(dot(inner, normals[:, i, None, :]), axis=1) for i in range(normals.shape[1])], axis=1)
    faces = np.concatenate([normals, offsets[..., None], np.zeros((*offsets.shape, FACE - 4))], axis=-1)
    start, end = (np.take_along_axis(inner, np.repeat(edges[..., i, None], 3, axis=2), axis=1) for i in (0, 1))
    sides = (np.take_along_axis(normals, np.repeat(edges[..., i, None], 3, axis=2), axis=1) for i in (2, 3))
    chords = norm(next(sides) - next(sides))[..., None]
    links = np.concatenate([edges, unit_or(end - start, STILL[0])[0], chords], axis=-1)
    parts = [inner, faces, links]
    counts = np.stack([_different(hulls.vertices), _different(hulls.planes), _different(edges)], axis=1)
    starts = np.zeros((len(inner), 3))
    starts[:] = FIRST + np.cumsum([p.shape[1] * p.shape[2] for p in parts])
    many = counts[:, 0] > MANY
    starts[:, 2] *= many
    starts[are_boxes, 2] = BOX
    flat = [p.reshape(len(p), p.shape[1] * p.shape[2]) for p in parts]
    if many.any():
        flat.append(_directory(inner))
    centre = hulls.middle - middle
    return np.concatenate([counts, centre, starts, *flat], axis=1), middle


def _boxes_first(hulls: Hull) -> tuple[Array, Indices, Bools]:
    """Vertices and edges, and which hulls are boxes, however skew: their vertices are put in the order of a box's."""
    vertices, edges = hulls.vertices.copy(), hulls.edges.copy()
    boxes: Bools = (_different(vertices) == 8) & (_different(hulls.planes) == 6) & (_different(edges) == 12)
    for i in np.flatnonzero(boxes):
        corners, ends = vertices[i, :8], edges[i, :12, :2]
        steps = corners[[sum(pair) for pair in ends if 0 in pair]] - corners[0]
        wanted = corners[0] + CORNERS @ steps
        order = np.argmin(np.max(np.abs(wanted[:, None] - corners), axis=2), axis=1)
        boxes[i] = np.max(np.abs(wanted - corners[order])) <= SKEW * np.max(np.abs(corners))
        if boxes[i]:
            vertices[i, :8] = corners[order]
            ends[:] = np.argsort(order)[ends.astype(np.int64)]
    return vertices, edges, boxes


def _directory(vertices: Array) -> Array:
    """Farthest vertices (g, cells) along the directions through the middles of the directory's cells."""
    u, v = np.stack(np.meshgrid(MIDDLES, MIDDLES, indexing="ij")).reshape(2, -1)
    one = np.ones_like(u)
    sides = [(s * one, u, v) for s in (1, -1)] + [(v, s * one, u) for s in (1, -1)] + [(u, v, s * one) for s in (1, -1)]
    cells = np.concatenate([np.stack(side, axis=-1) for side in sides])
    found = [np.argmax(dot(vertices, cell), axis=1) for cell in cells]
    return np.stack(found, axis=1).astype(np.float64)


def _different(rows: Any) -> Any:
    """How many rows come before the last one's repetitions, and it."""
    if rows.shape[1] == 0:
        return np.zeros(len(rows))
    other = np.any(rows != rows[:, -1:], axis=-1)
    return rows.shape[1] - np.argmax(other[:, ::-1], axis=1) + 1.0 - np.where(other.any(axis=1), 0.0, rows.shape[1])


_known: WeakKeyDictionary[Hull, tuple[Array, Array]] = WeakKeyDictionary()


def table_of(derived: Derived) -> tuple[Array, Array]:
    """Rows of a table of derived hulls, each brought to a size of about 1, and a note on each; found once."""
    table = derived.table
    if table not in _known:
        power = power_of_two(table.size)
        rows, middles = geometry_rows(table.times_power(-power))
        power = np.where(table.size > 0, power, NOTHING)
        _known[table] = rows, np.concatenate([middles, power[:, None], derived.digests], axis=1)
    return _known[table]


@cache
def own_row(kind: int) -> Array:
    """Row of the box from −1 to 1, of a segment, or of a point."""
    if kind == POINT:
        return np.array([1.0, 0, 0, 0, 0, 0, FIRST + 3, FIRST + 3, 0, 0, 0, 0])
    if kind == SEGMENT:
        return np.array([2.0, 0, 1, 0, 0, 0, FIRST + 6, FIRST + 6, 0, 0, 0, 0, 0, 0, 0, 0, 1, -1, -1, 0, 0, 0, 0])
    return np.array(geometry_rows(hull_of_box(-np.ones((1, 3)), np.ones((1, 3))))[0][0])


def side(x: Proxy) -> Side:
    """Rows of a batch of proxies as the kernel reads them; of spheres and capsules the centres and the axes."""
    count = len(x)
    columns: list[Any]
    if isinstance(x, (KDOP, ConvexPolyhedron)):
        derived = x.derived()
        rows = np.zeros((count, 0)) if isinstance(x, KDOP) else np.concatenate([x.position, x.rotation], axis=1)
        geometries, notes = table_of(derived)
        index = [np.array(column, dtype=np.int64) for column in (derived.which, derived.exponent)]
        columns = [rows.reshape(-1), rows.shape[1], geometries, notes.reshape(-1), *index, own_row(POINT)]
        return Side(STANDING if isinstance(x, KDOP) else PLACED, *columns)
    kind, rows, none = KINDS[type(x)], x.pack(), np.zeros(count, dtype=np.int64)
    own = own_row(kind)
    columns = [rows.reshape(-1), rows.shape[1], own[None], np.zeros(NOTE), none, none, own.copy()]
    return Side(kind, *columns)


def _as_lists(found: Any) -> Side:
    """Give the same as lists, without the geometries that none of the batch has."""
    used, which = np.unique(found.which, return_inverse=True)
    columns = (found.geometries[used], found.notes.reshape(-1, NOTE)[used].reshape(-1), which, found.powers, found.own)
    return Side(found.kind, found.rows.tolist(), found.width, *(column.tolist() for column in columns))


def separate(a: Proxy, b: Proxy) -> Separation:
    """Signed distance of the cores of two batches of proxies, of which each is a polytope, a segment or a point.

    Each pair is scaled by itself, so the batches may come as they are.
    """
    x, y = side(a), side(b)
    count, width = len(a), max(np.shape(s.geometries)[1] for s in (x, y))
    module = module_for("polytopes_batch", count * (1 + width // LARGE))
    if not is_compiled(module):
        x, y = _as_lists(x), _as_lists(y)
    room = [np.zeros(n) for n in (FACTOR + 1, FACTOR + 1, width, width, ROOM, width + FEATURES, width)]
    answers = numbers(np.zeros((count, 10)), module)
    module.separations(x, y, *(numbers(r, module) for r in room), answers)
    found = np.array(answers).reshape(count, 10)
    return Separation(found[:, 0], found[:, 4:7], found[:, 7:10], found[:, 1:4])


def _point_first(x: Point, b: Proxy) -> Separation:
    found = separate(x, b)
    return Separation(found.distance, x.position, found.on_b, found.normal)


def point_kdop(x: Point, b: KDOP) -> Separation:
    """Signed distance of a point from a k-DOP; inside, to the nearest face. Finite: closest features."""
    return _point_first(x, b)


def point_convexpolyhedron(x: Point, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a point from a convex polyhedron; inside, to the nearest face. Finite: closest features."""
    return _point_first(x, b)


def _widened(s: Sphere | Capsule, b: Proxy) -> Separation:
    return grown(separate(s, b), s.radius, np.zeros_like(s.radius))


def sphere_kdop(s: Sphere, b: KDOP) -> Separation:
    """Signed distance of a ball and a k-DOP: that of the centre, widened. Finite."""
    return _widened(s, b)


def sphere_convexpolyhedron(s: Sphere, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a ball and a convex polyhedron: that of the centre, widened. Finite."""
    return _widened(s, b)


def capsule_kdop(c: Capsule, b: KDOP) -> Separation:
    """Signed distance of a capsule and a k-DOP: that of the axis, a polytope of two vertices, widened. Finite."""
    return _widened(c, b)


def capsule_convexpolyhedron(c: Capsule, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a capsule and a convex polyhedron: that of the axis, widened. Finite."""
    return _widened(c, b)


def _above_plane(h: HalfSpace, b: KDOP | ConvexPolyhedron) -> Separation:
    """Signed distance of a half-space and a polytope: its lowest vertex decides."""
    n, _ = unit_plane(h)
    derived = b.derived()
    vertices = derived.table.vertices[derived.which]
    matrix = rotation_matrix(b.rotation) if isinstance(b, ConvexPolyhedron) else np.broadcast_to(STILL, (len(b), 3, 3))
    heights = dot(vertices, apply_inverse(matrix, n)[:, None, :])
    first = np.argmin(heights, axis=1)
    lowest = np.ldexp(vertices[np.arange(len(b)), first], derived.exponent[:, None])
    place = b.position + apply(matrix, lowest) if isinstance(b, ConvexPolyhedron) else lowest
    return lowest_against_plane(h, place, np.zeros(len(h))).flipped()


def halfspace_kdop(h: HalfSpace, b: KDOP) -> Separation:
    """Signed distance of a half-space and a k-DOP: its lowest vertex decides. Finite."""
    return _above_plane(h, b)


def halfspace_convexpolyhedron(h: HalfSpace, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a half-space and a convex polyhedron: its lowest vertex decides. Finite."""
    return _above_plane(h, b)


def aabb_kdop(a: AABB, b: KDOP) -> Separation:
    """Signed distance of an axis-aligned box and a k-DOP. Finite: closest features, separating axes."""
    return separate(a, b)


def aabb_convexpolyhedron(a: AABB, b: ConvexPolyhedron) -> Separation:
    """Signed distance of an axis-aligned box and a convex polyhedron. Finite: closest features, separating axes."""
    return separate(a, b)


def box_kdop(a: Box, b: KDOP) -> Separation:
    """Signed distance of a box and a k-DOP. Finite: closest features, separating axes."""
    return separate(a, b)


def box_convexpolyhedron(a: Box, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a box and a convex polyhedron. Finite: closest features, separating axes."""
    return separate(a, b)


def kdop_kdop(a: KDOP, b: KDOP) -> Separation:
    """Signed distance of two k-DOPs, whose directions need not be the same. Finite: features, separating axes."""
    return separate(a, b)


def kdop_convexpolyhedron(a: KDOP, b: ConvexPolyhedron) -> Separation:
    """Signed distance of a k-DOP and a convex polyhedron. Finite: closest features, separating axes."""
    return separate(a, b)


def convexpolyhedron_convexpolyhedron(a: ConvexPolyhedron, b: ConvexPolyhedron) -> Separation:
    """Signed distance of two convex polyhedra. Finite: closest features, separating axes."""
    return separate(a, b)
