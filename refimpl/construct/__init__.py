"""Proxies made from points and meshes.

Bounding volumes contain every given point, proven in exact arithmetic: a shape is proposed in doubles, and then
enlarged by the least that doubles allow, until not one point is outside by one bit. Colliders approximate a mesh by a
few shapes; `refimpl.construct.measures` tells how well.
"""

from refimpl.construct.balls import fast_sphere, sphere
from refimpl.construct.bounding import KINDS, bounding
from refimpl.construct.boxes import box, least_box
from refimpl.construct.decomposition import decomposed
from refimpl.construct.ellipsoids import ellipsoid
from refimpl.construct.fitting import (
    fitted_boxes,
    fitted_capsules,
    fitted_spheres,
    medial_spheres,
    packed_spheres,
)
from refimpl.construct.hierarchies import Hierarchy, hierarchy
from refimpl.construct.membership import contains
from refimpl.construct.polytopes import hull, simplified_hull
from refimpl.construct.rods import capsule, cylinder
from refimpl.construct.slabs import aabb, kdop
from refimpl.construct.sources import ConstructionError, points_of

__all__ = [
    "KINDS",
    "ConstructionError",
    "Hierarchy",
    "aabb",
    "bounding",
    "box",
    "capsule",
    "contains",
    "cylinder",
    "decomposed",
    "ellipsoid",
    "fast_sphere",
    "fitted_boxes",
    "fitted_capsules",
    "fitted_spheres",
    "hierarchy",
    "hull",
    "kdop",
    "least_box",
    "medial_spheres",
    "packed_spheres",
    "points_of",
    "simplified_hull",
    "sphere",
]
