"""Make certificates: the door to all searches."""

from __future__ import annotations

from refimpl.flat.base import Flat
from refimpl.proof.checker import check
from refimpl.proof.claims import Certificate, Claim
from refimpl.proof.convex import convex_claims
from refimpl.proof.flat import flat_claims
from refimpl.proof.mirror import mirrored
from refimpl.proof.points import round_down, round_up
from refimpl.proof.simple import simple_claims
from refimpl.proof.times import SIMPLE, time_claims
from refimpl.proof.union_cast import union_times
from refimpl.proof.union_search import union_claims
from refimpl.shapes import Composite, HalfSpace, Polyhedron, Proxy, Ray, UnsupportedOperation

__all__ = ["certify", "mirrored", "round_down", "round_up"]

UNION = Composite | Polyhedron


def certify(a: Proxy, b: Proxy) -> Certificate:
    """Prove the signed distance of two proxies, or the time when a ray first hits one, from both sides.

    Parameters
    ----------
    a, b : Proxy
        Single ones (batch shape ``()``); at most one is a `Ray`.

    Returns
    -------
    Certificate
        Its `lower` and `upper` are what `check` proves from it, rounded outwards to doubles. With s, the scene's
        largest coordinate, extent or distance, they are less than 1e-12·s apart for convex proxies with flat faces
        (1e-14·s and both 0 at touching, for spheres, capsules, boxes and half-spaces), and 1e-10·s for ellipsoids
        and cylinders; −∞ for half-spaces that are not opposite. Unions are as narrow when they are apart; of
        overlapping ones the lower is a translation that separates, the upper the deepest pair of convex parts. For
        a ray they enclose the time of the first hit, in units of the direction's length, to the last bits; both
        are 0 when it starts inside, and ∞ when it misses.

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
    if a.dimension != b.dimension:
        raise UnsupportedOperation(f"a {type(a).__name__} and a {type(b).__name__}: one is of the plane, one of space")
    if isinstance(a, Ray) and isinstance(b, Ray):
        raise UnsupportedOperation("two rays have no signed distance: one of the proxies must not be a Ray")
    if isinstance(b, Ray) or (isinstance(b, HalfSpace) and not isinstance(a, Ray | HalfSpace)):
        return mirrored(certify(b, a))
    claims = _claims(a, b)
    lower, upper = check(Certificate(claims), a, b)
    return Certificate(claims, round_down(lower), round_up(upper))


def _claims(a: Proxy, b: Proxy) -> tuple[Claim, ...]:
    if isinstance(a, UNION) or isinstance(b, UNION):
        return union_times(a, b) if isinstance(a, Ray) else union_claims(a, b)
    if isinstance(a, Ray):
        return time_claims(a, b)
    if isinstance(a, Flat):
        return flat_claims(a, b)
    if isinstance(a, SIMPLE) and isinstance(b, SIMPLE):
        return simple_claims(a, b)
    return convex_claims(a, b)
