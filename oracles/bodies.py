"""Bodies: proxies in the making, of no type yet, and what each type makes of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oracles import solids
from oracles.draws import Draws, quaternions
from oracles.flat_bodies import flat_proxy
from oracles.world import is_flat
from refimpl.linear import Array, apply, dot, rotation_matrix, scale
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Polyhedron,
    Proxy,
    Ray,
    Sphere,
)

Z_AXIS = np.array([0.0, 0.0, 1.0])
IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
QUARTER_TURNS = np.array(
    [
        [0, 0, 0, 1],
        [1, 0, 0, 1],
        [0, 1, 0, 1],
        [0, 0, 1, 1],
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [0, 0, 1, 0],
        [1, 1, 1, 1],
    ],
    dtype=np.float64,
)
ROUND_SIZES = (1.0, 0.5, 2.0, 1.5, 0.25)
ROUND_PLACES = (0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0)

ROUNDING = 1e-14
"""Slabs that are not along an axis are wider by this part of their place: a flat body would round out of them."""

KITS: tuple[tuple[type[Proxy], ...], ...] = (
    (Box, Sphere),
    (Box, Box, Capsule),
    (ConvexPolyhedron, Cylinder),
    (Capsule, Cylinder, Box, Sphere),
)
"""Types of a composite's parts, all of them such as both engines hold."""


@dataclass(frozen=True)
class Body:
    """A proxy in the making, of no type yet: place, half extents, rotation, and how far back a ray starts.

    Attributes
    ----------
    draws
        Where the numbers come from that only some types need: directions, vertices, the choice of parts.
    even
        Whether those are round numbers.
    """

    place: Array
    extents: Array
    rotation: Array
    back: Array
    length: Array
    draws: Draws
    even: bool = False

    def make(self, kind: type[Proxy]) -> Proxy:
        """Build a proxy of this type with this body's place, size and pose; its axis is the body's z axis."""
        if is_flat(kind):
            return flat_proxy(self, kind)
        made: dict[type[Proxy], Callable[[], Proxy]] = {
            Point: lambda: Point(self.place),
            Ray: lambda: Ray(self.place - scale(self.back, self._reach), scale(self.length, self._reach)),
            Sphere: lambda: Sphere(self.place, self.extents[:, 0]),
            Capsule: lambda: Capsule(self.place - self._reach, self.place + self._reach, self.extents[:, 0]),
            HalfSpace: lambda: HalfSpace(scale(self.length, self._axis), -self.length * dot(self._axis, self.place)),
            AABB: lambda: AABB(self.place - self.extents, self.place + self.extents),
            Box: lambda: Box(self.place, self.extents, self.rotation),
            KDOP: self._kdop,
            Ellipsoid: lambda: Ellipsoid(self.place, self.extents, self.rotation),
            Cylinder: lambda: Cylinder(self.place - self._reach, self.place + self._reach, self.extents[:, 0]),
            ConvexPolyhedron: self._hull,
            Polyhedron: self._solid,
            Composite: self._composite,
        }
        return made[kind]()

    @property
    def _axis(self) -> Array:
        return apply(rotation_matrix(self.rotation), np.broadcast_to(Z_AXIS, self.place.shape))

    @property
    def _reach(self) -> Array:
        return scale(self.extents[:, 2], self._axis)

    def _kdop(self) -> KDOP:
        """Slabs as wide as the box of the same extents, or narrower where they are not along an axis."""
        directions = solids.slab_directions(self.draws, self.even)
        odd = directions.shape[1] - 3
        wide, left = _width(directions, self.extents), np.ones((self.draws.n, 2, odd + 3))
        drawn = self.draws.choice((0.75, 0.5, 1.0), 2 * odd or 1) if self.even else None
        drawn = self.draws.uniform(0.4, 1.0, 2 * odd or 1) if drawn is None else drawn
        left[:, :, 3:] = drawn.reshape(self.draws.n, 2, -1)[:, :, :odd] if odd else 1.0
        middle = dot(directions, self.place[:, None, :])
        wide[:, 3:] += ROUNDING * dot(np.abs(directions), np.abs(self.place[:, None, :]))[:, 3:]  # or some are empty
        return KDOP(directions, middle - left[:, 0] * wide, middle + left[:, 1] * wide)

    def _hull(self) -> ConvexPolyhedron:
        """A hull of vertices, or a box of which planes cut off corners."""
        if solids.pick(self.draws, (1.0, 0.0)):
            vertices = solids.hull_vertices(self.draws, self.even) * self.extents[:, None, :]
            return ConvexPolyhedron.from_vertices(vertices, self.place, self.rotation)
        normals, left = solids.cuts(self.draws, self.even)
        sides = np.broadcast_to(np.concatenate([solids.AXES, -solids.AXES]), (self.draws.n, 6, 3))
        normals = np.concatenate([sides, normals], axis=1)
        offsets = _width(normals, self.extents) * np.concatenate([np.ones((self.draws.n, 6)), left], axis=1)
        return ConvexPolyhedron(np.concatenate([normals, -offsets[:, :, None]], axis=-1), self.place, self.rotation)

    def _solid(self) -> Polyhedron:
        """A mesh, of the first body's extents: the bodies of a batch share it, and stand in poses of their own."""
        vertices, triangles = solids.mesh(self.draws, self.even)
        return Polyhedron(vertices * self.extents[0], triangles, self.place, self.rotation)

    def _composite(self) -> Composite:
        """Parts of half the size, aside of the place; some stand turned."""
        kit = KITS[int(solids.pick(self.draws, range(len(KITS))))]
        parts = []
        for i, part in enumerate(kit):
            aside = self.draws.choice((0.0, 0.5, -0.5, 1.0), 3) if self.even else self.draws.uniform(-0.7, 0.7, 3)
            offset = apply(rotation_matrix(self.rotation), aside * self.extents)
            turn = self.rotation if self.even or i % 2 == 0 else quaternions(self.draws)
            piece = replace(self, place=self.place + offset, extents=self.extents * 0.5, rotation=turn)
            parts.append(piece.make(part))
        return Composite(parts)


def _width(directions: Array, extents: Array) -> Array:
    """Half the width of boxes of these half extents along each of their directions (n, k, 3)."""
    return dot(np.abs(directions), extents[:, None, :])


def random_body(draws: Draws, spread: float = 2.0) -> Body:
    """Any place, size and pose at the middle scale."""
    return Body(
        place=draws.uniform(-spread, spread, 3),
        extents=draws.uniform(0.2, 1.5, 3),
        rotation=quaternions(draws),
        back=draws.uniform(0.0, 6.0),
        length=draws.uniform(0.25, 4.0),
        draws=draws,
    )


def round_body(draws: Draws) -> Body:
    """Round numbers and quarter turns."""
    return Body(
        place=draws.choice(ROUND_PLACES, 3),
        extents=draws.choice(ROUND_SIZES, 3),
        rotation=QUARTER_TURNS[draws.choice(range(len(QUARTER_TURNS))).astype(int)],
        back=draws.choice((0.0, 1.0, 2.0, 4.0, 6.0)),
        length=draws.choice((1.0, 2.0, 0.5)),
        draws=draws,
        even=True,
    )
