"""Polytopes: k-DOPs and convex polyhedra, which are as large as their numbers say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.linear import Array, apply, dot, largest, power_of_two, rotation_matrix, scale
from refimpl.proxy import Proxy, as_offset, as_quaternion, rows, shifted, turned, turned_frame, vector

IDENTITY = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False, repr=False)
class KDOP(Proxy):
    """The set lower_i ≤ directions_i·x ≤ upper_i for every i: a slab for each direction.

    Parameters
    ----------
    directions : (..., k, 3)
        Of any non-zero length.
    lower, upper : (..., k)
        In units of the direction's length. Equal ones make the set flat.
    """

    header: ClassVar[int] = 1
    directions: Array = rows("k", 3, nonzero=True, length=False)
    lower: Array = rows("k")
    upper: Array = rows("k")

    if TYPE_CHECKING:

        def __init__(self, directions: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> None: ...

    def _check_together(self) -> None:
        self._refuse("upper", self.upper, self.upper < self.lower, "must not be below KDOP.lower")

    @property
    def sizes(self) -> tuple[int, ...]:
        """The number k of slabs."""
        return (self.lower.shape[-1],)

    @classmethod
    def _tails(cls, sizes: tuple[int, ...]) -> list[tuple[int, ...]]:
        (k,) = sizes
        return [(k, 3), (k,), (k,)]

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = dot(self.directions, as_offset(offset)[..., None, :])
        return type(self)(self.directions, self.lower + shift, self.upper + shift)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin, the directions with it."""
        matrix = rotation_matrix(as_quaternion(rotation))
        return type(self)(apply(matrix[..., None, :, :], self.directions), self.lower, self.upper)

    def _scaled(self, factor: Array) -> Self:
        return type(self)(self.directions, scale(factor, self.lower), scale(factor, self.upper))

    def _stretched(self, factors: Array) -> Self:
        return type(self)(self.directions / factors[..., None, :], self.lower, self.upper)

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent; the directions are brought to about 1."""
        own = power_of_two(largest(self.directions))
        power = np.asarray(exponent)[..., None] - own
        return self._trusted(
            shifted(self.directions, -own, 1), np.ldexp(self.lower, power), np.ldexp(self.upper, power)
        )


@dataclass(frozen=True, eq=False, repr=False, init=False)
class ConvexPolyhedron(Proxy):
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
    numbers: Array = rows("count", "width")
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

    def _store(self, columns: list[Array]) -> None:
        object.__setattr__(self, "given", "planes" if columns[0].shape[-1] == 4 else "vertices")
        super()._store(columns)

    def _check_together(self) -> None:
        if self.given == "planes":
            flat = np.all(self.numbers[..., :3] == 0, axis=-1)
            self._refuse("numbers", self.numbers, flat, "must have a normal that is not zero")

    def _label(self, name: str) -> str:
        return self.given if name == "numbers" else name

    def _constructor(self) -> str:
        return "ConvexPolyhedron" if self.given == "planes" else "ConvexPolyhedron.from_vertices"

    @property
    def sizes(self) -> tuple[int, ...]:
        """0 for planes or 1 for vertices, and how many."""
        return (int(self.given == "vertices"), self.numbers.shape[-2])

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

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        return self._placed(self.position + as_offset(offset), self.rotation)

    def rotated(self, rotation: Any) -> Self:
        """Turn about the origin."""
        return self._placed(turned(rotation, self.position), turned_frame(rotation, self.rotation))

    def _placed(self, position: Array, rotation: Array) -> Self:
        return self._validated(self.numbers, position, rotation)

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
        if self.given == "vertices":
            numbers = shifted(self.numbers, power, 2)
        else:
            own = power_of_two(largest(self.numbers[..., :3]))
            numbers = _with_offsets(
                shifted(self.numbers, -own, 1), np.ldexp(self.numbers[..., 3], power[..., None] - own)
            )
        return self._trusted(numbers, shifted(self.position, power, 1), self.rotation)


def _with_offsets(planes: Array, offsets: Array) -> Array:
    normals = np.broadcast_to(planes[..., :3], (*offsets.shape, 3))
    return np.concatenate([normals, offsets[..., None]], axis=-1)
