"""Volume, barycentre and inertia tensor of solids of uniform density.

Round solids have closed forms. Polytopes and meshes are integrated over their surface (Mirtich, Fast and Accurate
Computation of Polyhedral Mass Properties, 1996).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from refimpl.hulls import Hull
from refimpl.integrals import in_order, outer, surface_integrals, surface_of
from refimpl.linear import Array, apply, dot, norm, power_of_two, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Polyhedron,
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


def mass_properties(shape: Proxy, *, allowed_overlap: float = 0.0) -> MassProperties:
    """Volume, barycentre and inertia tensor, of density 1.

    Parameters
    ----------
    shape : a bounded solid
    allowed_overlap : length
        Of composites: parts that overlap deeper are refused. What they have in common counts twice.

    Raises
    ------
    UnsupportedOperation
        For points and rays, which have no volume, and half-spaces, which have no end; for a composite of parts that
        overlap.
    """
    if isinstance(shape, Composite):
        return _composite(shape, allowed_overlap)
    if isinstance(shape, Polyhedron):
        return _polyhedron(shape)
    rule = RULES.get(type(shape))
    if shape.dimension == 2:
        raise UnsupportedOperation(f"a {type(shape).__name__} has an area, no volume: use flat.area.area_properties")
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
    parts = [moments[..., i, None, None] * outer(c) for i, c in enumerate(columns)]
    return np.asarray(parts[0] + parts[1] + parts[2])


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
    inertia = across[..., None, None] * np.eye(3) + (along - across)[..., None, None] * outer(axis)
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


def _polytope(hull: Hull, position: Array, rotation: Array) -> MassProperties:
    if not hull.edges.shape[-2]:  # points only
        batch = hull.dimension.shape
        return MassProperties(np.zeros(batch), np.full((*batch, 3), np.nan), np.zeros((*batch, 3, 3)))
    return _of_surface(surface_of(hull), hull.dimension == 3, position, rotation)


def _polyhedron(p: Polyhedron) -> MassProperties:
    """One mesh for all poses; scaled by itself, as a batch may not scale it row by row."""
    exponent = power_of_two(np.max(np.abs(p.vertices)))
    mesh = np.ldexp(p.vertices, -exponent)[p.triangles]
    at_origin = _of_surface(mesh, np.True_, np.zeros(3), IDENTITY)
    axes = rotation_matrix(p.rotation)
    return MassProperties(
        np.broadcast_to(np.ldexp(at_origin.volume, 3 * exponent), p.batch_shape)[()],
        p.position + apply(axes, np.ldexp(at_origin.barycentre, exponent)),
        np.ldexp(_conjugated(at_origin.inertia, axes), 5 * exponent),
    )


def _composite(c: Composite, allowed_overlap: float) -> MassProperties:
    """Sum over parts that have no volume in common (Steiner's theorem)."""
    from refimpl.queries import distance  # noqa: PLC0415  the queries need the shapes first

    for a, b in combinations(range(len(c.parts)), 2):
        depth = -distance(c.parts[a], c.parts[b]).distance
        if np.any(depth > allowed_overlap):
            raise UnsupportedOperation(
                f"Composite.parts[{a}] and [{b}] overlap by {np.max(depth):g}: their common volume would count twice; "
                "build the union from parts that do not overlap, or allow it by `allowed_overlap`"
            )
    parts = [mass_properties(part, allowed_overlap=allowed_overlap) for part in c.parts]
    volume = np.asarray(in_order(np.stack([part.volume for part in parts]), 0))
    moments = [scale(part.volume, np.nan_to_num(part.barycentre)) for part in parts]
    with np.errstate(invalid="ignore", divide="ignore"):
        middle = in_order(np.stack(moments), 0) / volume[..., None]
    inertias = [part.inertia + _steiner(part.volume, np.nan_to_num(part.barycentre - middle)) for part in parts]
    return MassProperties(volume[()], middle, in_order(np.stack(inertias), 0))


def _steiner(volume: Array, away: Array) -> Array:
    """Inertia of a mass point of this volume, at `away` from the centre."""
    return np.asarray(
        np.asarray(volume)[..., None, None] * (dot(away, away)[..., None, None] * np.eye(3) - outer(away))
    )


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
