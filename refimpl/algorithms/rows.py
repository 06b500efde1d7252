"""Proxies as the flat rows of numbers that the scalar kernels read (`refimpl.kernels.bodies`)."""

from __future__ import annotations

import numpy as np

from refimpl.kernels import bodies
from refimpl.linear import Array, apply, cross, norm, perpendicular, rotation_matrix, unit_or
from refimpl.proxy import Proxy
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, Cylinder, Ellipsoid, Point, Sphere

SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def body_rows(shape: Proxy, origin: Array | None = None) -> Array:
    """Rows of a batch of convex, bounded proxies.

    Parameters
    ----------
    shape : Point, Sphere, Capsule, AABB, Box, KDOP, Ellipsoid, Cylinder or ConvexPolyhedron
        With exactly one batch axis.
    origin : (n, 3)
        Point that becomes the origin of the rows' coordinates; near the proxies, it saves digits.

    Returns
    -------
    (n, width)
        Hulls of the batch that have fewer vertices than others repeat some.
    """
    start = np.zeros((len(shape), 3)) if origin is None else origin
    if isinstance(shape, Ellipsoid):
        return _round_rows(bodies.ELLIPSOID, shape.center - start, rotation_matrix(shape.rotation), shape.radii)
    if isinstance(shape, Cylinder):
        step = shape.q - shape.p
        w = unit_or(step, SIGNS[0])[0]
        u = perpendicular(w)
        sizes = np.stack([shape.radius, shape.radius, norm(step) / 2], axis=-1)
        center = (shape.p - start) / 2 + (shape.q - start) / 2
        return _round_rows(bodies.CYLINDER, center, np.stack([u, cross(w, u), w], axis=-1), sizes)
    return _hull_rows(*_corners(shape, start))


def _round_rows(kind: float, center: Array, axes: Array, sizes: Array) -> Array:
    """Rows of ellipsoids or cylinders; the columns of `axes` are the body's."""
    rows = np.zeros((len(center), bodies.VERTICES))
    rows[:, bodies.KIND] = kind
    rows[:, bodies.CENTER : bodies.AXES] = center
    rows[:, bodies.AXES : bodies.SIZES] = np.swapaxes(axes, -1, -2).reshape(-1, 9)
    rows[:, bodies.SIZES :] = sizes
    return rows


def _hull_rows(vertices: Array, counts: Array, radius: Array) -> Array:
    """Rows of hulls of the first `counts` of the vertices (n, m, 3), widened."""
    n, m = vertices.shape[:2]
    rows = np.zeros((n, bodies.VERTICES + 3 * m))
    rows[:, bodies.KIND], rows[:, bodies.RADIUS], rows[:, bodies.COUNT] = bodies.HULL, radius, counts
    rows[:, bodies.VERTICES :] = vertices.reshape(n, 3 * m)
    return rows


def _corners(shape: Proxy, start: Array) -> tuple[Array, Array, Array]:  # noqa: PLR0911  one for each type
    """Vertices (n, m, 3) counted from `start`, how many of them count, and the radius of the ball around each."""
    n = len(shape)
    none, ones = np.zeros(n), np.ones(n)
    origin = start[:, None, :]
    match shape:
        case Point():
            return shape.position[:, None, :] - origin, ones, none
        case Sphere():
            return shape.center[:, None, :] - origin, ones, shape.radius
        case Capsule():
            ends = np.stack([shape.p, shape.q], axis=1)
            return ends - origin, np.where(np.all(shape.p == shape.q, axis=-1), 1.0, 2.0), shape.radius
        case AABB():
            corners = np.where(SIGNS > 0, shape.upper[:, None, :], shape.lower[:, None, :])
            return corners - origin, 8 * ones, none
        case Box():
            local = SIGNS * shape.half_extents[:, None, :]
            turned = apply(rotation_matrix(shape.rotation)[:, None, :, :], local)
            return (shape.center - start)[:, None, :] + turned, 8 * ones, none
        case KDOP():
            corners = shape.hull.vertices
            return corners - origin, corners.shape[1] * ones, none
        case ConvexPolyhedron():
            corners = shape.hull.vertices
            turned = apply(rotation_matrix(shape.rotation)[:, None, :, :], corners)
            return (shape.position - start)[:, None, :] + turned, corners.shape[1] * ones, none
    raise TypeError(f"{type(shape).__name__} is no convex body of finite size")
