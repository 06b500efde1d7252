"""Engines of the survey of bounding volumes: trimesh, miniball, FCL, and this project's own."""

from __future__ import annotations

from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from oracles.surveys.bounding import extent, points_in
from oracles.surveys.survey import Case, SurveyEngine
from refimpl.linear import Array


class Reference(SurveyEngine):
    """`refimpl.construct`."""

    calls: ClassVar[str] = "sphere, least_box, cylinder, hull, aabb"
    promise: ClassVar[str] = (
        "contains every point, exactly; the sphere is the smallest, up to the rounding of its centre"
    )

    def answers(self, question: str) -> bool:
        """All but those whose judge takes its own volumes for the smaller ones."""
        return question not in {"box-size", "cylinder-size"}

    def tolerance(self, case: Case) -> float:
        """The sphere's centre is rounded to doubles, the centre of a box too."""
        if case.question in {"sphere-size", "centre"}:
            return rounding(points_in(case.data))
        return 0.0

    def answer(self, case: Case) -> Any:
        """A volume, by the numbers that are its meaning; of one point and of collinear ones no cylinder."""
        from refimpl import construct  # noqa: PLC0415

        points = points_in(case.data)
        match case.question.partition("-")[0]:
            case "sphere":
                return _fields(construct.sphere(points), "center", "radius")
            case "box":
                return _fields(construct.least_box(points), "center", "half_extents", "rotation")
            case "cylinder":
                return _fields(construct.cylinder(points), "p", "q", "radius")
            case "hull":
                return {"vertices": construct.hull(points).vertices.tolist()}
        return {"center": construct.aabb(points).reference_point.tolist()}


def _fields(shape: Any, *names: str) -> dict[str, Any]:
    return {name: getattr(shape, name).tolist() for name in names}


def rounding(points: Array) -> float:
    """A few units in the last place of the coordinates, in extents of the cloud."""
    return 8 * 2.0**-53 * float(np.max(np.abs(points))) / extent(points)


class Trimesh(SurveyEngine):
    """Bounding primitives of `trimesh.PointCloud`."""

    calls: ClassVar[str] = "PointCloud.bounding_sphere, bounding_box_oriented, bounding_cylinder, convex_hull"
    promise: ClassVar[str] = (
        "each is documented as of minimum volume and around all vertices; held to 10⁻⁹ of the extent, and to 10⁻⁶ of "
        "the least size"
    )

    def answers(self, question: str) -> bool:
        """All that it has."""
        return question != "centre"

    def tolerance(self, case: Case) -> float:
        """Nothing is said about rounding; qhull joins what differs by 10⁻¹²."""
        return 1e-6 if case.question.endswith("size") else 1e-9 + 64 * rounding(points_in(case.data))

    def answer(self, case: Case) -> Any:
        """The primitive, by its own numbers."""
        trimesh: Any = import_module("trimesh")
        cloud = trimesh.PointCloud(points_in(case.data))
        match case.question.partition("-")[0]:
            case "sphere":
                ball = cloud.bounding_sphere.primitive
                return {"center": ball.center.tolist(), "radius": float(ball.radius)}
            case "box":
                to_origin, extents = trimesh.bounds.oriented_bounds(cloud.vertices)
                return {"to_origin": to_origin[:3].tolist(), "extents": extents.tolist()}
            case "cylinder":
                barrel = cloud.bounding_cylinder.primitive
                place = barrel.transform
                sizes = {"height": float(barrel.height), "radius": float(barrel.radius)}
                return {"center": place[:3, 3].tolist(), "axis": place[:3, 2].tolist(), **sizes}
        return {"vertices": cloud.convex_hull.vertices.tolist()}


class Miniball(SurveyEngine):
    """`miniball.get_bounding_ball`, Welzl's algorithm in numpy."""

    calls: ClassVar[str] = "miniball.get_bounding_ball"
    promise: ClassVar[str] = "the smallest bounding ball; held to 10⁻⁹ of the extent, and to 10⁻⁶ of the least radius"

    def answers(self, question: str) -> bool:
        """Spheres only."""
        return question.startswith("sphere")

    def tolerance(self, case: Case) -> float:
        """Nothing is said about rounding."""
        return 1e-6 if case.question.endswith("size") else 1e-9 + 64 * rounding(points_in(case.data))

    def answer(self, case: Case) -> Any:
        """The ball; it is drawn by chance, which is made the same every time."""
        import miniball  # noqa: PLC0415

        center, square = miniball.get_bounding_ball(points_in(case.data), rng=np.random.default_rng(0))
        return {"center": center.tolist(), "radius": float(np.sqrt(square))}


class Fcl(SurveyEngine):
    """FCL, of whose bounding volumes Python sees one point: the centre of a model's box along the axes."""

    calls: ClassVar[str] = "fcl.BVHModel.computeLocalAABB, aabb_center"
    promise: ClassVar[str] = "the centre of the box of all vertices; held to rounding"

    def answers(self, question: str) -> bool:
        """The centre only."""
        return question == "centre"

    def tolerance(self, case: Case) -> float:
        """A few roundings."""
        return rounding(points_in(case.data))

    def answer(self, case: Case) -> Any:
        """The centre."""
        import fcl  # noqa: PLC0415

        points = points_in(case.data)
        n = len(points)
        triangles = np.stack([np.arange(n), (np.arange(n) + 1) % n, (np.arange(n) + 2) % n], axis=1)
        model = fcl.BVHModel()
        model.beginModel(n, n)
        model.addSubModel(points, triangles)
        model.endModel()
        model.computeLocalAABB()
        return {"center": list(model.aabb_center)}
