"""Bounding volumes that move with their bodies: turned, moved, and grown by whatever that rounds.

A volume that is rounded apart from its collider could end up too small by the last bits, and reject a pair that
touches. So it is grown by more than both are rounded by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from refimpl.bounds import SLACK, bounding_sphere
from refimpl.linear import Array, largest, scale, unit_or
from refimpl.proxy import Proxy, ShapeError, UnsupportedOperation
from refimpl.shapes import AABB, KDOP, Box, Capsule, Composite, Cylinder, Ellipsoid, HalfSpace, Sphere
from refimpl.shapes.polytopes import USUAL_DIRECTIONS
from refimpl.supports import support

DIRECTIONS = np.concatenate([unit_or(USUAL_DIRECTIONS[26], np.eye(3)[0])[0] * sign for sign in (1.0, -1.0)])


def bounding_volume(collider: Proxy) -> Proxy:
    """Give a ball around a collider; what has no end is its own volume."""
    return collider if is_endless(collider) else bounding_sphere(collider)


def is_endless(shape: Proxy) -> bool:
    """Whether a solid has no bounding box: a half-space, or a union with one."""
    return isinstance(shape, HalfSpace) or (isinstance(shape, Composite) and any(map(is_endless, shape.parts)))


def require_around(volume: Proxy, collider: Proxy) -> None:
    """Refuse a volume that reaches less far than the collider along one of 26 directions.

    This finds the volume of another collider or in another frame, not every volume that is slightly too small.

    Raises
    ------
    ShapeError
        Names the direction, and by how much.
    UnsupportedOperation
        For a volume of a type that cannot be grown.
    """
    if volume is collider:
        return
    if type(volume) not in GROW:
        known = ", ".join(kind.__name__ for kind in GROW)
        raise UnsupportedOperation(f"a {type(volume).__name__} is no bounding volume: take one of {known}")
    within, around = support(collider, DIRECTIONS), support(volume, DIRECTIONS)
    short = np.where(np.isinf(around), -np.inf, within - around)
    worst = int(np.argmax(short))
    if short[worst] > SLACK * (largest(within[np.isfinite(within)]) + np.abs(around[worst])):
        raise ShapeError(
            f"Body.volume: the {type(volume).__name__} does not contain the {type(collider).__name__}, which reaches "
            f"{short[worst]:g} farther along {np.round(DIRECTIONS[worst], 3).tolist()}"
        )


def placed(shape: Proxy, rotation: Array, position: Array) -> Proxy:
    """Turn a batch of shapes about the origin and move it; what is not turned need not be of a type that can be."""
    still = not np.any(rotation[..., :3])
    return shape.translated(position) if still else shape.transformed(rotation, position)


def placed_volume(volume: Proxy, rotation: Array, position: Array, lower: Array, upper: Array) -> Proxy:
    """Place a batch of volumes so that they contain their placed colliders, as exact sets.

    Parameters
    ----------
    volume : a batch of n
    rotation, position : (n, 4) and (n, 3)
    lower, upper : (n, 3)
        Boxes of the placed colliders. An AABB cannot turn with its body, and becomes that box.
    """
    if isinstance(volume, AABB):
        return AABB(lower, upper)
    there = placed(volume, rotation, position)
    if type(there) not in GROW:
        return there
    size = there.magnitude + largest(position) + np.maximum(largest(lower), largest(upper))
    return GROW[type(there)](there, 2 * SLACK * size)


def _longer(volume: Cylinder, by: Array) -> Cylinder:
    axis = scale(by, unit_or(volume.q - volume.p, np.eye(3)[0])[0])
    return replace(volume, p=volume.p - axis, q=volume.q + axis, radius=volume.radius + by)


def _wider(volume: KDOP, by: Array) -> KDOP:
    reach = by[..., None] * np.sqrt(3.0) * largest(volume.directions)
    return KDOP(volume.directions, volume.lower - reach, volume.upper + reach)


def _swollen(volume: Ellipsoid, by: Array) -> Ellipsoid:
    """Scale by as much as the shortest radius needs: radii that are longer by the same do not contain it."""
    return replace(volume, radii=scale(1 + by / np.min(volume.radii, axis=-1), volume.radii))


GROW: dict[type[Proxy], Callable[[Any, Array], Proxy]] = {
    Sphere: lambda v, by: replace(v, radius=v.radius + by),
    Capsule: lambda v, by: replace(v, radius=v.radius + by),
    AABB: lambda v, by: AABB(v.lower - by[..., None], v.upper + by[..., None]),
    Box: lambda v, by: replace(v, half_extents=v.half_extents + by[..., None]),
    KDOP: _wider,
    Ellipsoid: _swollen,
    Cylinder: _longer,
}
"""How each type of volume contains all that is no farther than so much (...) from it."""
