"""Support function, bounding box and bounding sphere of every proxy.

Bounding volumes contain their proxy as exact sets: whatever is rounded is rounded outwards.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from refimpl.intervals import plus_rounded
from refimpl.linear import (
    Array,
    apply,
    apply_inverse,
    as_floats,
    dot,
    largest,
    norm,
    power_of_two,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.proxy import Proxy, UnsupportedOperation
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Ray,
    Sphere,
)

SLACK = 32 * 2.0**-53  # more than a rotation matrix, a square root and a sum of three lose together
LEAST = 1e-300  # more than is lost where numbers vanish beside the shape's size


def support(shape: Proxy, n: Any) -> Array:
    """Support function h(n) = max over x in the shape of n·x.

    Parameters
    ----------
    shape : any proxy
    n : (..., 3)
        Of any length; batch shapes broadcast.

    Returns
    -------
    (...)
        Infinite where the shape is unbounded along `n`.
    """
    way = as_floats(n)
    if isinstance(shape, Ray):
        return np.where(dot(way, shape.direction) > 0, np.inf, dot(way, shape.origin))[()]
    if isinstance(shape, HalfSpace):
        along, size = dot(way, shape.normal), dot(shape.normal, shape.normal)
        parallel = np.all(_cross(way, shape.normal) == 0, axis=-1) & (along >= 0)
        return np.where(parallel, -shape.k * (along / size), np.inf)[()]
    return dot(way, support_point(shape, way))[()]


def support_point(shape: Proxy, n: Any) -> Array:
    """Point of a bounded proxy that is farthest along `n` (..., 3); some such point where several are.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which have none along most directions.
    """
    way = as_floats(n)
    return _of(SUPPORTS, shape, "support point")(shape, way)[()]


def aabb(shape: Proxy) -> AABB:
    """Axis-aligned bounding box: contains the proxy, and is larger than the smallest by rounding only.

    Raises
    ------
    UnsupportedOperation
        For a ray or half-space, which are unbounded.
    """
    bounds = _of(BOXES, shape, "bounding box")
    exponent = power_of_two(shape.magnitude)
    middle, reach = bounds(shape.times_power(-exponent))
    return AABB(plus_rounded(middle, -reach, -np.inf), plus_rounded(middle, reach, np.inf)).times_power(exponent)
