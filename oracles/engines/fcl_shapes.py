"""Proxies as python-fcl takes them: a geometry in its own frame, and where that frame stands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from oracles.engine import Array, Kind, Row
from oracles.engines import geometry
from oracles.engines.geometry import Kept, Key
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Sphere,
)


class Placed(NamedTuple):
    """A proxy as FCL takes it; a rotation of None is none, and `key` names the geometry of a hull or mesh."""

    geometry: str
    sizes: tuple[float | Array, ...]
    rotation: list[list[float]] | None
    translation: list[float]
    key: Key = ()


def _rotation_to(x: float, y: float, z: float) -> list[list[float]]:
    """Rotation that takes the z axis to the unit vector (x, y, z) (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return [[1.0 + sign * x * x * a, b, x], [sign * b, sign + y * y * a, y], [-sign * x, -y, z]]


def _rotation_of(x: float, y: float, z: float, w: float) -> list[list[float]]:
    """Rotation matrix of a quaternion of any length."""
    size = max(abs(x), abs(y), abs(z), abs(w))
    x, y, z, w = x / size, y / size, z / size, w / size
    s = 2.0 / ((x * x + y * y) + (z * z + w * w))
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]


def _point(r: Row) -> Placed:
    return Placed("Sphere", (0.0,), None, r)


def _sphere(r: Row) -> Placed:
    return Placed("Sphere", (r[3],), None, r[:3])


def _on_axis(name: str, r: Row) -> Placed:
    """Stand a capsule or cylinder, which lies along z and whose length excludes the caps, on its axis."""
    px, py, pz, qx, qy, qz, radius = r
    x, y, z = qx - px, qy - py, qz - pz
    length = math.hypot(x, y, z)
    rotation = _rotation_to(x / length, y / length, z / length) if length > 0 else None
    return Placed(name, (radius, length), rotation, [px / 2 + qx / 2, py / 2 + qy / 2, pz / 2 + qz / 2])


def _halfspace(r: Row) -> Placed:
    """Turn normal·x + k ≤ 0 into FCL's n·x ≤ d with a unit n."""
    length = math.hypot(r[0], r[1], r[2])
    normal = np.array([r[0] / length, r[1] / length, r[2] / length])
    return Placed("Halfspace", (normal, -r[3] / length), None, [0.0, 0.0, 0.0])


def _aabb(r: Row) -> Placed:
    lower, upper = r[:3], r[3:]
    sides = tuple(u - v for u, v in zip(upper, lower, strict=True))
    return Placed("Box", sides, None, [u / 2 + v / 2 for u, v in zip(upper, lower, strict=True)])


def _box(r: Row) -> Placed:
    return Placed("Box", (2 * r[3], 2 * r[4], 2 * r[5]), _rotation_of(*r[6:]), r[:3])


def _ellipsoid(r: Row) -> Placed:
    return Placed("Ellipsoid", (r[3], r[4], r[5]), _rotation_of(*r[6:]), r[:3])


def _hull(kind: Kind, r: Row) -> Placed:
    framed = geometry.polytope(kind, r)
    turned = None if kind is KDOP else _rotation_of(*framed.rotation)
    return Placed("Convex", (), turned, framed.position, framed.key)


def _mesh(r: Row) -> Placed:
    framed = geometry.solid(r)
    return Placed("BVHModel", (), _rotation_of(*framed.rotation), framed.position, framed.key)


PLACE: dict[Kind, Callable[[Row], Placed]] = {
    Point: _point,
    Sphere: _sphere,
    Capsule: lambda r: _on_axis("Capsule", r),
    HalfSpace: _halfspace,
    AABB: _aabb,
    Box: _box,
    KDOP: lambda r: _hull(KDOP, r),
    Ellipsoid: _ellipsoid,
    Cylinder: lambda r: _on_axis("Cylinder", r),
    ConvexPolyhedron: lambda r: _hull(ConvexPolyhedron, r),
    Polyhedron: _mesh,
}


def place(kind: Kind, row: Row) -> list[Placed]:
    """A proxy as the objects of which FCL needs one each: the parts of a composite, or itself."""
    return [PLACE[part](numbers) for part, numbers in geometry.parts(kind, row)]


class Maker:
    """Makes collision objects; hulls and meshes are kept by their content."""

    def __init__(self, fcl: Any) -> None:
        self.fcl = fcl
        self._kept = {"Convex": Kept(self._convex, geometry.MOST_HULLS), "BVHModel": Kept(self._model)}

    def __call__(self, placed: Placed) -> Any:
        """Make the collision object; 2 to 4 µs where its geometry need not be made."""
        name, sizes, rotation, translation, key = placed
        shape = self._kept[name][key] if key else getattr(self.fcl, name)(*sizes)
        frame = self.fcl.Transform(translation) if rotation is None else self.fcl.Transform(rotation, translation)
        return self.fcl.CollisionObject(shape, frame)

    def _convex(self, key: Key) -> Any:
        return self.fcl.Convex(*convex(key))

    def _model(self, key: Key) -> Any:
        vertices, triangles = geometry.mesh(key)
        model = self.fcl.BVHModel()
        model.beginModel(len(vertices), len(triangles))
        model.addSubModel(vertices, triangles)
        model.endModel()
        return model


def convex(key: Key) -> tuple[Array, int, Any]:
    """Vertices, number of faces, and the faces as FCL takes them: one after the other, each led by its length."""
    vertices, faces = geometry.faced(key)
    return vertices, len(faces), np.array([n for face in faces for n in (len(face), *face)])


def shape_text(name: str, placed: Placed) -> str:
    """Python lines that make the geometry under a name."""
    if placed.geometry == "Convex":
        vertices, count, faces = convex(placed.key)
        arguments = f"    np.array({vertices.tolist()!r}),\n    {count},\n    np.array({faces.tolist()!r}),\n"
        return f"{name} = fcl.Convex(\n{arguments})\n"
    if placed.geometry == "BVHModel":
        corners, triangles = geometry.mesh(placed.key)
        return (
            f"{name} = fcl.BVHModel()\n{name}.beginModel({len(corners)}, {len(triangles)})\n"
            f"{name}.addSubModel(\n    np.array({corners.tolist()!r}),\n    np.array({triangles.tolist()!r}),\n)\n"
            f"{name}.endModel()\n"
        )
    texts = [f"np.array({s.tolist()!r})" if isinstance(s, np.ndarray) else repr(s) for s in placed.sizes]
    return f"{name} = fcl.{placed.geometry}({', '.join(texts)})\n"


def frame_text(placed: Placed) -> str:
    """Python text of where the geometry stands."""
    turned = "" if placed.rotation is None else f"np.array({placed.rotation!r}), "
    return f"fcl.Transform({turned}np.array({placed.translation!r}))"
