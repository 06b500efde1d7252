"""k-DOPs: slabs along fixed directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from refimpl.derived import Derived, of_planes
from refimpl.intervals import sum_rounded
from refimpl.linear import Array, apply, as_floats, dot, largest, power_of_two, rotation_matrix, scale
from refimpl.proxy import ShapeError, as_offset, as_quaternion, rows, shifted
from refimpl.shapes.polytope import Polytope

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
        """Hull of 2 k planes, as `Hull.active_planes` numbers them: first those of `upper`, then those of `lower`."""
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
        return made._deriving_as(self, lambda derived: derived.times_power(exponent))
