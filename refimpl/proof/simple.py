"""Claims about hulls of a few points and half-spaces: exact from beginning to end, then in doubles where these do."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from refimpl.proof.claims import Bound, Claim, Common, Core, Escape, Near, Separated
from refimpl.proof.exact import Features, features
from refimpl.proof.points import Vector, along, dot, minus, root
from refimpl.proof.times import TIGHT, direction_of, proven
from refimpl.shapes import Capsule, Proxy, Sphere


def _plain(claim: Claim) -> Claim:
    """Give a claim about a distance in doubles; as it is where it exceeds them."""
    try:
        match claim:
            case Separated(n) | Escape(n):
                return type(claim)(direction_of(n))
            case Near(p, q):
                return Near(_coordinates(p), _coordinates(q))
            case Common(p) if p is not None:
                return Common(_coordinates(p))
            case Core(pairs, triangles):
                return Core(tuple((_coordinates(p), _coordinates(q)) for p, q in pairs), triangles)
    except OverflowError:
        pass
    return claim


def _coordinates(place: Any) -> Vector:
    x, y, z = place
    return float(x), float(y), float(z)


def simple_claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    """Make one claim for each side: in doubles, unless exact numbers narrow the interval considerably."""
    found = features(a, b)
    if found.directions:
        return (_core(found),)
    exactly, touching = _exact_claims(found, _radius(a), _radius(b))
    plain = _plain(exactly[0]), _plain(exactly[1])
    lower, upper = proven(plain[0], a, b)[0], proven(plain[1], a, b)[1]
    sizes = [Fraction(a.magnitude.tolist()), Fraction(b.magnitude.tolist())]
    distance = min((abs(bound) for bound in (lower, upper) if isinstance(bound, Fraction)), default=0)
    slack = Fraction(0) if touching else TIGHT * max(*sizes, distance)
    if not _apart(lower, upper, slack):
        return plain
    low, high = proven(exactly[0], a, b)[0], proven(exactly[1], a, b)[1]
    return (
        exactly[0] if _apart(lower, low, slack / 2) else plain[0],
        exactly[1] if _apart(high, upper, slack / 2) else plain[1],
    )


def _apart(low: Bound, high: Bound, slack: Fraction) -> bool:
    finite = isinstance(low, Fraction) and isinstance(high, Fraction)
    return high - low > slack if finite else low < high


def _radius(shape: Proxy) -> Fraction:
    return Fraction(shape.radius.tolist()) if isinstance(shape, Sphere | Capsule) else Fraction(0)


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
