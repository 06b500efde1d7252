"""Closest points of two convex bodies by their support points: the algorithm of Gilbert, Johnson and Keerthi.

The points b − a, with a ∈ A and b ∈ B, form a convex set, the difference; its point nearest to the origin is as far
from it as A is from B. The search keeps a *simplex* of up to four points of the difference, finds the simplex's
point v nearest to the origin, and adds the point of the difference that lies deepest against v. Each direction n
that is tried gives a lower bound g(n) of the gap, each v an upper one. Gilbert, Johnson and Keerthi 1988;
van den Bergen, Collision Detection in Interactive 3D Environments, 4.3.

A simplex is a flat buffer of `SIMPLEX` floats: for each point k the difference at 3k, the point of A at 12 + 3k and
that of B at 24 + 3k, and its weight at 36 + k.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from . import kernel
from .bodies import Row, support, three
from .vectors import Vector, along, cross, dot, length, minus, opposite, times, unit_or

Simplex = MutableSequence[float]
SIMPLEX = 40
ON_A, ON_B, WEIGHT = 12, 24, 36

APART, OVERLAPPING = 1, 0
FLAT = 1e-12
"""How far from the origin, relative to its size, a tetrahedron's weights may lead that is said to hold it."""


@kernel
def store(buffer: Simplex, at: int, v: Vector) -> None:
    """Write three numbers into a buffer."""
    buffer[at], buffer[at + 1], buffer[at + 2] = v[0], v[1], v[2]


@kernel
def put(simplex: Simplex, k: int, on_a: Vector, on_b: Vector) -> None:
    """Make b − a the k-th point of a simplex, with weight 0."""
    store(simplex, 3 * k, minus(on_b, on_a))
    store(simplex, ON_A + 3 * k, on_a)
    store(simplex, ON_B + 3 * k, on_b)
    simplex[WEIGHT + k] = 0.0


@kernel
def keep(simplex: Simplex, i: int, k: int, weight: float) -> int:
    """Move point i down to place k ≤ i if its weight is positive; return the next free place."""
    if weight <= 0.0:
        return k
    for start in range(0, WEIGHT, 12):
        store(simplex, start + 3 * k, three(simplex, start + 3 * i))
    simplex[WEIGHT + k] = weight
    return k + 1


@kernel
def weighted(simplex: Simplex, count: int, start: int) -> Vector:
    """Weighted mean of the simplex's points: of the differences (start 0), those of A (12) or of B (24)."""
    mean = (0.0, 0.0, 0.0)
    for k in range(count):
        mean = along(mean, simplex[WEIGHT + k], three(simplex, start + 3 * k))
    return mean


@kernel
def nearest_of_two(p: Vector, q: Vector) -> float:
    """Weight of q in the point of the segment pq that is nearest to the origin."""
    step = minus(q, p)
    square = dot(step, step)
    if square == 0.0:
        return 0.0
    return min(max(-dot(p, step) / square, 0.0), 1.0)


@kernel
def nearest_of_three(p: Vector, q: Vector, r: Vector) -> tuple[float, float, float]:
    """Weights of the corners of a triangle in its point nearest to the origin.

    The foot of the perpendicular on the plane, where that lies inside, or the nearest point of the three sides:
    whichever is nearer in fact. So the answer lies in the triangle however thin it is.
    """
    t = nearest_of_two(p, q)
    best = (1.0 - t, t, 0.0)
    v = along(p, t, minus(q, p))
    least = dot(v, v)
    t = nearest_of_two(q, r)
    v = along(q, t, minus(r, q))
    if dot(v, v) < least:
        best, least = (0.0, 1.0 - t, t), dot(v, v)
    t = nearest_of_two(r, p)
    v = along(r, t, minus(p, r))
    if dot(v, v) < least:
        best, least = (t, 0.0, 1.0 - t), dot(v, v)
    normal = cross(minus(q, p), minus(r, p))
    x, y, z = dot(normal, cross(q, r)), dot(normal, cross(r, p)), dot(normal, cross(p, q))
    total = x + y + z
    if x > 0.0 and y > 0.0 and z > 0.0:
        x, y, z = x / total, y / total, z / total
        v = along(along(times(x, p), y, q), z, r)
        # what is left of v in the plane, found more precisely than v itself, corrects the weights of a thin triangle
        square = dot(normal, normal)
        s, t = dot(normal, cross(v, minus(r, p))) / square, dot(normal, cross(minus(q, p), v)) / square
        if s < y and t < z and s + t > -x:
            x, y, z = x + (s + t), y - s, z - t
            v = along(along(times(x, p), y, q), z, r)
        if dot(v, v) < least:
            best = (x, y, z)
    return best


