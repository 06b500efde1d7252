"""Relations of form: the same set written otherwise, and sets that contain it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from oracles.growth import CORNERS, grown, growth
from oracles.images import rewritten
from oracles.motion import Motion
from oracles.promises import Bounds
from oracles.reference import UNIONS
from oracles.refinements import refined, refined_surface
from oracles.related import GROWN, Asked, Carried, Image, image_of
from oracles.relation import FORM, exactly, relation
from oracles.scene import RAYCAST
from oracles.sweep_images import no_later
from oracles.world import is_flat, world_of
from refimpl.flat import ConvexPolygon, Disc, FlatPoint, Rectangle, Segment
from refimpl.linear import power_of_two
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Composite,
    ConvexPolyhedron,
    Point,
    Polyhedron,
    Proxy,
    Sphere,
)

GROWTH = -3
"""Power of two, relative to the scene's size, by which proxies are grown."""
ROUNDED = 2.0**-48
"""How far the corners of an AABB may be off when it is written as a box, relative to its largest number."""


@relation("writing the same sets in other numbers", FORM)
def same_sets(asked: Asked) -> Iterator[Image]:
    """Ends of a capsule, order of vertices and parts, length of a normal or quaternion mean nothing."""
    if isinstance(asked.motion, Motion) or all(rewritten(side) is None for side in asked.sides):
        return
    yield image_of(asked, lambda _, shape: exactly(rewritten(shape) or shape))


@relation("refining a mesh")
def finer_mesh(asked: Asked) -> Iterator[Image]:
    """More triangles of the same surface are the same solid: leaks between triangles, and trees of boxes, show."""
    for side, mesh in enumerate(asked.sides):
        found = refined(mesh) if isinstance(mesh, Polyhedron) else None
        if found is None:
            continue
        finer, plan = found

        def carry(
            here: int, shape: Proxy, side: int = side, mesh: Proxy = mesh, finer: Proxy = finer, plan: object = plan
        ) -> Carried:
            if here != side:
                return exactly(shape)
            if shape is mesh:
                return exactly(finer)
            cut = refined_surface(shape, plan) if isinstance(shape, Composite) else None  # type: ignore[arg-type]
            return (shape, np.full(len(shape), np.inf)) if cut is None else exactly(cut)

        yield image_of(asked, carry)


Replace = Callable[[Proxy], Carried | None]


def _replaced(asked: Asked, instead: Replace) -> Iterator[Image]:
    """One image for each side that has an equal proxy of another type."""
    if isinstance(asked.motion, Motion):
        return
    for side, shape in enumerate(asked.sides):
        made = instead(shape)
        if made is None:
            continue

        def carry(here: int, given: Proxy, side: int = side) -> Carried:
            found = instead(given) if here == side else None
            return found or exactly(given)

        yield image_of(asked, carry).in_table_order()


@relation("writing a sphere as an ellipsoid", FORM)
def as_ellipsoid(asked: Asked) -> Iterator[Image]:
    """A ball is an ellipsoid of equal radii: another algorithm for the same set."""
    yield from _replaced(asked, lambda s: exactly(s.to_ellipsoid()) if isinstance(s, Sphere) else None)


def _capsule(shape: Proxy) -> Carried | None:
    rounded = world_of(shape).rounded
    if isinstance(shape, Sphere | Disc):
        return exactly(rounded(shape.center, shape.center, shape.radius))
    return exactly(rounded(shape.position, shape.position, np.zeros(len(shape)))) if isinstance(shape, Point) else None


@relation("writing a ball, disc or point as a capsule", FORM)
def as_capsule(asked: Asked) -> Iterator[Image]:
    """A capsule of length 0 is a ball, of radius 0 too a point: axes that vanish divide by zero."""
    yield from _replaced(asked, _capsule)


def _box(shape: Proxy) -> Carried | None:
    if isinstance(shape, FlatPoint):
        return exactly(Rectangle(shape.position, shape.position))
    if isinstance(shape, Point):
        upright = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(shape), 4))
        return exactly(Box(shape.position, np.zeros((len(shape), 3)), upright))
    return (shape.to_box(), ROUNDED * shape.magnitude) if isinstance(shape, AABB) else None


