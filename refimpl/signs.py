"""Signs of determinants of points: in doubles where their error bound allows it, else exactly in integers.

Every decision about a mesh is such a sign. Doubles decide almost all of them; the others are repeated on an integer
grid that holds all coordinates exactly, since doubles are whole multiples of powers of two (Shewchuk 1997, Adaptive
Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates; here with one bound and no stages).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Array

Signs = NDArray[np.int8]
Indices = NDArray[np.int64]

ROUNDING = 2.0**-53
TINY = 1e-290  # where products may have lost bits by underflow, no double decides


def on_grid(numbers: Array) -> tuple[NDArray[Any], int]:
    """Whole numbers (an object array of ints) and the exponent e such that numbers = whole · 2^e, exactly."""
    mantissa, exponent = np.frexp(numbers)
    whole = np.ldexp(mantissa, 53).astype(np.int64).ravel().tolist()
    exponents = np.where(mantissa == 0, np.iinfo(np.int32).max, exponent).ravel()
    least = int(exponents.min(initial=np.iinfo(np.int32).max))
    if least == np.iinfo(np.int32).max:
        least = 53
    shifts = np.where(mantissa.ravel() == 0, 0, exponents - least).tolist()
    grid = np.empty(len(whole), dtype=object)
    grid[:] = [w << s for w, s in zip(whole, shifts, strict=True)]
    return grid.reshape(np.shape(numbers)), least - 53


class Points:
    """Points with coordinates in doubles, and the signs of the determinants that they span.

    Parameters
    ----------
    coordinates : (m, 3), finite
        Brought to about 1 by a power of two, which changes no sign.
    """

    def __init__(self, coordinates: Array) -> None:
        top = int(np.frexp(np.max(np.abs(coordinates), initial=0.0))[1])
        self.exponent = top
        self.near = np.ldexp(coordinates, -top)
        self._given = coordinates
        self._grid: NDArray[Any] | None = None
        self.grid_exponent = 0

    @property
    def grid(self) -> NDArray[Any]:
        """The coordinates as whole multiples of 2^grid_exponent; made when first needed."""
        if self._grid is None:
            self._grid, self.grid_exponent = on_grid(self._given)
        return self._grid

    def orientation(self, a: Indices, b: Indices, c: Indices, d: Indices) -> Signs:
        """Sign of det(b − a, c − a, d − a): + where d lies on the side from which abc turns anticlockwise."""
        x = self.near
        value, size = _volume(x[a], x[b], x[c], x[d])
        signs: Signs = np.sign(value).astype(np.int8)
        unsure = np.flatnonzero(np.abs(value) <= 16 * ROUNDING * size + TINY)
        if len(unsure):
            g = self.grid
            exact, _ = _volume(*(g[np.broadcast_to(i, value.shape)[unsure]] for i in (a, b, c, d)))
            signs[unsure] = [(v > 0) - (v < 0) for v in exact]
        return signs

    def turn(self, a: Indices, b: Indices, c: Indices, dropped: Indices) -> Signs:
        """Sign of the area of abc, seen along the axis `dropped`: + for anticlockwise in the two axes after it."""
        x = self.near
        u, v = (dropped + 1) % 3, (dropped + 2) % 3
        value, size = _area(*(x[i, axis] for i in (a, b, c) for axis in (u, v)))
        signs: Signs = np.sign(value).astype(np.int8)
        unsure = np.flatnonzero(np.abs(value) <= 8 * ROUNDING * size + TINY)
        if len(unsure):
            g = self.grid
            rows = [(np.broadcast_to(i, value.shape)[unsure], np.broadcast_to(axis, value.shape)[unsure])
                    for i in (a, b, c) for axis in (u, v)]  # fmt: skip
            exact, _ = _area(*(g[row] for row in rows))
            signs[unsure] = [(s > 0) - (s < 0) for s in exact]
        return signs


def _volume(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any]:
    """Six times the signed volume of a tetrahedron, and the sum of its terms' absolute values."""
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = ((e - a).T for e in (b, c, d))
    xy, yx, yz, zy, zx, xz = ux * vy, uy * vx, uy * vz, uz * vy, uz * vx, ux * vz
    value = wx * (yz - zy) + wy * (zx - xz) + wz * (xy - yx)
    size = abs(wx) * (abs(yz) + abs(zy)) + abs(wy) * (abs(zx) + abs(xz)) + abs(wz) * (abs(xy) + abs(yx))
    return value, size


def _area(ax: Any, ay: Any, bx: Any, by: Any, cx: Any, cy: Any) -> tuple[Any, Any]:
    """Twice the signed area of a triangle in the plane, and the sum of its terms' absolute values."""
    left, right = (bx - ax) * (cy - ay), (by - ay) * (cx - ax)
    return left - right, abs(left) + abs(right)
