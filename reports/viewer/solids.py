"""Proxies as things that can be drawn: bodies of revolution, meshes, planes, lines and dots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from refimpl.linear import Array, apply, norm, perpendicular, rotation_matrix
from refimpl.proxy import Proxy
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
    Ray,
    Sphere,
)
from refimpl.shapes.polytope import Polytope
from reports.viewer.meshes import Face, few_corners, few_triangles, polygons

MOST_PARTS = 24
"""Parts of a composite that are drawn, the largest first."""

MOST_TRIANGLES, FEWEST = 128, 16
"""Triangles of a shape that are drawn, and that any part of it may have."""


@dataclass(frozen=True)
class Lathe:
    """A body of revolution: the image of a ball, rod or can by an affine map.

    Attributes
    ----------
    kind : {"ball", "rod", "can"}
        A unit ball; one swept from −half to +half along z; a unit disc swept from −1 to 1.
    center : (3,)
    axes : (3, 3)
        Images of x, y and z, in rows; at right angles.
    half
        Of a rod: half of its axis, in units of its radius.
    """

    kind: str
    center: Array
    axes: Array
    half: float = 0.0

    def reach(self, n: Array) -> float:
        """How far it extends from its centre along the direction n."""
        along = self.axes @ n
        if self.kind == "can":
            return float(np.hypot(along[0], along[1]) + abs(along[2]))
        return float(norm(along) + self.half * abs(along[2]))

    def corners(self) -> Array:
        """Corners of its bounding box."""
        reach = np.array([self.reach(axis) for axis in np.eye(3)])
        return np.stack([self.center - reach, self.center + reach])


@dataclass(frozen=True)
class Mesh:
    """Flat faces.

    Attributes
    ----------
    vertices : (m, 3)
    faces
        Numbers of each face's corners, anticlockwise seen from outside.
    told
        Where it is drawn with fewer: what of how many, in words.
    """

    vertices: Array
    faces: tuple[Face, ...]
    told: str = ""

    def corners(self) -> Array:
        """Its vertices."""
        return self.vertices


@dataclass(frozen=True)
class Plane:
    """A half-space's plane; the solid lies behind it."""

    foot: Array
    normal: Array

    def corners(self) -> Array:
        """None: it has no end."""
        return np.empty((0, 3))


@dataclass(frozen=True)
class Line:
    """A segment, or a ray that goes on for ever."""

    start: Array
    end: Array
    endless: bool = False

    def corners(self) -> Array:
        """Its ends, of a ray only the first."""
        return self.start[None] if self.endless else np.stack([self.start, self.end])


@dataclass(frozen=True)
class Dot:
    """A point, or what is too small to be seen."""

    at: Array

    def corners(self) -> Array:
        """Itself."""
        return self.at[None]


Solid = Lathe | Mesh | Plane | Line | Dot

BEYOND_DRAWING = "reaches beyond what can be drawn"


def is_finite(part: Solid) -> bool:
    """Whether every number of a part is finite."""
    values = [value for value in vars(part).values() if isinstance(value, np.ndarray | float)]
    return all(np.isfinite(value).all() for value in values)


def solids(
    shape: Proxy, exponent: int, *, triangles: int = MOST_TRIANGLES, most: int = MOST_PARTS
) -> tuple[list[Solid], list[str]]:
    """What a proxy is drawn as, with all lengths times 2^−exponent; and what of it is left out, in words.

    Parameters
    ----------
    triangles, most
        How many triangles and parts are drawn.
    """
    parts = [part for part in _solids(shape, exponent, triangles) if is_finite(part)]
    told = [part.told for part in parts if isinstance(part, Mesh) and part.told][:2]
    if len(parts) <= most:
        return parts, told
    return _largest(parts, most), [f"{most} of {len(parts)} parts", *told]


