"""Read bounded convex proxies as bodies for the search."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.proof.bodies import Body, Corners, Curved, Vertices, placed, scaled
from refimpl.proof.lines import Lines
from refimpl.proof.planes import Planes
from refimpl.proof.points import AXES, along, core, cross, dot, frame, minus, opposite, rationals, turned
from refimpl.shapes import AABB, Box


def _cylinder(shape: Any) -> Curved:
    p, q, radius = rationals(shape.p), rationals(shape.q), float(shape.radius)
    half = along((0, 0, 0), Fraction(1, 2), minus(q, p))
    way = scaled(half)
    side = scaled(cross(way, min(AXES, key=lambda axis: abs(dot(axis, way)))))
    disc = [along((0, 0, 0), radius / math.sqrt(dot(u, u)), u) for u in (side, cross(way, side))]
    return Curved(along(p, 1, half), [*disc, half], flat=True)


def body(shape: Any) -> Body:
    """Read a bounded convex proxy."""
    match type(shape).__name__:
        case "Ellipsoid":
            return _ellipsoid(shape)
        case "Cylinder":
            return _cylinder(shape)
        case "KDOP":
            above = np.column_stack([shape.directions, -shape.upper])
            below = np.column_stack([-shape.directions, shape.lower])
            return Planes(np.concatenate([above, below]), (0, 0, 0), AXES, lambda: shape.hull.vertices)
        case "ConvexPolyhedron":
            return _polyhedron(shape)
        case "ConvexPolygon":
            return _polygon(shape)
    found = Corners(*core(shape))
    if isinstance(shape, AABB | Box):
        found.flat = [n for axis in frame(shape)[2] for n in (axis, opposite(axis))]
    return found


def _polygon(shape: Any) -> Body:
    return Lines(shape.numbers) if shape.given == "lines" else Vertices([rationals(v) for v in shape.numbers])


def _ellipsoid(shape: Any) -> Body:
    centre, radii = rationals(shape.center), rationals(shape.radii)
    if len(set(radii)) == 1:
        return Corners([centre], radii[0])
    axes = zip(radii, turned(shape.rotation), strict=True)
    return Curved(centre, [along((0, 0, 0), r, column) for r, column in axes], flat=False)


def _polyhedron(shape: Any) -> Body:
    position, columns = rationals(shape.position), turned(shape.rotation)
    if shape.given == "planes":
        return Planes(shape.numbers, position, columns, lambda: shape.hull.vertices)
    return Vertices([placed(rationals(vertex), position, columns) for vertex in shape.numbers])
