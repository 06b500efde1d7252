"""Pairs of which one at least is a union: a polyhedron or a composite.

One function serves them all, for a union is its convex atoms, whatever they are; see `refimpl.overlaps`.
"""

from __future__ import annotations

import numpy as np

from refimpl.linear import Bools
from refimpl.overlaps import Overlap, apart_or_overlapping, joined, meet
from refimpl.proxy import Proxy
from refimpl.results import Separation


def overlaps(a: Proxy, b: Proxy) -> list[Overlap]:
    """Everything that is known of each pair of a batch: bounds of the depth and contacts too.

    Parameters
    ----------
    a, b : Proxy with one batch axis, of the same length
        Solids or points, of which one at least is a `Polyhedron` or a `Composite`. In their own units: what is kept
        of a mesh belongs to its numbers.
    """
    return [apart_or_overlapping(a[i], b[i]) for i in range(len(a))]


def union_pair(a: Proxy, b: Proxy) -> Separation:
    """Signed distance of unions: the least over pairs of atoms; overlapping, by a translation that separates.

    Apart, it is as exact as the pairs of atoms are; so is the depth of a point in a polyhedron, and that of two
    unions where one pair of atoms decides. Otherwise the shortest separating translation lies between the
    deepest pair of atoms and what is answered.
    """
    found = [overlap.separation for overlap in overlaps(a, b)]
    return joined([Separation(*(np.asarray(getattr(s, n))[None] for n in NAMES)) for s in found])


def unions_meet(a: Proxy, b: Proxy) -> Bools:
    """Whether unions have a point in common."""
    return np.array([meet(a[i], b[i]) for i in range(len(a))], dtype=bool)


NAMES = ("distance", "on_a", "on_b", "normal")
