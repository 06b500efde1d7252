"""Boxes around the atoms of unions, and around runs of them: which pairs of atoms are near each other.

The atoms of a union, in their order, are halved again and again; the box around each run is kept, so that whole runs
can be passed over (Ericson, Real-Time Collision Detection, ch. 6). Node 1 is the run of all atoms, and nodes 2i and
2i + 1 are the halves of node i. The boxes are those of one placement, found anew for each, from the atoms upwards.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import kernel
from .atoms import (
    BOX,
    CYLINDER,
    HALF_SPACE,
    HULL,
    KIND,
    MATRIX,
    POINT,
    RADIUS,
    SEGMENT,
    SHAPE,
    SIZES,
    Scene,
)
from .axes import three
from .polytopes import BOX as OBLIQUE
from .polytopes import DIRECTORY, FACTOR, FIRST, N_VERTICES, Row, Scratch, vertex
from .vectors import Vector, dot

SLACK = 2.0**-48
"""Boxes are widened by this part of their coordinates, far more than they are rounded."""
ROUNDED = 2.0**-48
"""By how much the corners of a box may be rounded, more than enough: geometries have a size of about 1."""
BOXES_A, BOXES_B, NODES_A, NODES_B = 0, 1, 2, 3
"""Rows of a scene's scratch space: the boxes of atoms and of nodes, centre and half extents of each."""
STACK = 0
"""Row of whole numbers: pairs of nodes that are still to be looked at."""
FEW = 64
"""So many pairs of atoms are not worth a tree."""
LEAF = 4
"""Most atoms of a node that is not halved again."""


@kernel
def _box_around_box(atom: Row, geometry: Row, box: Scratch, at: int) -> None:
    """Box around a polytope that is a box, maybe a skew one, from one corner and its three neighbours."""
    corner = vertex(geometry, 0)
    for axis_at in range(3):
        m = three(atom, MATRIX + 3 * axis_at)
        low, middle, half = dot(m, corner), 0.0, ROUNDED
        for k in range(3):
            step = 0.5 * (dot(m, vertex(geometry, 1 << k)) - low)
            middle, half = middle + step, half + abs(step)
        box[at + axis_at] = atom[axis_at] + atom[FACTOR] * (low + middle)
        box[at + 3 + axis_at] = atom[FACTOR] * half


@kernel
def _hull_box(atom: Row, geometry: Row, box: Scratch, at: int) -> None:
    """Box around the placed vertices of a polytope."""
    if geometry[DIRECTORY] == OBLIQUE:
        _box_around_box(atom, geometry, box, at)
        return
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
def levels_of(count: int) -> int:
    """How often so many atoms are halved."""
    levels = 0
    while (count >> levels) >= LEAF:
        levels += 1
    return levels


@kernel
def _put_around(boxes: Row, first: int, after: int, nodes: Scratch, at: int) -> None:
    """Write the box around some boxes as number `at` of others."""
    for k in range(3):
        low, high = math.inf, -math.inf
        for i in range(6 * first + k, 6 * after, 6):
            low, high = min(low, boxes[i] - boxes[i + 3]), max(high, boxes[i] + boxes[i + 3])
        half = (high - low) / 2.0
        nodes[6 * at + k] = (low + high) / 2.0 if half < math.inf else 0.0
        nodes[6 * at + 3 + k] = half + SLACK * (abs(low) + abs(high))


