"""Check what a certificate claims about two proxies, in exact arithmetic.

This file, `sets` and `rational` are all of the project that has to be believed. They need nothing but the
standard library, take every number as the exact rational that it is, and return only bounds that they have
computed themselves.

What a convex proxy is, `sets` says: a core, with its support function h(n) and a test for its points, widened by
a ball of radius r. With A ⊖ B = {a − b}, the signed distance σ(A, B) is the distance of 0 from A ⊖ B, or, when 0
lies inside, minus its distance from the boundary. The support function of A ⊖ B is h_A(n) + h_B(−n), and widening
the cores by balls lowers σ by the sum of the radii: σ(A, B) = σ(core A, core B) − r_A − r_B. For a `Ray` the
bounds are on the time when it first hits, ∞ for a miss; a ray up to time t is a segment.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from refimpl.proof.rational import (
    Exact,
    InvalidCertificate,
    Number,
    Vector,
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
from refimpl.proof.sets import Half, Line, Round, Solid, ball_in_ball, read

Bound: TypeAlias = Fraction | float  # a float only for ±∞
Weights: TypeAlias = tuple[tuple[int, Number], ...]
"""Shares of numbered things, up to a common factor: of the vertices that mean a point, of the planes across n."""
Place: TypeAlias = Vector | Weights
"""A point of a proxy: its coordinates, or the weights of its vertices if the proxy is given by vertices."""


@dataclass(frozen=True)
class Separated:
    """σ ≥ L > 0: planes across `n`, from A to B, leave a gap. For a ray: up to the time `until`, or ever.

    `faces` are needed for a polytope that is given by planes: shares λ of its planes with n ∥ Σ λᵢ nᵢ in A, −n in B.
    """

    n: Vector
    until: Number | None = None
    faces: tuple[Weights, Weights] = ((), ())


@dataclass(frozen=True)
class Escape:
    """σ ≥ −D: moving B along `n`, a direction from A to B, by a length D ≥ 0 separates the interiors."""

    n: Vector
    faces: tuple[Weights, Weights] = ((), ())


@dataclass(frozen=True)
class Near:
    """σ ≤ ‖a − b‖, as `a` lies in A and `b` in B."""

    a: Place
    b: Place


@dataclass(frozen=True)
class Common:
    """σ ≤ 0, as the point `p` lies in both. For a ray, in place of `p`: the ray is inside at `time`.

    `p` with a `time` is where the ray is then, for a solid whose points are given by weights.
    """

    p: Place | None
    time: Number | None = None


@dataclass(frozen=True)
class Core:
    """σ ≤ −r − r_A − r_B: a closed polytope of points a_j − b_j of the cores holds a ball of radius r at 0.

    `pairs` are the (a_j, b_j), `triangles` their indices, counter-clockwise seen from outside. One pair and
    no triangle: σ ≤ ‖a − b‖ − r_A − r_B ≤ 0. With `directions`, the pairs are recession directions (u_j, v_j)
    of A and B, and a closed polytope around 0 proves that A ⊖ B is the whole space: σ = −∞.
    """

    pairs: tuple[tuple[Place, Place], ...]
    triangles: tuple[tuple[int, int, int], ...] = ()
    directions: bool = False


@dataclass(frozen=True)
class Inscribed:
    """σ ≤ −r − r_A − r_B: the cores hold ellipsoids whose difference holds the ball of `radius` r around 0.

    The ellipsoid in A is {a + P u : ‖u‖ ≤ 1}, with P's three columns in `p`; the one in B likewise, with Q's in `q`.
    So A ⊖ B holds a − b + (P − Q) u for all ‖u‖ ≤ 1. The `shares` are the numbers by which `sets.ball_in_ball` sees
    that the first lies in A, the second in B, and the ball in the third. This is what proves depths that whole
    circles or spheres of directions share, which a polytope only approaches.
    """

    a: Place
    p: tuple[Vector, Vector, Vector]
    b: Place
    q: tuple[Vector, Vector, Vector]
    radius: Number
    shares: tuple[Number, Number, Number]


Claim: TypeAlias = Separated | Escape | Near | Common | Core | Inscribed


@dataclass(frozen=True)
class Certificate:
    """Claims about one pair of proxies, and the bounds that whoever made it believes them to prove."""

    claims: tuple[Claim, ...]
    lower: Bound = -math.inf
    upper: Bound = math.inf


def _gap(n: Whole, a: Solid | Line, b: Solid | Line, faces: Any, radius: Fraction) -> tuple[Fraction, int]:
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
            _, side = _gap(n, first, second, faces, solid.radius)
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
            gap, side = _gap(n, a, b, faces, radius)
            if (side > 0) != apart:
                raise InvalidCertificate(f"n: the supporting planes {'do not ' if apart else ''}leave a gap")
            low, high = root(Fraction(dot(n, n)))
            bound = gap / (high if gap > 0 else low) - radius
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


def check(certificate: Certificate, a: Any, b: Any) -> tuple[Bound, Bound]:
    """Prove bounds on the signed distance of two single proxies, or on the time when a ray first hits one.

    Returns lower ≤ σ(a, b) ≤ upper [length], ±math.inf where nothing is proven or σ is infinite; for a ray
    lower ≤ t ≤ upper in units of its direction's length, (∞, ∞) when it misses. The certificate's own bounds
    are ignored. Raises `InvalidCertificate` when anything is malformed or false.
    """
    if not isinstance(certificate, Certificate):
        raise InvalidCertificate(f"not a certificate but {type(certificate).__name__}")
    first, second = read(a), read(b)
    claims = items(certificate.claims, "claims")
    bounds = [(-math.inf, math.inf), *(bounds_of(claim, first, second) for claim in claims)]
    lower, upper = max(low for low, _ in bounds), min(high for _, high in bounds)
    if lower > upper:
        raise InvalidCertificate("the claims contradict each other")
    return lower, upper
