"""A readable reference implementation of the collision half of a 3D game physics lecture.

Proxies are immutable data (`refimpl.shapes`); `intersect`, `distance`, `collide` and `raycast` answer for every
pair of them, alone or in batches; `table` names the algorithm of each pair; `certify` proves an answer, and
`proof.check` verifies the proof in exact arithmetic without believing anything else here.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from refimpl.bounds import aabb, bounding_sphere
from refimpl.contacts import Contacts, contacts
from refimpl.loading import from_trimesh, load_hulls, load_polyhedron
from refimpl.mass import MassProperties, mass_properties
from refimpl.motions import RigidMotion, Translation
from refimpl.pairs import table
from refimpl.queries import collide, distance, intersect, raycast
from refimpl.results import CollisionData, RayHit, Separation
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
    ShapeError,
    Sphere,
    UnsupportedOperation,
)
from refimpl.supports import support, support_point
from refimpl.sweeps import SweepHit, SweptShape, sweep, swept

if TYPE_CHECKING:
    from refimpl.proof import certify
else:

    def __getattr__(name: str) -> object:
        """Import the proofs when they are first named: whoever asks for distances alone starts a third faster."""
        if name in ("proof", "certify"):
            proof = import_module("refimpl.proof")
            return proof if name == "proof" else proof.certify
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "AABB",
    "KDOP",
    "Box",
    "Capsule",
    "CollisionData",
    "Composite",
    "Contacts",
    "ConvexPolyhedron",
    "Cylinder",
    "Ellipsoid",
    "HalfSpace",
    "MassProperties",
    "Point",
    "Polyhedron",
    "Proxy",
    "Ray",
    "RayHit",
    "RigidMotion",
    "Separation",
    "ShapeError",
    "Sphere",
    "SweepHit",
    "SweptShape",
    "Translation",
    "UnsupportedOperation",
    "aabb",
    "bounding_sphere",
    "certify",
    "collide",
    "contacts",
    "distance",
    "from_trimesh",
    "intersect",
    "load_hulls",
    "load_polyhedron",
    "mass_properties",
    "raycast",
    "support",
    "support_point",
    "sweep",
    "swept",
    "table",
]
