"""Make certificates: search exactly, then say it in plain doubles wherever these prove as much."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from typing import Any

from refimpl.proof import convex, rays_curved, rays_polytopes
from refimpl.proof.bodies import Corners, Planes, Vertices, body, exactly
from refimpl.proof.checker import (
    Bound,
    Certificate,
    Claim,
    Common,
    Core,
    Escape,
    Inscribed,
    Near,
    Place,
    Separated,
    Weights,
    check,
)
from refimpl.proof.convex import exact_nearest
from refimpl.proof.exact import Features, features
from refimpl.proof.points import Vector, along, dot, exact, minus, opposite, rationals, root
from refimpl.proof.rational import InvalidCertificate, Number
from refimpl.proof.rays import Hit, Miss, cast
from refimpl.shapes import (
    AABB,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Proxy,
    Ray,
    Sphere,
    UnsupportedOperation,
)

SIMPLE = Point | Sphere | Capsule | HalfSpace | AABB | Box
"""Hulls of a few points and half-spaces: searched exactly from beginning to end."""
TIGHT = Fraction(1, 1 << 49)  # an interval this wide, relative to the scene, is narrow enough to stay with doubles


def certify(a: Proxy, b: Proxy) -> Certificate:
    """Prove the signed distance of two proxies, or the time when a ray first hits one, from both sides.

    Parameters
    ----------
    a, b : Proxy
        Single ones (batch shape ``()``); at most one is a `Ray`.

    Returns
    -------
    Certificate
        Its `lower` and `upper` are what `check` proves from it, rounded outwards to doubles. They are less than
        1e-14·s apart, s being the scene's largest coordinate, extent or distance; both are 0 when the proxies
        touch, and −∞ for half-spaces that are not opposite. For a ray they enclose the time of the first hit,
        in units of the direction's length, to the last bits; both are 0 when it starts inside, and ∞ when it
        misses.

    Raises
    ------
    ValueError
        For batches.
    UnsupportedOperation
        For two rays.

    Notes
    -----
    The numbers of the certificate are doubles, or exact rationals where doubles would widen the interval: the
    corners of slivers, a common point of shapes that touch.
    """
    for shape in (a, b):
        if not isinstance(shape, Proxy):
            raise TypeError(f"certify needs two proxies, got {type(shape).__name__}: {shape!r}")
    if a.batch_shape or b.batch_shape:
        raise ValueError(f"certify takes single proxies, not batches of {a.batch_shape} and {b.batch_shape}")
    if isinstance(a, Ray) and isinstance(b, Ray):
        raise UnsupportedOperation("two rays have no signed distance: one of the proxies must not be a Ray")
    if isinstance(b, Ray) or (isinstance(b, HalfSpace) and not isinstance(a, Ray | HalfSpace)):
        return mirrored(certify(b, a))
    claims = _time_claims(a, b) if isinstance(a, Ray) else _distance_claims(a, b)
    lower, upper = check(Certificate(claims), a, b)
    return Certificate(claims, round_down(lower), round_up(upper))


def mirrored(certificate: Certificate) -> Certificate:
    """Give the certificate for the same proxies in the other order."""
    claims: list[Claim] = []
    for claim in certificate.claims:
        match claim:
            case Separated(n, until, faces):
                claims.append(Separated(opposite(n), until, faces[::-1]))
            case Escape(n, faces):
                claims.append(Escape(opposite(n), faces[::-1]))
            case Inscribed(p, columns, q, others, radius, shares):
                claims.append(Inscribed(q, others, p, columns, radius, (shares[1], shares[0], shares[2])))
            case Near(p, q):
                claims.append(Near(q, p))
            case Core(pairs, triangles, directions):
                swapped = tuple((q, p) for p, q in pairs)  # turns the polytope inside out, hence:
                claims.append(Core(swapped, tuple((i, k, j) for i, j, k in triangles), directions))
            case Common():
                claims.append(claim)
    return Certificate(tuple(claims), certificate.lower, certificate.upper)


def round_down(bound: Bound) -> float:
    """Largest double that is not above `bound`."""
    try:
        nearest = float(bound)
    except OverflowError:
        nearest = math.inf if bound > 0 else -math.inf
    return math.nextafter(nearest, -math.inf) if nearest > bound else nearest


def round_up(bound: Bound) -> float:
    """Smallest double that is not below `bound`."""
    return -round_down(-bound)


def _doubles(point: Any) -> Vector:
    return float(point[0]), float(point[1]), float(point[2])


def _direction(n: Vector) -> Vector:
    """Doubles along n; the stored normal of a half-space stays as it is, for it must not turn at all."""
    if all(isinstance(c, float) for c in n):
        return n
    largest = max(abs(Fraction(c)) for c in n)
    return _doubles((n[0] / largest, n[1] / largest, n[2] / largest))


def _plain(claim: Claim) -> Claim:
    """Give a claim about a distance in doubles; as it is where it exceeds them."""
    try:
        match claim:
            case Separated(n) | Escape(n):
                return type(claim)(_direction(n))
            case Near(p, q):
                return Near(_doubles(p), _doubles(q))
            case Common(p) if p is not None:
                return Common(_doubles(p))
            case Core(pairs, triangles):
                return Core(tuple((_doubles(p), _doubles(q)) for p, q in pairs), triangles)
    except OverflowError:
        pass
    return claim


def _distance_claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    """Make one claim for each side: in doubles, unless exact numbers narrow the interval considerably."""
    if not all(isinstance(shape, SIMPLE) for shape in (a, b)):
        return convex.claims(a, b)
    found = features(a, b)
    if found.directions:
        return (_core(found),)
    exactly, touching = _exact_claims(found, _radius(a), _radius(b))
    plain = _plain(exactly[0]), _plain(exactly[1])
    lower, upper = _proven(plain[0], a, b)[0], _proven(plain[1], a, b)[1]
    sizes = [Fraction(a.magnitude.tolist()), Fraction(b.magnitude.tolist())]
    distance = min((abs(bound) for bound in (lower, upper) if isinstance(bound, Fraction)), default=0)
    slack = Fraction(0) if touching else TIGHT * max(*sizes, distance)
    if not _apart(lower, upper, slack):
        return plain
    low, high = _proven(exactly[0], a, b)[0], _proven(exactly[1], a, b)[1]
    return (
        exactly[0] if _apart(lower, low, slack / 2) else plain[0],
        exactly[1] if _apart(high, upper, slack / 2) else plain[1],
    )


def _apart(low: Bound, high: Bound, slack: Fraction) -> bool:
    finite = isinstance(low, Fraction) and isinstance(high, Fraction)
    return high - low > slack if finite else low < high


def _radius(shape: Proxy) -> Fraction:
    return Fraction(shape.radius.tolist()) if isinstance(shape, Sphere | Capsule) else Fraction(0)


def _proven(claim: Claim, a: Proxy, b: Proxy) -> tuple[Bound, Bound]:
    """Bounds from one claim; none, if it does not hold."""
    try:
        return check(Certificate((claim,)), a, b)
    except InvalidCertificate:
        return -math.inf, math.inf


def _core(found: Features) -> Core:
    return Core(tuple(found.pairs), tuple(found.triangles), found.directions)


def _exact_claims(found: Features, radius_a: Fraction, radius_b: Fraction) -> tuple[tuple[Claim, Claim], bool]:
    """Claims for the lower and the upper bound, and whether the proxies just touch."""
    if found.triangles:
        return (Escape(found.normal), _core(found)), False
    ((p, q),) = found.pairs
    radius, across = radius_a + radius_b, minus(q, p)
    square = dot(across, across)
    length = root(square)[1]
    if square > radius * radius:
        on_a, on_b = along(p, radius_a / length, across), along(q, -radius_b / length, across)
        return (Separated(found.normal), Near(on_a, on_b)), False
    touching = square == radius * radius
    if radius == 0 or length > radius:  # or so close to touching that the root does not tell
        return (Escape(found.normal), Common(along(p, radius_a / radius if radius else 0, across))), touching
    return (Escape(found.normal), _core(found)), touching


def _time_claims(ray: Ray, shape: Proxy) -> tuple[Claim, ...]:
    """Make claims about the first hit: in doubles, or in exact numbers where those do not prove it."""
    found, faces, place = _cast(ray, shape)
    if isinstance(found, Miss):
        ways = ((n, faces(n)) for n in _directions(found.normal))
        return (_first_proven((Separated(n, None, ((), of_b)) for n, of_b in ways), ray, shape),)
    late: list[Number] = [*_near_doubles(found.high, round_up(found.high)), found.high, found.within]
    inside = _first_proven((Common(place(Fraction(time)), time) for time in late), ray, shape)
    if found.high == 0:
        return (inside,)
    before = round_down(found.low)
    early: list[Number] = [
        *_near_doubles(found.low, before, math.nextafter(before, 0.0)),
        found.low,
        found.low * (1 - Fraction(1, 1 << 100)),  # for where the ray grazes, and has no direction at the hit itself
    ]
    outside = (Separated(n, time, ((), faces(n))) for time in early for n in _directions(found.normal(Fraction(time))))
    return _first_proven(outside, ray, shape), inside


def _cast(ray: Ray, shape: Proxy) -> tuple[Hit | Miss, Callable[[Vector], Weights], Callable[[Fraction], Place | None]]:
    """Find the first hit; what a claim needs to know of the solid's planes; and how it says where the ray is."""
    origin, way = rationals(ray.origin), rationals(ray.direction)

    def no_faces(_: Vector) -> Weights:
        return ()

    def no_place(_: Fraction) -> None:
        return None

    if isinstance(shape, SIMPLE):
        return cast(ray, shape), no_faces, no_place
    if isinstance(shape, Cylinder):
        return rays_curved.cylinder(origin, way, shape), no_faces, no_place
    if isinstance(shape, Ellipsoid):
        return rays_curved.ellipsoid(origin, way, shape), no_faces, no_place
    solid = body(shape)
    if isinstance(solid, Planes):
        faces = lambda n: solid.faces(opposite(exact(n)))  # noqa: E731
        return rays_polytopes.planes(origin, way, solid), faces, no_place
    assert isinstance(solid, Vertices)

    def place(time: Fraction) -> Place | None:
        found, (_, mix) = exact_nearest(Corners([along(origin, time, way)]), solid)
        return None if any(found.normal) else exactly(mix)

    return rays_polytopes.hull(origin, way, solid), no_faces, place


def _near_doubles(time: Fraction, *candidates: float) -> list[float]:
    """Keep the doubles that are as near to `time` as doubles should be: they are not at the ends of their range."""
    return [t for t in candidates if math.isfinite(t) and abs(Fraction(t) - time) <= TIGHT * time]


def _directions(n: Vector) -> Iterator[Vector]:
    if any(n):  # there is none where the ray has come to the core of a proxy without radius
        yield _direction(n)
        yield n


def _first_proven(claims: Iterable[Claim], a: Proxy, b: Proxy) -> Claim:
    """Find the first of some claims that holds."""
    for claim in claims:
        if _proven(claim, a, b) != (-math.inf, math.inf):
            return claim
    raise AssertionError("exact numbers prove what exact arithmetic found")
