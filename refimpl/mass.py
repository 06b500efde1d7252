"""Volume, barycentre and inertia tensor of solids of uniform density.

Round solids have closed forms. Polytopes and meshes are sums of signed tetrahedra over their surface, which is the
divergence theorem (Mirtich, Fast and Accurate Computation of Polyhedral Mass Properties, 1996; Eberly, Polyhedral
Mass Properties (Revisited)); on fractions the same sums are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.hulls import Hull
from refimpl.linear import Array, apply, cross, dot, norm, power_of_two, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Sphere,
)


@dataclass(frozen=True)
class MassProperties:
    """Of solids of density 1; multiply volume and inertia by the density.

    Attributes
    ----------
    volume : (...), length³
    barycentre : (..., 3)
        Not a number for flat polytopes, which have no volume.
    inertia : (..., 3, 3), length⁵
        About the barycentre, in the axes of the world: ∫ (|r|² 1 − r rᵀ) dV.
    """

    volume: Array
    barycentre: Array
    inertia: Array

    def of_mass(self, mass: Any) -> Array:
        """Inertia tensor (..., 3, 3) of a body of this mass (...); not a number for one of no volume."""
        with np.errstate(invalid="ignore"):
            density = np.asarray(mass) / np.where(self.volume > 0, self.volume, np.nan)
        return np.asarray(density[..., None, None] * self.inertia)


def mass_properties(shape: Proxy) -> MassProperties:
    """Volume, barycentre and inertia tensor, of density 1.

    Raises
    ------
    UnsupportedOperation
        For points and rays, which have no volume, and half-spaces, which have no end; for a composite of parts that
        overlap, whose common volume would count twice.
    """
    rule = RULES.get(type(shape))
    if rule is None:
        raise UnsupportedOperation(f"a {type(shape).__name__} has no mass properties: it is not a bounded solid")
    exponent = power_of_two(shape.magnitude)
    found = rule(shape.times_power(-exponent))
    return MassProperties(
        np.ldexp(found.volume, 3 * exponent)[()],
        np.ldexp(found.barycentre, exponent[..., None]),
        np.ldexp(found.inertia, 5 * exponent[..., None, None]),
    )


def _turned(moments: Array, axes: Array) -> Array:
    """Tensor R diag(moments) Rᵀ."""
    columns = [axes[..., :, i] for i in range(3)]
    outer = [moments[..., i, None, None] * c[..., :, None] * c[..., None, :] for i, c in enumerate(columns)]
    return np.asarray(outer[0] + outer[1] + outer[2])


def _others(squares: Array) -> Array:
    """For each axis the sum over the two others."""
    x, y, z = squares[..., 0], squares[..., 1], squares[..., 2]
    return np.stack([y + z, z + x, x + y], axis=-1)


def _sphere(s: Sphere) -> MassProperties:
    volume = 4 / 3 * math.pi * s.radius**3
    moment = volume * (0.4 * s.radius**2)
    return MassProperties(volume, s.center, moment[..., None, None] * np.eye(3))


def _ellipsoid(e: Ellipsoid) -> MassProperties:
    volume = 4 / 3 * math.pi * (e.radii[..., 0] * e.radii[..., 1] * e.radii[..., 2])
    moments = scale(volume / 5, _others(e.radii**2))
    return MassProperties(volume, e.center, _turned(moments, rotation_matrix(e.rotation)))


def _box(b: Box) -> MassProperties:
    h = b.half_extents
    volume = 8 * (h[..., 0] * h[..., 1] * h[..., 2])
    return MassProperties(volume, b.center, _turned(scale(volume / 3, _others(h**2)), rotation_matrix(b.rotation)))


def _aabb(b: AABB) -> MassProperties:
    return _box(b.to_box())


def _about_axis(p: Array, q: Array, volume: Array, along: Array, across: Array) -> MassProperties:
    """Solid of revolution about pq, symmetric about the middle: moments about its axis and across it."""
    axis = unit_or(q - p, np.eye(3)[0])[0]
    outer = axis[..., :, None] * axis[..., None, :]
    inertia = across[..., None, None] * np.eye(3) + (along - across)[..., None, None] * outer
    return MassProperties(volume, p / 2 + q / 2, inertia)


def _cylinder(c: Cylinder) -> MassProperties:
    length, r = norm(c.q - c.p), c.radius
    volume = math.pi * r**2 * length
    return _about_axis(c.p, c.q, volume, volume * r**2 / 2, volume * (r**2 / 4 + length**2 / 12))


def _capsule(c: Capsule) -> MassProperties:
    """A cylinder and two halves of a ball, whose barycentres lie 3/8 r beyond its ends."""
    length, r = norm(c.q - c.p), c.radius
    shaft, ball = math.pi * r**2 * length, 4 / 3 * math.pi * r**3
    along = shaft * (r**2 / 2) + ball * (0.4 * r**2)
    across = shaft * (r**2 / 4 + length**2 / 12) + ball * (0.4 * r**2 + length**2 / 4 + 0.375 * length * r)
    return _about_axis(c.p, c.q, shaft + ball, along, across)


def surface_integrals(triangles: Any) -> tuple[Any, Any, Any]:
    """Integrals of 1, x and x xᵀ over a solid, from the outward triangles of its surface.

    Parameters
    ----------
    triangles : (..., t, 3, 3)
        Corners, anticlockwise as seen from outside. An object array of fractions gives exact results.

    Returns
    -------
    volume : (...)
    first : (..., 3)
    second : (..., 3, 3)
        About the origin of the coordinates: place it near the solid, or digits cancel.
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    six = dot(a, cross(b, c))  # six times the signed volume of the tetrahedron between triangle and origin
    total = a + b + c
    products = _outer(a) + _outer(b) + _outer(c) + _outer(total)
    first = _in_order(six[..., None] * total, -2) / 24
    return _in_order(six, -1) / 6, first, _in_order(six[..., None, None] * products, -3) / 120


