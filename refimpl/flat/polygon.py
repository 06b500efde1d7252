"""Convex polygons: by lines or by vertices."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.flat.base import Flat, turned_flat
from refimpl.flat.outlines import Outline, outline_of_lines, outline_of_vertices
from refimpl.linear import Array, dot, largest, power_of_two
from refimpl.proxy import as_offset, rows, shifted
from refimpl.shapes.polytope import Deriving


@dataclass(frozen=True, eq=False, repr=False, init=False)
class ConvexPolygon(Flat, Deriving):
    """An intersection of half-planes, or the hull of vertices.

    ``ConvexPolygon(lines)`` is the set of the points x with n_i·x + k_i ≤ 0 for every line (n_x, n_y, k);
    ``ConvexPolygon.from_vertices(vertices)`` the hull of the vertices, in any order.

    Parameters
    ----------
    lines : (..., m, 3)
        Outward normals of any non-zero length, and offsets. Redundant lines change nothing; together they must be
        bounded and have a point in common. They may leave only a segment or a point.

    Attributes
    ----------
    given : {"lines", "vertices"}
        Which of the two the polygon was built from: those numbers are its meaning, the other is derived.

    Raises
    ------
    ShapeError
        For lines behind which nothing lies, or something unbounded.
    """

    header: ClassVar[int] = 2
    derives_first: ClassVar[bool] = True
    numbers: Array = rows("n", "width")

    given: ClassVar[str]

    def __init__(self, lines: ArrayLike) -> None:
        self._build("lines", lines)

    @classmethod
    def from_vertices(cls, vertices: ArrayLike) -> Self:
        """Build the hull of vertices (..., m, 2), at least one; those within the hull of others change nothing."""
        shape = object.__new__(cls)
        shape._build("vertices", vertices)
        return shape

    def _build(self, given: str, numbers: Any) -> None:
        object.__setattr__(self, "given", given)
        self._fill([numbers])

    def _fit(self, name: str, value: Array, tail: Any, sizes: dict[str, int]) -> None:
        sizes.setdefault("width", 3 if self.given == "lines" else 2)
        super()._fit(name, value, tail, sizes)

    def _hint(self, name: str, value: Array) -> str:
        corners = self.given == "lines" and name == "numbers" and value.shape[-1:] == (2,)
        return "; of corners, use from_vertices" if corners else ""

    def _store(self, columns: list[Array]) -> None:
        object.__setattr__(self, "given", "lines" if columns[0].shape[-1] == 3 else "vertices")
        super()._store(columns)

    def _check_together(self) -> None:
        if self.given == "lines":
            zero = np.all(self.numbers[..., :2] == 0, axis=-1)
            self._refuse("numbers", self.numbers, zero, "must have a normal that is not zero")
            self._derive_now()

    def _derive(self) -> Outline:
        return outline_of_lines(self.numbers) if self.given == "lines" else outline_of_vertices(self.numbers)

    @property
    def outline(self) -> Outline:
        """Corners and outward unit normals of the sides, anticlockwise; see `refimpl.flat.outlines.Outline`."""
        found: Outline = self.derived()
        return found

    @property
    def vertices(self) -> Array:
        """The vertices (..., m, 2) as they were given, or else the corners of the lines."""
        return self.numbers if self.given == "vertices" else self.outline.corners

    @property
    def lines(self) -> Array:
        """The lines (..., m, 3) as they were given, or else those of the sides."""
        if self.given == "lines":
            return self.numbers
        corners, normals = self.outline.corners, self.outline.normals
        return np.concatenate([normals, -dot(normals, corners)[..., None]], axis=-1)

    @property
    def magnitude(self) -> Array:
        """Largest absolute coordinate of a corner."""
        corners = self.outline.corners
        return largest(corners.reshape((*corners.shape[:-2], -1)))

    @property
    def reference_point(self) -> Array:
        """The middle of the bounding rectangle."""
        corners = self.outline.corners
        return np.asarray(np.min(corners, axis=-2) / 2 + np.max(corners, axis=-2) / 2)

    def identity(self) -> tuple[tuple[Hashable, ...], Array]:
        """Sizes, and the numbers."""
        return self.sizes, self.numbers.reshape((*self.batch_shape, -1))

    def _label(self, name: str) -> str:
        return self.given if name == "numbers" else name

    def _constructor(self) -> str:
        return "ConvexPolygon" if self.given == "lines" else "ConvexPolygon.from_vertices"

    @property
    def sizes(self) -> tuple[int, ...]:
        """0 for lines or 1 for vertices, and how many."""
        return (int(self.given == "vertices"), self.numbers.shape[-2])

    @classmethod
    def _tails(cls, sizes: tuple[int, ...]) -> list[tuple[int, ...]]:
        by_vertices, count = sizes
        return [(count, 2 if by_vertices else 3)]

    @classmethod
    def _validated(cls, *columns: Array) -> Self:
        return cls(*columns) if columns[0].shape[-1] == 3 else cls.from_vertices(*columns)

    @classmethod
    def _read_sizes(cls, numbers: Array) -> tuple[int, ...]:
        sizes = super()._read_sizes(numbers)
        if sizes[0] > 1:
            cls._refuse_rows(f"the first number must be 0 for lines or 1 for vertices, got {sizes[0]}")
        return sizes

    def _with(self, linear: Array, offsets: Array) -> Self:
        """Lines of other normals and offsets."""
        return type(self)(np.concatenate([linear, offsets[..., None]], axis=-1))

    def translated(self, offset: Any) -> Self:
        """Move by `offset`."""
        shift = as_offset(offset, 2)[..., None, :]
        if self.given == "vertices":
            return self.from_vertices(self.numbers + shift)
        normals, moved = self.numbers[..., :2], self.numbers[..., 2] - dot(self.numbers[..., :2], shift)
        return self._with(np.broadcast_to(normals, (*moved.shape, 2)), moved)

    def _turned(self, cosine: Array, sine: Array) -> Self:
        turned = turned_flat(cosine[..., None], sine[..., None], self.numbers[..., :2])
        if self.given == "vertices":
            return self.from_vertices(turned)
        return self._with(turned, np.broadcast_to(self.numbers[..., 2], turned.shape[:-1]))

    def _scaled(self, factor: Array) -> Self:
        if self.given == "vertices":
            return self.from_vertices(factor[..., None, None] * self.numbers)
        offsets = factor[..., None] * self.numbers[..., 2]
        return self._with(np.broadcast_to(self.numbers[..., :2], (*offsets.shape, 2)), offsets)

    def _stretched(self, factors: Array) -> Self:
        by = factors[..., None, :]
        if self.given == "vertices":
            return self.from_vertices(by * self.numbers)
        normals = self.numbers[..., :2] / by
        return self._with(normals, np.broadcast_to(self.numbers[..., 2], normals.shape[:-1]))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent; the lines' normals are brought to about 1."""
        power = np.asarray(exponent)
        if self.given == "vertices":
            made = self._trusted(shifted(self.numbers, power, 2))
        else:
            own = power_of_two(largest(self.numbers[..., :2]))
            offsets = np.ldexp(self.numbers[..., 2], power[..., None] - own)
            normals = np.broadcast_to(shifted(self.numbers[..., :2], -own, 1), (*offsets.shape, 2))
            made = self._trusted(np.concatenate([normals, offsets[..., None]], axis=-1))
        return made._deriving_as(self, lambda derived: derived.times_power(power))
