"""Ellipsoids and cylinders against everything convex.

Against a half-space, the lowest point along the plane's normal decides; against all others, one search serves every
pair (`refimpl.kernels.curved`): projection for a point or a ball, else the closest points of the cores, and the
expanding polytope with Newton's method where the cores overlap.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from refimpl import compiling
from refimpl.algorithms.halfspaces import lowest_against_plane, unit_plane
from refimpl.algorithms.rows import body_rows
from refimpl.kernels import expanding
from refimpl.kernels.gjk import SIMPLEX
from refimpl.linear import Array, apply, apply_inverse, cross, dot, perpendicular, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy
from refimpl.results import Separation, where
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, Cylinder, Ellipsoid, HalfSpace, Point, Sphere


def separation(a: Proxy, b: Proxy) -> Separation:
    """Signed distance of two batches of convex proxies, at least one of each pair curved.

    Parameters
    ----------
    a, b
        With one batch axis of the same length.
    """
    origin = a.reference_point
    rows_a, rows_b = body_rows(a, origin), body_rows(b, origin)
    n = len(rows_a)
    module = compiling.module_for("curved", n)
    out = np.zeros((n, 10))
    answers = out if compiling.is_compiled(module) else out.tolist()
    width = max(rows_a.shape[1], rows_b.shape[1], 24)
    work = [compiling.buffer(size, module) for size in (SIMPLEX, expanding.POINTS, expanding.PLANES)]
    whole = [compiling.buffer(size, module, whole=True) for size in (expanding.FACETS, expanding.SCRATCH)]
    faces = [compiling.buffer(width, module) for _ in range(2)]
    rows = [compiling.numbers(r, module) for r in (rows_a, rows_b)]
    module.separations(*rows, answers, *work, *whole, *faces)
    found = np.asarray(answers).reshape(n, 10)
    return Separation(found[:, 0], origin + found[:, 4:7], origin + found[:, 7:10], found[:, 1:4])


def halfspace_ellipsoid(h: HalfSpace, e: Ellipsoid) -> Separation:
    """Signed distance of a half-space and an ellipsoid: its lowest point decides. Closed form.

    The lowest point along the plane's normal n is center − R D² Rᵀ n / ‖D Rᵀ n‖, D the radii. Unique.
    """
    n, _ = unit_plane(h)
    matrix = rotation_matrix(e.rotation)
    stretched = e.radii * apply_inverse(matrix, n)
    lowest = apply(matrix, e.radii * unit_or(stretched, stretched)[0])
    return lowest_against_plane(h, e.center - lowest, np.zeros(len(h))).flipped()


def halfspace_cylinder(h: HalfSpace, c: Cylinder) -> Separation:
    """Signed distance of a half-space and a cylinder: the lowest point of its lower rim decides. Closed form.

    Not unique when the axis is parallel to the plane (`p` is the lower end then) or at right angles to it.
    """
    n, _ = unit_plane(h)
    axis = unit_or(c.q - c.p, n)[0]
    # n less its part along the axis, so that nothing cancels where the two are nearly parallel
    sideways = cross(axis, cross(n, axis))
    down = unit_or(sideways, perpendicular(axis))[0]
    end = where(dot(n, axis) < 0, c.q, c.p)
    return lowest_against_plane(h, end - scale(c.radius, down), np.zeros(len(h))).flipped()


def point_ellipsoid(x: Point, e: Ellipsoid) -> Separation:
    """Signed distance of a point from an ellipsoid: one root of a monotone function.

    From the centre, along the least radius. Eberly, Distance from a Point to an Ellipse, an Ellipsoid, or a
    Hyperellipsoid.
    """
    return separation(x, e)


def point_cylinder(x: Point, z: Cylinder) -> Separation:
    """Signed distance of a point from a cylinder: nearest point of cap, side or rim. Closed form."""
    return separation(x, z)


def sphere_ellipsoid(s: Sphere, e: Ellipsoid) -> Separation:
    """Signed distance of a ball and an ellipsoid: that of its centre, less the radius."""
    return separation(s, e)


def sphere_cylinder(s: Sphere, z: Cylinder) -> Separation:
    """Signed distance of a ball and a cylinder: that of its centre, less the radius. Closed form."""
    return separation(s, z)


def capsule_ellipsoid(c: Capsule, e: Ellipsoid) -> Separation:
    """Signed distance of a capsule and an ellipsoid: the segment inside it searches, the radius is taken off."""
    return separation(c, e)


def capsule_cylinder(c: Capsule, z: Cylinder) -> Separation:
    """Signed distance of a capsule and a cylinder: the segment inside it searches, the radius is taken off."""
    return separation(c, z)


def aabb_ellipsoid(a: AABB, e: Ellipsoid) -> Separation:
    """Signed distance of an axis-aligned box and an ellipsoid, by the general search."""
    return separation(a, e)


def aabb_cylinder(a: AABB, z: Cylinder) -> Separation:
    """Signed distance of an axis-aligned box and a cylinder, by the general search."""
    return separation(a, z)


def box_ellipsoid(b: Box, e: Ellipsoid) -> Separation:
    """Signed distance of a box and an ellipsoid, by the general search."""
    return separation(b, e)


def box_cylinder(b: Box, z: Cylinder) -> Separation:
    """Signed distance of a box and a cylinder, by the general search."""
    return separation(b, z)


def kdop_ellipsoid(k: KDOP, e: Ellipsoid) -> Separation:
    """Signed distance of a k-DOP and an ellipsoid, by the general search over its corners."""
    return separation(k, e)


def kdop_cylinder(k: KDOP, z: Cylinder) -> Separation:
    """Signed distance of a k-DOP and a cylinder, by the general search over its corners."""
    return separation(k, z)


def ellipsoid_ellipsoid(e: Ellipsoid, f: Ellipsoid) -> Separation:
    """Signed distance of two ellipsoids, by the general search.

    Overlapping, the least depth of all; of several equal ones any.
    """
    return separation(e, f)


def ellipsoid_cylinder(e: Ellipsoid, z: Cylinder) -> Separation:
    """Signed distance of an ellipsoid and a cylinder, by the general search."""
    return separation(e, z)


def cylinder_cylinder(z: Cylinder, y: Cylinder) -> Separation:
    """Signed distance of two cylinders, by the general search.

    Overlapping, the least depth of all; of several equal ones, as around a common axis, any.
    """
    return separation(z, y)


def ellipsoid_convexpolyhedron(e: Ellipsoid, p: ConvexPolyhedron) -> Separation:
    """Signed distance of an ellipsoid and a convex polyhedron, by the general search over its corners."""
    return separation(e, p)


def cylinder_convexpolyhedron(z: Cylinder, p: ConvexPolyhedron) -> Separation:
    """Signed distance of a cylinder and a convex polyhedron, by the general search over its corners."""
    return separation(z, p)


def expanded(a: Proxy, b: Proxy, gap: float, direction: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """Give the expanding polytope of one overlapping pair, as evidence for its depth.

    Parameters
    ----------
    a, b
        Convex and bounded, of batch shape ().
    gap
        How near, as a length, the nearest facet has to come to the least depth. The polytope ends at a few hundred
        points in any case.
    direction : (3,)
        Unit normal from A to B as far as it is known; the search starts there.

    Returns
    -------
    on_a, on_b : (m, 3)
        Support points of A and of B; the corners of the polytope are the differences on_b − on_a.
    triangles : (t, 3) int
        Corners of its facets, counted so that on_a − on_b, seen from outside, goes round counterclockwise. None for a
        difference that is flat.
    """
    one, other = a.broadcast_to((1,)), b.broadcast_to((1,))
    origin = one.reference_point
    module = compiling.module_for("expanding", 1)
    rows = [compiling.numbers(body_rows(x, origin), module)[0] for x in (one, other)]
    floats = [compiling.buffer(size, module) for size in (expanding.POINTS, expanding.PLANES)]
    whole = [compiling.buffer(size, module, whole=True) for size in (expanding.FACETS, expanding.SCRATCH)]
    start = (float(direction[0]), float(direction[1]), float(direction[2]))
    points, facets, *_ = module.expand(*rows, start, gap, *floats, *whole)
    corners = np.asarray(floats[0]).reshape(-1, 9)[:points]
    table = np.asarray(whole[0]).reshape(-1, 7)[:facets]
    alive = table[table[:, expanding.MARK] != expanding.DEAD, :3]
    used, triangles = np.unique(alive, return_inverse=True)
    return origin + corners[used, 3:6], origin + corners[used, 6:9], triangles.reshape(-1, 3).astype(np.int64)