def _solids(shape: Proxy, exponent: int, most: int) -> Iterator[Solid]:
    def scaled(lengths: Array) -> Array:
        return np.asarray(np.ldexp(lengths, -exponent))

    match shape:
        case Point():
            yield Dot(scaled(shape.position))
        case Ray():
            origin = scaled(shape.origin)
            yield Line(origin, origin + shape.direction / norm(shape.direction), endless=True)
        case HalfSpace():
            yield Plane(scaled(shape.reference_point), shape.normal / norm(shape.normal))
        case Sphere():
            yield Lathe("ball", scaled(shape.center), scaled(shape.radius) * np.eye(3))
        case Ellipsoid():
            columns = rotation_matrix(shape.rotation).T
            yield Lathe("ball", scaled(shape.center), scaled(shape.radii)[:, None] * columns)
        case Capsule() | Cylinder():
            yield _turned(
                "rod" if isinstance(shape, Capsule) else "can", *map(scaled, (shape.p, shape.q, shape.radius))
            )
        case Composite():
            share = max(FEWEST, most // len(shape.parts))
            yield from (solid for part in shape.parts for solid in _solids(part, exponent, share))
        case Polyhedron():
            yield few_triangles_of(shape, exponent, most)
        case _:
            assert isinstance(shape, Polytope)
            yield polytope(shape, exponent, most)


def _turned(kind: str, p: Array, q: Array, radius: Array) -> Solid:
    """Rod or can from p to q."""
    length = float(norm(q - p))
    if not length > 0:
        return Lathe("ball", p, radius * np.eye(3)) if radius > 0 else Dot(p)
    if radius <= length * np.finfo(np.float64).tiny:
        return Line(p, q)
    axis = (q - p) / length
    across = perpendicular(axis)
    frame = np.stack([across, np.cross(axis, across), axis])
    if kind == "rod":
        return Lathe(kind, p / 2 + q / 2, radius * frame, length / 2 / float(radius))
    return Lathe(kind, p / 2 + q / 2, np.array([radius, radius, length / 2])[:, None] * frame)


def polytope(shape: Polytope, exponent: int, most: int) -> Mesh:
    """Faces of a polytope; one with very many corners is drawn as the hull of some of them."""
    told = ""
    if isinstance(shape, ConvexPolyhedron):
        fewer = few_corners(shape.numbers if shape.given == "vertices" else shape.hull.vertices, most // 2)
        if fewer is not None:
            corners, count = fewer
            told = f"the hull of {len(corners)} of {count} corners"
            shape = ConvexPolyhedron.from_vertices(corners, shape.position, shape.rotation)
    vertices, faces = polygons(shape.hull)
    return Mesh(_placed(shape, vertices, exponent), faces, told)


def few_triangles_of(shape: Polyhedron, exponent: int, most: int) -> Mesh:
    """Triangles of a mesh, or fewer that are like it."""
    vertices, faces = few_triangles(shape.vertices, shape.triangles, most)
    told = "" if len(faces) == len(shape.triangles) else f"{len(faces)} of {len(shape.triangles)} triangles"
    return Mesh(_placed(shape, vertices, exponent), faces, told)


def _placed(shape: Proxy, vertices: Array, exponent: int) -> Array:
    """Vertices in the world, from those in the shape's own frame."""
    scaled = np.ldexp(vertices, -exponent)
    match shape:
        case AABB() | KDOP():
            return np.asarray(scaled)
        case Box():
            position = shape.center
        case ConvexPolyhedron() | Polyhedron():
            position = shape.position
        case _:
            raise TypeError(f"a {type(shape).__name__} has no frame of its own")
    return np.asarray(apply(rotation_matrix(shape.rotation), scaled) + np.ldexp(position, -exponent))


def _largest(parts: list[Solid], most: int) -> list[Solid]:
    """The largest of many parts, in their own order."""
    sizes = [float(np.ptp(part.corners(), axis=0).max()) if len(part.corners()) else np.inf for part in parts]
    chosen = sorted(range(len(parts)), key=lambda i: (-sizes[i], i))[:most]
    return [parts[i] for i in sorted(chosen)]
