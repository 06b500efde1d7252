"""What each claim proves about two convex proxies, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from refimpl.proof.claims import Bound, Claim, Common, Core, Escape, Inscribed, Near, Separated
from refimpl.proof.rational import (
    Exact,
    InvalidCertificate,
    Whole,
    cross,
    direction,
    dot,
    index,
    items,
    minus,
    number,
    root,
    vector,
    whole,
)
from refimpl.proof.sets import Half, Line, Round, Solid, ball_in_ball


def gap(n: Whole, a: Solid | Line, b: Solid | Line, faces: Any, radius: Fraction) -> tuple[Fraction, int]:
    """‖n‖ times the gap between the supporting planes of the cores, and the sign of gap/‖n‖ − radius."""
    of_a, of_b = items(faces, "faces", 2)
    rise = a.support(n, of_a) + b.support([-c for c in n], of_b)
    beyond = rise * rise - radius * radius * dot(n, n) if rise <= 0 else Fraction(-1)
    return -rise, (beyond > 0) - (beyond < 0)


def _polytope(points: Sequence[Exact], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of `points`, proven by a closed surface.

    Every directed edge must occur as often as its reverse, and every triangle must turn its inner side to 0.
    Then the surface, seen from 0, covers every direction: it is a cycle, so it covers all directions equally
    often, counting each triangle by its orientation, and all of them, at least one, count as +1. So no ray
    from 0 leaves the hull before it meets some triangle, hence not within the distance of the nearest plane.
    """
    edges: Counter[tuple[int, int]] = Counter()
    corners, unit = whole(points)
    squares = []
    for triangle in items(triangles, "triangles"):
        i, j, k = (index(i, "triangles", len(points)) for i in items(triangle, "triangles", 3))
        edges.update([(i, j), (j, k), (k, i)])
        normal = cross(minus(corners[j], corners[i]), minus(corners[k], corners[i]))
        offset = dot(normal, corners[i])
        if offset <= 0:
            raise InvalidCertificate(f"triangles: {triangle!r} does not turn its inner side to 0")
        squares.append(Fraction(offset * offset, dot(normal, normal)))
    if not squares or any(edges[i, j] != edges[j, i] for i, j in list(edges)):
        raise InvalidCertificate("triangles: the surface is not closed")
    return min(squares) / (unit * unit)


def _whole_space(claim: Core, a: Solid, b: Solid) -> Bound:
    ways = [[vector(x, "pairs") for x in items(pair, "pairs", 2)] for pair in items(claim.pairs, "pairs")]
    for shape, way in [(shape, way) for pair in ways for shape, way in zip((a, b), pair, strict=True)]:
        if dot(shape.normal, way) > 0 if isinstance(shape, Half) else any(way):
            raise InvalidCertificate("pairs: not directions in which the shape is unbounded")
    _polytope([minus(u, v) for u, v in ways], claim.triangles)
    return -math.inf


def _core(claim: Core, a: Solid, b: Solid) -> Bound:
    """Upper bound of σ from points of the cores."""
    if claim.directions is True:
        return _whole_space(claim, a, b)
    ends = [items(pair, "pairs", 2) for pair in items(claim.pairs, "pairs")]
    found = [(a.member(p), b.member(q)) for p, q in ends]
    points = [minus(p, q) for (p, _), (q, _) in found]
    # moving its vertices by `outside` at most, into the cores, brings no facet of the hull nearer by more than that
    outside = max((beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found), default=Fraction(0))
    if len(points) == 1 and not items(claim.triangles, "triangles"):
        bound = root(dot(points[0], points[0]))[1] + outside - a.radius - b.radius
    else:
        bound = outside - root(_polytope(points, claim.triangles))[0] - a.radius - b.radius
    if bound > 0:
        raise InvalidCertificate("pairs: they do not prove that the shapes meet")
    return bound


