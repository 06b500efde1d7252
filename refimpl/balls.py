"""Lower bounds of depths by balls: two around one point, one within each solid, part by no less than both radii."""

from __future__ import annotations

import numpy as np

from refimpl.algorithms.surfaces import mesh_heights
from refimpl.atoms import leaves, portions
from refimpl.linear import Array, norm
from refimpl.proxy import Proxy
from refimpl.shapes import HalfSpace, Point, Polyhedron


def are_cut(a: Proxy, b: Proxy) -> bool:
    """Whether one of two unions holds a mesh that is no single piece: only then are balls larger than pieces are."""
    return any(isinstance(leaf, Polyhedron) and not leaf.solid.is_convex for leaf in (*portions(a), *portions(b)))


def depth_of_balls(a: Proxy, b: Proxy, middle: Array) -> Array:
    """Lengths below which no translation separates two batches of solids, or numbers that are not positive.

    Parameters
    ----------
    a, b : Proxy with one batch axis
    middle : (n, 3)
        A point of each overlap. Where one of the two is no composite, its reference point is tried as well.
    """
    points = [middle]
    points += [leaves(z)[0].reference_point for z in (a, b) if len(leaves(z)) == 1 and not isinstance(z, HalfSpace)]
    return np.asarray(np.max([-(_height(p, a) + _height(p, b)) for p in points], axis=0))


def _height(p: Array, shape: Proxy) -> Array:
    """Upper bounds of the signed distances of points; exact for all but composites."""
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names unions

    found = []
    for part in leaves(shape):
        if isinstance(part, Polyhedron):
            found.append(mesh_heights(p, part).distance)
        elif isinstance(part, Point):
            found.append(norm(p - part.position))
        else:
            found.append(distance(Point(p), part).distance)
    return np.asarray(np.min(found, axis=0))
