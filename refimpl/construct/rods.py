"""Capsules and cylinders: a small one is proposed by its axis, then radius and ends are the least that contain all.

No closed form of the smallest ones is known. The axis is searched from the best of the principal axes and the normals
of the hull's largest faces; for each direction it goes through the centre of the smallest circle around the points, as
seen along it (Ericson, Real-Time Collision Detection, 4.5; Schömer et al., Smallest Enclosing Cylinders, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from refimpl.construct.balls import around as sphere_around
from refimpl.construct.circles import smallest_circle
from refimpl.construct.cloud import Cloud
from refimpl.construct.extreme import centred, dimension, face_normals, few_corners
from refimpl.construct.formulas import across, inner, less, near_segment
from refimpl.construct.outwards import least_root, nearest
from refimpl.construct.sources import ConstructionError, points_of
from refimpl.linear import Array, scale
from refimpl.shapes import Capsule, Cylinder

Ends = tuple[Array, Array]
ATTEMPTS = 200  # pushes of an end by one more unit in the last place, then two, four, …


def capsule(points: ArrayLike) -> Capsule:
    """Small capsule around points (n, 3); of one point and of collinear ones, as thin as doubles allow.

    Raises
    ------
    ConstructionError
        See `points_of`; and for a capsule beyond the largest double.
    """
    cloud = Cloud(points_of(points))
    low, high, _ = _searched(cloud, _capsule_about)
    p, q = (nearest([Fraction(v) for v in end.tolist()], cloud, "end") for end in (low, high))
    start, end = ([cloud.inwards(v) for v in x.tolist()] for x in (p, q))
    if start == end:
        ball = sphere_around(cloud, p)
        single = len(np.unique(cloud.points[[0, -1]], axis=0)) == 1 and not np.any(np.ptp(cloud.points, axis=0))
        return Capsule(p, q, 0.0 if single else ball.radius)
    way = less(end, start)
    widest = cloud.greatest(near_segment(start, end)).value / inner(way, way)
    return Capsule(p, q, least_root(widest, cloud, "capsule"))


def cylinder(points: ArrayLike) -> Cylinder:
    """Small cylinder around points (n, 3), of which not all are on one line.

    Coplanar points give a disc as thin as doubles allow, or a cylinder whose axis lies in their plane.

    Raises
    ------
    ConstructionError
        See `points_of`; for collinear points, around which every cylinder can be made thinner; and for a cylinder
        beyond the largest double.
    """
    cloud = Cloud(points_of(points))
    if dimension(centred(cloud)[0])[0] < 2:
        raise ConstructionError(
            "the points lie on one line, up to rounding: no cylinder is the smallest around them; use a capsule"
        )
    low, high, axis = _searched(cloud, _cylinder_about)
    p, q = _ends_outside(cloud, low, high, axis)
    start, end = ([cloud.inwards(v) for v in x.tolist()] for x in (p, q))
    way = less(end, start)
    widest = cloud.greatest(across(start, way)).value / inner(way, way)
    return Cylinder(p, q, least_root(widest, cloud, "cylinder"))


def _ends_outside(cloud: Cloud, low: Array, high: Array, axis: Array) -> Ends:
    """Ends in doubles, moved outwards along their axis until no point lies beyond the planes through them."""
    more = [0.0, 0.0]
    ulp = 2.0**-53 * max(float(np.max(np.abs(low))), float(np.max(np.abs(high))))
    for attempt in range(ATTEMPTS):
        p, q = (
            nearest([Fraction(v) for v in end.tolist()], cloud, "end")
            for end in (low - more[0] * axis, high + more[1] * axis)
        )
        start, end = ([cloud.inwards(v) for v in x.tolist()] for x in (p, q))
        way = less(end, start)
        push = ulp * 1.5 ** (attempt // 2)
        if not any(way):
            more = [m + push for m in more]
            continue
        beyond = [cloud.highest([-v for v in way]) + inner(way, start), cloud.highest(way) - inner(way, end)]
        if max(beyond) <= 0:
            return p, q
        more = [m + push * (b > 0) for m, b in zip(more, beyond, strict=True)]
    raise ConstructionError("no cylinder in doubles around these points was found; scale them to about 1")


About = Callable[[Array, Array], tuple[float, Ends]]


def _searched(cloud: Cloud, about: About) -> tuple[Array, Array, Array]:
    """Ends of the axis, in a cloud's units, for which what lies about it is smallest; and its direction."""
    from scipy.optimize import minimize  # noqa: PLC0415  slow to import

    inside, middle = centred(cloud)
    corners = few_corners(inside)
    count, frame = dimension(inside)
    if count <= 1:
        reach = corners @ frame[:, 0]
        ends = scale(np.array([reach.min(), reach.max()]), frame[:, 0]) + (corners[0] - reach[0] * frame[:, 0])
        return ends[0] + middle, ends[1] + middle, frame[:, 0]
    size = float(np.max(np.abs(corners)))
    unit = corners / size

    def cost(turn: Array, about_axis: Array) -> float:
        return about(unit, _turned(about_axis, turn))[0]

    ways = np.concatenate([frame.T, face_normals(unit, MOST_FACES) if count == 3 else np.zeros((0, 3))])
    starts = sorted((about(unit, way)[0], i) for i, way in enumerate(ways))
    best = starts[0][0], ways[starts[0][1]]
    for volume, i in starts[:2]:
        options = {"initial_simplex": SIMPLEX, "maxfev": 120, "xatol": 1e-10, "fatol": 1e-12 * volume}
        found = minimize(cost, np.zeros(2), args=(ways[i],), method="Nelder-Mead", options=options)
        if found.fun < best[0]:
            best = float(found.fun), _turned(ways[i], found.x)
    low, high = about(unit, best[1])[1]
    return low * size + middle, high * size + middle, best[1]


