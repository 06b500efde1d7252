"""The proxies of the plane, in exact arithmetic, as sets of the plane z = 0: part of what has to be believed.

What is claimed about two sets of space holds for two of that plane as well, if no direction leaves it. Only a depth
needs a claim of its own, for no set of the plane has one in space.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from refimpl.proof.claims import Bound
from refimpl.proof.rational import InvalidCertificate, require, spend, whole
from refimpl.proof.reading import AXES, Fields, behind, product, segment
from refimpl.proof.reading import read as read_solid
from refimpl.proof.sets import Hull, Line, Planes, Points, Product
from refimpl.proof.vectors import NONE, Exact, Whole, cross, dot, minus, times


class Flat(NamedTuple):
    """A core widened by discs of the plane z = 0: see `sets`."""

    core: Product | Planes | Hull

    @property
    def radius(self) -> Fraction:
        """Radius of the discs."""
        return self.core.radius

    def support(self, n: Whole, faces: Any = ()) -> Fraction:
        """Largest n·x over the core."""
        require(n[2] == 0, "n: not a direction of the plane")
        return self.core.support(n, faces)

    def member(self, point: Any, widened: bool = False) -> tuple[Exact, Fraction]:
        """The point, and how far it is outside."""
        found, outside = self.core.member(point, widened)
        require(found[2] == 0, "point: not in the plane")
        return found, outside

    def holds(self, _centre: Exact, _columns: Sequence[Exact], _share: Fraction) -> bool:
        """No solid ellipsoid lies in a plane."""
        return False


def planar(*sets: Any) -> bool:
    """Whether all sets are of the plane."""
    return all(isinstance(one, Flat) for one in sets)


def polygon(points: Sequence[Exact], triangles: Any) -> Fraction:
    """Square of the radius of a disc around 0 in the hull of `points` of the plane, proven by the line through them.

    Every edge must have 0 to its left. Then the line, seen from 0, only turns anticlockwise, and being closed, it comes
    to every direction. So no ray from 0 leaves the hull before it meets some edge.
    """
    require(points and not triangles, "pairs: none, or triangles in the plane")
    least: Bound = math.inf
    for i, point in enumerate(points):
        spend(16)
        (u, v), unit = whole([points[i - 1], point])
        area, edge = cross(u, v)[2], minus(v, u)
        require(area > 0, "pairs: 0 is not to the left of an edge")
        least = min(least, Fraction(area * area, dot(edge, edge) * unit * unit))
    return Fraction(least)


def flat(field: Fields, name: str) -> Exact:
    """A vector of the plane."""
    return [*field(name, 2), NONE]


def _ray(field: Fields) -> Line:
    direction = flat(field, "direction")
    field.refuse("direction", not any(direction))
    return Line(flat(field, "origin"), direction)


def _rectangle(field: Fields) -> Flat:
    low, high = flat(field, "lower"), flat(field, "upper")
    half = times(Fraction(1, 2), minus(high, low))
    field.refuse("upper", min(half) < 0)
    return Flat(product(minus(high, half), [[times(half[i], AXES[i])] for i in (0, 1)]))


def _convex_polygon(field: Fields) -> Flat:
    match getattr(field.shape, "given", None):
        case "lines":
            return Flat(behind([[x, y, 0, k] for x, y, k in field.rows("numbers", 3)], [NONE] * 3, AXES))
        case "vertices":
            places, unit = whole([[x, y, 0] for x, y in field.rows("numbers", 2)])
            return Flat(Hull(Points(places, unit), range(len(places))))
    raise InvalidCertificate("ConvexPolygon.given: must be 'lines' or 'vertices'")


PLANE: dict[str, Callable[[Fields], Any]] = {
    "FlatPoint": lambda field: Flat(product(flat(field, "position"), [])),
    "FlatRay": _ray,
    "Disc": lambda field: Flat(product(flat(field, "center"), [], *field("radius", 1, least=0))),
    "Segment": lambda field: Flat(segment(flat(field, "p"), flat(field, "q"), *field("radius", 1, least=0))),
    "Rectangle": _rectangle,
    "ConvexPolygon": _convex_polygon,
}


def read(shape: Any) -> Any:
    """Take a convex proxy, of the plane or of space."""
    meaning = PLANE.get(type(shape).__name__)
    return read_solid(shape) if meaning is None else meaning(Fields(shape))


def is_of_plane(shape: Any) -> bool:
    """Whether a proxy is one of the plane, by the name of its type."""
    return type(shape).__name__ in PLANE
