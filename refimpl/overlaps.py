"""Unions against unions: nearest atoms, contacts of overlapping atoms, and ways out.

The signed distance of unions that are apart is the least over all pairs of atoms. Where they overlap it is minus the
length of the shortest translation that separates them, and that is known between two bounds: no pair of atoms comes
apart with less than its own depth, and every translation that is found to leave them disjoint is long enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from refimpl.algorithms.surfaces import point_surface
from refimpl.atoms import Group, candidates, groups, leaves
from refimpl.linear import Array, apply, apply_inverse, dot, norm, rotation_matrix, scale
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.shapes import Composite, HalfSpace, Point, Polyhedron, Sphere
from refimpl.signs import Indices

FIRST = 16  # pairs that are answered first, the most promising ones


@dataclass(frozen=True)
class Contacts:
    """Overlapping pairs of convex atoms of two unions, the deepest first.

    Attributes
    ----------
    part_a, part_b : (k,) int
        Numbers of the atoms: parts of a composite in order, nested ones in their place; each polyhedron counts as
        many as it has pieces.
    separation : Separation with one batch axis
        Each pair as if it were alone: depth (negated), contact points, normal from A to B.
    """

    part_a: Indices
    part_b: Indices
    separation: Separation

    def flipped(self) -> Contacts:
        """Return the same, seen from the other proxy."""
        return Contacts(self.part_b, self.part_a, self.separation.flipped())


class Pairs(NamedTuple):
    """Answers of many pairs of atoms: their numbers, and what `distance` says of them."""

    part_a: Indices
    part_b: Indices
    found: Separation


NONE = Separation(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))


def _distance(x: Proxy, y: Proxy) -> Separation:
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names this module

    return distance(x, y)


def joined(parts: Sequence[Separation]) -> Separation:
    """Several batches as one."""
    if not parts:
        return NONE
    columns = ([getattr(part, name) for part in parts] for name in ("distance", "on_a", "on_b", "normal"))
    return Separation(*(np.concatenate(column) for column in columns))


def nearest(xs: Sequence[Group], ys: Sequence[Group]) -> Separation:
    """Nearest pair of atoms of two unions, or some pair that meets; a single answer."""
    best: Separation | None = None
    for x in xs:
        for y in ys:
            bound = np.inf if best is None else float(best.distance)
            i, j, least = candidates(x, y, bound)
            start, size = 0, FIRST
            while start < len(i) and (best is None or least[start] <= best.distance):
                some = slice(start, start + size)
                found = _distance(x.proxies[i[some]], y.proxies[j[some]])
                row = int(np.argmin(found.distance))
                if best is None or found.distance[row] < best.distance:
                    best = found[row]
                    if best.distance < 0:
                        return best
                start, size = start + size, 2 * size
    assert best is not None
    return best


def meeting(xs: Sequence[Group], ys: Sequence[Group]) -> Pairs:
    """All pairs of atoms whose boxes meet."""
    numbers_a, numbers_b, parts = [], [], []
    for x in xs:
        for y in ys:
            i, j, _ = candidates(x, y, 0.0)
            if len(i):
                parts.append(_distance(x.proxies[i], y.proxies[j]))
                numbers_a.append(x.numbers[i])
                numbers_b.append(y.numbers[j])
    if not parts:
        return Pairs(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), NONE)
    return Pairs(np.concatenate(numbers_a), np.concatenate(numbers_b), joined(parts))


def one_inside(parts_a: Sequence[Proxy], parts_b: Sequence[Proxy]) -> bool:
    """Whether a part of one union has a point within a polyhedron of the other.

    For parts whose surfaces do not meet: then one point of each connected surface tells for all of it.
    """
    for ones, others in ((parts_a, parts_b), (parts_b, parts_a)):
        for mesh in ones:
            if isinstance(mesh, Polyhedron) and any(
                holds(mesh, point) for other in others for point in representatives(other)
            ):
                return True
    return False


def representatives(part: Proxy) -> Array:
    """A point of each connected surface of a part; none of a half-space, which no polyhedron holds."""
    if isinstance(part, HalfSpace):
        return np.zeros((0, 3))
    if isinstance(part, Polyhedron):
        firsts = part.vertices[part.solid.shell_corners]
        return apply(rotation_matrix(part.rotation), firsts) + part.position
    return part.reference_point[None]


def holds(mesh: Polyhedron, point: Array) -> bool:
    """Whether a point is in a polyhedron."""
    return point_surface(mesh.solid, into_frame(mesh, point))[0] <= 0


def into_frame(mesh: Polyhedron, point: Array) -> Array:
    """A point of the world in the frame of a polyhedron's mesh."""
    return apply_inverse(rotation_matrix(mesh.rotation), point - mesh.position)


def point_polyhedron(p: Array, mesh: Polyhedron) -> Separation:
    """Signed distance of a point from a polyhedron, exact on both sides of its surface."""
    gap, foot, outward = point_surface(mesh.solid, into_frame(mesh, p))
    turn = rotation_matrix(mesh.rotation)
    normal = -apply(turn, outward)
    return Separation(np.asarray(gap), p, p + gap * normal, normal) if gap != 0 else Separation(
        np.asarray(gap), p, apply(turn, foot) + mesh.position, normal
    )
