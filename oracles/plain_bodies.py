"""Plain bodies: the least proxies of each type, all of numbers that nobody has to read, and scenes of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oracles.scene import Cell, Scene
from oracles.solids import AXES, CORNERS, CUBE
from oracles.solids import block as cube_mesh
from oracles.world import world_of
from refimpl import flat
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

ORIGIN, ONES, UNIT = [0.0] * 3, [1.0] * 3, [0.0, 0.0, 0.0, 1.0]
ENDS = [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]
FLAT = [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]
CORNER = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""Corners of the least solid with round numbers."""
CORNER_FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
TURNED = [0.0, 0.0, 0.5, 1.0]

BALL, BOX = Sphere(ORIGIN, 1.0), Box(ORIGIN, ONES, UNIT)
HULL = ConvexPolyhedron.from_vertices(CORNER)

PLAIN_BODIES: dict[type[Proxy], tuple[Proxy, ...]] = {
    Point: (Point(ORIGIN),),
    Ray: tuple(
        Ray(o, d)
        for o in ([-2.0, 0.0, 0.0], ORIGIN, [-2.0, 0.5, 0.0])
        for d in ([1.0, 0.0, 0.0], [2.0, 0.5, 0.0], [1.0, 0.0, 1.0])
    ),
    Sphere: (BALL, Sphere(ORIGIN, 0.5)),
    Capsule: (Capsule(*ENDS, 1.0), Capsule(*FLAT, 0.5), Capsule(ORIGIN, [0.0, 1.0, 2.0], 0.5)),
    HalfSpace: (HalfSpace([0.0, 0.0, 1.0], 0.0), HalfSpace([1.0, 2.0, 2.0], 0.0)),
    AABB: (AABB([-1.0] * 3, ONES), AABB(ORIGIN, ONES)),
    Box: (BOX, Box(ORIGIN, [1.0, 0.5, 2.0], UNIT), Box(ORIGIN, ONES, TURNED)),
    KDOP: (
        KDOP(AXES, [-1.0] * 3, ONES),
        KDOP(AXES, ORIGIN, ONES),
        KDOP(AXES * [[2.0], [1.0], [1.0]], [-1.0] * 3, ONES),
        KDOP(np.concatenate([AXES, CORNERS]), [-1.0] * 3 + [-2.0] * 4, ONES + [2.0] * 4),
    ),
    Ellipsoid: (Ellipsoid(ORIGIN, [1.0, 0.5, 2.0]), Ellipsoid(ORIGIN, ONES)),
    Cylinder: (Cylinder(*ENDS, 1.0), Cylinder(*FLAT, 0.5), Cylinder(ORIGIN, [0.0, 1.0, 2.0], 0.5)),
    ConvexPolyhedron: (HULL, ConvexPolyhedron.from_vertices(CUBE), BOX.to_convex_polyhedron()),
    Polyhedron: (Polyhedron(CORNER, CORNER_FACES), Polyhedron(*cube_mesh(0.0))),
    Composite: (
        Composite([BOX]),
        Composite([BALL]),
        Composite([BOX, Sphere([0.0, 0.0, 2.0], 1.0)]),
        Composite([HULL]),
        Composite([Cylinder(*ENDS, 1.0)]),
        Composite([Capsule(*ENDS, 1.0)]),
    ),
}

BLOCK = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
PLAIN_BODIES |= {
    flat.FlatPoint: (flat.FlatPoint(np.zeros(2)),),
    flat.FlatRay: tuple(
        flat.FlatRay(np.array(o), np.array(d))
        for o in ([-2.0, 0.0], [0.0, 0.0], [-2.0, 0.5], [1.0, 0.0])
        for d in ([1.0, 0.0], [2.0, 0.5], [1.0, 1.0], [0.0, 1.0])
    ),
    flat.Disc: (flat.Disc([0.0, 0.0], 1.0), flat.Disc([0.0, 0.0], 0.5)),
    flat.Segment: (
        flat.Segment([-1.0, 0.0], [1.0, 0.0]),
        flat.Segment([0.0, 0.0], [0.0, 1.0]),
        flat.Segment([0.0, 0.0], [1.0, 2.0]),
        flat.Segment([0.0, -1.0], [0.0, 1.0], 0.5),
    ),
    flat.Rectangle: (
        flat.Rectangle([-1.0, -1.0], [1.0, 1.0]),
        flat.Rectangle([0.0, 0.0], [1.0, 1.0]),
        flat.Rectangle([-2.0, -0.5], [2.0, 0.5]),
        flat.Rectangle([-1.0, 0.0], [1.0, 0.0]),
    ),
    flat.ConvexPolygon: (
        flat.ConvexPolygon.from_vertices(BLOCK),
        flat.ConvexPolygon.from_vertices([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        flat.ConvexPolygon.from_vertices([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]),
    ),
}

OFFSETS = (
    (0.0, 0.0, 2.0),
    (2.0, 0.0, 0.0),
    (0.5, 0.0, 0.0),
    (0.0, 0.0, 0.5),
    (2.0, 2.0, 0.5),
    (1.0, 0.5, 2.0),
    (0.0, 0.0, 0.0),
    (0.5, 0.5, 0.5),
    (-1.0, 2.0, 0.0),
    (4.0, 0.0, 0.0),
)


def plain_pairs(cell: Cell) -> Iterator[Scene]:
    """Every plain A against every plain B at a few places; always the same."""
    axes = world_of(cell.type_b).axes
    for offset in dict.fromkeys(offset[:axes] for offset in OFFSETS):
        for a in PLAIN_BODIES[cell.type_a]:
            for b in PLAIN_BODIES[cell.type_b]:
                yield Scene(cell.query, a, b.translated(offset), "plain", "plain")
