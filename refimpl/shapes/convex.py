"""Convex polyhedra: by planes or by vertices, in a frame of their own."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.derived import Derived, of_planes, of_vertices, repeats
from refimpl.fields import IDENTITY
from refimpl.linear import Array, apply, largest, power_of_two, rotation_matrix, scale
from refimpl.proxy import as_offset, rows, shifted, turned, turned_frame, vector
from refimpl.shapes.polytope import Polytope


@dataclass(frozen=True, eq=False, repr=False, init=False)
class ConvexPolyhedron(Polytope):
    """An intersection of half-spaces, or the hull of vertices, in a frame of its own.

    ``ConvexPolyhedron(planes, position, rotation)`` is the set of the points position + R(rotation)·y with
    n_i·y + k_i ≤ 0 for every plane (n_i, k_i); ``ConvexPolyhedron.from_vertices(vertices, position, rotation)`` the
    hull of the points position + R(rotation)·vertices_i. Moving and turning it changes only position and rotation.

    Parameters
    ----------
    planes : (..., k, 4)
        Outward normals of any non-zero length and offsets, as of a `HalfSpace`.
    position : (..., 3)
    rotation : (..., 4)
        Quaternion (x, y, z, w) of any non-zero length; R is the rotation matrix of its direction.

    Attributes
    ----------
    given : {"planes", "vertices"}
        Which of the two the solid was built from: those numbers are its meaning, the other is derived.
    """

    header: ClassVar[int] = 2
    derives_first: ClassVar[bool] = True
    numbers: Array = rows("n", "width")
    position: Array = vector()
    rotation: Array = vector(width=4, nonzero=True, length=False)

    given: ClassVar[str]

    def __init__(
        self, planes: ArrayLike, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike = IDENTITY
    ) -> None:
        self._build("planes", planes, position, rotation)

    @classmethod
    def from_vertices(
        cls, vertices: ArrayLike, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike = IDENTITY
    ) -> Self:
        """Build the hull of vertices.

        Parameters
        ----------
        vertices : (..., m, 3)
            At least one; repeated ones and ones within the hull of others change nothing.
        position : (..., 3)
        rotation : (..., 4)
        """
        shape = object.__new__(cls)
        shape._build("vertices", vertices, position, rotation)
        return shape

    def _build(self, given: str, numbers: Any, position: Any, rotation: Any) -> None:
        object.__setattr__(self, "given", given)
        self._fill([numbers, position, rotation])

    def _fit(self, name: str, value: Array, tail: Any, sizes: dict[str, int]) -> None:
        sizes.setdefault("width", 4 if self.given == "planes" else 3)
        super()._fit(name, value, tail, sizes)

    def _hint(self, name: str, value: Array) -> str:
        corners = self.given == "planes" and name == "numbers" and value.shape[-1:] == (3,)
        return "; of corners, use from_vertices" if corners else ""

    def _store(self, columns: list[Array]) -> None:
        object.__setattr__(self, "given", "planes" if columns[0].shape[-1] == 4 else "vertices")
        super()._store(columns)

    def _check_together(self) -> None:
        if self.given == "planes":
            flat = np.all(self.numbers[..., :3] == 0, axis=-1)
            self._refuse("numbers", self.numbers, flat, "must have a normal that is not zero")
            self._derive_now()

    def _derive(self) -> Derived:
        return of_planes(self.numbers) if self.given == "planes" else of_vertices(self.numbers)

    @property
    def vertices(self) -> Array:
        """The vertices (..., m, 3) as they were given, or else the corners of the planes; in its own frame."""
        return self.numbers if self.given == "vertices" else self.hull.vertices

    @property
    def planes(self) -> Array:
        """The planes (..., k, 4) as they were given, or else the faces of the hull, outward; in its own frame."""
        return self.numbers if self.given == "planes" else self.hull.planes

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of the position, or of a corner in its own frame."""
        return np.asarray(np.maximum(largest(self.position), self.derived().size))

    @property
    def reference_point(self) -> Array:
        """The mean of the corners."""
        return np.asarray(self.position + apply(rotation_matrix(self.rotation), self.derived().middle))

    def identity(self) -> tuple[tuple[Hashable, ...], Array]:
        """Sizes, and rows of the pose and of numbers that tell geometries apart."""
        return self.sizes, np.concatenate([self.position, self.rotation, self.derived().marks], axis=-1)

    def _label(self, name: str) -> str:
        return self.given if name == "numbers" else name

    def _constructor(self) -> str:
        return "ConvexPolyhedron" if self.given == "planes" else "ConvexPolyhedron.from_vertices"

    @property
    def sizes(self) -> tuple[int, ...]:
        """0 for planes or 1 for vertices, and how many."""
        source, _ = self._shared() or (self.numbers, None)
        return (int(self.given == "vertices"), source.shape[-2])

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Leading axes shared by all fields."""
        return self.position.shape[:-1]

    @classmethod
    def _tails(cls, sizes: tuple[int, ...]) -> list[tuple[int, ...]]:
        by_vertices, count = sizes
        return [(count, 3 if by_vertices else 4), (3,), (4,)]

    @classmethod
    def _validated(cls, *columns: Array) -> Self:
        return cls(*columns) if columns[0].shape[-1] == 4 else cls.from_vertices(*columns)

    @classmethod
    def _read_sizes(cls, numbers: Array) -> tuple[int, ...]:
        sizes = super()._read_sizes(numbers)
        if sizes[0] > 1:
            cls._refuse_rows(f"the first number must be 0 for planes or 1 for vertices, got {sizes[0]}")
        return sizes

    def _shared(self) -> tuple[Array, Array | None] | None:
        """One geometry that the whole batch shares, and exponents by which it is scaled (None: as it was given)."""
        if "_geometry" in self.__dict__:
            found: tuple[Array, Array | None] = self.__dict__["_geometry"]
            return found
        numbers = self.numbers
        if numbers.ndim > 2 and not repeats(numbers, 2):
            return None
        return numbers[(0,) * (numbers.ndim - 2)], None

    def _posed(self, geometry: tuple[Array, Array | None], position: Array, rotation: Array) -> Self:
        """Give poses to one geometry, whose numbers are copied for each of them only when they are asked for."""
        made = object.__new__(type(self))
        object.__setattr__(made, "given", self.given)
        object.__setattr__(made, "_geometry", geometry)
        batch = np.broadcast_shapes(position.shape[:-1], rotation.shape[:-1])
        for name, value, width in (("position", position, 3), ("rotation", rotation, 4)):
            full = np.broadcast_to(value, (*batch, width))
            full.flags.writeable = False
            object.__setattr__(made, name, full)
        return made

    def __getattr__(self, name: str) -> Any:
        """Copy the numbers of a shared geometry, at the first call."""
        if name != "numbers" or "_geometry" not in self.__dict__:
            raise AttributeError(f"a {type(self).__name__} has no attribute {name!r}")
        source, power = self.__dict__["_geometry"]
        full = np.broadcast_to(source, (*self.batch_shape, *source.shape))
        if power is not None:
            full = self._scaled_by(full, power)
        full.flags.writeable = False
        object.__setattr__(self, "numbers", full)
        return full

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        shared = self._shared()
        if shared is None:
            return super()._mapped(change)
        geometry = (shared[0], None if shared[1] is None else change(shared[1], 0))
        made = self._posed(geometry, change(self.position, 1), change(self.rotation, 1))
        return made._deriving_as(self, lambda derived: derived.mapped(change))

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return self._placed(self.position + as_offset(offset), self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return self._placed(turned(rotation, self.position), turned_frame(rotation, self.rotation))

    def _placed(self, position: Array, rotation: Array) -> Self:
        """Give the same geometry, with what has been derived, another pose."""
        for name, value in (("position", position), ("rotation", rotation)):
            self._refuse(name, value, ~np.isfinite(value), "must be finite")
        shared = self._shared()
        if shared is None:
            made = self._trusted(self.numbers, position, rotation)
        else:
            batch = np.broadcast_shapes(position.shape[:-1], rotation.shape[:-1])
            geometry = (shared[0], None if shared[1] is None else np.broadcast_to(shared[1], batch))
            made = self._posed(geometry, position, rotation)
        return made._deriving_as(self, lambda derived: derived.broadcast_to(made.batch_shape))

    def _scaled(self, factor: Array) -> Self:
        if self.given == "vertices":
            numbers = factor[..., None, None] * self.numbers
        else:
            numbers = _with_offsets(self.numbers, scale(factor, self.numbers[..., 3]))
        return self._validated(numbers, scale(factor, self.position), self.rotation)

    def _stretched(self, factors: Array) -> Self:
        """Stretch in the world's axes: the frame's rotation goes into the numbers."""
        matrix = rotation_matrix(self.rotation)[..., None, :, :]
        by = factors[..., None, :]
        if self.given == "vertices":
            numbers = by * apply(matrix, self.numbers)
        else:
            normals = apply(matrix, self.numbers[..., :3]) / by
            offsets = np.broadcast_to(self.numbers[..., 3:], (*normals.shape[:-1], 1))
            numbers = np.concatenate([normals, offsets], axis=-1)
        return self._validated(numbers, factors * self.position, np.asarray(IDENTITY))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent; the planes' normals are brought to about 1."""
        power = np.asarray(exponent)
        position, shared = shifted(self.position, power, 1), self._shared()
        if shared is None:
            made = self._trusted(self._scaled_by(self.numbers, power), position, self.rotation)
        else:
            total = power if shared[1] is None else power + shared[1]
            made = self._posed((shared[0], np.broadcast_to(total, position.shape[:-1])), position, self.rotation)
        return made._deriving_as(self, lambda derived: derived.times_power(power))

    def _scaled_by(self, numbers: Array, power: Array) -> Array:
        """Planes or vertices times 2^power."""
        if self.given == "vertices":
            return shifted(numbers, power, 2)
        own = power_of_two(largest(numbers[..., :3]))
        return _with_offsets(shifted(numbers, -own, 1), np.ldexp(numbers[..., 3], power[..., None] - own))


def _with_offsets(planes: Array, offsets: Array) -> Array:
    normals = np.broadcast_to(planes[..., :3], (*offsets.shape, 3))
    return np.concatenate([normals, offsets[..., None]], axis=-1)
