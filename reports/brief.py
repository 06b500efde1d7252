"""Shapes and numbers in as few words as tell them apart: "a unit cube", "two spheres of radius 0.5", "0.0289"."""

from __future__ import annotations

import math

import numpy as np

from refimpl import flat
from refimpl.linear import Array
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

FEWEST, MOST = 3, 17
"""Significant digits of a number: enough to be read, and enough for any double."""

NOUNS: dict[type[Proxy], str] = {
    Point: "point",
    Ray: "ray",
    HalfSpace: "half-space",
    flat.FlatPoint: "point of the plane",
    flat.FlatRay: "ray of the plane",
}
"""Those of which all are alike."""


def digits(value: float, count: int = FEWEST) -> str:
    """So many significant digits, without those that say nothing; a plain 0 for either zero."""
    if value == 0:
        return "0"
    return f"{value:.{count}g}" if count < MOST else repr(float(value)).removesuffix(".0")


def digits_to_differ(said: float, true: float) -> int:
    """How many digits two numbers need for one to see that they differ: one more than the fewest."""
    for count in range(FEWEST, MOST):
        if digits(said, count) != digits(true, count):
            return count + 1
    return MOST


def simplest(lower: float, upper: float) -> float:
    """Return the number of an interval with the fewest digits."""
    if not (math.isfinite(lower) and math.isfinite(upper)):
        return lower
    middle = lower + (upper - lower) / 2
    for count in range(1, MOST):
        candidate = float(f"{middle:.{count}g}")
        if lower <= candidate <= upper:
            return candidate
    return middle


def in_brief(shape: Proxy) -> str:
    """Return a shape with its article: "a capsule of radius 0.25 and length 3"."""
    noun = _noun(shape)
    return f"{'an' if noun[0] in 'aeioA' else 'a'} {noun}"


def pair_in_brief(a: Proxy, b: Proxy) -> str:
    """Return two shapes: "two unit cubes", or "a sphere of radius 1 and a point"."""
    first, second = _noun(a), _noun(b)
    return f"two {_many(first)}" if first == second else f"{in_brief(a)} and {in_brief(b)}"


def _many(noun: str) -> str:
    head, of, rest = noun.partition(" of ")
    many = {"box": "boxes", "convex polyhedron": "convex polyhedra", "mesh": "meshes"}.get(head, f"{head}s")
    return many + of + rest


def _noun(shape: Proxy) -> str:
    match shape:
        case Sphere():
            size = f"sphere of radius {_size(shape.radius)}"
        case Capsule():
            size = f"capsule of radius {_size(shape.radius)} and length {_length(shape.q - shape.p)}"
        case Cylinder():
            size = f"cylinder of radius {_size(shape.radius)} and height {_length(shape.q - shape.p)}"
        case AABB():
            size = _cuboid("AABB", shape.upper - shape.lower)
        case Box():
            size = _cuboid("box", 2 * shape.half_extents)
        case Ellipsoid():
            size = f"ellipsoid of radii {', '.join(map(_size, shape.radii))}"
        case KDOP():
            size = f"KDOP of {len(shape.lower)} slabs"
        case ConvexPolyhedron():
            size = f"convex polyhedron of {len(shape.vertices)} vertices"
        case Polyhedron():
            size = f"mesh of {len(shape.triangles)} triangles"
        case Composite():
            size = f"union of {len(shape.parts)} {'part' if len(shape.parts) == 1 else 'parts'}"
        case _:
            size = _flat_noun(shape)
    return size


def _flat_noun(shape: Proxy) -> str:
    """The noun of a flat proxy, or of one of which all are alike."""
    match shape:
        case flat.Disc():
            return f"disc of radius {_size(shape.radius)}"
        case flat.Segment():
            radius = f" and radius {_size(shape.radius)}" if shape.radius > 0 else ""
            return f"segment of length {_length(shape.q - shape.p)}{radius}"
        case flat.Rectangle():
            return _cuboid("rectangle", shape.upper - shape.lower)
        case flat.ConvexPolygon():
            return f"convex polygon of {len(shape.outline.corners)} corners"
        case _:
            return NOUNS.get(type(shape), type(shape).__name__)


def _cuboid(name: str, extents: Array) -> str:
    if np.all(extents == 1.0):
        return "unit cube" if name == "box" else f"{name} of side 1"
    if np.all(extents == extents[0]):
        return f"{name} of side {_size(extents[0])}"
    return f"{name} of {' × '.join(map(_size, extents))}"


def _size(value: Array | float) -> str:
    return digits(float(value))


def _length(between: Array) -> str:
    return digits(float(math.hypot(*map(float, between))))
