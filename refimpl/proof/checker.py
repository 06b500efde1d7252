"""Check what a certificate claims about two proxies, in exact arithmetic.

This file and those it imports, `claims`, `bounds`, `gaps`, `unions`, `reading`, `plane`, `sets`, `rational` and
`vectors`, are all of the project that has to be believed. They need nothing but the standard library, take every number
as the exact rational that it is, and return only bounds that they have computed themselves.

What a convex proxy is, `sets`, `reading` and `plane` say: a core, with its support function h(n) and a test for points,
widened by a ball of radius r. With A ⊖ B = {a − b}, the signed distance σ(A, B) is that of 0 from A ⊖ B, or, inside,
minus that from the boundary. A ⊖ B has the support function h_A(n) + h_B(−n), and widening the cores lowers σ: σ(A, B)
= σ(core A, core B) − r_A − r_B. For a `Ray` the bounds are on the time of its first hit, ∞ for none. Unions are apart
when all parts are; else σ is minus the length of the shortest translation of B that parts the interiors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

from refimpl.proof.bounds import bounds_of
from refimpl.proof.claims import Bound, Certificate, Cover, Part
from refimpl.proof.gaps import Sides
from refimpl.proof.plane import is_of_plane
from refimpl.proof.rational import effort, items, require, spend
from refimpl.proof.sets import Line
from refimpl.proof.unions import Union, parts_of

UNIONS = {"Composite", "Polyhedron"}
EFFORT, EFFORT_PER_ITEM = 1 << 21, 64
"""How much a certificate may ask for, about a second of work; and more for every number or row of large shapes."""


@contextmanager
def sides_of(a: Any, b: Any) -> Iterator[Sides]:
    """Read two proxies of one world, and let no more be spent inside than is due to claims about them."""
    require(is_of_plane(a) == is_of_plane(b), "a proxy of the plane and one of space")
    with effort(1 << 62) as spent:
        sides = Union(parts_of(a)), Union(parts_of(b))
        size = spent()
    with effort(EFFORT + EFFORT_PER_ITEM * size):
        yield sides


def check(certificate: Certificate, a: Any, b: Any) -> tuple[Bound, Bound]:
    """Prove bounds on the signed distance of two single proxies, or on the time when a ray first hits one.

    Returns lower ≤ σ(a, b) ≤ upper [length], ±math.inf where nothing is proven or σ is infinite; for a ray
    lower ≤ t ≤ upper in units of its direction's length, (∞, ∞) when it misses. The certificate's own bounds
    are ignored. Raises `InvalidCertificate` when anything is malformed or false, or would take too long to check.
    """
    require(isinstance(certificate, Certificate), f"not a certificate but {type(certificate).__name__}")
    with sides_of(a, b) as sides:
        rays = sum(isinstance(side.convex.get(0), Line) for side in sides)
        require(rays < 2, "two rays have no signed distance")
        bounds: list[tuple[Bound, Bound]] = [(Fraction(0) if rays else -math.inf, math.inf)]
        for claim in items(certificate.claims, "claims"):
            spend(128)
            of_union = not isinstance(claim, Cover | Part) or {type(a).__name__, type(b).__name__} & UNIONS
            require(of_union, f"{type(claim).__name__}: a claim about unions")
            bounds.append(bounds_of(claim, sides))
    lower, upper = max(low for low, _ in bounds), min(high for _, high in bounds)
    require(lower <= upper, "the claims contradict each other")
    return lower, upper