def _outer(v: Any) -> Any:
    return v[..., :, None] * v[..., None, :]


def _in_order(terms: Any, axis: int) -> Any:
    """Sum over an axis, one after the other, so that a row of a batch adds as it would alone."""
    return np.take(np.cumsum(terms, axis=axis), -1, axis=axis)


def _of_surface(triangles: Array, solid: Any, position: Array, rotation: Array) -> MassProperties:
    """Properties of the solids inside closed surfaces, in frames of their own.

    Parameters
    ----------
    triangles : (..., t, 3, 3)
    solid : (...) bool
        Whether there is a volume: where not, the sums are only rounding.
    position, rotation
        Of the frames.
    """
    origin = triangles[..., 0, 0, :]
    volume, first, second = surface_integrals(triangles - origin[..., None, None, :])
    volume = np.where(solid, volume, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        middle = first / np.where(solid, volume, np.nan)[..., None]
    central = np.where(np.asarray(solid)[..., None, None], second - first[..., :, None] * middle[..., None, :], 0.0)
    central = (central + np.swapaxes(central, -1, -2)) / 2
    trace = central[..., 0, 0] + central[..., 1, 1] + central[..., 2, 2]
    axes = rotation_matrix(rotation)
    inertia = _conjugated(trace[..., None, None] * np.eye(3) - central, axes)
    return MassProperties(volume, position + apply(axes, origin + middle), inertia)


def _conjugated(tensor: Array, axes: Array) -> Array:
    """Tensor R T Rᵀ, symmetric to the bit."""
    half = np.stack([apply(axes, tensor[..., :, i]) for i in range(3)], axis=-1)
    full = np.stack([apply(axes, half[..., i, :]) for i in range(3)], axis=-2)
    return np.asarray((full + np.swapaxes(full, -1, -2)) / 2)


def _triangles(hull: Hull) -> Array:
    """Outward triangles of a hull: each edge with one fixed corner of the face to its left, and of that to its right.

    Where a batch is filled up with repeated edges, all but one of them become triangles of no size.
    """
    v, w, left, right = (hull.edges[..., i] for i in range(4))
    corner = np.zeros(hull.planes.shape[:-1], dtype=np.int64)
    np.put_along_axis(corner, left, v, axis=-1)
    np.put_along_axis(corner, right, v, axis=-1)
    fans = [
        (np.take_along_axis(corner, left, axis=-1), v, w),
        (np.take_along_axis(corner, right, axis=-1), w, v),
    ]
    repeated = np.zeros(v.shape, dtype=bool)
    repeated[..., 1:] = np.all(hull.edges[..., 1:, :] == hull.edges[..., :-1, :], axis=-1)
    index = np.concatenate([np.where(repeated[..., None], 0, np.stack(fan, axis=-1)) for fan in fans], axis=-2)
    flat = index.reshape((*index.shape[:-2], -1, 1))
    return np.take_along_axis(hull.vertices, flat, axis=-2).reshape((*index.shape, 3))


def _polytope(hull: Hull, position: Array, rotation: Array) -> MassProperties:
    if not hull.edges.shape[-2]:  # points only
        batch = hull.dimension.shape
        return MassProperties(np.zeros(batch), np.full((*batch, 3), np.nan), np.zeros((*batch, 3, 3)))
    return _of_surface(_triangles(hull), hull.dimension == 3, position, rotation)


IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])

RULES: dict[type[Proxy], Callable[[Any], MassProperties]] = {
    Sphere: _sphere,
    Capsule: _capsule,
    AABB: _aabb,
    Box: _box,
    Ellipsoid: _ellipsoid,
    Cylinder: _cylinder,
    KDOP: lambda k: _polytope(k.hull, np.zeros(3), IDENTITY),
    ConvexPolyhedron: lambda c: _polytope(c.hull, c.position, c.rotation),
}
