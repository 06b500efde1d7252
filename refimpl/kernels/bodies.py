"""The convex bodies that searches run on, as flat rows of floats, and their support points.

A body is a *core* widened by a ball. Its row is::

    [kind, radius, count, center (3), axis 0 (3), axis 1 (3), axis 2 (3), sizes (3), vertices (3·count)]

kind HULL
    The hull of `count` ≥ 1 vertices, of which several may be equal; axes and sizes mean nothing.
kind ELLIPSOID
    center + Σ yᵢ·axisᵢ with Σ (yᵢ / sizeᵢ)² ≤ 1, the axes orthonormal.
kind CYLINDER
    center + Σ yᵢ·axisᵢ with y₀² + y₁² ≤ size₀², abs(y₂) ≤ size₂.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import kernel
from .vectors import Vector, along, dot

HULL, ELLIPSOID, CYLINDER = 0.0, 1.0, 2.0
KIND, RADIUS, COUNT, CENTER, AXES, SIZES, VERTICES = 0, 1, 2, 3, 6, 15, 18

Row = Sequence[float]


@kernel
def three(row: Row, at: int) -> Vector:
    """Three numbers of a row."""
    return (row[at], row[at + 1], row[at + 2])


@kernel
def farthest_vertex(row: Row, n: Vector) -> int:
    """Index of the first vertex of a hull that is farthest along `n`."""
    best, at = 0, VERTICES
    most = row[at] * n[0] + row[at + 1] * n[1] + row[at + 2] * n[2]
    for i in range(1, int(row[COUNT])):
        at = VERTICES + 3 * i
        here = row[at] * n[0] + row[at + 1] * n[1] + row[at + 2] * n[2]
        if here > most:
            best, most = i, here
    return best


@kernel
def support(row: Row, n: Vector) -> Vector:
    """Point of the core that is farthest along `n`; some such point where it is not unique, or `n` is zero."""
    if row[KIND] == HULL:
        return three(row, VERTICES + 3 * farthest_vertex(row, n))
    u, v, w = three(row, AXES), three(row, AXES + 3), three(row, AXES + 6)
    a, b, c = three(row, SIZES)
    x, y, z = dot(u, n), dot(v, n), dot(w, n)
    if row[KIND] == ELLIPSOID:
        x, y, z = a * x, b * y, c * z
        size = max(abs(x), abs(y), abs(z))
        if size == 0.0:
            return three(row, CENTER)
        x, y, z = x / size, y / size, z / size
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = a * (x / length), b * (y / length), c * (z / length)
    else:
        size = max(abs(x), abs(y))
        if size > 0.0:
            x, y = x / size, y / size
            length = math.sqrt(x * x + y * y)
            x, y = a * (x / length), a * (y / length)
        z = math.copysign(c, z)
    return along(along(along(three(row, CENTER), x, u), y, v), z, w)