@relation("writing an AABB or point as a box", FORM)
def as_box(asked: Asked) -> Iterator[Image]:
    """An AABB is a box without rotation, a point one without size: flat boxes have faces without area."""
    yield from _replaced(asked, _box)


def _slabs(shape: Proxy) -> Carried | None:
    if isinstance(shape, Rectangle):
        sides = np.broadcast_to(np.concatenate([np.eye(2), -np.eye(2)]), (len(shape), 4, 2))
        offsets = np.concatenate([-shape.upper, shape.lower], axis=1)
        return exactly(ConvexPolygon(np.concatenate([sides, offsets[:, :, None]], axis=-1)))
    if not isinstance(shape, AABB):
        return None
    directions = np.broadcast_to(np.eye(3), (len(shape), 3, 3))
    return exactly(KDOP(directions, shape.lower, shape.upper))


@relation("writing an AABB or rectangle as slabs", FORM)
def as_kdop(asked: Asked) -> Iterator[Image]:
    """An AABB is the k-DOP of three slabs along the axes, a rectangle the polygon of two."""
    yield from _replaced(asked, _slabs)


def _hull(shape: Proxy) -> Carried | None:
    if isinstance(shape, Box):
        corners = CORNERS * shape.half_extents[:, None, :]
        return exactly(ConvexPolyhedron.from_vertices(corners, shape.center, shape.rotation))
    if isinstance(shape, AABB):
        corners = np.where(CORNERS > 0, shape.upper[:, None, :], shape.lower[:, None, :])
        return exactly(ConvexPolyhedron.from_vertices(corners))
    if isinstance(shape, Rectangle):
        return exactly(shape.to_polygon())
    if isinstance(shape, Segment):
        bare = shape.radius == 0
        return ConvexPolygon.from_vertices(np.stack([shape.p, shape.q], axis=1)), np.where(bare, 0.0, np.inf)
    if isinstance(shape, KDOP):
        normals = np.concatenate([shape.directions, -shape.directions], axis=1)
        offsets = np.concatenate([-shape.upper, shape.lower], axis=1)
        return exactly(ConvexPolyhedron(np.concatenate([normals, offsets[:, :, None]], axis=-1)))
    return None


@relation("writing a box, k-DOP, rectangle or segment as a hull", FORM)
def as_hull(asked: Asked) -> Iterator[Image]:
    """Boxes are hulls of eight corners, k-DOPs of planes, segments of two points: special cases against the general."""
    yield from _replaced(asked, _hull)


@relation("writing a proxy as a composite of itself", FORM)
def as_composite(asked: Asked) -> Iterator[Image]:
    """A union of one part is that part: the way through compounds and their frames must change nothing."""
    yield from _replaced(asked, lambda s: None if not s.is_solid or _alone(s) else exactly(Composite([s])))


def _alone(shape: Proxy) -> bool:
    """Whether a proxy is a union, or of the plane, which has none."""
    return isinstance(shape, UNIONS) or is_flat(shape)


@relation("growing a proxy", contradiction="growing a proxy moves it away")
def larger(asked: Asked) -> Iterator[Image]:
    """A larger set is nowhere farther: a distance never grows with it, an overlap never ends, no hit comes later."""
    if isinstance(asked.motion, Motion):
        return
    by = np.ldexp(1.0, power_of_two(np.maximum(asked.size, np.finfo(float).tiny)) + GROWTH)
    for side, shape in enumerate(asked.sides):
        if not shape.is_solid:
            continue

        def carry(here: int, given: Proxy, side: int = side) -> Carried:
            return exactly(grown(given, by) if here == side else given)

        least, most = growth(shape, grown(shape, by), by)
        if set(map(type, asked.sides)) & set(UNIONS):
            least, most = np.zeros(len(by)), np.full(len(by), np.inf)  # unions may be grown into each other
        bounds = Bounds(asked.bounds.low - most, asked.bounds.high - least)
        if asked.cell.query == RAYCAST:
            bounds = Bounds(np.full(len(by), -np.inf), asked.bounds.high)
        yield image_of(asked, carry, expected=bounds, alike=GROWN, timing=no_later)
