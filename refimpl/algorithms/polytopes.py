"""Pairs of polytopes, and of polytopes with points, segments and half-spaces.

Spheres and capsules are points and segments, widened afterwards. The search itself is a scalar kernel
(`refimpl.kernels.polytopes_pair`); here proxies are turned into the rows that it reads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.algorithms.halfspaces import lowest_against_plane, unit_plane
from refimpl.algorithms.rounds import grown
from refimpl.compiling import is_compiled, module_for, numbers
from refimpl.hulls import Hull, hull_of_box
from refimpl.kernels.axes import REMEMBERED
from refimpl.kernels.polytopes import EDGE, FACE, FIRST
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.linear import Array, apply, dot, rotation_matrix, scale, unit_or
from refimpl.results import Separation
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, HalfSpace, Point, Proxy, Sphere

Indices = NDArray[np.int64]
STILL = np.eye(3)
LARGE = 64
"""Work counts as that of so many small pairs when a polytope has that many times this number of vertices."""


@dataclass(frozen=True)
class Polytopes:
    """A batch of polytopes as the kernel reads them.

    Attributes
    ----------
    geometry : (g, width)
        Rows of different geometries, as `refimpl.kernels.polytopes` describes them.
    which : (n,) int
        The geometry of each.
    pose : (n, 13)
        Origin, rotation matrix row by row, and the factor by which the geometry is to be multiplied.
    """

    geometry: Array
    which: Indices
    pose: Array


def _shared(a: Any) -> bool:
    return len(a) > 1 and a.strides[0] == 0


def geometry_rows(hull: Hull) -> tuple[Array, Array]:
    """Rows of a batch of hulls, relative to the middles of their bounding boxes, and those middles.

    A face's offset is that of the farthest rounded vertex, so that both tell of the same polytope.
    """
    vertices, edges = hull.vertices, hull.edges
    count = len(vertices)
    middle = np.min(vertices, axis=1) / 2 + np.max(vertices, axis=1) / 2
    inner = vertices - middle[:, None, :]
    normals = np.broadcast_to(hull.planes[..., :3], (count, *hull.planes.shape[1:-1], 3))
    heights = inner[:, None, :, :] * normals[:, :, None, :]
    offsets = np.max((heights[..., 0] + heights[..., 1]) + heights[..., 2], axis=-1)
    faces = np.concatenate([normals, offsets[..., None], np.zeros((*offsets.shape, 1))], axis=-1)
    ends = (np.take_along_axis(inner, np.broadcast_to(edges[..., i, None], (*edges.shape[:2], 3)), 1) for i in (0, 1))
    start, end = ends
    ways = unit_or(end - start, STILL[0])[0]
    links = np.broadcast_to(edges, (count, *edges.shape[1:])).astype(np.float64)
    sizes = np.array([inner.shape[1], faces.shape[1], links.shape[1]], dtype=np.float64)
    centre = np.cumsum(inner, axis=1)[:, -1] / inner.shape[1]  # one by one: the same bits in any batch
    parts = [np.broadcast_to(sizes, (count, 3)), centre, inner, faces]
    parts.append(np.concatenate([links, ways], axis=-1))
    return np.concatenate([p.reshape(count, -1) for p in parts], axis=1), middle


def _of_hull(x: Any) -> tuple[Hull, Any]:
    """Hull of a polytope, and the exponent of the power of two by which it is scaled."""
    if hasattr(x, "hull_and_exponent"):
        hull, exponent = x.hull_and_exponent()
        return hull, exponent
    return x.hull, np.zeros(len(x), dtype=np.int64)


def polytopes(x: Proxy) -> Polytopes:
    """Rows of a batch of proxies; of spheres and capsules the centres and the axes."""
    count = len(x)
    origin, matrix, exponent = x.reference_point, np.broadcast_to(STILL, (count, 3, 3)), np.zeros(count, dtype=np.int64)
    match x:
        case Point() | Sphere():
            geometry = np.array([[1.0, 0, 0, 0, 0, 0, 0, 0, 0]])
        case Capsule():
            geometry = _segments(x.p - origin, x.q - origin)
        case AABB():
            geometry = _boxes(x.lower - origin, x.upper - origin)
        case Box():
            geometry = _boxes(-x.half_extents, x.half_extents)
            matrix = rotation_matrix(x.rotation)
        case _:
            hull, exponent = _of_hull(x)
            one = _shared(hull.vertices) and _shared(hull.planes)
            geometry, middle = geometry_rows(hull.mapped(lambda a, _: a[:1]) if one else hull)
            middle = np.ldexp(np.broadcast_to(middle, (count, 3)), exponent[:, None])
            if isinstance(x, ConvexPolyhedron):
                matrix = rotation_matrix(x.rotation)
                origin = x.position + apply(matrix, middle)
            else:
                origin = middle
    which = np.arange(count) if len(geometry) == count else np.zeros(count, dtype=np.int64)
    pose = np.concatenate([origin, matrix.reshape(count, 9), np.ldexp(1.0, exponent)[:, None]], axis=1)
    return Polytopes(geometry, which, pose)


def _segments(p: Array, q: Array) -> Array:
    """Rows of segments: two vertices, and an edge without faces."""
    sizes = np.broadcast_to(np.array([2.0, 0, 1, 0, 0, 0]), (len(p), FIRST))
    link = np.broadcast_to(np.array([0.0, 1, -1, -1]), (len(p), 4))
    return np.concatenate([sizes, p, q, link, unit_or(q - p, STILL[0])[0]], axis=1)


def _template() -> tuple[Array, Array, Array]:
    """Row of the box from −1 to 1, and where its vertices and its faces' offsets are."""
    row = geometry_rows(hull_of_box(-np.ones((1, 3)), np.ones((1, 3))))[0]
    vertices = np.arange(FIRST, FIRST + 24)
    offsets = np.arange(FIRST + 24 + 3, FIRST + 24 + 6 * FACE, FACE)
    return row, vertices, offsets


