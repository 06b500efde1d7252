"""Solids bounded by triangle meshes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.bsp import Piece
from refimpl.fields import IDENTITY
from refimpl.linear import Array, apply, as_floats, largest, rotation_matrix
from refimpl.meshes import MeshError, Triangles
from refimpl.proxy import (
    Proxy,
    ShapeError,
    UnsupportedOperation,
    as_offset,
    shifted,
    turned,
    turned_frame,
    vector,
)
from refimpl.solids import Solid


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Polyhedron(Proxy):
    """The solid bounded by a closed triangle surface, concave or not, in a frame of its own.

    The points position + R(rotation)·y for all y that the surface winds around. A proxy wholly inside overlaps it.

    Parameters
    ----------
    vertices : (m, 3)
        One mesh serves a whole batch.
    triangles : (t, 3) int
        Corners of each face, anticlockwise seen from outside; those of a cavity seen from within the cavity.
    position : (..., 3)
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.

    Raises
    ------
    MeshError
        A `ShapeError`, where the surface is open, flipped, self-intersecting or has faces without area.
    """

    header: ClassVar[int] = 2
    position: Array = vector()
    rotation: Array = vector(width=4, nonzero=True, length=False)

    solid: ClassVar[Solid]

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = IDENTITY,
    ) -> None:
        numbers = self._numbers("vertices", vertices)
        if numbers.ndim != 2 or numbers.shape[1] != 3:
            raise ShapeError(f"Polyhedron.vertices: expected m × 3 numbers, got an array of shape {numbers.shape}")
        self._refuse("vertices", numbers, ~np.isfinite(numbers), "must be finite")
        try:
            solid = Solid(numbers, _whole(triangles))
        except MeshError as error:
            raise MeshError(f"Polyhedron: {error}") from None
        object.__setattr__(self, "solid", solid)
        self._fill([position, rotation])

    @property
    def vertices(self) -> Array:
        """Vertices (m, 3), in the solid's own frame."""
        return self.solid.vertices

    @property
    def triangles(self) -> Triangles:
        """Faces (t, 3), as numbers of vertices."""
        return self.solid.triangles

    @property
    def pieces(self) -> list[Piece]:
        """Convex pieces with disjoint interiors that together are the solid, in its own frame; derived once."""
        return self.solid.pieces

    def _with(self, solid: Solid, position: Array, rotation: Array) -> Self:
        made = object.__new__(type(self))
        object.__setattr__(made, "solid", solid)
        made._store([position, rotation])
        return made

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        return self._with(self.solid, change(self.position, 1), change(self.rotation, 1))

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of vertices and of faces."""
        return len(self.vertices), len(self.triangles)

    @property
    def storage(self) -> int:
        """How many numbers one proxy of this batch is."""
        return 2 + self.vertices.size + self.triangles.size + 7

    def pack(self) -> Array:
        """Sizes, vertices, triangles, position, rotation side by side; shape (..., storage)."""
        mesh = np.concatenate([self.sizes, self.vertices.ravel(), self.triangles.ravel()])
        shared = np.broadcast_to(mesh, (*self.batch_shape, len(mesh)))
        return np.concatenate([shared, self.position, self.rotation], axis=-1)

    @classmethod
    def unpack(cls, rows: Array) -> Self:
        """Build from the rows that `pack` gives, which must all hold one mesh."""
        numbers = np.asarray(rows, dtype=np.float64)
        m, t = cls._read_sizes(numbers)
        start, stop = 2, 2 + 3 * m + 3 * t
        if numbers.shape[-1] != stop + 7:
            cls._refuse_rows(f"expected rows of {stop + 7} numbers, got an array of shape {numbers.shape}")
        meshes = numbers[..., start:stop].reshape(-1, stop - start)
        if not np.all(meshes == meshes[0]):
            cls._refuse_rows("the rows of one batch must hold one mesh")
        vertices, triangles = meshes[0, : 3 * m].reshape(m, 3), meshes[0, 3 * m :].reshape(t, 3)
        return cls(vertices, triangles, numbers[..., stop : stop + 3], numbers[..., stop + 3 :])

    def rebuilt(self, rows: Array) -> Self:
        """Give the same mesh the poses of other packed rows, which are trusted."""
        return self._with(self.solid, rows[..., -7:-4], rows[..., -4:])

    def identity(self) -> tuple[tuple[Hashable, ...], Array]:
        """The mesh's digest, and rows of the pose."""
        return (self.solid.digest,), np.concatenate([self.position, self.rotation], axis=-1)

    def __repr__(self) -> str:
        """Name the sizes of the mesh, and the pose."""
        m, t = self.sizes
        return f"Polyhedron(<{m} vertices, {t} triangles>, {self.position.tolist()!r}, {self.rotation.tolist()!r})"

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of the position, or of a vertex in its own frame."""
        return np.asarray(np.maximum(largest(self.position), self.solid.extent))

    @property
    def reference_point(self) -> Array:
        """The middle of the mesh's own bounding box."""
        middle = self.vertices.min(axis=0) / 2 + self.vertices.max(axis=0) / 2
        return np.asarray(self.position + apply(rotation_matrix(self.rotation), middle))

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return self._placed(self.position + as_offset(offset), self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return self._placed(turned(rotation, self.position), turned_frame(rotation, self.rotation))

    def _placed(self, position: Array, rotation: Array) -> Self:
        for name, value in (("position", position), ("rotation", rotation)):
            self._refuse(name, value, ~np.isfinite(value), "must be finite")
        return self._with(self.solid, position, rotation)

    def _scaled(self, factor: Array) -> Self:
        one = self._one(factor, "factor")
        return type(self)(one * self.vertices, self.triangles, factor[..., None] * self.position, self.rotation)

    def _stretched(self, factors: Array) -> Self:
        """Stretch in the world's axes: the frame's rotation goes into the vertices."""
        by, rotation = self._one(factors, "factors", 1), self._one(self.rotation, "rotation", 1)
        vertices = by * apply(rotation_matrix(rotation), self.vertices)
        return type(self)(vertices, self.triangles, factors * self.position)

    def _one(self, value: Array, name: str, ends: int = 0) -> Array:
        """The one value that all proxies of a batch have: they share the mesh."""
        flat = value.reshape((-1, *value.shape[value.ndim - ends :]))
        if not np.all(flat == flat[0]):
            raise UnsupportedOperation(
                f"the Polyhedrons of a batch share one mesh: scaling them needs the same {name} for all; "
                "scale them one by one"
            )
        return np.asarray(flat[0])

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent, the same for the whole batch."""
        power = np.asarray(exponent)
        position = shifted(self.position, power, 1)
        one = int(self._one(power, "exponent")) if power.size else 0
        solid = self.solid if one == 0 else Solid(np.ldexp(self.vertices, one), self.triangles)
        return self._with(solid, position, self.rotation)


def _whole(triangles: Any) -> Triangles:
    """Check that faces are rows of three whole numbers."""
    try:
        numbers = as_floats(triangles)
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(f"Polyhedron.triangles: not an array of whole numbers ({error})") from None
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise ShapeError(f"Polyhedron.triangles: expected t × 3 numbers, got an array of shape {numbers.shape}")
    bad = ~(np.isfinite(numbers) & (numbers == np.floor(numbers)) & (np.abs(numbers) < 2**31))
    if np.any(bad):
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ShapeError(
            f"Polyhedron.triangles must be whole numbers of vertices, got {numbers[where]!r} at index {where}"
        )
    return numbers.astype(np.int64)
