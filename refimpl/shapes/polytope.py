"""What the solids with flat faces share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from refimpl.derived import Derived
from refimpl.hulls import Hull
from refimpl.linear import Array
from refimpl.proxy import Proxy, ShapeError


@dataclass(frozen=True, eq=False, repr=False)
class Deriving(Proxy):
    """A proxy from whose numbers something is derived once and kept, also by its slices, copies and scalings.

    What is kept is batched like the proxy, and has methods `mapped(change)` and `times_power(exponent)` of its own.
    """

    derives_first: ClassVar[bool] = False
    """Whether to derive before copying, so that all copies share what costs time."""

    def derived(self) -> Any:
        """What is derived from the batch: found at the first call, then kept."""
        if "_derived" not in self.__dict__:
            object.__setattr__(self, "_derived", self._derive())
        return self.__dict__["_derived"]

    def _derive(self) -> Any:
        raise NotImplementedError

    def _deriving_as(self, other: Deriving, change: Callable[[Any], Any]) -> Self:
        """Take over what another proxy has derived, changed as this one was made from that one."""
        if other.derives_first or "_derived" in other.__dict__:
            object.__setattr__(self, "_derived", change(other.derived()))
        return self

    def _mapped(self, change: Callable[[Array, int], Array]) -> Self:
        return super()._mapped(change)._deriving_as(self, lambda derived: derived.mapped(change))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent, exactly, and with it what has been derived."""
        return super().times_power(exponent)._deriving_as(self, lambda derived: derived.times_power(exponent))

    def _derive_now(self) -> None:
        """Derive, so that an empty or unbounded set is refused when it is built."""
        try:
            self.derived()
        except ShapeError as error:
            raise ShapeError(f"{type(self).__name__}: {error}") from None


@dataclass(frozen=True, eq=False, repr=False)
class Polytope(Deriving):
    """What the solids with flat faces share: corners, faces and edges, derived once and kept."""

    def derived(self) -> Derived:
        """Hulls of the batch, one for each different geometry: found at the first call, then kept."""
        found: Derived = super().derived()
        return found

    @property
    def hull(self) -> Hull:
        """Corners, outward unit planes and edges, in the polytope's own frame; see `refimpl.hulls.Hull`."""
        return self.derived().hull

    def _derive(self) -> Derived:
        raise NotImplementedError

    @property
    def vertices(self) -> Array:
        """Corners (..., m, 3), in the polytope's own frame."""
        return self.hull.vertices

    @property
    def planes(self) -> Array:
        """Faces (..., f, 4): outward unit normals and offsets, normal·x + offset ≤ 0, in the polytope's own frame."""
        return self.hull.planes
