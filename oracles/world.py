"""Worlds: space, where most proxies are, and the plane, where the flat ones are; what judging needs of each.

An engine's answer has vectors of three numbers in either world; those of the plane end with 0, and are judged without.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from refimpl import flat
from refimpl.flat.pairs import PROBES as FLAT_PROBES
from refimpl.flat.pairs import SOLIDS as FLAT_SOLIDS
from refimpl.linear import Array, dot, norm, scale
from refimpl.pairs import PROBES, SOLIDS, TABLE, Rule
from refimpl.shapes import Capsule, HalfSpace, Point, Proxy, Ray

if TYPE_CHECKING:
    from oracles.engine import Answers

Kind = type[Proxy]
VECTORS = ("on_a", "on_b", "normal", "point")
"""Columns of an answer that are places or directions."""


@dataclass(frozen=True, eq=False)
class World:
    """A world: its types, and what the reference says in it.

    Attributes
    ----------
    axes
        Numbers of a vector.
    table
        Pairs of types.
    probes, solids
        Types, in the order of the table.
    point, ray
        The types of these names.
    rounded : (p, q, radius) → proxy
        Everything within `radius` of a segment; where its ends are one, a ball or disc, or a point.
    beyond : (at, outward, half) → proxy
        What lies on the side of the plane or line through `at` to which `outward` points: all of it, or a cube or
        square of half the side `half`, which stands on `at`.
    """

    axes: int
    table: Mapping[tuple[Kind, Kind], Rule]
    probes: tuple[Kind, ...]
    solids: tuple[Kind, ...]
    point: Callable[[Array], Proxy]
    ray: Callable[[Array, Array], Proxy]
    rounded: Callable[[Array, Array, Array], Proxy]
    beyond: Callable[[Array, Array, Array], Proxy]

    @property
    def up(self) -> Array:
        """Some direction."""
        return np.asarray(np.eye(self.axes)[-1])

    def vectors(self, vectors: Array) -> Array:
        """Vectors of space as such of this world."""
        return vectors[..., : self.axes]

    def level(self, vectors: Array) -> Array:
        """What of vectors of space lies in this world, with three numbers."""
        return self.fill(self.vectors(vectors))

    def cut(self, answers: Answers) -> Answers:
        """Answers with the vectors of this world; one that leaves the plane has no end, which none has."""
        if self.axes == SPACE.axes:
            return answers
        found: dict[str, Any] = {}
        for name in VECTORS:
            column = getattr(answers, name)
            rest = column[:, self.axes :]
            whole = np.where(np.isnan(rest), np.nan, column[:, : self.axes])
            found[name] = np.where((rest != 0) & ~np.isnan(rest), np.inf, whole)
        return replace(answers, **found)

    def fill(self, vectors: NDArray[Any]) -> Array:
        """Vectors of this world with the three numbers that an answer has."""
        zeros = np.where(np.isnan(vectors[..., :1]), np.nan, 0.0)
        return np.concatenate([vectors, *[zeros] * (SPACE.axes - self.axes)], axis=-1)


def _all_beyond(at: Array, outward: Array, half: Array) -> HalfSpace:
    """All that lies on that side."""
    del half
    return HalfSpace(-outward, dot(outward, at))


def _square(at: Array, outward: Array, half: Array) -> flat.ConvexPolygon:
    """Squares that stand on the line: flat sets have an end."""
    up = scale(half / norm(outward), outward)
    along = np.stack([-up[:, 1], up[:, 0]], axis=-1)
    corners = at - along, at + along, at + along + 2.0 * up, at - along + 2.0 * up
    return flat.ConvexPolygon.from_vertices(np.stack(corners, axis=1))


SPACE = World(3, TABLE, PROBES, SOLIDS, Point, Ray, Capsule, _all_beyond)
PLANE = World(2, flat.table(), FLAT_PROBES, FLAT_SOLIDS, flat.FlatPoint, flat.FlatRay, flat.Segment, _square)
WORLDS = (SPACE, PLANE)


def world_of(shape: Proxy | Kind) -> World:
    """The world of a proxy or of a type."""
    kind = shape if isinstance(shape, type) else type(shape)
    return PLANE if issubclass(kind, flat.Flat) else SPACE


def is_flat(shape: Proxy | Kind) -> bool:
    """Whether a proxy or type is of the plane."""
    return world_of(shape) is PLANE