def _boxes(lower: Array, upper: Array) -> Array:
    """Rows of boxes."""
    row, vertices, offsets = _template()
    rows = np.repeat(row, len(lower), axis=0)
    corner = row[0, vertices].reshape(8, 3)
    rows[:, vertices] = np.where(corner > 0, upper[:, None, :], lower[:, None, :]).reshape(-1, 24)
    rows[:, offsets] = np.concatenate([upper, -lower], axis=1)
    return rows


def separate(a: Proxy, b: Proxy) -> Separation:
    """Signed distance of the cores of two batches of proxies, of which each is a polytope, a segment or a point."""
    x, y = polytopes(a), polytopes(b)
    count = len(x.pose)
    work = count * (1 + (x.geometry.shape[1] + y.geometry.shape[1]) // (LARGE * EDGE))
    module = module_for("polytopes_pair", work)
    rows = (x.geometry, x.which, x.pose, y.geometry, y.which, y.pose)
    width = max(x.geometry.shape[1], y.geometry.shape[1])
    room = [np.zeros(n) for n in (width, width, ROOM, width + 96 + REMEMBERED)]
    answers = numbers(np.zeros((count, 10)), module)
    module.separations(*(numbers(r, module) for r in (*rows, *room)), answers)
    found = np.asarray(answers) if is_compiled(module) else np.array(answers).reshape(count, 10)
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
    hull, exponent = _of_hull(b)
    if isinstance(b, ConvexPolyhedron):
        matrix, position = rotation_matrix(b.rotation), b.position
        turned = np.swapaxes(matrix, -1, -2)
        down = apply(turned, n)
    else:
        matrix, position, down = np.broadcast_to(STILL, (len(b), 3, 3)), np.zeros((len(b), 3)), n
    heights = dot(hull.vertices, down[:, None, :])
    first = np.argmin(heights, axis=1)[:, None, None]
    lowest = np.take_along_axis(np.broadcast_to(hull.vertices, (*heights.shape, 3)), first, axis=1)[:, 0]
    place = position + apply(matrix, scale(np.ldexp(1.0, exponent), lowest))
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
