"""Unions as flat rows of floats: one row for each of their convex atoms, and what bounds the distance of two.

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
from .polytopes import FACTOR, FIRST, N_VERTICES, Row, Scratch, farthest, vertex
from .vectors import Vector, dot, minus, opposite, plus, times, unit_or

POINT, SEGMENT, BOX, HULL, ELLIPSOID, CYLINDER, HALF_SPACE = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0
MATRIX, SIZES, RADIUS, KIND, SHAPE, ATOM = 3, 13, 16, 17, 18, 19
ANSWER = 11
"""An answered pair: its number, signed distance, normal, witness points."""
SLACK = 2.0**-48
"""Boxes are widened by this part of their coordinates, far more than they are rounded."""
BOXES_A, BOXES_B = 0, 1
"""Rows of the scratch space in which the boxes around the atoms are kept: centre and half extents of each."""
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
        Scratch rows of floats and of whole numbers; `atom_pairs` says which is which.
    pairs
        Room for all pairs of atoms, `ANSWER` numbers each.
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
        return turned(atom, times(atom[FACTOR], vertex(geometry, farthest(geometry, own))))
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


@kernel
def _hull_box(atom: Row, geometry: Row, box: Scratch, at: int) -> None:
    """Box around the placed vertices of a polytope."""
    for axis_at in range(3):
        row = MATRIX + 3 * axis_at
        low, high = math.inf, -math.inf
        for v in range(FIRST, FIRST + 3 * int(geometry[N_VERTICES]), 3):
            here = atom[row] * geometry[v] + atom[row + 1] * geometry[v + 1] + atom[row + 2] * geometry[v + 2]
            low, high = min(low, here), max(high, here)
        box[at + axis_at] = atom[axis_at] + atom[FACTOR] * ((low + high) / 2.0)
        box[at + 3 + axis_at] = atom[FACTOR] * ((high - low) / 2.0)


@kernel
def _half(atom: Row, row: int) -> float:
    """Half the extent of an atom that has a centre, along one axis of the world."""
    kind = atom[KIND]
    if kind == SEGMENT:
        return abs(atom[SIZES + row])
    if kind == POINT:
        return 0.0
    at = MATRIX + 3 * row
    x, y, z = atom[at] * atom[SIZES], atom[at + 1] * atom[SIZES + 1], atom[at + 2] * atom[SIZES + 2]
    if kind == BOX:
        return abs(x) + abs(y) + abs(z)
    if kind == CYLINDER:
        return math.sqrt(x * x + y * y) + abs(z)
    return math.sqrt(x * x + y * y + z * z)


@kernel
def put_boxes(atoms: Sequence[Row], shapes: Sequence[Row], boxes: Scratch) -> None:
    """Write the boxes around atoms, six numbers each; half-spaces have infinite ones."""
    for i in range(len(atoms)):
        atom, at = atoms[i], 6 * i
        if atom[KIND] == HULL:
            _hull_box(atom, shapes[int(atom[SHAPE])], boxes, at)
        for k in range(3):
            if atom[KIND] == HALF_SPACE:
                boxes[at + k], boxes[at + 3 + k] = 0.0, math.inf
                continue
            if atom[KIND] != HULL:
                boxes[at + k], boxes[at + 3 + k] = atom[k], _half(atom, k)
            half = boxes[at + 3 + k] + atom[RADIUS]
            boxes[at + 3 + k] = half + SLACK * (abs(boxes[at + k]) + half)


@kernel
def prepare(scene: Scene) -> None:
    """Put the boxes around all atoms of a scene where `box_gap` finds them."""
    put_boxes(scene.a, scene.shapes_a, scene.work[BOXES_A])
    put_boxes(scene.b, scene.shapes_b, scene.work[BOXES_B])


@kernel
def gap_of_boxes(a: Row, i: int, b: Row, j: int, move: Vector) -> float:
    """Distance of box `i` of one list and box `j` of another, moved; 0 where they meet."""
    square = 0.0
    for k in range(3):
        between, moved = abs(a[6 * i + k] - (b[6 * j + k] + move[k])), abs(move[k])
        gap = between - (a[6 * i + 3 + k] + b[6 * j + 3 + k]) - SLACK * (between + moved)
        if gap > 0.0:
            square += gap * gap
    return math.sqrt(square) if square > 0.0 else 0.0


@kernel
def box_gap(scene: Scene, i: int, j: int, move: Vector) -> float:
    """Distance of the boxes around two atoms once B is moved: never more than that of the atoms."""
    return gap_of_boxes(scene.work[BOXES_A], i, scene.work[BOXES_B], j, move)


@kernel
def near(scene: Scene, move: Vector, within: float, listed: MutableSequence[int]) -> int:
    """List the pairs of atoms, as numbers i·(atoms of B) + j, whose boxes are no farther apart; gives how many."""
    a, b, count, across = scene.work[BOXES_A], scene.work[BOXES_B], 0, len(scene.b)
    for i in range(len(scene.a)):
        for j in range(across):
            if gap_of_boxes(a, i, b, j, move) <= within:
                listed[count] = i * across + j
                count += 1
    return count
