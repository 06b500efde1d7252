"""Pairs of which one at least is a union: a polyhedron or a composite.

One function serves them all, for a union is its convex atoms, whatever they are; see `refimpl.overlaps`.
"""

from __future__ import annotations

from refimpl.linear import Array, Bools
from refimpl.overlaps import meet, resolve, separate
from refimpl.proxy import Proxy
from refimpl.results import Separation


def union_pair(a: Proxy, b: Proxy) -> Separation:
    """Signed distance of unions: the least over pairs of atoms; overlapping, by a translation that separates.

    Apart, it is as exact as the pairs of atoms are; so is the depth of unions of polytopes of moderate size, and where
    one pair of atoms decides. Otherwise the shortest separating translation lies between the deepest pair of atoms and
    what is answered; `refimpl.contacts.contacts` tells both ends.

    Parameters
    ----------
    a, b : Proxy with one batch axis, of the same length
        Solids or points, of which one at least is a `Polyhedron` or a `Composite`. In their own units: what is kept
        of a mesh belongs to its numbers.
    """
    return separate(a, b)


def unions_meet(a: Proxy, b: Proxy) -> Bools:
    """Whether unions have a point in common; as soon as two atoms do."""
    return meet(a, b)


def overlap_bounds(a: Proxy, b: Proxy) -> tuple[Separation, Array]:
    """Signed distance of unions, and a length below which no translation separates them; 0 where they are apart."""
    found = resolve(a, b)
    return found.separation, found.lower
