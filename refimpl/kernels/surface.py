"""A triangle surface as a flat row of floats, and the point of it that is nearest to a given one.

The triangles hang in a binary tree of boxes, of which every level is full: node k has the children 2k + 1 and 2k + 2,
and the last level holds a run of triangles each. The nearest triangle is sought depth first, the nearer child first
(Ericson, Real-Time Collision Detection, 6.6). A row is::

    [leaves, where their runs start, where the faces start,
     nodes (6 each: centre and half extents of the box), runs (first face of each leaf, and the end), faces (22 each)]

face
    Its three corners, anticlockwise seen from outside, the longest side first; an orthonormal frame at the first
    corner: along that side, up across it, outwards; then in that frame the length of the side, the height of the third
    corner above it, and how far along it that corner is; the face's number.
"""

from __future__ import annotations

import math

from . import kernel
from .axes import three
from .polytopes import Row, Scratch
from .segments import on_segment
from .vectors import Vector, along, dot, length, minus, times, unit_or

LEAVES, RUNS, FACES, NODES = 0, 1, 2, 3
NODE, FACE = 6, 22
ALONG, UP, OUTWARD, LENGTH, HEIGHT, APEX, NUMBER = 9, 12, 15, 18, 19, 20, 21
NOISE = 2.0**-44
"""Part of the coordinates by which an offset may miss the multiple of a unit normal that it is said to be."""
STACK = 128
"""Room for the nodes that wait, two numbers each: no more than one a level."""


@kernel
def box_square(row: Row, node: int, p: Vector) -> float:
    """Square of the distance of a point from a node's box."""
    at = NODES + NODE * node
    x, y, z = (
        abs(p[0] - row[at]) - row[at + 3],
        abs(p[1] - row[at + 1]) - row[at + 4],
        abs(p[2] - row[at + 2]) - row[at + 5],
    )
    square = 0.0
    if x > 0.0:
        square += x * x
    if y > 0.0:
        square += y * y
    if z > 0.0:
        square += z * z
    return square


@kernel
def _side_square(x: float, y: float, u: float, v: float) -> float:
    """Square of the distance of (x, y) from the segment from the origin to (u, v)."""
    square = u * u + v * v
    t = 0.0
    if square > 0.0:
        t = min(max((x * u + y * v) / square, 0.0), 1.0)
    x, y = x - t * u, y - t * v
    return x * x + y * y


@kernel
def face_square(row: Row, at: int, p: Vector) -> float:
    """Square of the distance of a point from a face, in the face's frame.

    The frame of a thin face may be tilted by rounding, but about its longest side: that moves no point of it far.
    Seen from above, the nearest point lies on a side beyond which the point is, if there is one. The longest side has
    acute angles at both ends, so a point beyond it is beyond no other as far as this matters.
    """
    u, v, w = p[0] - row[at], p[1] - row[at + 1], p[2] - row[at + 2]
    x = u * row[at + 9] + v * row[at + 10] + w * row[at + 11]
    y = u * row[at + 12] + v * row[at + 13] + w * row[at + 14]
    z = u * row[at + 15] + v * row[at + 16] + w * row[at + 17]
    side, height, apex = row[at + LENGTH], row[at + HEIGHT], row[at + APEX]
    if y <= 0.0:
        x -= min(max(x, 0.0), side)
        return x * x + y * y + z * z
    aside = math.inf
    if x * height < apex * y:
        aside = _side_square(x, y, apex, height)
    if (side - x) * height < (side - apex) * y:
        aside = min(aside, _side_square(x - side, y, apex - side, height))
    return z * z if aside == math.inf else z * z + aside


@kernel
def nearest_face(row: Row, p: Vector, stack: Scratch) -> int:
    """Where in the row the face starts that is nearest to a point; of equal ones, any."""
    leaves, runs, faces = int(row[LEAVES]), int(row[RUNS]), int(row[FACES])
    best, found, node, waiting = math.inf, faces, 0, 0
    while True:
        if node >= leaves - 1:
            run = runs + node - (leaves - 1)
            for i in range(int(row[run]), int(row[run + 1])):
                square = face_square(row, faces + FACE * i, p)
                if square < best:
                    best, found = square, faces + FACE * i
        else:
            node = 2 * node + 1
            square, other = box_square(row, node, p), box_square(row, node + 1, p)
            farther = node + 1
            if other < square:
                square, other, farther, node = other, square, node, node + 1
            if other < best:
                stack[2 * waiting], stack[2 * waiting + 1] = farther, other
                waiting += 1
            if square < best:
                continue
        while waiting > 0 and not stack[2 * waiting - 1] < best:
            waiting -= 1
        if waiting == 0:
            return found
        waiting -= 1
        node = int(stack[2 * waiting])


@kernel
def foot_on_face(row: Row, at: int, p: Vector) -> Vector:
    """Point of a face nearest to `p`: its foot on the plane, or a point of a side; reaches the corners exactly."""
    a, b, c = three(row, at), three(row, at + 3), three(row, at + 6)
    way, up = three(row, at + ALONG), three(row, at + UP)
    from_a = minus(p, a)
    x, y = dot(from_a, way), dot(from_a, up)
    side, height, apex = row[at + LENGTH], row[at + HEIGHT], row[at + APEX]
    best, least = a, math.inf
    if y > 0.0 and x * height >= apex * y and (side - x) * height >= (side - apex) * y:
        best = along(along(a, x, way), y, up)
        least = length(minus(p, best))
    for i in range(3):
        u, v = (a, b) if i == 0 else ((b, c) if i == 1 else (c, a))
        foot = on_segment(p, u, v)
        gap = length(minus(p, foot))
        if gap < least:
            best, least = foot, gap
    return best


@kernel
def _shortfall(row: Row, at: int, p: Vector, side: float, gap: float, n: Vector) -> float:
    """By how much the plane across `n` through the nearest point fails to have its face on one side."""
    least = math.inf
    for i in range(3):
        least = min(least, side * dot(minus(p, three(row, at + 3 * i)), n))
    return gap - least


@kernel
def outward_at(row: Row, at: int, p: Vector, foot: Vector, side: float) -> Vector:
    """Unit normal, outwards, at the point of the surface nearest to `p`, which is outside (`side` 1) or inside (−1).

    It is the direction between the two points. Where the face's own normal says the same, but for what rounding may
    have done to a short way between them, the better of both counts.
    """
    face = three(row, at + OUTWARD)
    offset = times(side, minus(p, foot))
    straight = unit_or(offset, face)
    gap = length(offset)
    aside = length(minus(offset, times(gap, face)))
    if aside > NOISE * (1.0 + max(abs(p[0]), abs(p[1]), abs(p[2]))):
        return straight
    if _shortfall(row, at, p, side, gap, straight) < _shortfall(row, at, p, side, gap, face) + aside:
        return straight
    return face
