"""Images of proxies under maps that can be told exactly: turned and mirrored, moved, refined, written otherwise.

A map that permutes the axes, with signs, is exact for every type: a frame is turned with its contents, so that only
numbers change places. Moving rounds, and says by how much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.flat_images import FLAT_REWRITE, FLAT_TURN
from oracles.world import world_of
from refimpl.flat import ConvexPolygon, Rectangle, Segment
from refimpl.linear import Array, Bools, dot, norm
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

ROUND = 2.0**-53
"""Relative error of one rounding."""


@dataclass(frozen=True)
class Axes:
    """The isometry that gives coordinate i of the image the sign `signs[i]` and the place of coordinate `order[i]`."""

    order: tuple[int, int, int]
    signs: tuple[float, float, float]

    @property
    def keeps_the_plane(self) -> bool:
        """Whether what is flat stays so."""
        return self.order[2] == 2

    @property
    def parity(self) -> float:
        """1 of a rotation, −1 of a reflection."""
        swaps = sum(self.order[i] > self.order[j] for i in range(3) for j in range(i + 1, 3))
        return float((-1) ** swaps * np.prod(self.signs))

    @property
    def inverse(self) -> Axes:
        """The isometry that takes the image back."""
        order = (self.order.index(0), self.order.index(1), self.order.index(2))
        return Axes(order, (self.signs[order[0]], self.signs[order[1]], self.signs[order[2]]))

    def places(self, v: Array) -> Array:
        """Vectors (..., 3) that have signs, such as positions and velocities; of the plane (..., 2)."""
        axes = v.shape[-1]
        return np.asarray(v[..., self.order[:axes]] * np.array(self.signs[:axes]) + 0.0)

    def spins(self, v: Array) -> Array:
        """Vectors (..., 3) of rotation, whose sign a reflection turns."""
        return np.asarray(self.parity * self.places(v) + 0.0)

    def sizes(self, v: Array) -> Array:
        """Extents (..., 3) along the axes."""
        return np.asarray(v[..., self.order])

    def frames(self, q: Array) -> Array:
        """Quaternions (..., 4) of frames whose contents are mapped, too."""
        return np.concatenate([self.spins(q[..., :3]), q[..., 3:]], axis=-1)

    def tensors(self, m: Array) -> Array:
        """Symmetric matrices (..., 3, 3)."""
        signs = np.array(self.signs)
        return np.asarray(m[..., self.order, :][..., :, self.order] * signs[:, None] * signs + 0.0)

    def __call__(self, shape: Proxy) -> Proxy:
        """Give the image of a proxy."""
        return _TURN[type(shape)](self, shape)

    def _aabb(self, box: AABB) -> Proxy:
        ends = self.places(box.lower), self.places(box.upper)
        return AABB(np.minimum(*ends), np.maximum(*ends))

    def _hull(self, hull: ConvexPolyhedron) -> Proxy:
        pose = self.places(hull.position), self.frames(hull.rotation)
        if hull.given == "vertices":
            return ConvexPolyhedron.from_vertices(self.places(hull.numbers), *pose)
        planes = np.concatenate([self.places(hull.numbers[..., :3]), hull.numbers[..., 3:]], axis=-1)
        return ConvexPolyhedron(planes, *pose)

    def _solid(self, mesh: Polyhedron) -> Proxy:
        triangles = mesh.triangles if self.parity > 0 else mesh.triangles[:, ::-1]
        return Polyhedron(self.places(mesh.vertices), triangles, self.places(mesh.position), self.frames(mesh.rotation))


_TURN: dict[type[Proxy], Callable[[Axes, Any], Proxy]] = {
    Point: lambda m, s: Point(m.places(s.position)),
    Ray: lambda m, s: Ray(m.places(s.origin), m.places(s.direction)),
    Sphere: lambda m, s: Sphere(m.places(s.center), s.radius),
    Capsule: lambda m, s: Capsule(m.places(s.p), m.places(s.q), s.radius),
    HalfSpace: lambda m, s: HalfSpace(m.places(s.normal), s.k),
    AABB: Axes._aabb,
    Box: lambda m, s: Box(m.places(s.center), m.sizes(s.half_extents), m.frames(s.rotation)),
    KDOP: lambda m, s: KDOP(m.places(s.directions), s.lower, s.upper),
    Ellipsoid: lambda m, s: Ellipsoid(m.places(s.center), m.sizes(s.radii), m.frames(s.rotation)),
    Cylinder: lambda m, s: Cylinder(m.places(s.p), m.places(s.q), s.radius),
    ConvexPolyhedron: Axes._hull,
    Polyhedron: Axes._solid,
    Composite: lambda m, s: Composite([m(part) for part in s.parts]),
    **FLAT_TURN,
}

TURNED = Axes((1, 2, 0), (1.0, 1.0, 1.0))
QUARTER = Axes((1, 0, 2), (-1.0, 1.0, 1.0))
MIRRORED = Axes((0, 1, 2), (-1.0, 1.0, 1.0))


# -- moving --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Moved:
    """Proxies moved by vectors, as far as doubles allow.

    Attributes
    ----------
    error : (n,)
        No point of the image is farther than this from where it should be; infinite where that is not known.
    """

    shape: Proxy
    error: Array


def sum_error(x: Array, y: Array) -> Array:
    """What rounding took from x + y, exactly (Knuth 1969)."""
    total = x + y
    part = total - x
    return np.asarray((x - (total - part)) + (y - part))


def moved(shape: Proxy, offset: Array) -> Moved:
    """Move proxies by `offset` (n, 3), of the plane by what of it is there.

    Where a cylinder would lose its axis, it stays, with an infinite error.
    """
    offset = world_of(shape).vectors(offset)
    if isinstance(shape, Composite):
        parts = [moved(part, offset) for part in shape.parts]
        return Moved(Composite([p.shape for p in parts]), np.max([p.error for p in parts], axis=0))
    if isinstance(shape, Cylinder):
        return _moved_cylinder(shape, offset)
    if isinstance(shape, HalfSpace):
        terms = np.abs(shape.k) + dot(np.abs(shape.normal), np.abs(offset))
        return Moved(shape.translated(offset), 4 * ROUND * terms / norm(shape.normal))
    if isinstance(shape, KDOP):
        return _moved_slabs(shape, offset)
    if isinstance(shape, ConvexPolygon):
        return _moved_lines(shape, offset) if shape.given == "lines" else _moved_vertices(shape, offset)
    names = next((names for types, names in PLACED_BY.items() if isinstance(shape, types)), ("center",))
    errors = [np.abs(sum_error(getattr(shape, name), offset)) for name in names]
    return Moved(shape.translated(offset), norm(np.max(errors, axis=0)))


PLACED_BY: dict[tuple[type[Proxy], ...], tuple[str, ...]] = {
    (AABB, Rectangle): ("lower", "upper"),
    (Capsule, Segment): ("p", "q"),
    (Point, ConvexPolyhedron, Polyhedron): ("position",),
    (Ray,): ("origin",),
}
"""Places among the numbers of a proxy; of all others the centre."""


def _moved_vertices(shape: ConvexPolygon, offset: Array) -> Moved:
    """Each vertex is rounded by itself, and the hull by no more."""
    return Moved(shape.translated(offset), norm(sum_error(shape.numbers, offset[:, None, :])).max(axis=-1))


def _moved_cylinder(shape: Cylinder, offset: Array) -> Moved:
    """Rounding the ends of an axis turns its discs."""
    stays = np.all(shape.p + offset == shape.q + offset, axis=-1)
    offset = np.where(stays[:, None], 0.0, offset)
    ends = norm(sum_error(shape.p, offset)), norm(sum_error(shape.q, offset))
    image = shape.translated(offset)
    length = np.minimum(norm(shape.q - shape.p), norm(image.q - image.p))
    error = np.maximum(*ends) + 2 * shape.radius * (ends[0] + ends[1]) / length
    return Moved(image, np.where(stays, np.inf, error))


def _moved_slabs(shape: KDOP, offset: Array) -> Moved:
    """Slabs meet in corners that rounding may take anywhere: only exact sums count."""
    shift = dot(shape.directions, offset[:, None, :])
    lost = np.abs(sum_error(shape.lower, shift)) + np.abs(sum_error(shape.upper, shift))
    image = KDOP(shape.directions, shape.lower + shift, np.maximum(shape.lower + shift, shape.upper + shift))
    exact = _by_a_power(offset) & (lost.max(axis=-1) == 0)
    return Moved(image, np.where(exact, 0.0, np.inf))


def has_slabs(shape: Proxy) -> bool:
    """Whether corners of it, or of a part, are where planes or lines meet."""
    if isinstance(shape, Composite):
        return any(map(has_slabs, shape.parts))
    return isinstance(shape, KDOP) or (isinstance(shape, ConvexPolygon) and shape.given == "lines")


def _moved_lines(shape: ConvexPolygon, offset: Array) -> Moved:
    """As slabs; those that would be rounded stay, with an infinite error, as nothing might be left of them."""
    shift = dot(shape.numbers[..., :2], offset[:, None, :])
    lost = np.abs(sum_error(shape.numbers[..., 2], -shift)).max(axis=-1)
    exact = _by_a_power(offset) & (lost == 0)
    image = shape.translated(np.where(exact[:, None], offset, 0.0))
    return Moved(image, np.where(exact, 0.0, np.inf))


def _by_a_power(offset: Array) -> Bools:
    """Whether a move is along an axis, by a power of two: products with it are exact."""
    one = np.count_nonzero(offset, axis=-1) <= 1
    return np.asarray(one & np.all(np.abs(np.frexp(offset)[0]) * (offset != 0) % 0.5 == 0, axis=-1))


# -- the same set in other numbers -----------------------------------------------------------------------------


def rewritten(shape: Proxy) -> Proxy | None:
    """The very same set written otherwise: ends, vertices or parts in another order, normals and quaternions longer."""
    change = _REWRITE.get(type(shape))
    return change(shape) if change else None


def _reversed(hull: ConvexPolyhedron) -> Proxy:
    numbers = hull.numbers[..., ::-1, :] * (np.array([2.0, 2.0, 2.0, 2.0]) if hull.given == "planes" else 1.0)
    return hull._validated(numbers, hull.position, -2.0 * hull.rotation)


def _renumbered(mesh: Polyhedron) -> Proxy:
    """Vertices in reverse order, triangles too, each beginning with another corner."""
    last = len(mesh.vertices) - 1
    triangles = last - mesh.triangles[::-1][:, [1, 2, 0]]
    return Polyhedron(mesh.vertices[::-1], triangles, mesh.position, -2.0 * mesh.rotation)


_REWRITE: dict[type[Proxy], Callable[[Any], Proxy]] = {
    Capsule: lambda s: Capsule(s.q, s.p, s.radius),
    Cylinder: lambda s: Cylinder(s.q, s.p, s.radius),
    HalfSpace: lambda s: HalfSpace(2.0 * s.normal, 2.0 * s.k),
    Box: lambda s: Box(s.center, s.half_extents, -2.0 * s.rotation),
    Ellipsoid: lambda s: Ellipsoid(s.center, s.radii, -2.0 * s.rotation),
    KDOP: lambda s: KDOP(-2.0 * s.directions[..., ::-1, :], -2.0 * s.upper[..., ::-1], -2.0 * s.lower[..., ::-1]),
    ConvexPolyhedron: _reversed,
    Polyhedron: _renumbered,
    Composite: lambda s: Composite([rewritten(part) or part for part in s.parts[::-1]]),
    **FLAT_REWRITE,
}
