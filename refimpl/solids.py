"""A mesh that bounds a solid, with what is derived from it once: checks, convex pieces, trees of boxes.

Everything here is in the mesh's own frame, so that it serves every placement of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.boxtree import BoxTree
from refimpl.bsp import Piece, bounds_convex, convex_pieces
from refimpl.hulls import Hull
from refimpl.linear import Array, cross, dot, norm, unit_or
from refimpl.meshes import Triangles, require_solid, shells

REMEMBERED = 64  # meshes whose pieces are kept


class Solid:
    """The solid that a closed triangle surface bounds.

    Parameters
    ----------
    vertices : (m, 3)
    triangles : (t, 3) int

    Raises
    ------
    MeshError
        Where the surface bounds no solid; see `meshes.require_solid`.
    """

    def __init__(self, vertices: Array, triangles: Triangles) -> None:
        self.vertices = vertices
        self.triangles = triangles
        self.vertices.flags.writeable = False
        self.triangles.flags.writeable = False
        if self.digest not in _CHECKED:
            require_solid(vertices, triangles)
            _CHECKED[self.digest] = None
            while len(_CHECKED) > 1024:
                del _CHECKED[next(iter(_CHECKED))]

    @cached_property
    def digest(self) -> str:
        """What tells this mesh from others: a hash of its numbers."""
        content = blake2b(np.array(self.vertices.shape[0]).tobytes(), digest_size=16)
        content.update(np.ascontiguousarray(self.vertices).tobytes())
        content.update(np.ascontiguousarray(self.triangles).tobytes())
        return content.hexdigest()

    @cached_property
    def corners(self) -> Array:
        """Corners of the faces, (t, 3, 3)."""
        return self.vertices[self.triangles]

    @cached_property
    def surface(self) -> BoxTree:
        """Tree of the faces."""
        return BoxTree(*self.face_bounds)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner of the whole, widened by rounding."""
        slack = 1e-12 * self.extent
        return self.vertices.min(axis=0) - slack, self.vertices.max(axis=0) + slack

    @cached_property
    def face_bounds(self) -> tuple[Array, Array]:
        """Lower and upper corners of the faces' boxes."""
        return self.corners.min(axis=1), self.corners.max(axis=1)

    @cached_property
    def pieces(self) -> list[Piece]:
        """Convex pieces with disjoint interiors; a convex solid is one."""
        return _pieces(self)

    @cached_property
    def is_convex(self) -> bool:
        """Whether the solid is one piece."""
        return bounds_convex(self.vertices, self.triangles)

    @cached_property
    def shell_corners(self) -> NDArray[np.int64]:
        """A vertex of each connected surface."""
        _, first = np.unique(shells(self.triangles, len(self.vertices)), return_index=True)
        return np.asarray(self.triangles[first, 0])

    @cached_property
    def extent(self) -> float:
        """Largest absolute coordinate."""
        return float(np.max(np.abs(self.vertices)))


_CHECKED: dict[str, None] = {}
_PIECES: dict[str, list[Piece]] = {}


def _pieces(solid: Solid) -> list[Piece]:
    """Pieces of a mesh, shared by all that have the same numbers."""
    found = _PIECES.pop(solid.digest, None)
    if found is None:
        found = convex_pieces(solid.vertices, solid.triangles)
    _PIECES[solid.digest] = found  # the last to be forgotten
    while len(_PIECES) > REMEMBERED:
        del _PIECES[next(iter(_PIECES))]
    return found


def face_hulls(corners: Array) -> Hull:
    """Faces (t, 3, 3) as flat polytopes: two sides, and a prism's planes around them."""
    count = len(corners)
    sides = np.roll(corners, -1, axis=1) - corners
    top = unit_or(cross(sides[:, 0], sides[:, 1]), np.eye(3)[2])[0]
    around = unit_or(cross(sides, np.repeat(top[:, None], 3, axis=1)), top[:, None])[0]
    normals = np.concatenate([top[:, None], -top[:, None], around], axis=1)
    offsets = -np.max(dot(normals[:, :, None], corners[:, None]), axis=-1)
    edges = [edge for i in range(3) for edge in ((i, (i + 1) % 3, 0, 2 + i), ((i + 1) % 3, i, 1, 2 + i))]
    return _hull(
        corners,
        np.concatenate([normals, offsets[..., None]], axis=-1),
        np.broadcast_to(np.array(edges, dtype=np.int64), (count, 6, 4)),
        2,
    )


def piece_hulls(pieces: Sequence[Piece]) -> Hull:
    """Convex pieces as polytopes, filled up to one size; planes are rounded from the exact ones."""
    planes = []
    for piece in pieces:
        sizes = [max(map(abs, plane[:3])) for plane in piece.planes]
        level = np.array([[x / size for x in plane] for plane, size in zip(piece.planes, sizes, strict=True)])
        planes.append(level / norm(level[:, :3])[:, None])
    return _hull(
        filled([piece.vertices for piece in pieces]),
        filled(planes),
        filled([_edges(piece) for piece in pieces]),
        3,
    )


def _edges(piece: Piece) -> Array:
    """Start, end, facet to the left, facet to the right of each edge, seen from outside."""
    left = {(u, v): i for i, loop in enumerate(piece.facets) for u, v in zip(loop, loop[1:] + loop[:1], strict=True)}
    return np.array([(u, v, i, left[v, u]) for (u, v), i in left.items() if u < v])


def filled(rows: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays stacked, of which those with fewer rows than others repeat their last."""
    most = max(len(r) for r in rows)
    return np.stack([r[np.minimum(np.arange(most), len(r) - 1)] for r in rows])


def _hull(vertices: Array, planes: Array, edges: Any, dimension: int) -> Hull:
    count = len(vertices)
    none = np.int64(-1)
    return Hull(
        vertices,
        planes,
        edges,
        np.broadcast_to(none, planes.shape[:2]),
        np.broadcast_to(none, vertices.shape[:2]),
        np.full(count, dimension, dtype=np.int64),
    )
