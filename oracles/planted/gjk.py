"""GJK: the nearest points of two convex sets, from their support functions alone."""

from __future__ import annotations

from itertools import combinations

from oracles.planted.shapes import Brick
from oracles.planted.vectors import ZERO, Vec, add, along, cross, dot, length, sub, times

Corner = tuple[Vec, Vec, Vec]
"""A corner b − a of the Minkowski difference, with its a and b."""
Simplex = tuple[list[Corner], list[float]]
"""Up to four corners, with the weights of the point that is nearest to 0."""

MOST_STEPS = 60
FULL = 4
"""A tetrahedron that is the nearest part of itself holds 0 inside."""
CONVERGED = 1e-14
"""Relative to the scene's size: the engine promises 1e-9."""


class Gjk:
    """Gilbert, Johnson and Keerthi's search, with the nearest point of each simplex by trying all of its parts."""

    def gjk(self, a: Brick, b: Brick) -> tuple[Vec, Vec, bool]:
        """Nearest points of two boxes, and whether they are known to be the nearest.

        They are not where the boxes overlap, nor over faces that are nearly parallel: there the steps become so small
        that rounding swallows them, and the search stops before its end.
        """
        size = max(a.size, b.size)
        simplex: Simplex = ([self.corner(a, b, sub(b.center, a.center))], [1.0])
        nearest, settled = simplex[0][0][0], False
        for _ in range(self.most_steps()):
            new = self.corner(a, b, nearest)
            settled = self.has_converged(nearest, new[0], size)
            if settled:
                break
            simplex = self.nearest_part([*simplex[0], new])
            before, nearest = nearest, _weighted(simplex, 0)
            if len(simplex[0]) == FULL or not length(nearest) < length(before):
                break
        return _weighted(simplex, 1), _weighted(simplex, 2), settled

    def most_steps(self) -> int:
        """Bound on the number of steps."""
        return MOST_STEPS

    def has_converged(self, nearest: Vec, new: Vec, size: float) -> bool:
        """Whether the new corner is hardly nearer to 0 than the plane through the nearest point."""
        return dot(nearest, sub(nearest, new)) <= CONVERGED * size * length(nearest)

    def corner(self, a: Brick, b: Brick, direction: Vec) -> Corner:
        """The corner of B − A that is farthest against a direction."""
        x, y = a.support(direction), b.support(times(-1.0, direction))
        return sub(y, x), x, y

    def nearest_part(self, corners: list[Corner]) -> Simplex:
        """The corners that carry the point of a simplex that is nearest to 0, and their weights."""
        points = [corner[0] for corner in corners]
        best: Simplex = ([corners[-1]], [1.0])
        least = length(points[-1])
        for count in range(1, len(corners) + 1):
            for part in combinations(range(len(corners)), count):
                weights = self.weights([points[i] for i in part])
                if weights is not None:
                    found = ([corners[i] for i in part], weights)
                    away = length(_weighted(found, 0))
                    if away < least:
                        best, least = found, away
        return best

    def weights(self, points: list[Vec]) -> list[float] | None:
        """Weights, all positive, of the point of a simplex' inside that is nearest to 0; None where there is none."""
        if len(points) == 1:
            return [1.0]
        raw = {2: _of_segment, 3: _of_triangle, 4: _of_tetrahedron}[len(points)](points)
        total = sum(raw)
        if not total > 0 or min(raw) <= 0:
            return None
        return [weight / total for weight in raw]


def _of_segment(points: list[Vec]) -> list[float]:
    p, q = points
    way = sub(q, p)
    return [dot(q, way), -dot(p, way)]


def _of_triangle(points: list[Vec]) -> list[float]:
    """Areas of the parts into which the foot of 0 divides the triangle."""
    p, q, r = points
    normal = cross(sub(q, p), sub(r, p))
    return [dot(normal, cross(q, r)), dot(normal, cross(r, p)), dot(normal, cross(p, q))]


def _of_tetrahedron(points: list[Vec]) -> list[float]:
    """Volumes of the parts into which 0 divides the tetrahedron, with the sign that makes the whole positive."""
    p, q, r, s = points
    sign = 1.0 if dot(sub(q, p), cross(sub(r, p), sub(s, p))) >= 0 else -1.0
    return [
        sign * dot(q, cross(r, s)),
        -sign * dot(p, cross(r, s)),
        sign * dot(p, cross(q, s)),
        -sign * dot(p, cross(q, r)),
    ]


def _weighted(simplex: Simplex, which: int) -> Vec:
    corners, weights = simplex
    found = ZERO
    for corner, weight in zip(corners, weights, strict=True):
        found = along(found, weight, corner[which])
    return add(found, ZERO)
