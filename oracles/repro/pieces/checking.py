"""From the literals of a script to a proven interval."""

from __future__ import annotations

import math
from typing import Any

from oracles.repro.pieces.boxes import aabb, box
from oracles.repro.pieces.claims import Interval, common, core, endless, escape, inscribed, near, separated
from oracles.repro.pieces.curved import cylinder, ellipsoid
from oracles.repro.pieces.exact import require
from oracles.repro.pieces.flat import (
    around,
    disc,
    flat_point,
    flat_ray,
    flat_segment,
    polygon,
    rectangle,
)
from oracles.repro.pieces.polytopes import halfspace, kdop, polytope
from oracles.repro.pieces.rays import free, hit, ray
from oracles.repro.pieces.rounds import capsule, point, sphere
from oracles.repro.pieces.unions import Union, cover, part, polyhedron

MEANING: dict[str, Any] = {
    "Point": point,
    "Sphere": sphere,
    "Capsule": capsule,
    "AABB": aabb,
    "Box": box,
    "HalfSpace": halfspace,
    "Ellipsoid": ellipsoid,
    "Cylinder": cylinder,
    "KDOP": kdop,
    "ConvexPolyhedron": polytope,
    "Polyhedron": polyhedron,
    "Ray": ray,
    "FlatPoint": flat_point,
    "FlatRay": flat_ray,
    "Disc": disc,
    "Segment": flat_segment,
    "Rectangle": rectangle,
    "ConvexPolygon": polygon,
}
CHECKS: dict[str, Any] = {
    "separated": separated,
    "escape": escape,
    "near": near,
    "common": common,
    "core": core,
    "endless": endless,
    "inscribed": inscribed,
    "cover": cover,
    "part": part,
    "free": free,
    "hit": hit,
    "around": around,
}


def read(shape: Any) -> Any:
    """Take one shape by the name of its type: what its numbers mean, exactly."""
    return MEANING[shape["type"]](shape)


def parts_of(shape: Any) -> list[Any]:
    """The parts of a composite, those of composites in it too; any other shape is its own only part."""
    if shape["type"] == "Composite":
        return [found for part_of_it in shape["parts"] for found in parts_of(part_of_it)]
    return [read(shape)]


def interval_of(claims: Any, a: Any, b: Any, least: Any = -math.inf) -> Interval:
    """Interval in which the signed distance of two shapes lies, or the time of a hit, by all claims together."""
    bounds = [CHECKS[claim["kind"]](claim, a, b) for claim in claims]
    lower, upper = max([least, *(low for low, _ in bounds)]), min([math.inf, *(high for _, high in bounds)])
    require(lower <= upper, "its claims contradict each other")
    return lower, upper


def of_solids(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the signed distance of two convex shapes."""
    return interval_of(claims, read(x), read(y))


def of_unions(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the signed distance of two shapes, of which one is a union."""
    return interval_of(claims, Union(parts_of(x)), Union(parts_of(y)))


def of_rays(claims: Any, x: Any, y: Any) -> Interval:
    """Proven interval of the time when a ray first hits a shape; both ends are infinite where it never does."""
    return interval_of(claims, Union([read(x)]), Union(parts_of(y)), 0)


KINDS: dict[str, Any] = {
    "solids": of_solids,
    "unions": of_unions,
    "rays": of_rays,
}


def proven(proof: Any) -> Interval:
    """Check a certificate, which must prove the interval that is stated with it."""
    lower, upper = KINDS[proof["kind"]](proof["claims"], proof["x"], proof["y"])
    low, high = proof["interval"]
    known = math.nextafter(low, -math.inf) <= lower and upper <= math.nextafter(high, math.inf)
    require(known, "it proves less than is stated with it")
    return lower, upper
