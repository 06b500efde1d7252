"""Images of proxies under maps that can be told exactly: turned and mirrored, moved, refined, written otherwise.

A map that permutes the axes, with signs, is exact for every type: a frame is turned with its contents, so that only
numbers change places. Moving rounds, and says by how much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.linear import Array, dot, norm
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
        """Vectors (..., 3) that have signs, such as positions and velocities."""
        return np.asarray(v[..., self.order] * np.array(self.signs) + 0.0)

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
    """Move proxies by `offset` (n, 3); where a cylinder would lose its axis, it stays, with an infinite error."""
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
    fields = {AABB: ("lower", "upper"), Capsule: ("p", "q"), Point: ("position",), Ray: ("origin",)}
    placed = (ConvexPolyhedron, Polyhedron)
    names = fields.get(type(shape), ("position",) if isinstance(shape, placed) else ("center",))
    errors = [np.abs(sum_error(getattr(shape, name), offset)) for name in names]
    return Moved(shape.translated(offset), norm(np.max(errors, axis=0)))


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
    one = np.count_nonzero(offset, axis=-1) <= 1
    powers = np.all(np.abs(np.frexp(offset)[0]) * (offset != 0) % 0.5 == 0, axis=-1)
    shift = dot(shape.directions, offset[:, None, :])
    lost = np.abs(sum_error(shape.lower, shift)) + np.abs(sum_error(shape.upper, shift))
    image = KDOP(shape.directions, shape.lower + shift, np.maximum(shape.lower + shift, shape.upper + shift))
    exact = one & powers & (lost.max(axis=-1) == 0)
    return Moved(image, np.where(exact, 0.0, np.inf))


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
}


# -- finer meshes ----------------------------------------------------------------------------------------------

MOST_REFINED = 400
"""Triangles of the largest mesh that is refined."""


@dataclass(frozen=True)
class Refinement:
    """A mesh with more triangles and the same surface.

    Attributes
    ----------
    vertices, triangles
        Of the finer mesh.
    sources
        Number of the triangle from which each one comes.
    """

    vertices: Array
    triangles: list[tuple[int, int, int]]
    sources: list[int]


def refinement(vertices: Array, triangles: Any) -> Refinement | None:
    """Cut triangles at those middles of their edges that doubles can hold; None where they can hold none."""
    points, middles = [*vertices], {}
    edges = {(min(e), max(e)) for t in triangles.tolist() for e in zip(t, (*t[1:], t[0]), strict=True)}
    for a, b in sorted(edges):
        total = vertices[a] + vertices[b]
        if np.all(sum_error(vertices[a], vertices[b]) == 0) and np.all(2 * (total / 2) == total):
            middles[a, b] = len(points)
            points.append(total / 2)
    if not middles or len(triangles) > MOST_REFINED:
        return None
    found: list[tuple[int, int, int]] = []
    sources: list[int] = []
    for number, corners in enumerate(triangles.tolist()):
        pieces = list(_cut(corners, middles))
        found += pieces
        sources += [number] * len(pieces)
    return Refinement(np.array(points), found, sources)


def _cut(corners: list[int], middles: dict[tuple[int, int], int]) -> list[tuple[int, int, int]]:
    """Triangles of one triangle, whose outline has a corner more for each middle."""
    for turn in range(3):
        a, b, c = corners[turn:] + corners[:turn]
        ab, bc, ca = (middles.get((min(e), max(e))) for e in ((a, b), (b, c), (c, a)))
        if ab is not None and bc is not None and ca is not None:
            return [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        if ab is not None and bc is not None:
            return [(ab, b, bc), (a, ab, bc), (a, bc, c)]
        if ab is not None and ca is None:
            return [(a, ab, c), (ab, b, c)]
    return [(corners[0], corners[1], corners[2])]


def refined(mesh: Polyhedron) -> tuple[Polyhedron, Refinement] | None:
    """The same solid with a finer surface, where there is one."""
    finer = refinement(mesh.vertices, mesh.triangles)
    if finer is None:
        return None
    return Polyhedron(finer.vertices, finer.triangles, mesh.position, mesh.rotation), finer


def refined_surface(surface: Composite, finer: Refinement) -> Composite | None:
    """What an engine takes for the solid, the union of its triangles, cut as the mesh was."""
    first = surface.parts[0]
    if len(surface.parts) != max(finer.sources) + 1 or not isinstance(first, ConvexPolyhedron):
        return None
    corners = [finer.vertices[list(triangle)] for triangle in finer.triangles]
    return Composite([ConvexPolyhedron.from_vertices(c, first.position, first.rotation) for c in corners])
