"""The binary space partition of a solid: which side of the planes of its faces something is on, exactly.

The tree is the one that `Polyhedron.pieces` come from. What is on a plane is in both of its halves: a point is inside
where all that it may belong to is solid, outside where nothing is, else on the surface (Thibault & Naylor 1987). A ray
is cut by every plane that it comes to, the nearer part is looked at first, and the first part in a solid cell is where
it enters. All in rational numbers; doubles only spare them where they decide without doubt.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.bsp import EMPTY, SOLID, Piece, solid_tree
from refimpl.linear import Array, apply_inverse, as_floats, largest, rotation_matrix
from refimpl.proxy import ShapeError
from refimpl.shapes import Polyhedron, Ray
from refimpl.signs import Indices

DOUBT = 2.0**-46
"""More than heights above planes err by, in units of the largest coordinate and of the plane's largest coefficient."""

Vector = tuple[Fraction, Fraction, Fraction]
IN, ON, OUT = 1, 0, -1


class SolidTree:
    """The tree of one polyhedron, placed where it is.

    Parameters
    ----------
    mesh : Polyhedron
        A single one, no batch.

    Attributes
    ----------
    cuts : list of bsp.Cut
        The nodes, in the mesh's own frame and unit.
    """

    def __init__(self, mesh: Polyhedron) -> None:
        if mesh.batch_shape:
            raise ShapeError(f"SolidTree: expected a single Polyhedron, got a batch of shape {mesh.batch_shape}")
        self.mesh = mesh
        self.cuts = solid_tree(mesh.vertices, mesh.triangles)
        self._children = np.array([cut.children for cut in self.cuts])
        self._sizes = [max(map(abs, cut.plane[:3])) for cut in self.cuts]
        self._axes = _columns(mesh.rotation)

    @property
    def pieces(self) -> list[Piece]:
        """Convex pieces with disjoint interiors that together are the solid, in its own frame."""
        return self.mesh.pieces

    # -- points ------------------------------------------------------------------------------------------------

    def locate(self, points: ArrayLike) -> NDArray[np.int8]:
        """Where points are: 1 inside, 0 on the surface, −1 outside; exact for the numbers as they are stored.

        Parameters
        ----------
        points : (..., 3), finite
        """
        where = as_floats(points)
        if where.shape[-1:] != (3,) or not np.all(np.isfinite(where)):
            raise ShapeError(f"points: expected finite numbers of shape (..., 3), got shape {where.shape}")
        flat = where.reshape(-1, 3)
        near, slopes = self._in_doubles(flat)
        exact: dict[int, Vector] = {}
        seen = np.zeros((len(flat), 2), dtype=bool)  # empty and solid cells
        point, node = np.arange(len(flat)), np.zeros(len(flat), dtype=np.int64)
        while len(point):
            side = self._sides(flat, near, slopes, exact, point, node)
            below, above = np.flatnonzero(side <= 0), np.flatnonzero(side >= 0)
            child = np.concatenate([self._children[node[below], 0], self._children[node[above], 1]])
            point = np.concatenate([point[below], point[above]])
            for place, kind in enumerate((EMPTY, SOLID)):
                seen[point[child == kind], place] = True
            point, node = point[child >= 0], child[child >= 0]
        found = np.where(seen[:, 0], np.where(seen[:, 1], ON, OUT), IN)
        return found.astype(np.int8).reshape(where.shape[:-1])

    def _in_doubles(self, points: Array) -> tuple[Array, Array]:
        """Points in the mesh's frame and planes, in a unit in which no coordinate of either exceeds 1."""
        most = max(float(np.max(largest(points), initial=0.0)), float(self.mesh.magnitude))
        exponent = int(np.frexp(most)[1]) + 3
        position, around = (np.ldexp(x, -exponent) for x in (self.mesh.position, points))
        near = apply_inverse(rotation_matrix(self.mesh.rotation), around - position)
        unit = Fraction(2) ** exponent
        slopes = []
        for cut, size in zip(self.cuts, self._sizes, strict=True):
            a, b, c, d = cut.plane
            slopes.append([a / size, b / size, c / size, float(Fraction(d, size) / unit)])
        return near, np.array(slopes)

    def _sides(
        self, points: Array, near: Array, slopes: Array, exact: dict[int, Vector], point: Indices, node: Indices
    ) -> Indices:
        """Signs of the heights of points above the planes of nodes."""
        plane, x = slopes[node], near[point]
        height = plane[:, 0] * x[:, 0] + plane[:, 1] * x[:, 1] + plane[:, 2] * x[:, 2] + plane[:, 3]
        side = np.sign(height).astype(np.int64)
        for i in np.flatnonzero(np.abs(height) <= DOUBT).tolist():
            p = int(point[i])
            if p not in exact:
                exact[p] = self._local(_minus(_exact(points[p]), _exact(self.mesh.position)))
            value = _height(self.cuts[int(node[i])].plane, exact[p])
            side[i] = (value > 0) - (value < 0)
        return side

    # -- rays --------------------------------------------------------------------------------------------------

    def enter(self, ray: Ray) -> Array:
        """Times at which rays first meet the solid: 0 from inside, inf on a miss; exact, then rounded.

        Parameters
        ----------
        ray : Ray, of any batch shape

        Returns
        -------
        (...)
            In units of the ray's direction; a ray that only grazes the solid meets it.
        """
        position = _exact(self.mesh.position)
        times = [
            self._enter(self._local(_minus(_exact(start), position)), self._local(_exact(way)))
            for start, way in zip(ray.origin.reshape(-1, 3), ray.direction.reshape(-1, 3), strict=True)
        ]
        return np.array(times).reshape(ray.batch_shape)

    def _enter(self, start: Vector, way: Vector) -> float:
        best: Fraction | None = None
        waiting: list[tuple[int, Fraction, Fraction | None]] = [(0, Fraction(0), None)]
        while waiting:
            node, first, last = waiting.pop()
            if node == EMPTY or (best is not None and first >= best):
                continue
            if node == SOLID:
                best = first
                continue
            plane, (below, above) = self.cuts[node].plane, self.cuts[node].children
            height, speed = _height(plane, start), _height((*plane[:3], 0), way)
            if speed == 0:
                waiting += [(child, first, last) for child, met in ((below, height <= 0), (above, height >= 0)) if met]
                continue
            time = -height / speed
            nearer, farther = (below, above) if speed > 0 else (above, below)
            if last is None or time <= last:
                waiting.append((farther, max(first, time), last))
            if first <= time:
                waiting.append((nearer, first, time if last is None else min(last, time)))
        return math.inf if best is None else _rounded(best)

    def _local(self, vector: Vector) -> Vector:
        """Turn a vector into the mesh's frame."""
        x, y, z = (sum(a * b for a, b in zip(axis, vector, strict=True)) for axis in self._axes)
        return Fraction(x), Fraction(y), Fraction(z)


def _columns(rotation: Array) -> Any:
    """Columns of the rotation matrix of a quaternion, exactly."""
    from refimpl.proof.points import turned  # noqa: PLC0415  the proofs are not needed to import the broad phase

    return turned(rotation)


def _exact(vector: Array) -> Vector:
    x, y, z = map(Fraction, vector.tolist())
    return x, y, z


def _minus(u: Vector, v: Vector) -> Vector:
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def _height(plane: tuple[int, int, int, int], point: Vector) -> Fraction:
    a, b, c, d = plane
    return a * point[0] + b * point[1] + c * point[2] + d


def _rounded(time: Fraction) -> float:
    """Nearest double; infinite where there is none."""
    try:
        return float(time)
    except OverflowError:
        return math.inf
