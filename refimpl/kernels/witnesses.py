"""Points of two bodies that realise their signed distance, when its direction is known: the witness points.

Along the normal n every body has an extreme face: a vertex, an edge, a polygon, the cap of a cylinder, or the one
point of a smooth surface. When B is moved by −σ·n, the faces of A and B lie in one plane, and witness points are where
they meet. That there are such points also proves that g has a maximum at n: a local one, and when the bodies are
apart the only one.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence

from . import kernel
from .bodies import AXES, CENTER, COUNT, CYLINDER, ELLIPSOID, HULL, KIND, SIZES, VERTICES, Row, support, three
from .features import feature, points_of_face, polish
from .gjk import ON_A, ON_B, Simplex, gjk, nearest_of_three, store, weighted
from .newton import ZERO, curvature
from .projection import nearest_to_point
from .vectors import Vector, along, cross, dot, length, minus, opposite, perpendicular, plus, times, unit_or, without

Floats = MutableSequence[float]

EPS = 2.0**-52
ROUNDS = 4
"""Most rounds of correcting witness points."""


@kernel
def middle(row: Row) -> Vector:
    """Some point of a body, for a first guess."""
    if row[KIND] == HULL:
        return three(row, VERTICES)
    return three(row, CENTER)


@kernel
def face_towards(row: Row, n: Vector, shift: Vector, slack: float, face: Floats) -> None:
    """Write the face of a body that is farthest along `n`, moved by `shift`, as the row of a body of its own.

    A vertex, an edge, a polygon; the side of a cylinder, a segment there; its cap, a flat cylinder.
    """
    for i in range(VERTICES):
        face[i] = row[i]
    face[KIND], face[COUNT] = HULL, 1.0
    top = support(row, n)
    axis = three(row, AXES + 6)
    count = 0
    if row[KIND] == HULL:
        for i in range(int(row[COUNT])):
            v = three(row, VERTICES + 3 * i)
            if dot(minus(top, v), n) <= slack:
                store(face, VERTICES + 3 * count, plus(v, shift))
                count += 1
        face[COUNT] = float(count)
    elif row[KIND] == CYLINDER and length(without(n, axis)) * row[SIZES] <= slack:
        face[KIND], face[COUNT], face[SIZES + 2] = CYLINDER, 0.0, 0.0
        cap = along(three(row, CENTER), math.copysign(row[SIZES + 2], dot(n, axis)), axis)
        store(face, CENTER, plus(cap, shift))
    elif row[KIND] == CYLINDER and abs(dot(n, axis)) * row[SIZES + 2] <= slack:
        out = along(three(row, CENTER), row[SIZES], unit_or(without(n, axis), n))
        store(face, VERTICES, plus(along(out, row[SIZES + 2], axis), shift))
        store(face, VERTICES + 3, plus(along(out, -row[SIZES + 2], axis), shift))
        face[COUNT] = 2.0
    else:
        store(face, VERTICES, plus(top, shift))


@kernel
def nearest_on_polygon(face: Row, point: Vector) -> Vector:
    """Point of a hull that is a polygon, a segment or a point, nearest to a given one."""
    count = int(face[COUNT])
    best, least = three(face, VERTICES), math.inf
    for i in range(max(count - 2, 1)):
        for j in range(i + 1, max(count - 1, i + 2)):
            for k in range(j + 1, max(count, j + 2)):
                u = minus(three(face, VERTICES + 3 * i), point)
                v = minus(three(face, VERTICES + 3 * min(j, count - 1)), point)
                w = minus(three(face, VERTICES + 3 * min(k, count - 1)), point)
                _, s, t = nearest_of_three(u, v, w)
                way = along(along(u, s, minus(v, u)), t, minus(w, u))
                if dot(way, way) < least:
                    best, least = plus(point, way), dot(way, way)
    return best


@kernel
def nearest_on_feature(row: Row, face: Row, n: Vector, point: Vector) -> Vector:
    """Point of a body's surface, on the feature that is extreme along `n`, nearest to a given point.

    The direction tells a point of a rim or of a flat ellipsoid only roughly where it nearly is their flat side's.
    """
    if row[KIND] == ELLIPSOID or face[KIND] == CYLINDER:
        return nearest_to_point(row, point)[2]
    if row[KIND] == CYLINDER and face[COUNT] == 1.0:
        axis = three(row, AXES + 6)
        cap = along(three(row, CENTER), math.copysign(row[SIZES + 2], dot(n, axis)), axis)
        return along(cap, row[SIZES], unit_or(without(minus(point, cap), axis), three(row, AXES)))
    return nearest_on_polygon(face, point)


@kernel
def flat_ways(row: Row, face: Row, n: Vector) -> tuple[Vector, float, Vector, float]:
    """Two tangent directions in which a body is curved most and least where it is extreme along `n`, and how little.

    How little is the radius of curvature: infinite along an edge and in a face, 0 at a vertex.
    """
    s = perpendicular(n)
    t = cross(n, s)
    if face[KIND] == CYLINDER or face[COUNT] > 2.0:
        return s, math.inf, t, math.inf
    if face[COUNT] == 2.0:
        s = unit_or(without(minus(three(face, VERTICES + 3), three(face, VERTICES)), n), s)
        t = cross(n, s)
    top = support(row, n)
    _, _, p, q, r = curvature(feature(row, (top, top, top))[0], n, s, t)
    if face[COUNT] == 2.0:
        return s, math.inf, t, r
    middle_radius, half = (p + r) / 2.0, (p - r) / 2.0
    spread = math.sqrt(half * half + q * q)
    # eigenvector of the matrix (p, q; q, r), from the one of its rows that loses nothing
    way = (spread + half, q) if half > 0.0 else (q, spread - half)
    u = unit_or(along(times(way[0], s), way[1], t), s)
    return u, middle_radius + spread, cross(n, u), max(middle_radius - spread, 0.0)


@kernel
def shares(
    misfit: Vector, n: Vector, flat_a: tuple[Vector, float, Vector, float], flat_b: tuple[Vector, float, Vector, float]
) -> tuple[Vector, Vector]:
    """Split a tangential vector into a part that moves A and one that moves B, each where that body is flattest."""
    ways = (flat_a[0], flat_a[2], flat_b[0], flat_b[2])
    radii = (flat_a[1], flat_a[3], flat_b[1], flat_b[3])
    first, second, most = 0, -1, 0.0
    for i in range(1, 4):
        if radii[i] > radii[first]:
            first = i
    for i in range(4):
        sine = abs(dot(cross(ways[first], ways[i]), n))
        value = min(radii[i], 1e300) * sine
        if i != first and sine > 1e-12 and value > most:
            second, most = i, value
    on_a, on_b = ZERO, ZERO
    if second < 0:
        return times(dot(misfit, ways[first]) if first < 2 else 0.0, ways[first]), on_b
    area = dot(cross(ways[first], ways[second]), n)
    lengths = dot(cross(misfit, ways[second]), n) / area, dot(cross(ways[first], misfit), n) / area
    for i, size in ((first, lengths[0]), (second, lengths[1])):
        if i < 2:
            on_a = along(on_a, size, ways[i])
        else:
            on_b = along(on_b, size, ways[i])
    return on_a, on_b


@kernel
def witnesses(
    a: Row, b: Row, sigma: float, n: Vector, size: float, simplex: Simplex, face_a: Floats, face_b: Floats
) -> tuple[Vector, Vector, float]:
    """Find points of two bodies that are σ·n apart, and how much they fail to be.

    They are where the extreme faces along n meet, when B is moved by −σ·n. A direction tells a point badly where a
    body is nearly flat; so what is missing is made up there, where a body's surface can be followed for a long way.

    """
    slack = 256.0 * EPS * size
    face_towards(a, n, (0.0, 0.0, 0.0), slack, face_a)
    face_towards(b, opposite(n), times(-sigma, n), slack, face_b)
    start = unit_or(minus(middle(face_b), middle(face_a)), n)
    _, count, _, _ = gjk(face_a, face_b, 0.0, 0.0, start, simplex, 0, EPS * size, 40)
    x, y = weighted(simplex, count, ON_A), along(weighted(simplex, count, ON_B), sigma, n)
    misfit = length(along(minus(y, x), -sigma, n))
    if misfit <= 2.0 * EPS * size:
        return x, y, misfit
    face_towards(b, opposite(n), ZERO, slack, face_b)
    flat_a, flat_b = flat_ways(a, face_a, n), flat_ways(b, face_b, opposite(n))
    for _ in range(ROUNDS):
        move_a, move_b = shares(along(minus(y, x), -sigma, n), n, flat_a, flat_b)
        p = nearest_on_feature(a, face_a, n, plus(x, move_a))
        q = nearest_on_feature(b, face_b, opposite(n), minus(y, move_b))
        rest = length(along(minus(q, p), -sigma, n))
        if rest >= misfit:
            break
        x, y, misfit = p, q, rest
    return x, y, misfit


@kernel
def settled(
    a: Row, b: Row, sigma: float, n: Vector, size: float, simplex: Simplex, face_a: Floats, face_b: Floats
) -> tuple[float, Vector, Vector, Vector, float]:
    """Witness points for a distance and its direction, and both sharpened once more where the points do not fit.

    What g(n) tells in rounded numbers leaves n a little free. So the features are tried that would meet if n were
    wrong by ever less.

    Returns
    -------
    sigma, direction, x, y, misfit
        The last is the length of y − x − σ·n.
    """
    x, y, misfit = witnesses(a, b, sigma, n, size, simplex, face_a, face_b)
    start = n
    slack = 1e-4 * size
    while misfit > 32.0 * EPS * size and slack > EPS * size:
        p, q = points_of_face(a, start, slack), points_of_face(b, opposite(start), slack)
        gap, m, _, _, _ = polish(a, b, p, q, start)
        if gap >= sigma - 16.0 * EPS * size:
            u, v, rest = witnesses(a, b, gap, m, size, simplex, face_a, face_b)
            if rest < misfit or gap > sigma + 16.0 * EPS * size:
                sigma, n, x, y, misfit = gap, m, u, v, rest
        slack *= 0.1
    return sigma, n, x, y, misfit
