"""Buckets for the tests of the viewer: every type in every role, without the cost of a proof."""

from __future__ import annotations

import math

import numpy as np

from oracles.outcome import Bucket, Finding, Kind, Severity, Verdict
from oracles.scene import DISTANCE, RAYCAST, Scene
from refimpl import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Ray,
    Sphere,
)
from refimpl.proof import Certificate
from refimpl.shapes.polytopes import USUAL_DIRECTIONS

TURNED = (0.25, 0.5, -0.125, 0.75)
WEDGE = Polyhedron([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

KINDS: dict[type[Proxy], Proxy] = {
    Point: Point([0.25, 0.5, 0.75]),
    Ray: Ray([-4.0, 0.5, 1.0], [1.0, -0.25, -0.25]),
    Sphere: Sphere([0.5, 0.25, 0.0], 1.25),
    Capsule: Capsule([-1.0, 0.0, 0.5], [1.0, 0.5, 1.0], 0.5),
    HalfSpace: HalfSpace([0.25, 0.5, 1.0], 0.5),
    AABB: AABB([-1.0, -0.5, -0.25], [1.0, 0.5, 0.75]),
    Box: Box([0.25, 0.0, 0.5], [1.0, 0.5, 0.25], TURNED),
    KDOP: KDOP(USUAL_DIRECTIONS[14], [-1.0] * 3 + [-1.25] * 4, [1.0, 1.5, 1.0] + [1.5] * 4),
    Ellipsoid: Ellipsoid([0.0, 0.5, 0.25], [1.5, 0.75, 0.5], TURNED),
    Cylinder: Cylinder([0.0, 0.0, -1.0], [0.5, 0.25, 1.0], 0.75),
    ConvexPolyhedron: ConvexPolyhedron.from_vertices(
        [[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], [0.5, 0.0, 0.0], TURNED
    ),
    Polyhedron: WEDGE.translated([-0.5, -0.5, 0.0]),
    Composite: Composite([Sphere([0.0, 0.0, 2.0], 0.5), Box([0.0, 0.0, 0.5], [0.5, 1.0, 0.5], TURNED), WEDGE]),
}


def torus(around: int, across: int) -> Polyhedron:
    """A ring with 2 · around · across triangles."""
    vertices, triangles = [], []
    for i in range(around):
        for j in range(across):
            a, b = 2 * math.pi * i / around, 2 * math.pi * j / across
            reach = 2 + 0.75 * math.cos(b)
            vertices.append([reach * math.cos(a), reach * math.sin(a), 0.75 * math.sin(b)])
            here, there, up = i * across, (i + 1) % around * across, (j + 1) % across
            triangles += [(here + j, there + j, there + up), (here + j, there + up, here + up)]
    return Polyhedron(vertices, triangles)


def stone(corners: int) -> ConvexPolyhedron:
    """A hull of as many corners as wished, all on a ball."""
    z, turn = np.linspace(-0.98, 0.98, corners), 2.4 * np.arange(corners)
    flat = np.sqrt(1 - z * z)
    return ConvexPolyhedron.from_vertices(np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1))


def viewed(
    a: Proxy,
    b: Proxy,
    query: str = "",
    *,
    answer: object = None,
    reference: object = None,
    interval: tuple[float, float] = (math.nan, math.nan),
    certificate: Certificate | None = None,
    proof_scene: Scene | None = None,
    engine: str = "fcl",
    claim: str = "fcl answers a distance of 3: distance too large",
    kind: Kind = Kind.WRONG,
) -> Bucket:
    """A bucket of one finding on these proxies."""
    scene = Scene(query or (RAYCAST if isinstance(a, Ray) else DISTANCE), a, b, "generic")
    verdict = Verdict(kind, "distance too large", Severity.LARGE, 0.5, *interval, claim, certificate, proof_scene)
    finding = Finding(engine, scene, answer or {}, reference or {}, verdict)  # type: ignore[arg-type]
    return Bucket(engine, scene.query, scene.cell.pair, verdict.symptom, "generic", -1, finding, 1)


def points(on_a: object, on_b: object, distance: float = 3.0) -> dict[str, object]:
    """An answer with witness points along x."""
    return {"distance": distance, "on_a": on_a, "on_b": on_b, "normal": [1.0, 0.0, 0.0]}
