"""Unions against unions: nearest atoms, contacts of overlapping atoms, and the bounds of the depth.

The signed distance of unions that are apart is the least over all pairs of atoms. Where they overlap it is minus the
length of the shortest translation that separates them. Branch and bound finds it for polytopes; of round atoms it is
known between two bounds: no pair comes apart with less than its own depth, and every translation that is found to leave
all disjoint is long enough.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from refimpl.algorithms.surfaces import balls_mesh, mesh_heights, points_faces, points_mesh
from refimpl.balls import are_cut, depth_of_balls
from refimpl.large_meshes import has_large_mesh, surfaces_apart
from refimpl.linear import Array, Bools
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.scenes import ROUNDING, scenes
from refimpl.shapes import Composite, Point, Polyhedron, Sphere


@dataclass(frozen=True)
class Overlaps:
    """What is known of a batch of pairs of unions, apart or overlapping.

    Attributes
    ----------
    separation : Separation with one batch axis
        Where they overlap, the distance is minus the length of a translation along the normal that was found to
        separate them, or −inf where none was.
    lower : (n,)
        No shorter translation separates; 0 where they do not overlap.
    deepest : (n,)
        Depth of the deepest pair of atoms, which `lower` may exceed; that itself, where no atoms were asked.
    """

    separation: Separation
    lower: Array
    deepest: Array


def resolve(a: Proxy, b: Proxy) -> Overlaps:
    """Answer for two batches of proxies with one axis, of which one at least holds unions."""
    known = _by_surface(a, b)
    return _by_atoms(a, b, _by_pieces_and_balls) if known is None else _of_surface(*known)


def separate(a: Proxy, b: Proxy) -> Separation:
    """Give the same without looking for greater lower bounds."""
    known = _by_surface(a, b)
    return known[0] if known else _by_atoms(a, b, _by_pieces).separation


def nearest(a: Proxy, b: Proxy) -> Array:
    """Signed distances from above: of unions that overlap minus the depth of their deepest pair of atoms."""
    known = _by_surface(a, b)
    found = _of_surface(*known) if known else _by_atoms(a, b, _by_deepest_pair)
    sigma = found.separation.distance
    return np.where(sigma < 0, -found.deepest, sigma)


def _completed(
    known: Separation, decided: Bools, a: Proxy, b: Proxy, others: Callable[[Proxy, Proxy], Overlaps]
) -> Overlaps:
    """Answers of which some rows are decided, and those of a second way for all others."""
    rest = np.flatnonzero(~decided)
    lower = np.maximum(0.0, -known.distance)
    if not len(rest):
        return _of_surface(known, lower)
    if len(rest) == len(a):
        return others(a, b)
    found = others(a[rest], b[rest])
    columns = []
    for name in ("distance", "on_a", "on_b", "normal"):
        column = getattr(known, name).copy()
        column[rest] = getattr(found.separation, name)
        columns.append(column)
    deepest = lower.copy()
    lower[rest], deepest[rest] = found.lower, found.deepest
    return Overlaps(Separation(*columns), lower, deepest)


def _of_surface(known: Separation, lower: Array) -> Overlaps:
    return Overlaps(known, lower, lower)


def _by_surface(a: Proxy, b: Proxy) -> tuple[Separation, Array] | None:
    """Points and balls against polyhedra, and points against their faces: answers, and lower bounds of depths."""
    if isinstance(a, Polyhedron) and isinstance(b, Point | Sphere):
        found, lower = balls_mesh(b, a) if isinstance(b, Sphere) else points_mesh(b, a)
        return found.flipped(), lower
    if isinstance(b, Polyhedron) and isinstance(a, Sphere):
        return balls_mesh(a, b)
    if isinstance(b, Polyhedron) and isinstance(a, Point):
        return points_mesh(a, b)
    if isinstance(a, Point) and isinstance(b, Composite) and b.mesh is not None:
        return points_faces(a, b.mesh)
    if isinstance(b, Point) and isinstance(a, Composite) and a.mesh is not None:
        found, lower = points_faces(b, a.mesh)
        return found.flipped(), lower
    return None


def _by_atoms(a: Proxy, b: Proxy, by_pieces: Callable[[Proxy, Proxy], Overlaps]) -> Overlaps:
    """Nearest atoms; where some overlap, a way out."""
    if not len(a) or not has_large_mesh(a, b):
        return by_pieces(a, b)
    known, apart = surfaces_apart(a, b)
    return _completed(known, apart, a, b, by_pieces)


def _by_pieces(a: Proxy, b: Proxy) -> Overlaps:
    return _searched(a, b)[0]


def _by_deepest_pair(a: Proxy, b: Proxy) -> Overlaps:
    return _searched(a, b, ways=False)[0]


def _searched(a: Proxy, b: Proxy, ways: bool = True) -> tuple[Overlaps, Array]:
    """What pairs of atoms tell, and a point of each deepest overlap."""
    found = [there.separations(ways) for there in scenes(a, b)]
    columns = [[getattr(part, name) for part, *_ in found] for name in ("distance", "on_a", "on_b", "normal")]
    lower, middle, deepest = (np.concatenate([part[i] for part in found]) for i in (1, 2, 3))
    return Overlaps(Separation(*map(np.concatenate, columns)), lower, deepest), middle


def _by_pieces_and_balls(a: Proxy, b: Proxy) -> Overlaps:
    """The same, with lower bounds by balls where these are greater."""
    found, middle = _searched(a, b)
    if are_cut(a, b):
        lower, depth = found.lower, np.maximum(0.0, -found.separation.distance)
        rows = np.flatnonzero(depth > lower)
        x, y = a[rows], b[rows]
        some = depth[rows] > lower[rows] + 2.0 * ROUNDING * np.maximum(x.magnitude, y.magnitude)
        rows, x, y = rows[some], x[some], y[some]
        if len(rows):
            balls = depth_of_balls(x, y, middle[rows])
            lower[rows] = np.minimum(depth[rows], np.maximum(lower[rows], balls))
    return found


def meet(a: Proxy, b: Proxy) -> Bools:
    """Whether two batches have points in common, row by row."""
    for x, y in ((a, b), (b, a)):
        if isinstance(x, Point) and isinstance(y, Polyhedron):
            return np.asarray(mesh_heights(x.position, y).distance <= 0)
        if isinstance(x, Sphere) and isinstance(y, Polyhedron):
            return np.asarray(mesh_heights(x.center, y).distance <= x.radius)
    return meet_atoms(a, b)


def meet_atoms(a: Proxy, b: Proxy) -> Bools:
    """The same, by pairs of atoms."""
    if len(a) and has_large_mesh(a, b):
        known, apart = surfaces_apart(a, b)
        return ~apart | (known.distance <= 0)
    return np.concatenate([there.meetings() for there in scenes(a, b)])
