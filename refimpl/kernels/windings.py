"""Rays through a triangle surface: the faces that they may meet, and whether a point is inside.

A point is inside where a ray from it leaves the surface once more than it enters. A ray meets a face where it passes
all three sides in the same sense; that are signs of determinants, which doubles tell where they exceed their
rounding. Where they do not, for the ray passes too close to an edge, another ray is tried.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence

from . import kernel
from .axes import three
from .polytopes import Row, Scratch
from .surface import FACE, FACES, LEAVES, NODE, NODES, NUMBER, RUNS, box_square
from .vectors import Vector, minus

WAYS = ((0.2113, 0.3659, 0.9071), (-0.8887, 0.2297, 0.3967), (0.3313, -0.9349, -0.1279))
"""Directions of the rays: such as no edge is likely to have."""
ROUNDING, TINY = 2.0**-53, 1e-290
SLACK = 2.0**-48
"""Part of the coordinates by which boxes are widened, far more than they are rounded."""
UNSURE = 2


@kernel
def _determinant(a: Vector, b: Vector, c: Vector) -> tuple[float, bool]:
    """det(a, b, c) of vectors that are differences, rounded once, and whether its sign is certain."""
    p, q = b[1] * c[2], b[2] * c[1]
    r, s = b[2] * c[0], b[0] * c[2]
    t, u = b[0] * c[1], b[1] * c[0]
    value = a[0] * (p - q) + a[1] * (r - s) + a[2] * (t - u)
    size = abs(a[0]) * (abs(p) + abs(q)) + abs(a[1]) * (abs(r) + abs(s)) + abs(a[2]) * (abs(t) + abs(u))
    return value, abs(value) > 32.0 * ROUNDING * size + TINY


@kernel
def crossing(row: Row, at: int, p: Vector, way: Vector) -> int:
    """1 where a ray from `p` leaves through a face, −1 where it enters, 0 where it misses; or `UNSURE`."""
    a, b, c = minus(three(row, at), p), minus(three(row, at + 3), p), minus(three(row, at + 6), p)
    u, sure_u = _determinant(way, b, c)
    v, sure_v = _determinant(way, c, a)
    if sure_u and sure_v and (u > 0.0) != (v > 0.0):
        return 0
    w, sure_w = _determinant(way, a, b)
    if sure_w and ((sure_u and (u > 0.0) != (w > 0.0)) or (sure_v and (v > 0.0) != (w > 0.0))):
        return 0
    if not (sure_u and sure_v and sure_w):
        return UNSURE
    volume, sure = _determinant(a, b, c)
    if not sure:
        return UNSURE
    side = 1 if u > 0.0 else -1
    return side if (volume > 0.0) == (side > 0) else 0


@kernel
def enters(row: Row, node: int, p: Vector, way: Vector) -> bool:
    """Whether a ray meets a node's box, a little widened."""
    at = NODES + NODE * node
    near, far = 0.0, math.inf
    for i in range(3):
        gap, reach = row[at + i] - p[i], row[at + 3 + i] + SLACK * abs(p[i])
        if way[i] == 0.0:
            if abs(gap) > reach:
                return False
            continue
        one, other = (gap - reach) / way[i], (gap + reach) / way[i]
        near, far = max(near, min(one, other)), min(far, max(one, other))
    return near <= far * (1.0 + SLACK)


@kernel
def next_leaf(row: Row, p: Vector, way: Vector, stack: Scratch, waiting: int) -> tuple[int, int]:
    """Next leaf whose box a ray may meet, as the place of its run, or −1; and how many nodes wait then."""
    leaves = int(row[LEAVES])
    while waiting > 0:
        waiting -= 1
        node = int(stack[waiting])
        if enters(row, node, p, way):
            if node >= leaves - 1:
                return int(row[RUNS]) + node - (leaves - 1), waiting
            stack[waiting], stack[waiting + 1] = 2 * node + 1, 2 * node + 2
            waiting += 2
    return -1, 0


@kernel
def winding(row: Row, p: Vector, way: Vector, stack: Scratch) -> tuple[int, bool]:
    """How often the surface winds around a point, by one ray, and whether this is certain."""
    faces, number = int(row[FACES]), 0
    stack[0] = 0
    run, waiting = next_leaf(row, p, way, stack, 1)
    while run >= 0:
        for i in range(int(row[run]), int(row[run + 1])):
            side = crossing(row, faces + FACE * i, p, way)
            if side == UNSURE:
                return 0, False
            number += side
        run, waiting = next_leaf(row, p, way, stack, waiting)
    return number, True


@kernel
def inside(row: Row, p: Vector, stack: Scratch) -> tuple[bool, bool]:
    """Whether a point is inside, and whether this is certain; where not, the point is next to the surface."""
    if box_square(row, 0, p) > 0.0:
        return False, True
    for i in range(len(WAYS)):
        number, sure = winding(row, p, WAYS[i], stack)
        if sure:
            return number > 0, True
    return True, False


@kernel
def faces_on_the_way(row: Row, rays: Sequence[Row], found: MutableSequence[int], stack: Scratch) -> int:
    """Write pairs of a ray's place in the batch and a face's number, for all faces in boxes that the ray may meet.

    Rays are six numbers, origin and direction. Returns how many pairs there are; those that do not fit are left out.
    """
    faces, count = int(row[FACES]), 0
    for ray in range(len(rays)):
        p, way = three(rays[ray], 0), three(rays[ray], 3)
        stack[0] = 0
        run, waiting = next_leaf(row, p, way, stack, 1)
        while run >= 0:
            for i in range(int(row[run]), int(row[run + 1])):
                if 2 * count + 1 < len(found):
                    found[2 * count], found[2 * count + 1] = ray, int(row[faces + FACE * i + NUMBER])
                count += 1
            run, waiting = next_leaf(row, p, way, stack, waiting)
    return count
