"""Certificates for the same proxies in the other order."""

from __future__ import annotations

from refimpl.proof.claims import (
    Certificate,
    Claim,
    Common,
    Core,
    Cover,
    Escape,
    Inscribed,
    Near,
    Part,
    Separated,
    Simple,
    Split,
    Tree,
)
from refimpl.proof.points import Vector, opposite


def mirrored(certificate: Certificate) -> Certificate:
    """Give the certificate for the same proxies in the other order."""
    claims = tuple(_claim(claim) for claim in certificate.claims)
    return Certificate(claims, certificate.lower, certificate.upper)


def _claim(claim: Claim) -> Claim:
    match claim:
        case Cover(tree, shift, places, until):
            return Cover(_tree(tree), _back(shift), places[::-1], until)
        case Part(of_a, of_b, inner):
            return Part(of_b, of_a, _simple(inner))
    return _simple(claim)


def _simple(claim: Simple) -> Simple:
    match claim:
        case Separated(n, until, faces):
            return Separated(opposite(n), until, faces[::-1])
        case Escape(n, faces):
            return Escape(opposite(n), faces[::-1])
        case Near(p, q):
            return Near(q, p)
        case Core(pairs, triangles, directions):
            swapped = tuple((q, p) for p, q in pairs)  # turns the polytope inside out, hence:
            return Core(swapped, tuple((i, k, j) for i, j, k in triangles), directions)
        case Inscribed(p, columns, q, others, radius, shares):
            return Inscribed(q, others, p, columns, radius, (shares[1], shares[0], shares[2]))
        case Common():
            return claim
    raise TypeError(f"not a claim: {claim!r}")


def _tree(tree: Tree) -> Tree:
    if isinstance(tree, Separated):
        return Separated(opposite(tree.n), tree.until, tree.faces[::-1])
    one, other = tree.branches
    return Split(1 - tree.side, tree.first, (_tree(one), _tree(other)))


def _back(shift: Vector) -> Vector:
    """Give −shift, and 0 for 0."""
    return 0 - shift[0], 0 - shift[1], 0 - shift[2]