def _inscribed(claim: Inscribed, a: Solid, b: Solid) -> Bound:
    """Upper bound of σ from ellipsoids in the cores.

    The ball of radius r lies in {d + M u : ‖u‖ ≤ 1} if ‖M⁻¹(r w − d)‖ ≤ 1 for all ‖w‖ ≤ 1.
    """
    centres, maps = [], []
    *shares, last = vector(claim.shares, "shares", 3)
    for shape, place, columns, share in zip((a, b), (claim.a, claim.b), (claim.p, claim.q), shares, strict=True):
        centre = shape.member(place)[0]
        matrix = [vector(column, "columns") for column in items(columns, "columns", 3)]
        if not shape.holds(centre, matrix, share):
            raise InvalidCertificate("columns: the ellipsoid is not proven to lie in its core")
        centres.append(centre)
        maps.append(matrix)
    across, radius = minus(*centres), number(claim.radius, "radius")
    u, v, w = (minus(*columns) for columns in zip(*maps, strict=True))
    rows, volume = [cross(v, w), cross(w, u), cross(u, v)], dot(u, cross(v, w))  # of M⁻¹, times det M
    if radius < 0 or volume == 0:
        raise InvalidCertificate("radius: negative, or of a ball in a flat set")
    start = [-dot(row, across) / volume for row in rows]
    images = [[radius * row[axis] / volume for row in rows] for axis in range(3)]
    if not ball_in_ball(start, images, Fraction(1), last):
        raise InvalidCertificate("radius: the ball is not proven to lie in the difference of the ellipsoids")
    return -radius - a.radius - b.radius


def _times(claim: Claim, a: Solid | Line, b: Solid | Line) -> tuple[Bound, Bound]:
    """Bounds on the time when a ray first hits, from one claim."""
    ray, solid, sign = (a, b, 1) if isinstance(a, Line) else (b, a, -1)
    if not isinstance(ray, Line) or isinstance(solid, Line):
        raise InvalidCertificate("two rays have no signed distance")
    match claim:
        case Separated(way, until, faces):
            n, rises = direction(way), False
            time: Bound = math.inf
            part: Round | Line = ray
            if until is not None:
                time = number(until, "until")
                (start, edge), unit = whole([ray.origin, minus(ray.at(time), ray.origin)])
                part = Round(start, [edge], unit, Fraction(0))
                rises = sign * dot(n, ray.direction) > 0  # then only the end of the segment may touch its plane
            first, second = (part, solid) if sign > 0 else (solid, part)
            _, side = gap(n, first, second, faces, solid.radius)
            if time < 0 or side < (0 if rises else 1):
                raise InvalidCertificate("n: the supporting planes do not leave a gap")
            return time, math.inf
        case Common(p, instant):
            moment = number(instant, "time")
            place = ray.at(moment)
            point, outside = solid.member(place if p is None else p, True)
            if moment < 0 or outside > 0 or any(minus(point, place)):
                raise InvalidCertificate("time: the ray is not inside then")
            return Fraction(0), moment
    raise InvalidCertificate(f"{type(claim).__name__}: not a claim about a ray")


def bounds_of(claim: Claim, a: Solid | Line, b: Solid | Line) -> tuple[Bound, Bound]:
    """Bounds on σ, or on the time of the first hit, from one claim."""
    if isinstance(a, Line) or isinstance(b, Line):
        return _times(claim, a, b)
    match claim:
        case Separated(way, None, faces) | Escape(way, faces):
            apart, n, radius = isinstance(claim, Separated), direction(way), a.radius + b.radius
            rise, side = gap(n, a, b, faces, radius)
            if (side > 0) != apart:
                raise InvalidCertificate(f"n: the supporting planes {'do not ' if apart else ''}leave a gap")
            low, high = root(Fraction(dot(n, n)))
            bound = rise / (high if rise > 0 else low) - radius
            return max(bound, Fraction(0)) if apart else bound, math.inf
        case Near(p, q):
            (on_a, beyond_a), (on_b, beyond_b) = a.member(p, True), b.member(q, True)
            across = minus(on_a, on_b)
            return -math.inf, root(dot(across, across))[1] + beyond_a + beyond_b
        case Common(p, None) if p is not None:
            return bounds_of(Near(p, p), a, b)
        case Core():
            return -math.inf, _core(claim, a, b)
        case Inscribed():
            return -math.inf, _inscribed(claim, a, b)
    raise InvalidCertificate(f"{type(claim).__name__}: not a claim about two solids")
