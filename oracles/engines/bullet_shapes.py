"""Proxies as PyBullet takes them: arguments of a collision shape, and where the shape stands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from oracles.course import WIDTH, Course
from oracles.engine import Array, Kind, Row, UnsupportedCell
from oracles.engines import geometry
from oracles.engines.geometry import Key
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)

MARGIN = 0.001
"""Collision margin of everything but spheres, capsules and planes, and how near a ray must come to hit."""

UPRIGHT = [0.0, 0.0, 0.0, 1.0]
SPHERE, CAPSULE, PLANE, BOX, CYLINDER = "GEOM_SPHERE", "GEOM_CAPSULE", "GEOM_PLANE", "GEOM_BOX", "GEOM_CYLINDER"
MOST_CHILDREN = 16
"""createCollisionShapeArray drops what comes after so many parts, and says nothing."""
HULL, MESH, COMPOUND = "hull", "mesh", "compound"
"""Two uses of GEOM_MESH, and createCollisionShapeArray."""
NO_ELLIPSOID = "Bullet has no ellipsoid: its spheres are not stretched"
NO_SOLID_PART = "a mesh that is part of a Composite would be asked as a surface, beside solids"


class Placed(NamedTuple):
    """A proxy as PyBullet takes it.

    `extra` is the part of its radius that the proxy does not have, to be taken off the answer again; `key` names the
    geometry of a hull or mesh; `children` stand in the frame of their compound.
    """

    geometry: str
    sizes: dict[str, float | list[float]]
    position: list[float]
    orientation: list[float]
    extra: float = 0.0
    key: Key = ()
    children: tuple[Placed, ...] = ()


def _point(r: Row, thinnest: float) -> Placed:
    extra = _instead_of_0(r, thinnest)
    return Placed(SPHERE, {"radius": extra}, r, UPRIGHT, extra)


def _sphere(r: Row, _: float) -> Placed:
    return Placed(SPHERE, {"radius": r[3]}, r[:3], UPRIGHT)


def _capsule(r: Row, thinnest: float) -> Placed:
    """Stand a capsule, which lies along z and whose height excludes the caps, on its segment."""
    middle, turn, length = _axis(r)
    extra = 0.0 if r[6] else _instead_of_0(middle, thinnest)
    return Placed(CAPSULE, {"radius": r[6] or extra, "height": length}, middle, turn, extra)


def _cylinder(r: Row, _: float) -> Placed:
    middle, turn, length = _axis(r)
    return Placed(CYLINDER, {"radius": r[6], "height": length}, middle, turn)


def _axis(r: Row) -> tuple[list[float], list[float], float]:
    """Middle, orientation and length of a segment that lies along z in its own frame."""
    px, py, pz, qx, qy, qz = r[:6]
    x, y, z = qx - px, qy - py, qz - pz
    length = math.hypot(x, y, z)
    turn = _turn_to(x / length, y / length, z / length) if length > 0 else UPRIGHT
    return [px / 2 + qx / 2, py / 2 + qy / 2, pz / 2 + qz / 2], turn, length


def _instead_of_0(position: list[float], thinnest: float) -> float:
    return thinnest * max(1.0, *map(abs, position))


def _turn_to(x: float, y: float, z: float) -> list[float]:
    """Quaternion that takes the z axis to a unit vector, or to its opposite: a capsule has no front."""
    return _unit(-y, x, 0.0, 1.0 + z) if z >= 0 else _unit(y, -x, 0.0, 1.0 - z)


def _unit(x: float, y: float, z: float, w: float) -> list[float]:
    size = max(abs(x), abs(y), abs(z), abs(w))
    x, y, z, w = x / size, y / size, z / size, w / size
    length = math.hypot(x, y, z, w)
    return [x / length, y / length, z / length, w / length]


def _halfspace(r: Row, _: float) -> Placed:
    """Stand a plane, which can only be given by its normal, on its point nearest to the origin."""
    length = math.hypot(r[0], r[1], r[2])
    normal = [r[0] / length, r[1] / length, r[2] / length]
    offset = -r[3] / length
    return Placed(PLANE, {"planeNormal": normal}, [offset * u for u in normal], UPRIGHT)


def _aabb(r: Row, _: float) -> Placed:
    center = [u / 2 + v / 2 for u, v in zip(r[3:], r[:3], strict=True)]
    half = [u / 2 - v / 2 for u, v in zip(r[3:], r[:3], strict=True)]
    return Placed(BOX, {"halfExtents": half}, center, UPRIGHT)


def _box(r: Row, _: float) -> Placed:
    return Placed(BOX, {"halfExtents": r[3:6]}, r[:3], _unit(*r[6:]))


def _hull(kind: Kind, r: Row) -> Placed:
    framed = geometry.polytope(kind, r)
    return Placed(HULL, {}, framed.position, _unit(*framed.rotation), key=framed.key)


def _mesh(r: Row, _: float) -> Placed:
    framed = geometry.solid(r)
    return Placed(MESH, {}, framed.position, _unit(*framed.rotation), key=framed.key)


PLACE: dict[Kind, Callable[[Row, float], Placed]] = {
    Point: _point,
    Sphere: _sphere,
    Capsule: _capsule,
    HalfSpace: _halfspace,
    AABB: _aabb,
    Box: _box,
    KDOP: lambda r, _: _hull(KDOP, r),
    Cylinder: _cylinder,
    ConvexPolyhedron: lambda r, _: _hull(ConvexPolyhedron, r),
    Polyhedron: _mesh,
}


def place(kind: Kind, row: Row, thinnest: float) -> list[Placed]:
    """A proxy as the shapes of which PyBullet needs one each.

    A composite's boxes, spheres, capsules and cylinders become one compound; its hulls stand beside it, because
    PyBullet reads those of a compound from files only.
    """
    if kind is not Composite:
        return [PLACE[kind](row, thinnest)]
    single: list[Placed] = []
    together: list[Placed] = []
    for part, numbers in geometry.parts(kind, row):
        if part not in PLACE or part is Polyhedron:
            raise UnsupportedCell(NO_SOLID_PART if part is Polyhedron else NO_ELLIPSOID)
        placed = PLACE[part](numbers, thinnest)
        joins = placed.geometry in (SPHERE, CAPSULE, BOX, CYLINDER) and not placed.extra
        (together if joins else single).append(placed)
    compounds = [together[i : i + MOST_CHILDREN] for i in range(0, len(together), MOST_CHILDREN)]
    return single + [parts[0] if len(parts) == 1 else _compound(parts) for parts in compounds]


def _compound(parts: list[Placed]) -> Placed:
    """Join shapes in a frame that stands where the first one does, and is not turned."""
    base = parts[0].position
    children = tuple(p._replace(position=[u - v for u, v in zip(p.position, base, strict=True)]) for p in parts)
    return Placed(COMPOUND, {}, base, UPRIGHT, children=children)


def compound_arguments(placed: Placed) -> dict[str, list[Any]]:
    """Arguments of createCollisionShapeArray, without the types: PyBullet wants every size of every part."""
    parts = placed.children
    return {
        "radii": [p.sizes.get("radius", 0.0) for p in parts],
        "halfExtents": [p.sizes.get("halfExtents", [0.0, 0.0, 0.0]) for p in parts],
        "lengths": [p.sizes.get("height", 0.0) for p in parts],
        "collisionFramePositions": [p.position for p in parts],
        "collisionFrameOrientations": [p.orientation for p in parts],
    }


# -- hulls as Bullet keeps them ------------------------------------------------------------------------------

STEPS = 10216
"""Bullet keeps the vertices of a hull on a grid of so many steps along each side of their bounding box."""


def on_grid(vertices: Array) -> Array:
    """Vertices (..., m, 3) of hulls as `btConvexHullComputer` leaves them: towards the middle, to the next step."""
    lower, upper = vertices.min(axis=-2, keepdims=True), vertices.max(axis=-2, keepdims=True)
    middle, step = (lower + upper) * 0.5, (upper - lower) * (1.0 / STEPS)  # in the roundings of btVector3
    steps = (vertices - middle) * np.divide(1.0, step, out=np.zeros_like(step), where=step != 0)
    return np.asarray(np.trunc(steps) * step + middle)


# -- rays ----------------------------------------------------------------------------------------------------


def ray_of(row: Row) -> tuple[Row, list[float]]:
    """A moving Point as the ray that it is as seen from the other, and how that other moves.

    Raises
    ------
    UnsupportedCell
        When the other turns.
    """
    course = Course.unpack(np.array(row[-WIDTH:]))
    if course.b.angular.any():
        raise UnsupportedCell("a ray test knows no turning bodies")
    own, along = course.a.linear.tolist(), course.b.linear.tolist()
    if course.a.angular.any() and course.a.center.tolist() != row[:3]:
        raise UnsupportedCell("a ray test knows no Point that turns about another place")
    return [*row[:3], *(u - v for u, v in zip(own, along, strict=True))], along


def reach(placed: Placed) -> float:
    """Bound on how far a shape extends from its position."""
    if placed.geometry in (HULL, MESH):
        points = geometry.vertices(placed.key) if placed.geometry == HULL else geometry.mesh(placed.key)[0]
        return float(np.linalg.norm(points, axis=1).max())
    if placed.geometry == COMPOUND:
        return max(math.hypot(*child.position) + reach(child) for child in placed.children)
    return sum(math.hypot(*s) if isinstance(s, list) else s for s in placed.sizes.values())


def ray_end(ray: Row, target: Placed) -> float:
    """Time at which a ray is past the whole target; a plane is past at twice the time of its crossing."""
    origin, direction = ray[:3], ray[3:]
    length = math.hypot(*direction)
    toward = [c - o for c, o in zip(target.position, origin, strict=True)]
    if target.geometry == PLANE:
        normal: Any = target.sizes["planeNormal"]
        speed, gap = _dot(normal, direction), _dot(normal, toward)
        return 2 * gap / speed if gap * speed > 0 else 1.0
    along = _dot([u / length for u in toward], [d / length for d in direction])
    return max(along, 0.0) + 2 * (reach(target) + MARGIN) / length


def _dot(u: list[float], v: list[float]) -> float:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def ray_at(ray: Row, t: float) -> list[float]:
    """Point of a ray."""
    return [o + t * d for o, d in zip(ray[:3], ray[3:], strict=True)]
