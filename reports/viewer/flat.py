"""Flat scenes as they are drawn: as thin things in the plane z = 0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from oracles.outcome import Finding
from oracles.scene import Scene
from oracles.world import PLANE, is_flat
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.linear import Array
from refimpl.shapes import AABB, Capsule, ConvexPolyhedron, Cylinder, Point, Proxy, Ray

THIN = 1e-3
"""Half the height of a disc, by its radius."""
ROUND = 24
"""Corners that stand for the round ends of a segment with a radius."""


def in_space(finding: Finding) -> Finding:
    """The finding with its flat scenes in space; as it is, where it has none."""
    verdict = finding.verdict
    proof = None if verdict.proof_scene is None else _raised(verdict.proof_scene)
    return replace(finding, scene=_raised(finding.scene), verdict=replace(verdict, proof_scene=proof))


def _raised(scene: Scene) -> Scene:
    if not is_flat(scene.b):
        return scene
    return replace(scene, a=RAISED[type(scene.a)](scene.a), b=RAISED[type(scene.b)](scene.b))


def _fill(vectors: Array) -> Array:
    return PLANE.fill(vectors)


def _disc(disc: Any) -> Cylinder:
    center, up = _fill(disc.center), np.array([0.0, 0.0, THIN * float(disc.radius)])
    return Cylinder(center - up, center + up, disc.radius)


def _segment(segment: Any) -> Proxy:
    if segment.radius == 0:
        return Capsule(_fill(segment.p), _fill(segment.q), 0.0)
    angles = 2.0 * np.pi * np.arange(ROUND) / ROUND
    circle = segment.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return _hull(np.concatenate([segment.p + circle, segment.q + circle]))


def _hull(corners: Array) -> ConvexPolyhedron:
    return ConvexPolyhedron.from_vertices(_fill(corners))


RAISED: dict[type[Proxy], Callable[[Any], Proxy]] = {
    FlatPoint: lambda p: Point(_fill(p.position)),
    FlatRay: lambda r: Ray(_fill(r.origin), _fill(r.direction)),
    Disc: _disc,
    Segment: _segment,
    Rectangle: lambda r: AABB(_fill(r.lower), _fill(r.upper)),
    ConvexPolygon: lambda p: _hull(p.outline.corners),
}
