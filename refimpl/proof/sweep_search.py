"""Make certificates of first contacts: the door to the searches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from fractions import Fraction

import numpy as np

from refimpl.flat.polygon import ConvexPolygon
from refimpl.motions import Motion, RigidMotion, as_motion
from refimpl.proof.bodies import Corners, Mix, exactly, numbered
from refimpl.proof.certify import certify
from refimpl.proof.checker import sides_of
from refimpl.proof.claims import Certificate, Claim, Cover, Escape, Place, Separated
from refimpl.proof.convex import plain
from refimpl.proof.points import Vector, along, dot, exact, minus, opposite, rationals, round_down, round_up
from refimpl.proof.rational import InvalidCertificate
from refimpl.proof.reaches import Pairs
from refimpl.proof.solids import body
from refimpl.proof.sweep_casts import NARROW, Contact, Miss, Undecided, clear_until, flat, landing, pointed, rounded
from refimpl.proof.sweeps import Clear, Meets, SweepCertificate, SweepClaim, check_sweep, clear, meets
from refimpl.shapes import (
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Ray,
    UnsupportedOperation,
)

UNION = Composite | Polyhedron
ROUND = 20
"""Bits after the point of round numbers."""
ENOUGH = Fraction(1, 1 << 42)
"""An interval of time as narrow is narrow enough."""


def certify_sweep(
    a: Proxy, b: Proxy, motion_a: Motion | None = None, motion_b: Motion | None = None
) -> SweepCertificate:
    """Prove from both sides when two moving proxies first meet.

    Parameters
    ----------
    a, b : solids, or a point and a solid
        Single ones (batch shape ``()``).
    motion_a, motion_b : Translation, RigidMotion or None
        Single ones.

    Returns
    -------
    SweepCertificate
        Its `lower` and `upper` are what `check_sweep` proves from it, rounded outwards to doubles: 0 for both where the
        proxies overlap from the start, ∞ where they do not meet from 0 to 1. For translations of proxies with flat
        faces they are equal up to that rounding, and less than 1e-12 apart for others. Where it could not be told
        whether two round proxies that pass each other touch, `lower` is the time of which it is known that they do
        not meet before, and `upper` is ∞.

    Raises
    ------
    ValueError
        For batches.
    UnsupportedOperation
        For rays, and for two points.
    """
    from_a, from_b = as_motion(motion_a, a.dimension), as_motion(motion_b, b.dimension)
    for part in (a, b, from_a, from_b):
        if part.batch_shape:
            raise ValueError(f"certify_sweep takes single proxies and motions, not batches of {part.batch_shape}")
    if isinstance(a, Ray) or isinstance(b, Ray) or (isinstance(a, Point) and isinstance(b, Point)):
        raise UnsupportedOperation("a sweep is of solids, or of a point and a solid")
    if isinstance(from_a, RigidMotion) or isinstance(from_b, RigidMotion):
        from refimpl.proof.rigid_search import certify_rigid  # noqa: PLC0415  what only rotations need

        return certify_rigid(a, b, from_a, from_b)
    claims = _claims(a, b, minus(rationals(from_b.vector), rationals(from_a.vector)))
    lower, upper = check_sweep(SweepCertificate(claims), a, b, from_a, from_b)
    return SweepCertificate(claims, round_down(lower), round_up(upper) + 0.0)


def _claims(a: Proxy, b: Proxy, way: Vector) -> tuple[SweepClaim, ...]:
    """Claims about the contact at the start, or about the first one."""
    start = certify(a, b)
    if start.upper <= 0:
        return _at_start(start)
    still = _staying(start, way)
    if still is not None:
        return (still,)
    if isinstance(a, UNION) or isinstance(b, UNION):
        from refimpl.proof.sweep_unions import union_sweep  # noqa: PLC0415  what only unions need

        return union_sweep(a, b, way)
    claims: tuple[SweepClaim, ...] = ()
    with suppress(Undecided):
        claims = convex_claims(a, b, way, first_contact(a, b, way))
    if any(isinstance(claim, Clear) and claim.until is None for claim in claims):
        return claims
    meets = tuple(claim for claim in claims if isinstance(claim, Meets)) or _witnessed(a, b, way)
    return (*_waiting(a, b, way, claims, meets), *meets)


def _waiting(
    a: Proxy, b: Proxy, way: Vector, claims: Sequence[SweepClaim], meets: Sequence[Meets]
) -> tuple[Clear, ...]:
    """The span before a contact; where it was not found together with the contact, by planes for times before that."""
    known = tuple(claim for claim in claims if isinstance(claim, Clear))
    until = Fraction(known[0].until or 0) if known else Fraction(0)
    time = Fraction(meets[0].time) if meets else Fraction(1)
    if time - until <= ENOUGH or isinstance(a, HalfSpace) or isinstance(b, HalfSpace):
        return known
    for early, n in clear_until(Pairs(a, b, way, True), time):
        if early > until:
            found = first_proven(a, b, way, [Clear(separated(a, b, m), early) for m in (plain(n), n)])
            if found:
                return found
    return known


def _witnessed(a: Proxy, b: Proxy, way: Vector) -> tuple[Meets, ...]:
    """A contact at the time and in a point that doubles find, or round numbers near them, where these are exact."""
    from refimpl.queries import distance  # noqa: PLC0415  it imports this package
    from refimpl.sweeps.translations import advance  # noqa: PLC0415

    course = np.array([float(c) for c in way])
    t = float(advance(a.broadcast_to((1,)), b.broadcast_to((1,)), course[None]).t[0])
    for time in sorted({t, _round(t)}) if t <= 1 else ():
        near = distance(a, b.translated(time * course))
        for point in (near.on_a, near.on_b, 0.5 * (near.on_a + near.on_b)):
            for place in (point, np.array([_round(c) for c in point.tolist()])):
                on_a: Vector = rationals(place)
                claim = Meets(time, on_a, along(on_a, -Fraction(time), way))
                with suppress(InvalidCertificate), sides_of(a, b) as sides:
                    meets(claim, sides, way)
                    return (claim,)
    return ()


def _round(number: float) -> float:
    """The nearest multiple of a power of two that is small, but larger than what a graze loses to rounding."""
    return math.ldexp(round(math.ldexp(number, ROUND)), -ROUND)


def _at_start(start: Certificate) -> tuple[Claim, ...]:
    return tuple(claim for claim in start.claims if not isinstance(claim, Separated | Escape | Cover))


def _staying(start: Certificate, way: Vector) -> Clear | None:
    """A plane that keeps the proxies apart at the start, and from which they move away."""
    for claim in start.claims if start.lower > 0 else ():
        if isinstance(claim, Separated) and dot(exact(claim.n), way) >= 0:
            return Clear(claim)
        if isinstance(claim, Cover) and not any(way):
            return Clear(claim.tree, None, claim.places)
    return None


def first_contact(a: Proxy, b: Proxy, way: Vector) -> Contact | Miss:
    """First contact of two convex proxies that are apart at the start, of which `b` moves along `way`.

    Raises
    ------
    Undecided
        Where they come too near to each other to tell.
    """
    if isinstance(b, HalfSpace):
        return mirrored(landing(b, a, opposite(way)))
    if isinstance(a, HalfSpace):
        return landing(a, b, way)
    if isinstance(a, Point) and isinstance(b, Cylinder | Ellipsoid):
        return pointed(a, b, way)
    if isinstance(b, Point) and isinstance(a, Cylinder | Ellipsoid):
        return mirrored(pointed(b, a, opposite(way)))
    bodies = body(a), body(b)
    radius = bodies[0].radius + bodies[1].radius
    if not all(isinstance(side, Corners) for side in bodies):
        return flat(Pairs(a, b, way, True), NARROW)
    pairs = Pairs(a, b, way, False)
    return rounded(pairs, radius) if radius else flat(pairs)


def mirrored(found: Contact | Miss) -> Contact | Miss:
    """The same for the proxies in the other order."""
    if isinstance(found, Miss):
        return Miss(opposite(found.normal))
    return found._replace(normal=opposite(found.normal), ends=found.ends[::-1])


def convex_claims(a: Proxy, b: Proxy, way: Vector, found: Contact | Miss) -> tuple[SweepClaim, ...]:
    """Claims about two convex proxies: in doubles, or in exact numbers where those do not prove as much."""
    ways = dict.fromkeys((plain(found.normal), found.normal)) if any(found.normal) else {}
    never = [Clear(separated(a, b, n)) for n in ways]
    if isinstance(found, Miss):
        return first_proven(a, b, way, never)
    early = round_down(found.low)
    lows = [low for low in (early, math.nextafter(early, 0.0), found.low) if 0 < low <= 1]
    before = [Clear(separated(a, b, n), low) for low in lows for n in ways]
    if found.high > 1:
        return first_proven(a, b, way, [*never, *before])
    on_a, on_b = place_of(a, *found.ends[0]), place_of(b, *found.ends[1])
    return (*first_proven(a, b, way, before), Meets(found.high, on_a, on_b))


def separated(a: Proxy, b: Proxy, n: Vector) -> Separated:
    """Planes across a direction, with what the checker needs to know of polytopes given by planes."""
    faces = [
        () if isinstance(shape, HalfSpace) else numbered(0, body(shape).faces(outwards))
        for shape, outwards in ((a, exact(n)), (b, opposite(exact(n))))
    ]
    return Separated(n, None, (faces[0], faces[1]))


def place_of(shape: Proxy, point: Vector, mix: Mix) -> Place:
    """How a certificate says a point of a proxy, exactly."""
    return exactly(mix) if isinstance(shape, ConvexPolyhedron | ConvexPolygon) and shape.given == "vertices" else point


def first_proven(a: Proxy, b: Proxy, way: Vector, claims: Iterable[Clear]) -> tuple[Clear, ...]:
    """The first of some claims that holds, if any does."""
    with sides_of(a, b) as sides:
        for claim in claims:
            try:
                clear(claim, sides, way, Fraction(0))
            except InvalidCertificate:
                continue
            return (claim,)
    return ()
