"""Surfaces of boxes, by which trees are judged and built: how likely something at random meets a box."""

from __future__ import annotations

import numpy as np

from refimpl.linear import Array


def reach(lower: Array, upper: Array) -> int:
    """Exponent e such that no finite coordinate of boxes (n, D) exceeds 2^e."""
    most = 0.0
    for side in (lower, upper):
        most = max(most, float(np.max(np.abs(side), initial=0.0, where=np.isfinite(side))))
    return int(np.frexp(most)[1])


def bounded(lower: Array, upper: Array, exponent: int) -> tuple[Array, Array]:
    """Boxes (..., D) in units of 2^exponent, cut off at ±1: finite, and without overflow in what is made of them.

    Where one coordinate is no greater than another, it still is.
    """
    with np.errstate(over="ignore", under="ignore"):
        low, high = (np.clip(np.ldexp(side, -exponent), -1.0, 1.0) for side in (lower, upper))
    return low, high


def surface(extent: Array) -> Array:
    """Half the surface of boxes of these extents (..., 3), half the perimeter of those in the plane, (..., 2)."""
    if extent.shape[-1] == 2:
        return np.asarray(extent[..., 0] + extent[..., 1])
    x, y, z = extent[..., 0], extent[..., 1], extent[..., 2]
    return np.asarray(x * y + y * z + z * x)