@kernel
def _put_nodes(boxes: Row, count: int, nodes: Scratch) -> None:
    """Write the boxes of all runs."""
    last = 1 << levels_of(count)
    for i in range(last):
        _put_around(boxes, count * i // last, count * (i + 1) // last, nodes, last + i)
    for node in range(last - 1, 0, -1):
        _put_around(nodes, 2 * node, 2 * node + 2, nodes, node)


@kernel
def prepare(scene: Scene) -> None:
    """Put the boxes around all atoms of a scene where `box_gap` finds them."""
    put_boxes(scene.a, scene.shapes_a, scene.work[BOXES_A])
    put_boxes(scene.b, scene.shapes_b, scene.work[BOXES_B])
    if len(scene.a) * len(scene.b) > FEW:
        _put_nodes(scene.work[BOXES_A], len(scene.a), scene.work[NODES_A])
        _put_nodes(scene.work[BOXES_B], len(scene.b), scene.work[NODES_B])


@kernel
def _gap_on_axis(a: Row, at: int, b: Row, to: int, moved: float) -> float:
    """Gap between two intervals, of which the second is moved; negative where they overlap."""
    between = abs(a[at] - (b[to] + moved))
    return between - (a[at + 3] + b[to + 3]) - SLACK * (between + abs(moved))


@kernel
def gap_of_boxes(a: Row, i: int, b: Row, j: int, move: Vector) -> float:
    """Distance of box `i` of one list and box `j` of another, moved; 0 where they meet."""
    square = 0.0
    for k in range(3):
        gap = _gap_on_axis(a, 6 * i + k, b, 6 * j + k, move[k])
        if gap > 0.0:
            square += gap * gap
    return math.sqrt(square) if square > 0.0 else 0.0


@kernel
def _are_near(a: Row, i: int, b: Row, j: int, move: Vector, within: float) -> bool:
    """Whether that distance is no more than `within`; mostly one axis tells that it is."""
    square = 0.0
    for k in range(3):
        gap = _gap_on_axis(a, 6 * i + k, b, 6 * j + k, move[k])
        if gap > within:
            return False
        if gap > 0.0:
            square += gap * gap
    return square == 0.0 or math.sqrt(square) <= within


@kernel
def box_gap(scene: Scene, i: int, j: int, move: Vector) -> float:
    """Distance of the boxes around two atoms once B is moved: never more than that of the atoms."""
    return gap_of_boxes(scene.work[BOXES_A], i, scene.work[BOXES_B], j, move)


@kernel
def _near_items(
    scene: Scene, i: int, j: int, move: Vector, within: float, listed: MutableSequence[int], count: int
) -> int:
    """List the near pairs of two nodes of the last levels."""
    boxes_a, boxes_b, across = scene.work[BOXES_A], scene.work[BOXES_B], len(scene.b)
    last_a, last_b = 1 << levels_of(len(scene.a)), 1 << levels_of(across)
    i, j = i - last_a, j - last_b
    for p in range(len(scene.a) * i // last_a, len(scene.a) * (i + 1) // last_a):
        for q in range(across * j // last_b, across * (j + 1) // last_b):
            if _are_near(boxes_a, p, boxes_b, q, move, within):
                if count < len(listed):
                    listed[count] = p * across + q
                count += 1
    return count


@kernel
def _near_by_nodes(scene: Scene, move: Vector, within: float, listed: MutableSequence[int]) -> int:
    nodes_a, nodes_b, stack = scene.work[NODES_A], scene.work[NODES_B], scene.whole[STACK]
    last_a, last_b = 1 << levels_of(len(scene.a)), 1 << levels_of(len(scene.b))
    stack[0], stack[1], waiting, count = 1, 1, 2, 0
    while waiting > 0:
        waiting -= 2
        i, j = stack[waiting], stack[waiting + 1]
        if not _are_near(nodes_a, i, nodes_b, j, move, within):
            continue
        if i >= last_a and j >= last_b:
            count = _near_items(scene, i, j, move, within, listed, count)
            continue
        halve_a = i < last_a and (i <= j or j >= last_b)
        for half in range(1, -1, -1):
            stack[waiting] = 2 * i + half if halve_a else i
            stack[waiting + 1] = j if halve_a else 2 * j + half
            waiting += 2
    return count


@kernel
def near(scene: Scene, move: Vector, within: float, listed: MutableSequence[int]) -> int:
    """List the pairs of atoms, as numbers i·(atoms of B) + j, whose boxes are no farther apart; gives how many.

    Where there are more than the list has room for, the others are only counted.
    """
    across, count = len(scene.b), 0
    if len(scene.a) * across > FEW:
        return _near_by_nodes(scene, move, within, listed)
    a, b = scene.work[BOXES_A], scene.work[BOXES_B]
    for i in range(len(scene.a)):
        for j in range(across):
            if _are_near(a, i, b, j, move, within):
                if count < len(listed):
                    listed[count] = i * across + j
                count += 1
    return count


@kernel
def promising(scene: Scene, move: Vector) -> int:
    """Number of a pair of atoms whose boxes are near each other, if not the nearest: down the trees, greedily."""
    nodes_a, nodes_b, across = scene.work[NODES_A], scene.work[NODES_B], len(scene.b)
    last_a, last_b = 1 << levels_of(len(scene.a)), 1 << levels_of(across)
    i, j = 1, 1
    while i < last_a:
        i *= 2
        i += gap_of_boxes(nodes_a, i + 1, nodes_b, j, move) < gap_of_boxes(nodes_a, i, nodes_b, j, move)
        if j < last_b:
            j *= 2
            j += gap_of_boxes(nodes_a, i, nodes_b, j + 1, move) < gap_of_boxes(nodes_a, i, nodes_b, j, move)
    while j < last_b:
        j *= 2
        j += gap_of_boxes(nodes_a, i, nodes_b, j + 1, move) < gap_of_boxes(nodes_a, i, nodes_b, j, move)
    return len(scene.a) * (i - last_a) // last_a * across + across * (j - last_b) // last_b
