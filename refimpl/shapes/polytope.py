"""What the solids with flat faces share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from refimpl.hulls import Hull
from refimpl.linear import Array
from refimpl.proxy import Proxy, ShapeError


@dataclass(frozen=True, eq=False, repr=False)
class Polytope(Proxy):
    """What the solids with flat faces share: corners, faces and edges, derived once and kept."""

    @property
    def hull(self) -> Hull:
        """Corners, outward unit planes and edges, in the polytope's own frame; see `refimpl.hulls.Hull`."""
        if "_hull" not in self.__dict__:
            object.__setattr__(self, "_hull", self._derived())
        found: Hull = self.__dict__["_hull"]
        return found

    def _derived(self) -> Hull:
        raise NotImplementedError

    def _with_hull_of(self, other: Polytope, change: Callable[[Hull], Hull]) -> Self:
        """Take over what another polytope has derived, changed as this one was made from that one."""
        if "_hull" in other.__dict__:
            object.__setattr__(self, "_hull", change(other.hull))
        return self

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        return super()._mapped(change)._with_hull_of(self, lambda hull: hull.mapped(change))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent, exactly, and with it what has been derived."""
        return super().times_power(exponent)._with_hull_of(self, lambda hull: hull.times_power(exponent))

    @property
    def vertices(self) -> Array:
        """Corners (..., m, 3), in the polytope's own frame."""
        return self.hull.vertices

    @property
    def planes(self) -> Array:
        """Faces (..., f, 4): outward unit normals and offsets, normal·x + offset ≤ 0, in the polytope's own frame."""
        return self.hull.planes

    def _derive_now(self) -> None:
        """Derive the hull, so that an empty or unbounded set is refused when it is built."""
        try:
            _ = self.hull
        except ShapeError as error:
            raise ShapeError(f"{type(self).__name__}: {error}") from None


def middle_of_corners(hull: Hull) -> Array:
    """Mean of the corners, which lies in the hull; a repeated last corner, which fills up a batch, counts once."""
    v = hull.vertices
    counts = np.ones(v.shape[:-1])
    counts[..., 1:] = np.any(v[..., 1:, :] != v[..., :-1, :], axis=-1)
    number = np.cumsum(counts, axis=-1)[..., -1]
    shares = counts / number[..., None]
    return np.asarray(np.cumsum(shares[..., None] * v, axis=-2)[..., -1, :])
