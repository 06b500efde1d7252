"""Unions as flat rows of floats: one row for each of their convex atoms, and their support points.

An atom is a row::

    [pose (13), sizes (3), radius, kind, shape]

Its set is what the kind says, turned and placed by the pose (see `polytopes`), widened by the radius:

kind POINT, SEGMENT, BOX
    The origin; from −sizes to sizes about it, in the world's axes; the box with half extents `sizes`.
kind HULL
    A polytope, whose geometry is row number `shape` of a table.
kind ELLIPSOID, CYLINDER
    With radii `sizes`; with radius, radius and half length `sizes` along the third axis.
kind HALF_SPACE
    n·x + k ≤ 0, with n where the rotation matrix begins, and k the first of the sizes. Of half-spaces whose normals
    are exactly opposite, `shape` is the same number; it is 0 for all others.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import NamedTuple

from . import kernel
from .axes import three
from .polytopes import FACTOR, Row, Scratch, farthest_of, vertex
from .vectors import Vector, dot, minus, opposite, plus, times, unit_or

POINT, SEGMENT, BOX, HULL, ELLIPSOID, CYLINDER, HALF_SPACE = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0
MATRIX, SIZES, RADIUS, KIND, SHAPE, ATOM = 3, 13, 16, 17, 18, 19
ANSWER = 11
"""An answered pair: its number, signed distance, normal, witness points."""
NOWHERE = (math.nan, math.nan, math.nan)


class Scene(NamedTuple):
    """Two unions, and room to work in.

    Attributes
    ----------
    a, b
        Rows of their atoms, scaled so that squares of lengths neither overflow nor vanish.
    shapes_a, shapes_b
        Tables of geometries.
    work, whole
        Scratch rows of floats and of whole numbers; `nearby` and `atom_pairs` say which is which.
    pairs
        Room for answered pairs of atoms, `ANSWER` numbers each: sorted ones, and as many before they are.
    """

    a: Sequence[Row]
    b: Sequence[Row]
    shapes_a: Sequence[Row]
    shapes_b: Sequence[Row]
    work: Sequence[Scratch]
    whole: Sequence[MutableSequence[int]]
    pairs: Sequence[Scratch]


@kernel
def origin(atom: Row) -> Vector:
    """Where an atom lies."""
    return (atom[0], atom[1], atom[2])


@kernel
def axis(atom: Row, i: int) -> Vector:
    """One of an atom's own axes: a column of its rotation matrix."""
    return (atom[MATRIX + i], atom[MATRIX + 3 + i], atom[MATRIX + 6 + i])


@kernel
def turned(atom: Row, v: Vector) -> Vector:
    """A vector given along an atom's own axes."""
    return (
        atom[3] * v[0] + atom[4] * v[1] + atom[5] * v[2],
        atom[6] * v[0] + atom[7] * v[1] + atom[8] * v[2],
        atom[9] * v[0] + atom[10] * v[1] + atom[11] * v[2],
    )


@kernel
def _own_support(atom: Row, n: Vector) -> Vector:
    """Point of a box, an ellipsoid or a cylinder that is farthest along `n`, all along its own axes."""
    p, q, r = atom[SIZES], atom[SIZES + 1], atom[SIZES + 2]
    if atom[KIND] == ELLIPSOID:
        u = unit_or((p * n[0], q * n[1], r * n[2]), (1.0, 0.0, 0.0))
        return (p * u[0], q * u[1], r * u[2])
    z = r if n[2] > 0.0 else -r
    if atom[KIND] == BOX:
        return (p if n[0] > 0.0 else -p, q if n[1] > 0.0 else -q, z)
    u = unit_or((n[0], n[1], 0.0), (1.0, 0.0, 0.0))
    return (p * u[0], q * u[1], z)


@kernel
def core_support(atom: Row, shapes: Sequence[Row], n: Vector) -> Vector:
    """Point farthest along `n`, counted from the atom's origin, of any but a half-space before it is widened."""
    if atom[KIND] == POINT:
        return (0.0, 0.0, 0.0)
    if atom[KIND] == SEGMENT:
        h = three(atom, SIZES)
        return opposite(h) if dot(h, n) < 0.0 else h
    own = (dot(axis(atom, 0), n), dot(axis(atom, 1), n), dot(axis(atom, 2), n))
    if atom[KIND] == HULL:
        geometry = shapes[int(atom[SHAPE])]
        return turned(atom, times(atom[FACTOR], vertex(geometry, farthest_of(geometry, own))))
    return turned(atom, _own_support(atom, own))


@kernel
def height_of(atom: Row, shapes: Sequence[Row], n: Vector) -> float:
    """Largest n·x over an atom, `n` a unit vector: infinite for half-spaces, but along their own normal."""
    if atom[KIND] == HALF_SPACE:
        m = three(atom, MATRIX)
        return -atom[SIZES] if n[0] == m[0] and n[1] == m[1] and n[2] == m[2] else math.inf
    return dot(origin(atom), n) + dot(core_support(atom, shapes, n), n) + atom[RADIUS]


@kernel
def height(scene: Scene, side: int, i: int, n: Vector) -> float:
    """The same for atom `i` of A (side 0) or B."""
    if side == 0:
        return height_of(scene.a[i], scene.shapes_a, n)
    return height_of(scene.b[i], scene.shapes_b, n)


@kernel
def support_gap(scene: Scene, i: int, j: int, move: Vector, n: Vector) -> float:
    """Gap between two atoms along the unit vector `n` once B is moved: a lower bound of their signed distance."""
    a, b = scene.a[i], scene.b[j]
    if a[KIND] == HALF_SPACE or b[KIND] == HALF_SPACE:
        return -(height_of(a, scene.shapes_a, n) + height_of(b, scene.shapes_b, opposite(n))) + dot(move, n)
    between = plus(minus(origin(b), origin(a)), move)
    reach = minus(core_support(b, scene.shapes_b, opposite(n)), core_support(a, scene.shapes_a, n))
    return dot(plus(between, reach), n) - (a[RADIUS] + b[RADIUS])
