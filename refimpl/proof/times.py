"""Claims about the time when a ray first hits a convex proxy: in doubles, or in exact numbers where those fail."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction

from refimpl.flat.shapes import Disc, Segment
from refimpl.proof import rays_curved, rays_polytopes
from refimpl.proof.bodies import Corners, Vertices, exactly, numbered
from refimpl.proof.checker import check
from refimpl.proof.claims import Bound, Certificate, Claim, Common, Faces, Place, Separated, Weights
from refimpl.proof.convex import exact_nearest
from refimpl.proof.planes import Planes
from refimpl.proof.points import Vector, along, doubles, exact, opposite, rationals, round_down, round_up
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.rays import Hit, Miss, cast
from refimpl.proof.solids import body
from refimpl.proof.vectors import Number
from refimpl.shapes import AABB, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Point, Proxy, Ray, Sphere

SIMPLE = Point | Sphere | Capsule | HalfSpace | AABB | Box
"""Hulls of a few points and half-spaces: searched exactly from beginning to end."""
TIGHT = Fraction(1, 1 << 49)  # an interval this wide, relative to the scene, is narrow enough to stay with doubles


def time_claims(ray: Ray, shape: Proxy) -> tuple[Claim, ...]:
    """Make claims about the first hit: in doubles, or in exact numbers where those do not prove it."""
    found, faces, place = first_hit(ray, shape)

    def of_b(n: Vector) -> Faces:
        return (), numbered(0, faces(n))

    if isinstance(found, Miss):
        return (_first_proven((Separated(n, None, of_b(n)) for n in directions(found.normal)), ray, shape),)
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
    outside = (Separated(n, time, of_b(n)) for time in early for n in directions(found.normal(Fraction(time))))
    return _first_proven(outside, ray, shape), inside


def first_hit(
    ray: Ray, shape: Proxy
) -> tuple[Hit | Miss, Callable[[Vector], Weights], Callable[[Fraction], Place | None]]:
    """Find the first hit; what a claim needs to know of the solid's planes; and how it says where the ray is."""
    origin, way = rationals(ray.origin), rationals(ray.direction)

    def no_faces(_: Vector) -> Weights:
        return ()

    def no_place(_: Fraction) -> None:
        return None

    if isinstance(shape, SIMPLE) or (isinstance(shape, Disc | Segment) and shape.radius > 0):
        return cast(ray, shape), no_faces, no_place
    if isinstance(shape, Cylinder):
        return rays_curved.cylinder(origin, way, shape), no_faces, no_place
    if isinstance(shape, Ellipsoid):
        return rays_curved.ellipsoid(origin, way, shape), no_faces, no_place
    solid = body(shape)
    if isinstance(solid, Planes):
        faces = lambda n: solid.faces(opposite(exact(n)))  # noqa: E731
        return rays_polytopes.planes(origin, way, solid), faces, no_place
    assert isinstance(solid, Corners)
    if not isinstance(solid, Vertices):
        return rays_polytopes.hull(origin, way, solid), no_faces, no_place

    def place(time: Fraction) -> Place | None:
        found, (_, mix) = exact_nearest(Corners([along(origin, time, way)]), solid)
        return None if any(found.normal) else exactly(mix)

    return rays_polytopes.hull(origin, way, solid), no_faces, place


def _near_doubles(time: Fraction, *candidates: float) -> list[float]:
    """Keep the doubles that are as near to `time` as doubles should be: they are not at the ends of their range."""
    return [t for t in candidates if math.isfinite(t) and abs(Fraction(t) - time) <= TIGHT * time]


def directions(n: Vector) -> Iterator[Vector]:
    """Give a direction in doubles, and as it is."""
    if any(n):  # there is none where the ray has come to the core of a proxy without radius
        yield direction_of(n)
        yield n


def direction_of(n: Vector) -> Vector:
    """Doubles along n; the stored normal of a half-space stays as it is, for it must not turn at all."""
    if all(isinstance(c, float) for c in n):
        return n
    largest = max(abs(Fraction(c)) for c in n)
    return doubles((n[0] / largest, n[1] / largest, n[2] / largest))


def proven(claim: Claim, a: Proxy, b: Proxy) -> tuple[Bound, Bound]:
    """Bounds from one claim; none, if it does not hold."""
    try:
        return check(Certificate((claim,)), a, b)
    except InvalidCertificate:
        return -math.inf, math.inf


def _first_proven(claims: Iterable[Claim], a: Proxy, b: Proxy) -> Claim:
    """Find the first of some claims that holds."""
    for claim in claims:
        if proven(claim, a, b) != (-math.inf, math.inf):
            return claim
    raise AssertionError("exact numbers prove what exact arithmetic found")
