"""Shapes that claims are about: moved, cut off, or made anew; and what the rounding of a move costs."""

from __future__ import annotations

import numpy as np

from oracles.world import world_of
from refimpl import KDOP, Box, Cylinder, HalfSpace, Point, Proxy, Ray, ShapeError
from refimpl.atoms import portions
from refimpl.linear import Array, Bools, dot, largest, norm, scale

FRAGILE = (Cylinder, KDOP)
"""Types that rounding a move may turn or bend: thin discs, slabs that nearly are parallel. The other shape is moved."""
ROUNDING = 2.0**-50
"""What rounding a sum of two vectors costs, relative to their largest coordinates, with room to spare."""

FARTHEST = 6.0
"""No part of a bounded solid is so many times its magnitude away from its reference point: two corners of the cube of
its coordinates are 2·√3 apart, and there may be a radius at one of them."""

WELL_PAST = 2.0
"""Time for which a ray goes on into a half-space: that has no size to measure the way by."""


def is_fragile(shape: Proxy) -> bool:
    """Whether rounding a move may turn or bend a shape, or a part of it."""
    return any(isinstance(part, FRAGILE) for part in portions(shape))


def moved_by(shape: Proxy, way: Array) -> tuple[Proxy, Bools]:
    """The shapes moved, and which of them could be: rounding a long move may leave flat slabs without any point."""
    try:
        return shape.translated(way), np.ones(len(way), dtype=bool)
    except ShapeError:
        can_move = np.array([_can_move(shape[i], step) for i, step in enumerate(way)])
        return shape.translated(np.where(can_move[:, None], way, 0.0)), can_move


def _can_move(shape: Proxy, way: Array) -> bool:
    try:
        shape.translated(way)
    except ShapeError:
        return False
    return True


def leverage(shape: Proxy) -> Array | float:
    """By how much the rounding of a move grows: rounding the ends of a flat disc's axis turns the disc."""
    found: Array | float = 1.0
    for part in portions(shape):
        if isinstance(part, Cylinder):
            found = np.maximum(found, 1.0 + part.radius / norm(part.q - part.p))
    return found


def rounding_of(u: Array, v: Array) -> Array:
    """What rounding a sum of two vectors costs, given one of them and the sum."""
    return ROUNDING * (largest(u) + largest(v))


def past(ray: Ray, b: Proxy) -> Array:
    """Time by which a ray is past anything of a bounded solid, or well past a half-space's near side.

    No farther than that: the rounding of a far end would hide how near a small solid the ray starts.
    """
    past_all = (norm(b.reference_point - ray.origin) + FARTHEST * b.magnitude) / norm(ray.direction)
    if isinstance(b, HalfSpace):
        past_all = past_all + np.where(dot(b.normal, ray.direction) < 0, WELL_PAST, 0.0)
    return np.asarray(past_all)


def tested(shape: Proxy) -> Proxy:
    """The shape as one that a point can be tested against: two points are no cell of the table."""
    if not isinstance(shape, Point):
        return shape
    return world_of(shape).rounded(shape.position, shape.position, np.zeros(len(shape)))


def cube_on(point: Array, outward: Array, half: Array) -> Box:
    """Cubes that stand on the plane through `point`, on the side to which `outward` points."""
    n = outward / norm(outward)[:, None]
    up = np.where(n[:, 2:] < 0, -n, n)
    turn = np.stack([-up[:, 1], up[:, 0], np.zeros(len(up)), 1.0 + up[:, 2]], axis=-1)
    return Box(point + scale(half, n), np.repeat(half[:, None], 3, axis=1), turn)