@kernel
def holds_origin(simplex: Simplex) -> bool:
    """Whether a tetrahedron has the origin inside; its weights are then those of the origin."""
    p, q, r, s = three(simplex, 0), three(simplex, 3), three(simplex, 6), three(simplex, 9)
    total = dot(minus(q, p), cross(minus(r, p), minus(s, p)))
    pq, rs = cross(p, q), cross(r, s)
    x, y, z, w = dot(q, rs), -dot(p, rs), dot(s, pq), -dot(r, pq)
    if total < 0.0:
        x, y, z, w = -x, -y, -z, -w
    if not (x > 0.0 and y > 0.0 and z > 0.0 and w > 0.0):
        return False
    total = x + y + z + w
    simplex[WEIGHT], simplex[WEIGHT + 1] = x / total, y / total
    simplex[WEIGHT + 2], simplex[WEIGHT + 3] = z / total, w / total
    # a tetrahedron without thickness seems to hold anything; then the weights do not fit
    size = length(p) + length(q) + length(r) + length(s)
    return length(weighted(simplex, 4, 0)) <= FLAT * size


@kernel
def reduce(simplex: Simplex, count: int) -> int:
    """Find a simplex's point nearest to the origin, drop the corners that it does not need, and count the rest.

    Of a tetrahedron only the sides at the last corner are looked at: the point added last is needed. Four corners
    remain only when they hold the origin.
    """
    weights = (1.0, 0.0, 0.0, 0.0)
    if count == 2:
        t = nearest_of_two(three(simplex, 0), three(simplex, 3))
        weights = (1.0 - t, t, 0.0, 0.0)
    elif count == 3:
        x, y, z = nearest_of_three(three(simplex, 0), three(simplex, 3), three(simplex, 6))
        weights = (x, y, z, 0.0)
    elif count == 4:
        if holds_origin(simplex):
            return 4
        least = math.inf
        last = three(simplex, 9)
        for left_out in range(3):
            p, q = three(simplex, 3 * ((left_out + 1) % 3)), three(simplex, 3 * ((left_out + 2) % 3))
            x, y, z = nearest_of_three(p, q, last)
            v = along(along(times(x, p), y, q), z, last)
            if dot(v, v) < least:
                least = dot(v, v)
                if left_out == 0:
                    weights = (0.0, x, y, z)
                elif left_out == 1:
                    weights = (y, 0.0, x, z)
                else:
                    weights = (x, y, 0.0, z)
    k = 0
    for i in range(count):
        k = keep(simplex, i, k, weights[i])
    return k


@kernel
def direction_to(simplex: Simplex, count: int, fallback: Vector) -> Vector:
    """Direction from the origin to the nearest point of a reduced simplex, of at most three corners.

    Taken from the plane of a triangle and across a segment, where the point itself may be little more than rounding.
    """
    v = weighted(simplex, count, 0)
    if count == 3:
        p = three(simplex, 0)
        normal = cross(minus(three(simplex, 3), p), minus(three(simplex, 6), p))
        return unit_or(times(math.copysign(1.0, dot(normal, v)), normal), fallback)
    if count == 2:
        step = minus(three(simplex, 3), three(simplex, 0))
        v = along(v, -dot(v, step) / dot(step, step), step)
    return unit_or(v, fallback)


@kernel
def core_support(row: Row, n: Vector, rounding: float) -> Vector:
    """Support point of a body that is a smaller body, its core, widened by a ball of radius `rounding`: the core's."""
    return along(support(row, n), -rounding, n)


@kernel
def difference_support(a: Row, b: Row, n: Vector, inset_a: float, inset_b: float, simplex: Simplex, k: int) -> float:
    """Put the point of the difference of the cores that is deepest against `n` at place k; give g(n)."""
    put(simplex, k, core_support(a, n, inset_a), core_support(b, opposite(n), inset_b))
    return dot(three(simplex, 3 * k), n)


@kernel
def gjk(
    a: Row,
    b: Row,
    inset_a: float,
    inset_b: float,
    n: Vector,
    simplex: Simplex,
    count: int,
    tolerance: float,
    limit: int,
) -> tuple[int, int, float, Vector]:
    """Search for the closest points of two bodies; the balls by which their rows are widened do not count.

    Parameters
    ----------
    a, b
        Rows of bodies (`bodies`).
    inset_a, inset_b
        Radii of balls that are taken off first, so that smooth bodies become smaller and overlap less: at most the
        least radius of curvature; 0 for all others. The answer is that of the cores that are left.
    n
        Unit direction to start with, from A to B.
    simplex, count
        Reduced simplex to start with; `count` may be 0. Holds the final simplex afterwards.
    tolerance
        Gap between upper and lower bound at which to end; a length.
    limit
        Most steps to take.

    Returns
    -------
    state, count, gap, direction
        State `OVERLAPPING` when the final simplex has the origin inside, else `APART`, which may still mean that
        the gap is 0 up to rounding; corners of the final simplex; the best lower bound g(n), also when it is
        negative, and its n.
    """
    best, direction, nearest = -math.inf, n, math.inf
    if count > 0:
        nearest = length(weighted(simplex, count, 0))
    for _ in range(limit):
        gap = difference_support(a, b, n, inset_a, inset_b, simplex, count)
        if gap > best:
            best, direction = gap, n
        if nearest - best <= tolerance:
            break
        count = reduce(simplex, count + 1)
        if count == 4:
            return OVERLAPPING, count, best, direction
        v = length(weighted(simplex, count, 0))
        if v >= nearest:
            break
        nearest = v
        n = direction_to(simplex, count, direction)
    return APART, count, best, direction
