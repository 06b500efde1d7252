"""Polytopes: k-DOPs and convex polyhedra, which are as large as their numbers say."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from hashlib import blake2b
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.derived import Derived, of_planes, of_vertices
from refimpl.intervals import sum_rounded
from refimpl.linear import Array, apply, as_floats, dot, largest, power_of_two, rotation_matrix, scale
from refimpl.proxy import ShapeError, as_offset, as_quaternion, rows, shifted, turned, turned_frame, vector
from refimpl.shapes.polytope import Polytope

IDENTITY = (0.0, 0.0, 0.0, 1.0)
AXES = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
CORNERS = [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]
EDGES = [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
USUAL_DIRECTIONS = {
    6: np.array(AXES, dtype=np.float64),
    14: np.array(AXES + CORNERS, dtype=np.float64),
    18: np.array(AXES + EDGES, dtype=np.float64),
    26: np.array(AXES + CORNERS + EDGES, dtype=np.float64),
}


@dataclass(frozen=True, eq=False, repr=False)
class KDOP(Polytope):
    """The set lower_i ≤ directions_i·x ≤ upper_i for every i: a slab for each direction.

    Slabs may be redundant; together they must be bounded and have a point in common.

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
        self._derive_now()

    def _derive(self) -> Derived:
        """Hull of the planes: first those of `upper`, then those of `lower`."""
        normals = np.concatenate([self.directions, -self.directions], axis=-2)
        return of_planes(
            np.concatenate([normals, np.concatenate([-self.upper, self.lower], axis=-1)[..., None]], axis=-1)
        )

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of a corner."""
        return self.derived().size

    @property
    def reference_point(self) -> Array:
        """The mean of the corners."""
        return self.derived().middle

    @classmethod
    def around(cls, points: ArrayLike, k: int = 26) -> Self:
        """Build the smallest k-DOP of the usual directions around points.

        Parameters
        ----------
        points : (..., m, 3)
        k : {6, 14, 18, 26}
            Number of planes, two for each direction: the axes; with the cube's diagonals (14), with the diagonals of
            its faces (18), with both (26). Klosowski et al., Efficient Collision Detection Using Bounding Volume
            Hierarchies of k-DOPs, 1998.
        """
        if k not in USUAL_DIRECTIONS:
            raise ShapeError(f"KDOP.around: the usual k are {', '.join(map(str, USUAL_DIRECTIONS))}, got {k!r}")
        inside = as_floats(points)
        if inside.ndim < 2 or inside.shape[-1] != 3 or not inside.shape[-2] or not np.all(np.isfinite(inside)):
            raise ShapeError(f"KDOP.around: expected finite points (..., m, 3), got an array of shape {inside.shape}")
        directions = USUAL_DIRECTIONS[k]
        terms = inside[..., :, None, :] * directions
        lower = np.min(sum_rounded(terms, -np.inf), axis=-2)
        upper = np.max(sum_rounded(terms, np.inf), axis=-2)
        return cls(directions, lower, upper)

    @property
    def sizes(self) -> tuple[int, ...]:
        """The number of slabs."""
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
        lower, upper = np.ldexp(self.lower, power), np.ldexp(self.upper, power)
        made = self._trusted(shifted(self.directions, -own, 1), lower, upper)
        return made._with_hull_of(self, lambda derived: derived.times_power(exponent))


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
        """Sizes, and rows of the pose and of a digest of the planes or vertices."""
        marks = _digests(self.numbers)
        return self.sizes, np.concatenate([self.position, self.rotation, marks], axis=-1)

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
        """Give the same geometry, with what has been derived, another pose."""
        for name, value in (("position", position), ("rotation", rotation)):
            self._refuse(name, value, ~np.isfinite(value), "must be finite")
        made = self._trusted(self.numbers, position, rotation)
        return made._with_hull_of(self, lambda derived: derived.broadcast_to(made.batch_shape))

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
        made = self._trusted(numbers, shifted(self.position, power, 1), self.rotation)
        return made._with_hull_of(self, lambda derived: derived.times_power(power))


def _with_offsets(planes: Array, offsets: Array) -> Array:
    normals = np.broadcast_to(planes[..., :3], (*offsets.shape, 3))
    return np.concatenate([normals, offsets[..., None]], axis=-1)


def _digests(numbers: Array) -> Array:
    """Two doubles (..., 2) that tell geometries (..., n, w) apart by their content."""
    batch = numbers.shape[:-2]
    if batch and numbers.size and not any(step for step, n in zip(numbers.strides, batch, strict=False) if n > 1):
        return np.broadcast_to(_digests(numbers[(0,) * len(batch)]), (*batch, 2))
    marks = [
        [int.from_bytes(digest[:6], "big"), int.from_bytes(digest[6:], "big")]
        for where in np.ndindex(*batch)
        for digest in [blake2b((numbers[where] + 0.0).tobytes(), digest_size=12).digest()]
    ]
    return np.array(marks, dtype=np.float64).reshape((*batch, 2))
