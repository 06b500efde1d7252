"""Contacts of overlapping unions, pair by pair of convex atoms, and the bounds of their depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array
from refimpl.overlaps import resolve
from refimpl.proxy import Proxy, ShapeError
from refimpl.queries import distance
from refimpl.results import Separation
from refimpl.scenes import Contact, Scenes
from refimpl.shapes import Point, Polyhedron
from refimpl.signs import Indices


@dataclass(frozen=True)
class Contacts:
    """How two proxies overlap.

    Attributes
    ----------
    separation : Separation
        What `distance` answers.
    depth_interval : (2,)
        The shortest translation of B that separates has a length between these: at least that of the deepest pair of
        atoms, at most that of a translation that was found to separate. Both are that length where branch and bound
        found it, as for most polytopes; (0, 0) where the proxies are apart, and inf at the end where none was found.
    part_a, part_b : (k,) int
        For each overlapping pair of convex atoms, the deepest first, their numbers: the parts of a composite in
        order, nested ones in their place; each polyhedron counts as many as it has pieces.
    pairs : Separation with one batch axis
        Each pair as if it were alone: minus its depth, contact points, normal from A to B.
    """

    separation: Separation
    depth_interval: Array
    part_a: Indices
    part_b: Indices
    pairs: Separation

    def __len__(self) -> int:
        return len(self.part_a)


def _of_flat(a: Proxy, b: Proxy) -> Contacts:
    """Contacts of two flat proxies, which are convex: one, or none."""
    found = distance(a, b)
    pairs = Separation(*(column[None][: int(found.distance <= 0)] for column in map(np.asarray, vars(found).values())))
    number = np.zeros(len(pairs.distance), dtype=np.int64)
    return Contacts(found, np.full(2, max(0.0, -float(found.distance))), number, number, pairs)


def contacts(a: Proxy, b: Proxy) -> Contacts:
    """Contacts of two single solids, or of a point and a solid.

    Parameters
    ----------
    a, b : proxies without batch axes
        Convex ones have one contact at most. A point in a polyhedron has none: its depth is that of the surface.

    Returns
    -------
    Contacts
    """
    for shape in (a, b):
        if shape.batch_shape:
            raise ShapeError(
                f"contacts are of single proxies, got a batch of shape {shape.batch_shape}: take them by index"
            )
    if a.dimension == 2:
        return _of_flat(a, b)
    x, y = a.broadcast_to((1,)), b.broadcast_to((1,))
    found = resolve(x, y)
    upper = max(0.0, -float(found.separation.distance[0]))
    interval = np.array([min(float(found.lower[0]), upper), upper])
    nothing = upper == 0.0 or {type(a), type(b)} == {Point, Polyhedron}
    pairs = Contact.none() if nothing else Scenes(x, y).contacts()
    return Contacts(found.separation[0], interval, pairs.part_a, pairs.part_b, pairs.found)
