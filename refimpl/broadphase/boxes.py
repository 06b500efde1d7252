"""Arrays of closed axis-aligned boxes, points and rays: what is accepted, and as what."""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.linear import Array, Bools, as_floats
from refimpl.proxy import ShapeError

DIMENSIONS = (2, 3)


def as_boxes(lower: Any, upper: Any, dimension: int | None = None) -> tuple[Array, Array]:
    """Corners (N, D) as arrays of their own; of one box, (D,) will do.

    Raises
    ------
    ShapeError
        Names the first box that has a NaN, a lower corner above the upper one, or no finite point.
    """
    low, up = _vectors("lower", lower, dimension), _vectors("upper", upper, dimension)
    if low.shape != up.shape:
        raise ShapeError(f"lower and upper differ in shape: {low.shape} and {up.shape}")
    for name, values in (("lower", low), ("upper", up)):
        _refuse(f"{name} must not be NaN", np.isnan(values), low, up)
    _refuse("lower must not be above upper", low > up, low, up)
    _refuse("a box must have a finite point", (low == np.inf) | (up == -np.inf), low, up)
    return low, up


def as_points(points: Any, dimension: int) -> Array:
    """Finite points (N, D); of one point, (D,) will do."""
    found = _vectors("points", points, dimension)
    _refuse("points must be finite", ~np.isfinite(found), found)
    return found


def as_rays(origin: Any, direction: Any, length: Any, dimension: int) -> tuple[Array, Array, Array]:
    """Origins and directions (N, D), and lengths (N,)."""
    start, way = _vectors("origin", origin, dimension), _vectors("direction", direction, dimension)
    if start.shape != way.shape:
        raise ShapeError(f"origin and direction differ in shape: {start.shape} and {way.shape}")
    _refuse("origin must be finite", ~np.isfinite(start), start)
    _refuse("direction must be finite", ~np.isfinite(way), way)
    _refuse("direction must not be zero", np.all(way == 0, axis=1, keepdims=True), way)
    try:
        end = np.broadcast_to(as_floats(length), (len(start),))
    except ValueError:
        raise ShapeError(f"length: expected {len(start)} numbers, got an array of {np.shape(length)}") from None
    _refuse("length must be at least 0", ~(end >= 0)[:, None], end[:, None])
    return start, way, end


def as_flags(static: Any, count: int) -> Bools:
    """One flag for each of `count` objects; None means that none is set."""
    flags = np.asarray(False if static is None else static)
    if flags.size and flags.dtype.kind != "b":
        raise ShapeError(f"static: expected booleans, got {flags.dtype}")
    if flags.shape not in {(), (count,)}:
        raise ShapeError(f"static: expected {count} flags, got an array of shape {flags.shape}")
    return np.array(np.broadcast_to(flags, (count,)), dtype=bool)


def _vectors(name: str, values: Any, dimension: int | None) -> Array:
    try:
        found = np.atleast_2d(as_floats(values))
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(f"{name}: not an array of real numbers ({error})") from None
    wanted = DIMENSIONS if dimension is None else (dimension,)
    if found.ndim != 2 or found.shape[1] not in wanted:
        raise ShapeError(f"{name}: expected shape (N, {' or '.join(map(str, wanted))}), got {found.shape}")
    return found


def _refuse(why: str, bad: Bools, *shown: Array) -> None:
    if np.any(bad):
        row = int(np.argwhere(bad)[0, 0])
        raise ShapeError(f"{why}, got {', '.join(str(values[row].tolist()) for values in shown)} at index {row}")
