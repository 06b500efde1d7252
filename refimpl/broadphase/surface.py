"""The triangles of a mesh in a bounding volume hierarchy: rays, points and boxes against a surface.

The tree proposes faces, in the mesh's own frame; the faces are then asked themselves, by the exact signs and the
closest features that answer everywhere else.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from refimpl.algorithms.union_rays import crossings, first_entry
from refimpl.atoms import groups
from refimpl.bounds import aabb
from refimpl.boxtree import Boxes
from refimpl.broadphase.bvh import BVH
from refimpl.broadphase.nearest import nearest
from refimpl.broadphase.surfaces import reach
from refimpl.linear import Array, apply, apply_inverse, rotation_matrix
from refimpl.proxy import Proxy, ShapeError
from refimpl.queries import distance, intersect
from refimpl.results import RayHit
from refimpl.shapes import Point, Polyhedron, Ray
from refimpl.signs import Indices


class SurfaceTree:
    """The faces of one polyhedron, placed where it is.

    Parameters
    ----------
    mesh : Polyhedron
        A single one, no batch.
    """

    def __init__(self, mesh: Polyhedron) -> None:
        if mesh.batch_shape:
            raise ShapeError(f"SurfaceTree: expected a single Polyhedron, got a batch of shape {mesh.batch_shape}")
        self.mesh = mesh
        self.boxes = BVH().build(*mesh.solid.face_bounds)
        self._faces: Any = groups([mesh], surfaces=True)[0].proxies
        self._turn = rotation_matrix(mesh.rotation)

    def raycast(self, ray: Ray) -> RayHit:
        """First point of the solid on each ray (n,), as `refimpl.raycast` gives it."""
        origin, direction = self._local(ray)
        t, normal = first_entry(self.mesh.solid, origin, direction, *self._on_the_way(origin, direction))
        hit = np.isfinite(t)
        point = np.where(hit[:, None], ray.at(np.where(hit, t, 0.0)), np.nan)
        return RayHit(hit, t, point, np.where((hit & (t > 0))[:, None], apply(self._turn, normal), np.nan))

    def crossings(self, ray: Ray) -> tuple[Indices, Indices, Array]:
        """All faces that rays (n,) go through, from one side to the other.

        Returns
        -------
        rays, faces, times : (k,)
            By ray, time, face. Through an edge or a corner a ray goes through all faces that have it.
        """
        origin, direction = self._local(ray)
        near = self._on_the_way(origin, direction)
        row, face, time, _ = crossings(self.mesh.solid, origin, direction, *near)
        sort = np.lexsort((face, time, row))
        return row[sort], face[sort], time[sort]

    def nearest(self, points: ArrayLike) -> tuple[Array, Array, Indices]:
        """Distances of points (n, 3) from the surface, the nearest points of it, and their faces."""
        point = Point(points)
        local = apply_inverse(self._turn, point.position - self.mesh.position)
        exponent = max(reach(local, local), reach(self.boxes.lower, self.boxes.upper))

        def length(query: Indices, face: Indices) -> Array:
            return np.ldexp(distance(point[query], self._faces[face]).distance, -exponent)

        nodes = self.boxes.tree.nodes.in_units(exponent)
        _, face = nearest(self.boxes.tree, nodes, np.ldexp(local, -exponent), 1, length)
        found = distance(point, self._faces[face[:, 0]])
        return found.distance, found.on_b, face[:, 0]

    def meeting(self, shape: Proxy) -> tuple[Indices, Indices]:
        """Bounded proxies (n,) and the faces that they have a point in common with: their places, and faces, sorted."""
        box = aabb(shape)
        inverse = self._turn.T
        local = Boxes.around(box.lower, box.upper).moved(inverse, -apply_inverse(self._turn, self.mesh.position))
        place, face = self.boxes.query_boxes(local.center - local.half, local.center + local.half).T
        met = np.flatnonzero(intersect(shape[place], self._faces[face])) if len(place) else place
        return place[met], face[met]

    def _local(self, ray: Ray) -> tuple[Array, Array]:
        return apply_inverse(self._turn, ray.origin - self.mesh.position), apply_inverse(self._turn, ray.direction)

    def _on_the_way(self, origin: Array, direction: Array) -> tuple[Indices, Indices]:
        """Rays and faces whose boxes they may meet."""
        none = np.empty(0, dtype=np.int64)
        found = list(self.boxes._near_rays(origin, direction, np.full(len(origin), np.inf)))
        row, face = (np.concatenate([none, *column]) for column in zip(*found, strict=True)) if found else (none, none)
        return row, face
