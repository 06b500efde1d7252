"""The proxies: what is tested for collision, as immutable data.

Each constructor's docstring says which closed set its numbers mean.
"""

from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.shapes.boxes import AABB, Box
from refimpl.shapes.composite import Composite
from refimpl.shapes.convex import ConvexPolyhedron
from refimpl.shapes.curved import Cylinder, Ellipsoid
from refimpl.shapes.polyhedron import Polyhedron
from refimpl.shapes.polytopes import KDOP
from refimpl.shapes.simple import Capsule, HalfSpace, Point, Ray, Sphere

__all__ = [
    "AABB",
    "KDOP",
    "Box",
    "Capsule",
    "Composite",
    "ConvexPolyhedron",
    "Cylinder",
    "Ellipsoid",
    "HalfSpace",
    "Point",
    "Polyhedron",
    "Proxy",
    "Ray",
    "ShapeError",
    "Sphere",
    "UnsupportedOperation",
]
