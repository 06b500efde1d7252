"""Check what a certificate claims about two proxies, in exact arithmetic.

This file and those it imports, `rational`, `sets`, `reading`, `claims`, `bounds` and `unions`, are all of the project
that has to be believed. They need nothing but the standard library, take every number as the exact rational that it
is, and return only bounds that they have computed themselves.

What a convex proxy is, `sets` and `reading` say: a core, with its support function h(n) and a test for its points,
widened by a ball of radius r. With A ⊖ B = {a − b}, the signed distance σ(A, B) is the distance of 0 from A ⊖ B, or,
when 0 lies inside, minus its distance from the boundary. The support function of A ⊖ B is h_A(n) + h_B(−n), and
widening the cores by balls lowers σ by the sum of the radii: σ(A, B) = σ(core A, core B) − r_A − r_B. For a `Ray` the
bounds are on the time when it first hits, ∞ for a miss; a ray up to time t is a segment. Unions, which are not convex,
are apart when all their parts are; when they overlap, σ is minus the length of the shortest translation of B after
which their interiors are disjoint.
"""

from __future__ import annotations

import math
from typing import Any

from refimpl.proof.bounds import bounds_of
from refimpl.proof.claims import (
    Bound,
    Certificate,
    Claim,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    Near,
    Part,
    Piece,
    Place,
    Separated,
    Split,
    Tree,
    Weights,
)
from refimpl.proof.rational import InvalidCertificate, items
from refimpl.proof.reading import read
from refimpl.proof.unions import UNIONS, union_bounds

__all__ = [
    "Bound",
    "Certificate",
    "Claim",
    "Common",
    "Core",
    "Cover",
    "Escape",
    "Inscribed",
    "InvalidCertificate",
    "Near",
    "Part",
    "Piece",
    "Place",
    "Separated",
    "Split",
    "Tree",
    "Weights",
    "check",
]


def check(certificate: Certificate, a: Any, b: Any) -> tuple[Bound, Bound]:
    """Prove bounds on the signed distance of two single proxies, or on the time when a ray first hits one.

    Returns lower ≤ σ(a, b) ≤ upper [length], ±math.inf where nothing is proven or σ is infinite; for a ray
    lower ≤ t ≤ upper in units of its direction's length, (∞, ∞) when it misses. The certificate's own bounds
    are ignored. Raises `InvalidCertificate` when anything is malformed or false.
    """
    if not isinstance(certificate, Certificate):
        raise InvalidCertificate(f"not a certificate but {type(certificate).__name__}")
    claims = items(certificate.claims, "claims")
    if {type(a).__name__, type(b).__name__} & set(UNIONS):
        proofs = union_bounds(a, b)
        bounds = [(-math.inf, math.inf), *(proofs(claim) for claim in claims)]
    else:
        first, second = read(a), read(b)
        bounds = [(-math.inf, math.inf), *(bounds_of(claim, first, second) for claim in claims)]
    lower, upper = max(low for low, _ in bounds), min(high for _, high in bounds)
    if lower > upper:
        raise InvalidCertificate("the claims contradict each other")
    return lower, upper
