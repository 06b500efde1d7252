"""Colliders: a few spheres, capsules or boxes that approximate a mesh.

What they should be like differs: inside and disjoint, so that masses add up (`packed_spheres`); inside and overlapping,
so that nothing collides too early (`medial_spheres`); or as near to the solid's volume as can be, on both sides of its
surface (`fitted_spheres`, `fitted_capsules`, `fitted_boxes`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl.construct.adjusting import Target, adjusted, target_of
from refimpl.construct.medial import covering, medial_balls
from refimpl.construct.models import in_moderate_unit, placed, solid_of, whole_number
from refimpl.construct.packing import packed_balls
from refimpl.construct.parts import moments, split
from refimpl.construct.primitives import BOXES, CAPSULES, LEAST, SPHERES, Family
from refimpl.construct.relocating import relocated
from refimpl.construct.sources import ConstructionError
from refimpl.construct.surfaces import surface_samples
from refimpl.linear import Array
from refimpl.principal import quaternion_of
from refimpl.shapes import Composite, Polyhedron, Sphere
from refimpl.solids import Solid
from refimpl.threads import products_in_one_thread

COVERED = 6144
"""Points in the solid that tell how much a ball covers, at most."""
SAMPLES = 2048
"""Points of the surface from which balls are shrunk."""
DETAIL = 12_288
ROUNDS = 60


def medial_spheres(mesh: Any, count: int, *, seed: int = 0, detail: int = DETAIL) -> Composite:
    """Spheres inside a mesh that may overlap and cover as much of it as they can.

    Out of balls that touch the surface at least twice (see `refimpl.construct.medial`), one after the other the one
    that covers the most of what is not covered yet.

    Parameters
    ----------
    mesh : Polyhedron, path of a mesh file, or trimesh object
    count : int
        Spheres, 1 to 256.
    seed : int
        The same seed gives the same spheres.
    detail : int
        Boxes at the surface by which volumes are measured: more of them see finer details and take longer.

    Returns
    -------
    Composite
        Of `Sphere`s. In the mesh's own frame each is within the solid; placing rounds.

    Raises
    ------
    ShapeError
        For what is no solid, a batch, and a count that is not 1 to 256.
    """
    count, polyhedron = whole_number(count), solid_of(mesh)
    solid, exponent = in_moderate_unit(polyhedron)
    center, radius = _balls(solid, seed)
    target = target_of(solid, detail)
    with products_in_one_thread():
        chosen = _covering(target, center, radius, count)
    return placed(polyhedron, exponent, Composite([Sphere(center[i], radius[i]) for i in chosen]))


def packed_spheres(mesh: Any, count: int, *, seed: int = 0) -> Composite:
    """Spheres inside a mesh without common points, one after the other the largest that fits.

    So the mass properties of the composite are the sums of those of the spheres. Each sphere grows from many places at
    once away from what it touches (Weller and Zachmann, ProtoSphere: A GPU-Assisted Prototype Guided Sphere Packing
    Algorithm for Arbitrary Objects, 2010).

    Parameters
    ----------
    mesh, count, seed
        As for `medial_spheres`.
    """
    count, polyhedron = whole_number(count), solid_of(mesh)
    solid, exponent = in_moderate_unit(polyhedron)
    center, radius = packed_balls(solid, _balls(solid, seed), count, seed)
    return placed(polyhedron, exponent, Composite([Sphere(c, r) for c, r in zip(center, radius, strict=True)]))


def fitted_spheres(mesh: Any, count: int, *, seed: int = 0, detail: int = DETAIL) -> Composite:
    """Spheres whose union has as large an intersection over union with a mesh as could be found.

    They start as `medial_spheres` and may reach through the surface.

    Parameters
    ----------
    mesh, count, seed, detail
        As for `medial_spheres`.
    """
    return _fitted(SPHERES, _first_spheres, mesh, count, seed, detail)


def fitted_capsules(mesh: Any, count: int, *, seed: int = 0, detail: int = DETAIL) -> Composite:
    """Capsules whose union has as large an intersection over union with a mesh as could be found.

    They start as the capsules that have the moments of the solid's parts; see `refimpl.construct.parts`.

    Parameters
    ----------
    mesh, count, seed, detail
        As for `medial_spheres`.
    """
    return _fitted(CAPSULES, _first_capsules, mesh, count, seed, detail)


def fitted_boxes(mesh: Any, count: int, *, seed: int = 0, detail: int = DETAIL) -> Composite:
    """Boxes whose union has as large an intersection over union with a mesh as could be found.

    They start as the boxes that have the moments of the solid's parts; see `refimpl.construct.parts`.

    Parameters
    ----------
    mesh, count, seed, detail
        As for `medial_spheres`.
    """
    return _fitted(BOXES, _first_boxes, mesh, count, seed, detail)


# ------------------------------------------------------------------------------------------- how


def _balls(solid: Solid, seed: int) -> tuple[Array, Array]:
    """Medial balls of a solid."""
    samples = surface_samples(Polyhedron(solid.vertices, solid.triangles), SAMPLES, seed)
    center, radius = medial_balls(solid, samples, float(np.max(np.ptp(solid.vertices, axis=0))))
    if not len(radius):
        raise ConstructionError(
            "mesh: no ball fits inside that its coordinates can tell from none; move it to the origin"
        )
    return center, radius


def _fitted(
    family: Family, first: Callable[[Solid, Target, int, int], Array], mesh: Any, count: int, seed: int, detail: int
) -> Composite:
    count, polyhedron = whole_number(count), solid_of(mesh)
    solid, exponent = in_moderate_unit(polyhedron)
    target = target_of(solid, detail)
    with products_in_one_thread():
        rows, loss = adjusted(family, first(solid, target, count, seed), target, ROUNDS)
        rows = relocated(family, rows, loss, target)
    shapes = Composite([family.proxy(row) for row in rows]).times_power(target.exponent).translated(target.middle)
    return placed(polyhedron, exponent, shapes)


def _first_spheres(solid: Solid, target: Target, count: int, seed: int) -> Array:
    """The medial spheres that cover the most."""
    center, radius = _balls(solid, seed)
    chosen = _covering(target, center, radius, count)
    return np.concatenate([target.own(center[chosen]), np.ldexp(radius[chosen, None], -target.exponent)], axis=1)


def _covering(target: Target, center: Array, radius: Array, count: int) -> list[int]:
    """Balls of the solid's frame that together cover much of it."""
    points, weight = target.within
    every = -(-len(points) // COVERED)
    return covering(target.own(center), np.ldexp(radius, -target.exponent), points[::every], weight[::every], count)


def _first_capsules(_: Solid, target: Target, count: int, __: int) -> Array:
    """Capsules of the volumes and mean squared radii of parts."""
    rows = []
    for points, weight in split(*target.within, count):
        mean, covariance = moments(points, weight)
        spread, axes = np.linalg.eigh(covariance)
        radius = max(2 * np.sqrt((spread[0] + spread[1]) / 2), LEAST)
        length = max(np.sum(weight) / (np.pi * radius**2) - 4 / 3 * radius, 0.1 * radius)
        half = length / 2 * axes[:, 2]
        rows.append([*(mean - half), *(mean + half), radius])
    return np.array(rows)


def _first_boxes(solid: Solid, target: Target, count: int, _: int) -> Array:
    """Boxes of the moments of parts, along the axes along which the part's own box is smallest."""
    usual = [np.eye(3), _frame_of_faces(solid)]
    rows = []
    for points, weight in split(*target.within, count):
        mean, covariance = moments(points, weight)
        frames = [_right_handed(np.linalg.eigh(covariance)[1]), *usual]
        axes = frames[int(np.argmin([np.prod(np.ptp(points @ frame, axis=0)) for frame in frames]))]
        half = np.sqrt(3 * np.maximum(np.diag(axes.T @ covariance @ axes), LEAST**2))
        rows.append([*mean, *half, *quaternion_of(axes)])
    return np.array(rows)


def _frame_of_faces(solid: Solid) -> Array:
    """Axes along the normals of the faces that have the most area."""
    twice = np.cross(solid.corners[:, 1] - solid.corners[:, 0], solid.corners[:, 2] - solid.corners[:, 0])
    area = np.linalg.norm(twice, axis=1)
    normals = twice / np.where(area > 0, area, 1.0)[:, None]
    alike = np.abs(normals @ normals[np.argsort(-area)[:64]].T) > 0.999
    first = normals[np.argsort(-area)[:64]][int(np.argmax(area @ alike))]
    beside = area * (np.abs(normals @ first) < 0.1)
    second = normals[int(np.argmax(beside))] if np.any(beside > 0) else np.roll(first, 1)
    return _right_handed(np.linalg.qr(np.stack([first, second, np.cross(first, second)], axis=1))[0])


def _right_handed(axes: Array) -> Array:
    return np.asarray(axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))]))
