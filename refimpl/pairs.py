"""The table: one row per pair of types, with its algorithm and its exactness class.

The lecture's "VS" table. It is literal, so that it reads as the matrix it is; a pair without a row is an error
when this module is imported, not when somebody meets it.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

from refimpl.algorithms import boxes, curved, halfspaces, polytopes, rays, rounds, union_rays, unions
from refimpl.rules import CLOSED, FINITE, ITERATIVE, Rule, require_rows
from refimpl.shapes import (
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

__all__ = ["CLOSED", "FINITE", "ITERATIVE", "PROBES", "SOLIDS", "TABLE", "Rule", "required_pairs", "table"]

SOLIDS: tuple[type[Proxy], ...] = (
    Sphere, Capsule, HalfSpace, AABB, Box, KDOP, Ellipsoid, Cylinder, ConvexPolyhedron, Polyhedron, Composite,
)  # fmt: skip
PROBES: tuple[type[Proxy], ...] = (Point, Ray)

# fmt: off
# ruff: noqa: E501  a row of the table is a line
TABLE: dict[tuple[type[Proxy], type[Proxy]], Rule] = {
    (Point, Sphere):                  Rule(rounds.point_sphere, CLOSED, "distance to the centre", rounds.point_meets_sphere),
    (Point, Capsule):                 Rule(rounds.point_capsule, CLOSED, "nearest point of the axis", rounds.point_meets_capsule),
    (Point, HalfSpace):               Rule(halfspaces.point_halfspace, CLOSED, "height above the plane"),
    (Point, AABB):                    Rule(boxes.point_aabb, CLOSED, "clamping; nearest face inside", boxes.point_meets_aabb),
    (Point, Box):                     Rule(boxes.point_box, CLOSED, "clamping in the box's frame", boxes.point_meets_box),
    (Point, KDOP):                    Rule(polytopes.point_kdop, FINITE, "closest features; nearest face inside", whole=True),
    (Point, Ellipsoid):               Rule(curved.point_ellipsoid, ITERATIVE, "root of a monotone function, bracketed"),
    (Point, Cylinder):                Rule(curved.point_cylinder, CLOSED, "nearest of side, caps and rims"),
    (Point, ConvexPolyhedron):        Rule(polytopes.point_convexpolyhedron, FINITE, "closest features; nearest face inside", whole=True),
    (Point, Polyhedron):              Rule(unions.union_pair, FINITE, "nearest triangle; winding number", unions.unions_meet, unions.overlap_bounds),
    (Point, Composite):               Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Ray, Sphere):                    Rule(rays.ray_sphere, CLOSED, "half chord at the nearest point"),
    (Ray, Capsule):                   Rule(rays.ray_capsule, CLOSED, "side and two end balls"),
    (Ray, HalfSpace):                 Rule(rays.ray_halfspace, CLOSED, "height over speed"),
    (Ray, AABB):                      Rule(rays.ray_aabb, CLOSED, "three slabs"),
    (Ray, Box):                       Rule(rays.ray_box, CLOSED, "three slabs in the box's frame"),
    (Ray, KDOP):                      Rule(rays.ray_kdop, CLOSED, "k slabs"),
    (Ray, Ellipsoid):                 Rule(rays.ray_ellipsoid, CLOSED, "half chord in the frame of the unit ball"),
    (Ray, Cylinder):                  Rule(rays.ray_cylinder, CLOSED, "side and two caps"),
    (Ray, ConvexPolyhedron):          Rule(rays.ray_convexpolyhedron, FINITE, "clipping by every face's plane"),
    (Ray, Polyhedron):                Rule(union_rays.union_ray, FINITE, "first of the triangles; winding number at the start"),
    (Ray, Composite):                 Rule(union_rays.union_ray, ITERATIVE, "first of the parts"),
    (Sphere, Sphere):                 Rule(rounds.sphere_sphere, CLOSED, "distance of the centres", rounds.sphere_meets_sphere),
    (Sphere, Capsule):                Rule(rounds.sphere_capsule, CLOSED, "nearest point of the axis", rounds.sphere_meets_capsule),
    (Sphere, HalfSpace):              Rule(halfspaces.sphere_halfspace, CLOSED, "height of the centre"),
    (Sphere, AABB):                   Rule(boxes.sphere_aabb, CLOSED, "clamping; nearest face inside", boxes.sphere_meets_aabb),
    (Sphere, Box):                    Rule(boxes.sphere_box, CLOSED, "clamping in the box's frame", boxes.sphere_meets_box),
    (Sphere, KDOP):                   Rule(polytopes.sphere_kdop, FINITE, "closest features; nearest face inside", whole=True),
    (Sphere, Ellipsoid):              Rule(curved.sphere_ellipsoid, ITERATIVE, "root of a monotone function, bracketed"),
    (Sphere, Cylinder):               Rule(curved.sphere_cylinder, CLOSED, "nearest of side, caps and rims"),
    (Sphere, ConvexPolyhedron):       Rule(polytopes.sphere_convexpolyhedron, FINITE, "closest features; nearest face inside", whole=True),
    (Sphere, Polyhedron):             Rule(unions.union_pair, FINITE, "nearest triangle; winding number", unions.unions_meet, unions.overlap_bounds),
    (Sphere, Composite):              Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Capsule, Capsule):               Rule(rounds.capsule_capsule, CLOSED, "closest points of two segments", symmetric=True),
    (Capsule, HalfSpace):             Rule(halfspaces.capsule_halfspace, CLOSED, "height of the lower end"),
    (Capsule, AABB):                  Rule(boxes.capsule_aabb, FINITE, "segment and box: closest features, 6 axes", whole=True),
    (Capsule, Box):                   Rule(boxes.capsule_box, FINITE, "segment and box: closest features, 6 axes", whole=True),
    (Capsule, KDOP):                  Rule(polytopes.capsule_kdop, FINITE, "closest features; separating axes", whole=True),
    (Capsule, Ellipsoid):             Rule(curved.capsule_ellipsoid, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Capsule, Cylinder):              Rule(curved.capsule_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Capsule, ConvexPolyhedron):      Rule(polytopes.capsule_convexpolyhedron, FINITE, "closest features; separating axes", whole=True),
    (Capsule, Polyhedron):            Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Capsule, Composite):             Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (HalfSpace, HalfSpace):           Rule(halfspaces.halfspace_halfspace, CLOSED, "facing exactly, or without end"),
    (HalfSpace, AABB):                Rule(halfspaces.halfspace_aabb, CLOSED, "height of the lowest corner"),
    (HalfSpace, Box):                 Rule(halfspaces.halfspace_box, CLOSED, "height of the lowest corner"),
    (HalfSpace, KDOP):                Rule(polytopes.halfspace_kdop, CLOSED, "height of the lowest corner"),
    (HalfSpace, Ellipsoid):           Rule(curved.halfspace_ellipsoid, CLOSED, "height of the lowest point"),
    (HalfSpace, Cylinder):            Rule(curved.halfspace_cylinder, CLOSED, "height of the lowest point"),
    (HalfSpace, ConvexPolyhedron):    Rule(polytopes.halfspace_convexpolyhedron, CLOSED, "height of the lowest corner"),
    (HalfSpace, Polyhedron):          Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (HalfSpace, Composite):           Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (AABB, AABB):                     Rule(boxes.aabb_aabb, CLOSED, "intervals of the three coordinates", boxes.aabb_meets_aabb),
    (AABB, Box):                      Rule(boxes.aabb_box, FINITE, "closest features, 15 separating axes", boxes.aabb_meets_box, whole=True),
    (AABB, KDOP):                     Rule(polytopes.aabb_kdop, FINITE, "closest features; separating axes", whole=True),
    (AABB, Ellipsoid):                Rule(curved.aabb_ellipsoid, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (AABB, Cylinder):                 Rule(curved.aabb_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (AABB, ConvexPolyhedron):         Rule(polytopes.aabb_convexpolyhedron, FINITE, "closest features; separating axes", whole=True),
    (AABB, Polyhedron):               Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (AABB, Composite):                Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Box, Box):                       Rule(boxes.box_box, FINITE, "closest features, 15 separating axes", boxes.box_meets_box, symmetric=True, whole=True),
    (Box, KDOP):                      Rule(polytopes.box_kdop, FINITE, "closest features; separating axes", whole=True),
    (Box, Ellipsoid):                 Rule(curved.box_ellipsoid, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Box, Cylinder):                  Rule(curved.box_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Box, ConvexPolyhedron):          Rule(polytopes.box_convexpolyhedron, FINITE, "closest features; separating axes", whole=True),
    (Box, Polyhedron):                Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Box, Composite):                 Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (KDOP, KDOP):                     Rule(polytopes.kdop_kdop, FINITE, "closest features; separating axes", symmetric=True, whole=True),
    (KDOP, Ellipsoid):                Rule(curved.kdop_ellipsoid, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (KDOP, Cylinder):                 Rule(curved.kdop_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (KDOP, ConvexPolyhedron):         Rule(polytopes.kdop_convexpolyhedron, FINITE, "closest features; separating axes", whole=True),
    (KDOP, Polyhedron):               Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (KDOP, Composite):                Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Ellipsoid, Ellipsoid):           Rule(curved.ellipsoid_ellipsoid, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Ellipsoid, Cylinder):            Rule(curved.ellipsoid_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Ellipsoid, ConvexPolyhedron):    Rule(curved.ellipsoid_convexpolyhedron, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Ellipsoid, Polyhedron):          Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Ellipsoid, Composite):           Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Cylinder, Cylinder):             Rule(curved.cylinder_cylinder, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Cylinder, ConvexPolyhedron):     Rule(curved.cylinder_convexpolyhedron, ITERATIVE, "GJK or expanding polytope, then Newton on the normal"),
    (Cylinder, Polyhedron):           Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Cylinder, Composite):            Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (ConvexPolyhedron, ConvexPolyhedron): Rule(polytopes.convexpolyhedron_convexpolyhedron, FINITE, "closest features; separating axes", symmetric=True, whole=True),
    (ConvexPolyhedron, Polyhedron):   Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (ConvexPolyhedron, Composite):    Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Polyhedron, Polyhedron):         Rule(unions.union_pair, FINITE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Polyhedron, Composite):          Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
    (Composite, Composite):           Rule(unions.union_pair, ITERATIVE, "least over pairs of convex pieces", unions.unions_meet, unions.overlap_bounds),
}
# fmt: on


def required_pairs() -> list[tuple[type[Proxy], type[Proxy]]]:
    """Every cell that the table must fill: probes against solids, and solids among themselves."""
    probes = [(probe, solid) for probe in PROBES for solid in SOLIDS]
    return probes + list(combinations_with_replacement(SOLIDS, 2))


def require_complete(rows: dict[tuple[type[Proxy], type[Proxy]], Rule]) -> None:
    """Raise LookupError for a missing row, or for one that no pair needs."""
    require_rows(rows, required_pairs())


require_complete(TABLE)


def table() -> dict[tuple[type[Proxy], type[Proxy]], Rule]:
    """Return the pair table: a row per pair of types, in the order in which its function takes them."""
    return dict(TABLE)
