"""The shortest vector that satisfies linear constraints in space.

The constraint that is broken most joins, and of those that held the vector so far, at most two stay: the dual method
of Goldfarb and Idnani (A numerically stable dual method for solving strictly convex quadratic programs, 1983), with
its small systems solved by trial. The vector only grows, so it ends.
"""

from __future__ import annotations

from collections.abc import Sequence

from . import kernel
from .axes import three
from .vectors import Vector, cross, dot, length, plus, times

Planes = Sequence[float]
"""Four numbers for each constraint n·t ≥ level: the unit vector n, and the level."""
PLANE, LEVEL = 4, 3

ROUNDED = 1e-13
"""Part of a level, or of the vector, by which rounding may miss a plane."""
THIN = 1e-12
"""Determinants below say that constraints are the same, or contradict."""
SUBSETS = ((-1, -1), (0, -1), (1, -1), (2, -1), (0, 1), (0, 2), (1, 2))
"""Which of the constraints that hold a vector so far may hold it together with another one; −1 for none."""
NOWHERE = (0.0, 0.0, 0.0)
Corner = tuple[int, int, int]
"""Numbers of the up to three constraints that hold a vector; −1 for none."""
FREE = (-1, -1, -1)


@kernel
def _slack(planes: Planes, i: int, t: Vector) -> float:
    """How far a vector is beyond a plane."""
    at = PLANE * i
    return planes[at] * t[0] + planes[at + 1] * t[1] + planes[at + 2] * t[2] - planes[at + LEVEL]


@kernel
def _meeting(planes: Planes, i: int, j: int, k: int) -> tuple[Vector, bool]:
    """Shortest vector on one, two or three planes, and whether there is one that all of them push outwards."""
    n, level = three(planes, PLANE * i), planes[PLANE * i + LEVEL]
    if j < 0:
        return times(level, n), level >= 0.0
    m, other = three(planes, PLANE * j), planes[PLANE * j + LEVEL]
    if k < 0:
        g = dot(n, m)
        det = (1.0 - g) * (1.0 + g)
        if det <= THIN:
            return NOWHERE, False
        u, v = (level - g * other) / det, (other - g * level) / det
        return plus(times(u, n), times(v, m)), u >= 0.0 and v >= 0.0
    l, third = three(planes, PLANE * k), planes[PLANE * k + LEVEL]
    p, q, r = cross(m, l), cross(l, n), cross(n, m)
    det = dot(n, p)
    if abs(det) <= THIN:
        return NOWHERE, False
    t = times(1.0 / det, plus(plus(times(level, p), times(other, q)), times(third, r)))
    return t, dot(t, p) / det >= 0.0 and dot(t, q) / det >= 0.0 and dot(t, r) / det >= 0.0


@kernel
def _held(planes: Planes, corner: Corner, last: int, slack: float) -> tuple[Vector, Corner, bool]:
    """Shortest vector for the constraints of a corner and one more that holds it for certain, if there is one."""
    for first, second in SUBSETS:
        i, j = (corner[first] if first >= 0 else -1), (corner[second] if second >= 0 else -1)
        if (first >= 0 and i < 0) or (second >= 0 and j < 0):
            continue
        t, right = _meeting(planes, last, i, j)
        if right:
            give = -(slack + ROUNDED * length(t))
            fits = _slack(planes, last, t) >= give
            for k in corner:
                if k >= 0 and _slack(planes, k, t) < give:
                    fits = False
            if fits:
                return t, (last, i, j), True
    return NOWHERE, corner, False


@kernel
def shortest(planes: Planes, count: int) -> tuple[Vector, Corner, bool]:
    """Shortest vector that satisfies the first `count` constraints, which hold it, and whether there is one."""
    return lengthened(planes, count, NOWHERE, FREE)


@kernel
def lengthened(planes: Planes, count: int, t: Vector, corner: Corner) -> tuple[Vector, Corner, bool]:
    """The same, from the shortest vector for some of them, and those which hold it."""
    size = 0.0
    for i in range(count):
        size = max(size, abs(planes[PLANE * i + LEVEL]))
    for _ in range(8 * count + 8):
        worst, least = -1, -ROUNDED * (size + length(t))
        for i in range(count):
            here = _slack(planes, i, t)
            if here < least:
                worst, least = i, here
        if worst < 0:
            return t, corner, True
        t, corner, held = _held(planes, corner, worst, ROUNDED * size)
        if not held:
            break
    return t, corner, False
