"""Meshes of many faces against other unions: their faces, which need no splitting, tell whether they are apart.

The nearest atoms of two unions that are apart lie on their surfaces. So faces stand for the pieces of large meshes as
long as no two of them meet, and no surface lies within a solid; only where they overlap, pieces are asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from refimpl.algorithms.surfaces import points_surface
from refimpl.atoms import Group, candidates, groups, leaves, portions
from refimpl.linear import Array, Bools, apply, apply_inverse, rotation_matrix
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.shapes import HalfSpace, Polyhedron

FEW_FACES = 256  # meshes of so many faces, or convex ones, are cut into pieces without asking what they meet
FIRST = 16  # pairs that are answered first, the most promising ones


def has_large_mesh(*unions: Proxy) -> bool:
    """Whether a part of some unions is a mesh that is better not split without need."""
    meshes = [leaf for x in unions for leaf in portions(x) if isinstance(leaf, Polyhedron)]
    return any(len(mesh.triangles) > FEW_FACES and not mesh.solid.is_convex for mesh in meshes)


def surfaces_apart(a: Proxy, b: Proxy) -> tuple[Separation, Bools]:
    """Nearest pair of atoms of each row, faces for meshes; and the rows where the unions are apart.

    What is answered for the others, where faces meet or one union holds a part of the other, is of no use.
    """
    found = [_nearest(groups(leaves(a[row]), True), groups(leaves(b[row]), True)) for row in range(len(a))]
    answer = Separation(*(np.concatenate([getattr(f, name) for f in found]) for name in NAMES))
    apart = answer.distance >= 0
    for row in np.flatnonzero(answer.distance > 0).tolist():
        apart[row] = not _swallowed(leaves(a[row]), leaves(b[row]))
    return answer, apart


NAMES = ("distance", "on_a", "on_b", "normal")


def _nearest(xs: Sequence[Group], ys: Sequence[Group]) -> Separation:
    """Nearest pair of atoms of two unions, or some pair that overlaps."""
    best, within = None, np.inf
    for x in xs:
        for y in ys:
            i, j, least = candidates(x, y, within)
            start, size = 0, FIRST
            while start < len(i) and least[start] <= within:
                some = slice(start, start + size)
                answer = ask(x.proxies[i[some]], y.proxies[j[some]])
                row = np.array([np.argmin(answer.distance)])
                if best is None or answer.distance[row] < best.distance:
                    best = answer[row]
                    within = min(within, float(best.distance[0]))
                    if within < 0:
                        return best
                start, size = start + size, 2 * size
    assert best is not None  # no bound keeps the first pair out
    return best


def ask(x: Proxy, y: Proxy) -> Separation:
    """Signed distance of two batches, by the door."""
    from refimpl.queries import distance  # noqa: PLC0415  the door needs the pair table, which names unions

    return distance(x, y)


def _swallowed(parts_a: Sequence[Proxy], parts_b: Sequence[Proxy]) -> bool:
    """Whether a part of one union has a point within a polyhedron of the other, where no surfaces meet.

    One point of each connected surface tells for all of it.
    """
    return any(
        _holds(mesh, point)
        for ones, others in ((parts_a, parts_b), (parts_b, parts_a))
        for mesh in ones
        if isinstance(mesh, Polyhedron)
        for other in others
        for point in _representatives(other)
    )


def _representatives(part: Proxy) -> Array:
    """A point of each connected surface of a part; none of a half-space, which no polyhedron holds."""
    if isinstance(part, HalfSpace):
        return np.zeros((0, 3))
    if isinstance(part, Polyhedron):
        return apply(rotation_matrix(part.rotation), part.vertices[part.solid.shell_corners]) + part.position
    return part.reference_point[None]


def _holds(mesh: Polyhedron, point: Array) -> bool:
    local = apply_inverse(rotation_matrix(mesh.rotation), point - mesh.position)
    low, high = mesh.solid.bounds
    return bool(np.all((low <= local) & (local <= high))) and points_surface(mesh.solid, local[None])[0][0] <= 0
