"""Check when two moving proxies first meet, in exact arithmetic: part of what has to be believed.

Only the relative translation matters: A rests, B moves by v = v_B − v_A, a difference of exact numbers. Across a
direction n the room between a part of A and a part of B is a linear function of the time. Where it is positive at one
time and not negative at another, it is positive between them. So two planes' worth of arithmetic keeps two convex parts
apart over a span of time, and a list of spans may take another direction for each. Solid meshes take part by their
surfaces: as long as those do not meet anything, what is outside stays outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from refimpl.proof.bounds import bounds_of, part_of
from refimpl.proof.checker import sides_of
from refimpl.proof.claims import Bound, Claim, Piece, Place, Tree
from refimpl.proof.gaps import Sides, gaps, require_outside
from refimpl.proof.plane import flat
from refimpl.proof.rational import InvalidCertificate, items, rational, require, spend
from refimpl.proof.reading import Fields
from refimpl.proof.sets import Line
from refimpl.proof.vectors import NONE, Exact, Number, dot, minus, times


@dataclass(frozen=True)
class Clear:
    """No contact from the time up to which the claims before show it, until a time; with None, until 1 and then.

    `tree` are planes between all atoms of A and B, as in a `Cover`; so are `places`, which only the first span needs.
    """

    tree: Tree
    until: Number | None = None
    places: tuple[tuple[Place, ...], tuple[Place, ...]] = ((), ())


@dataclass(frozen=True)
class Meets:
    """Contact at a time: the point `a` of A and `b` of B, each where it is at the start, are then in one place.

    `of_a` and `of_b` choose convex parts, as in a `Part`.
    """

    time: Number
    a: Place
    b: Place
    of_a: int | tuple[int, Piece] | None = None
    of_b: int | tuple[int, Piece] | None = None


SweepClaim: TypeAlias = Clear | Meets | Claim
"""A claim about the signed distance at the start may show that the proxies meet there."""


@dataclass(frozen=True)
class SweepCertificate:
    """Claims about the first contact of a moving pair, and the bounds that whoever made it believes them to prove.

    The claims about rigid motions are those of `refimpl.proof.rigid`.
    """

    claims: tuple[Any, ...]
    lower: Bound = NONE
    upper: Bound = math.inf


def check_sweep(
    certificate: SweepCertificate, a: Any, b: Any, motion_a: Any = None, motion_b: Any = None
) -> tuple[Bound, Bound]:
    """Prove bounds on the time from 0 to 1 when two single proxies in motion first meet.

    Returns lower ≤ t ≤ upper; the upper is ∞ where no contact is proven, and both are when it is proven that there is
    none. The certificate's own bounds are ignored. Raises `InvalidCertificate` when anything is malformed or false.
    """
    require(isinstance(certificate, SweepCertificate), f"not a certificate but {type(certificate).__name__}")
    if "RigidMotion" in {type(motion_a).__name__, type(motion_b).__name__}:
        from refimpl.proof.rigid import check_rigid  # noqa: PLC0415  it needs what is here

        return check_rigid(certificate, a, b, motion_a, motion_b)
    with sides_of(a, b) as sides:
        rays = any(isinstance(side.convex.get(0), Line) for side in sides)
        require(not rays, "a ray does not move")
        way = minus(translation(motion_b), translation(motion_a))
        lower: Bound = NONE
        upper: Bound = math.inf
        for claim in items(certificate.claims, "claims"):
            spend(128)
            if isinstance(claim, Clear):
                lower = clear(claim, sides, way, lower)
            else:
                upper = min(upper, meets(claim, sides, way))
    require(lower <= upper, "the claims contradict each other")
    return lower, upper


def translation(motion: Any) -> Exact:
    """Read the vector of a translation; None is rest."""
    if motion is None:
        return [NONE] * 3
    if type(motion).__name__ == "FlatTranslation":
        return flat(Fields(motion), "vector")
    require(type(motion).__name__ == "Translation", f"not a translation but {type(motion).__name__}")
    return Fields(motion)("vector")


def clear(claim: Clear, sides: Sides, way: Exact, start: Bound) -> Bound:
    """End of a span in which nothing meets, which begins at `start`; ∞ where it leaves no time to meet."""
    end = Fraction(1) if claim.until is None else rational(claim.until, "until")
    require(start < end <= 1, "until: before the start, or after the end")
    for gap in gaps(claim.tree, sides, times(start, way)):
        require(gap.compared() > 0, "n: the supporting planes do not leave a gap at the start")
        gap.room += (end - start) * dot(gap.n, way)
        require(gap.compared() >= (claim.until is None), "n: the supporting planes do not leave a gap until the end")
    if start == 0:
        require_outside(sides, claim.places)
    return math.inf if claim.until is None else end


def meets(claim: Any, sides: Sides, way: Exact) -> Bound:
    """Time of a contact."""
    if not isinstance(claim, Meets):
        require(bounds_of(claim, sides)[1] <= 0, "not a contact at the start")
        return NONE
    time, found = rational(claim.time, "time"), []
    require(0 <= time <= 1, "time: not from 0 to 1")
    for side, choice, place in ((sides[0], claim.of_a, claim.a), (sides[1], claim.of_b, claim.b)):
        solid = part_of(side, choice)
        if isinstance(solid, Line):
            raise InvalidCertificate("a ray does not move")
        point, outside = solid.member(place, True)
        require(outside == 0, "a, b: a point outside its proxy")
        found.append(point)
    require(not any(minus(minus(*found), times(time, way))), "time: the points are not in one place")
    return time