MOST_FACES = 32  # of the hull, whose normals are tried
SIMPLEX = np.array([[0.0, 0.0], [0.2, 0.0], [0.0, 0.2]])


def _turned(axis: Array, by: Array) -> Array:
    """Direction near an axis, moved by two coordinates at right angles to it."""
    u, v = _across(axis)
    way = axis + by[0] * u + by[1] * v
    return np.asarray(way / np.linalg.norm(way))


def _across(axis: Array) -> Ends:
    """Two unit vectors at right angles to one and to each other; by numbers, as small arrays are slow."""
    way: list[float] = axis.tolist()
    least = min(range(3), key=lambda i: abs(way[i]))
    u = _cross(way, [float(i == least) for i in range(3)])
    length = math.hypot(*u)
    u = [v / length for v in u]
    return np.array(u), np.array(_cross(way, u))


def _cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _seen_along(points: Array, axis: Array) -> tuple[Array, float, Array, Array]:
    """Point of the axis through the smallest circle, its radius, heights along the axis, squared distances from it."""
    u, v = _across(axis)
    x, y, heights = np.stack([u, v, axis]) @ points.T
    (a, b), radius = smallest_circle(x, y)
    return a * u + b * v, radius, heights, (x - a) ** 2 + (y - b) ** 2


def _cylinder_about(points: Array, axis: Array) -> tuple[float, Ends]:
    start, radius, heights, _ = _seen_along(points, axis)
    low, high = float(heights.min()), float(heights.max())
    return radius * radius * (high - low), (start + low * axis, start + high * axis)


def _capsule_about(points: Array, axis: Array) -> tuple[float, Ends]:
    """Ends as near to each other as the round caps allow, and the volume over π."""
    start, radius, heights, square = _seen_along(points, axis)
    caps = np.sqrt(np.maximum(radius * radius - square, 0.0))
    low, high = float(np.min(heights + caps)), float(np.max(heights - caps))
    if low > high:
        low = high = (low + high) / 2
    return radius * radius * (high - low) + 4 / 3 * radius**3, (start + low * axis, start + high * axis)
