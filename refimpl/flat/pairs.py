"""The flat pair table: for every pair of flat types the algorithm that answers it and how exact that is."""

from __future__ import annotations

from itertools import combinations_with_replacement

from refimpl.algorithms import boxes, rays, rounds
from refimpl.flat import polygons
from refimpl.flat.base import Flat
from refimpl.flat.polygon import ConvexPolygon
from refimpl.flat.rays import ray_convexpolygon, ray_segment
from refimpl.flat.shapes import Disc, FlatPoint, FlatRay, Rectangle, Segment
from refimpl.proxy import Proxy
from refimpl.rules import CLOSED, FINITE, Rule, require_rows

SOLIDS: tuple[type[Flat], ...] = (Disc, Segment, Rectangle, ConvexPolygon)
PROBES: tuple[type[Flat], ...] = (FlatPoint, FlatRay)

# fmt: off
# ruff: noqa: E501  a row of the table is a line
TABLE: dict[tuple[type[Proxy], type[Proxy]], Rule] = {
    (FlatPoint, Disc):              Rule(rounds.point_sphere, CLOSED, "distance to the centre", rounds.point_meets_sphere),
    (FlatPoint, Segment):           Rule(rounds.point_capsule, CLOSED, "nearest point of the segment", rounds.point_meets_capsule),
    (FlatPoint, Rectangle):         Rule(boxes.point_aabb, CLOSED, "clamping; nearest side inside", boxes.point_meets_aabb),
    (FlatPoint, ConvexPolygon):     Rule(polygons.point_convexpolygon, FINITE, "nearest point of the sides"),
    (FlatRay, Disc):                Rule(rays.ray_sphere, CLOSED, "half chord at the nearest point"),
    (FlatRay, Segment):             Rule(ray_segment, CLOSED, "sides and two end discs"),
    (FlatRay, Rectangle):           Rule(rays.ray_aabb, CLOSED, "two slabs"),
    (FlatRay, ConvexPolygon):       Rule(ray_convexpolygon, FINITE, "last of the sides that face the ray"),
    (Disc, Disc):                   Rule(rounds.sphere_sphere, CLOSED, "distance of the centres", rounds.sphere_meets_sphere),
    (Disc, Segment):                Rule(rounds.sphere_capsule, CLOSED, "nearest point of the segment", rounds.sphere_meets_capsule),
    (Disc, Rectangle):              Rule(boxes.sphere_aabb, CLOSED, "clamping; nearest side inside", boxes.sphere_meets_aabb),
    (Disc, ConvexPolygon):          Rule(polygons.disc_convexpolygon, FINITE, "nearest point of the sides"),
    (Segment, Segment):             Rule(polygons.segment_segment, FINITE, "origin against the Minkowski difference"),
    (Segment, Rectangle):           Rule(polygons.segment_rectangle, FINITE, "origin against the Minkowski difference"),
    (Segment, ConvexPolygon):       Rule(polygons.segment_convexpolygon, FINITE, "origin against the Minkowski difference"),
    (Rectangle, Rectangle):         Rule(boxes.aabb_aabb, CLOSED, "intervals of the two coordinates", boxes.aabb_meets_aabb),
    (Rectangle, ConvexPolygon):     Rule(polygons.rectangle_convexpolygon, FINITE, "origin against the Minkowski difference"),
    (ConvexPolygon, ConvexPolygon): Rule(polygons.convexpolygon_convexpolygon, FINITE, "origin against the Minkowski difference"),
}
# fmt: on

require_rows(TABLE, [(p, s) for p in PROBES for s in SOLIDS] + list(combinations_with_replacement(SOLIDS, 2)))


def table() -> dict[tuple[type[Proxy], type[Proxy]], Rule]:
    """Return the flat pair table: a row per pair of types, in the order in which its function takes them."""
    return dict(TABLE)
