"""Who is asked for mass properties: this project's own formulas, trimesh, and PyBullet for the inertia of a body."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from oracles.scene import shape_from_json
from oracles.surveys.survey import Case, SurveyEngine
from refimpl.linear import Array, norm, rotation_matrix
from refimpl.mass import mass_properties
from refimpl.shapes import Box, Capsule, ConvexPolyhedron, Cylinder, Polyhedron, Proxy, Sphere

TOLERANCE = 1e-9
"""Relative; of libraries that compute in doubles and promise nothing: a million roundings."""


ROUNDING = 2.0**-50
"""A barycentre far from the origin is rounded to so much of its distance."""


def allowed(relative: float, case: Case) -> float:
    """Relative error that is allowed, of a thin solid and a far one also what its numbers and its place leave."""
    return relative * max(1.0, float(case.data["thin"])) + ROUNDING * float(case.data["away"])


def principal(inertia: Array, volume: float) -> list[float]:
    """Principal moments of a body of mass 1, the least first."""
    return [float(x) for x in np.linalg.eigvalsh(inertia / volume)]


class Reference(SurveyEngine):
    """The formulas of `refimpl.mass`."""

    calls = "refimpl.mass_properties"
    promise = "rounding, 1e-13 by the thickness of a thin solid; of a barycentre far away 4 units in its last place"

    def tolerance(self, case: Case) -> float:
        """Rounding: corners that are turned against the axes know a thickness to a bit of their own size."""
        return allowed(1e-13, case)

    def answer(self, case: Case) -> Any:
        """All four."""
        found = mass_properties(shape_from_json(case.data["solid"]))
        return {
            "volume": float(found.volume),
            "barycentre": found.barycentre.tolist(),
            "inertia": found.inertia.tolist(),
            "moments": principal(found.inertia, float(found.volume)),
        }


class Trimesh(SurveyEngine):
    """Its meshes, and its primitives where it has them."""

    calls = "trimesh.Trimesh.volume, center_mass, moment_inertia, principal_inertia_components; trimesh.primitives"
    promise = f"nothing; held to {TOLERANCE:g} of the true values, of a solid that is given exactly"
    TYPES: ClassVar[Mapping[str, str]] = {
        "Sphere": "Sphere",
        "Box": "Box",
        "Capsule": "Capsule",
        "Cylinder": "Cylinder",
        "ConvexPolyhedron": "",
        "Polyhedron": "",
    }

    def answers(self, question: str) -> bool:
        """It has no ellipsoids, no k-DOPs, and no unions without a further engine."""
        return question in self.TYPES

    def tolerance(self, case: Case) -> float:
        """As promised, with the numbers' own share for thin solids."""
        return allowed(TOLERANCE, case)

    def answer(self, case: Case) -> Any:
        """All four."""
        trimesh = importlib.import_module("trimesh")
        mesh = self._made(trimesh, shape_from_json(case.data["solid"]))
        volume = float(mesh.volume)
        return {
            "volume": volume,
            "barycentre": np.asarray(mesh.center_mass).tolist(),
            "inertia": np.asarray(mesh.moment_inertia).tolist(),
            "moments": sorted((np.asarray(mesh.principal_inertia_components) / volume).tolist()),
        }

    @staticmethod
    def _made(trimesh: Any, shape: Proxy) -> Any:
        transform = np.eye(4)
        match shape:
            case Sphere():
                return trimesh.primitives.Sphere(radius=float(shape.radius), center=shape.center)
            case Box():
                transform[:3, :3], transform[:3, 3] = rotation_matrix(shape.rotation), shape.center
                return trimesh.primitives.Box(extents=2 * shape.half_extents, transform=transform)
            case Capsule() | Cylinder():
                transform = trimesh.geometry.align_vectors([0, 0, 1], shape.q - shape.p)
                transform[:3, 3] = shape.p / 2 + shape.q / 2
                make = getattr(trimesh.primitives, type(shape).__name__)
                return make(radius=float(shape.radius), height=float(norm(shape.q - shape.p)), transform=transform)
            case Polyhedron():
                return trimesh.Trimesh(shape.vertices, shape.triangles, process=False)
            case ConvexPolyhedron():
                return trimesh.convex.convex_hull(shape.numbers)
        raise ValueError(f"no {type(shape).__name__}")


MARGIN = 0.04
"""Bullet's own, in lengths."""


class Bullet(SurveyEngine):
    """The inertia that a body of mass 1 is given for its collision shape."""

    calls = "pybullet.createMultiBody and getDynamicsInfo: localInertiaDiagonal"
    promise = (
        f"principal moments of the shape in its own frame, held to {TOLERANCE:g}; hulls and capsules count as bounding "
        "boxes by convention, concave meshes cannot move and have no inertia, and volumes are not told"
    )
    TYPES = ("Sphere", "Box", "Capsule", "Cylinder", "ConvexPolyhedron")

    def answers(self, question: str) -> bool:
        """It has no ellipsoids and k-DOPs; unions it gives the inertia of their bounding box."""
        return question in self.TYPES

    def tolerance(self, case: Case) -> float:
        """As promised; sizes are kept less a collision margin, which is added again: 4 bits of it may be lost."""
        return TOLERANCE + ROUNDING * MARGIN / float(case.data["size"])

    def answer(self, case: Case) -> Any:
        """The moments."""
        bullet = importlib.import_module("pybullet")
        client = bullet.connect(bullet.DIRECT)
        try:
            made = self._made(bullet, client, shape_from_json(case.data["solid"]))
            body = bullet.createMultiBody(1.0, made, physicsClientId=client)
            return {"moments": sorted(bullet.getDynamicsInfo(body, -1, physicsClientId=client)[2])}
        finally:
            bullet.disconnect(client)

    @staticmethod
    def _made(bullet: Any, client: int, shape: Proxy) -> Any:
        def create(sort: int, **sizes: Any) -> Any:
            return bullet.createCollisionShape(sort, physicsClientId=client, **sizes)

        match shape:
            case Sphere():
                return create(bullet.GEOM_SPHERE, radius=float(shape.radius))
            case Box():
                return create(bullet.GEOM_BOX, halfExtents=shape.half_extents.tolist())
            case Capsule() | Cylinder():
                sort = bullet.GEOM_CAPSULE if isinstance(shape, Capsule) else bullet.GEOM_CYLINDER
                return create(sort, radius=float(shape.radius), height=float(norm(shape.q - shape.p)))
            case ConvexPolyhedron():
                return create(bullet.GEOM_MESH, vertices=shape.numbers.tolist())
        raise ValueError(f"no {type(shape).__name__}")
