"""What each claim proves, in exact arithmetic: part of what has to be believed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from refimpl.proof.claims import Bound, Claim, Common, Core, Cover, Escape, Inscribed, Near, Part, Separated
from refimpl.proof.gaps import Sides, cover, escape, piece_of
from refimpl.proof.plane import planar, polygon
from refimpl.proof.rational import InvalidCertificate, index, items, rational, require, spend, surface, vector, whole
from refimpl.proof.sets import Line, Planes, Solid, ball_in_ball
from refimpl.proof.unions import Union
from refimpl.proof.vectors import NONE, Exact, cross, dot, minus, root


def _polytope(points: Sequence[Exact], triangles: Any) -> Fraction:
    """Square of the radius of a ball around 0 in the hull of `points`, proven by a closed surface.

    Every triangle must turn its inner side to 0. Then the surface, seen from 0, covers every direction: it is a
    cycle, so it covers all directions equally often, counting each triangle by its orientation, and all of them, at
    least one, count as +1. So no ray from 0 leaves the hull before it meets some triangle, hence not within the
    distance of the nearest plane.
    """
    least: Bound = math.inf
    for i, j, k in surface(triangles, "triangles", len(points)):
        spend(16)
        (u, v, w), unit = whole([points[i], points[j], points[k]])
        normal = cross(minus(v, u), minus(w, u))
        offset = dot(normal, u)
        require(offset > 0, "triangles: one does not turn its inner side to 0")
        least = min(least, Fraction(offset * offset, dot(normal, normal) * unit * unit))
    return Fraction(least)


def _whole_space(claim: Core, a: Solid, b: Solid) -> Bound:
    ways = [[vector(x, "pairs") for x in items(pair, "pairs", 2)] for pair in items(claim.pairs, "pairs")]
    for shape, way in [(shape, way) for pair in ways for shape, way in zip((a, b), pair, strict=True)]:
        within = all(dot(n, way) <= 0 for n, _ in shape.planes) if isinstance(shape, Planes) else not any(way)
        require(within, "pairs: not directions in which the shape is unbounded")
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
    outside = max((beyond_a + beyond_b for (_, beyond_a), (_, beyond_b) in found), default=NONE)
    if len(points) == 1 and not items(claim.triangles, "triangles"):
        bound = root(dot(points[0], points[0]))[1] + outside
    else:
        bound = outside - root((polygon if planar(a, b) else _polytope)(points, claim.triangles))[0]
    bound -= a.radius + b.radius
    require(bound <= 0, "pairs: they do not prove that the shapes meet")
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
        require(shape.holds(centre, matrix, share), "columns: the ellipsoid is not proven to lie in its core")
        centres.append(centre)
        maps.append(matrix)
    across, radius = minus(*centres), rational(claim.radius, "radius")
    u, v, w = (minus(*columns) for columns in zip(*maps, strict=True))
    rows, volume = [cross(v, w), cross(w, u), cross(u, v)], dot(u, cross(v, w))  # of M⁻¹, times det M
    require(radius >= 0 and volume, "radius: negative, or of a ball in a flat set")
    start = [-dot(row, across) / volume for row in rows]
    images = [[radius * row[axis] / volume for row in rows] for axis in range(3)]
    require(ball_in_ball(start, images, last), "radius: the ball is not proven to lie in the ellipsoids' difference")
    return -radius - a.radius - b.radius


def _near(p: Any, q: Any, a: Solid, b: Solid) -> Bound:
    (on_a, beyond_a), (on_b, beyond_b) = a.member(p, True), b.member(q, True)
    across = minus(on_a, on_b)
    return root(dot(across, across))[1] + beyond_a + beyond_b


def _hit(claim: Any, ray: Line, solid: Solid | Line) -> Bound:
    """Upper bound of the time of the first hit: the ray is inside then."""
    if not isinstance(claim, Common) or isinstance(solid, Line):
        raise InvalidCertificate(f"{type(claim).__name__}: not a claim about a ray")
    time = rational(claim.time, "time")
    place = ray.at(time)
    point, outside = solid.member(place if claim.p is None else claim.p, True)
    require(time >= 0 and outside == 0 and not any(minus(point, place)), "time: the ray is not inside then")
    return time


def _upper(claim: Any, a: Solid | Line, b: Solid | Line) -> Bound:
    """Upper bound of σ, or of the time of the first hit, from points of two convex sets."""
    if isinstance(a, Line):
        return _hit(claim, a, b)
    if isinstance(b, Line):
        return _hit(claim, b, a)
    match claim:
        case Near(p, q):
            return _near(p, q, a, b)
        case Common(p, None):
            return _near(p, p, a, b)
        case Core():
            return _core(claim, a, b)
        case Inscribed():
            return _inscribed(claim, a, b)
    raise InvalidCertificate(f"{type(claim).__name__}: not a claim about two convex solids")


def part_of(side: Union, choice: Any) -> Solid | Line:
    """A convex part, as a claim chooses it."""
    if choice is None:
        return side.alone()
    if type(choice) is int:
        return side.atoms[index(choice, "of", len(side.atoms))]
    part, piece = items(choice, "of", 2)
    require(type(part) is int and part in side.meshes, "of: not a mesh")
    return piece_of(side.meshes[part], piece)


def bounds_of(claim: Claim, sides: Sides) -> tuple[Bound, Bound]:
    """Bounds on σ, or on the time of the first hit, from one claim."""
    match claim:
        case Separated():
            return cover(Cover(claim, until=claim.until), sides), math.inf
        case Cover():
            return cover(claim, sides), math.inf
        case Escape():
            return escape(claim, sides), math.inf
        case Part(of_a, of_b, inner):
            return -math.inf, _upper(inner, part_of(sides[0], of_a), part_of(sides[1], of_b))
    return -math.inf, _upper(claim, sides[0].alone(), sides[1].alone())
