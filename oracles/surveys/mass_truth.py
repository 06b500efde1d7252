"""Mass properties in rationals: exact for polytopes and meshes; of round solids good to 50 digits, for π and roots.

Moments about the origin, ∫ 1, ∫ x and ∫ x xᵀ, of solids of density 1 add up, so that unions of parts that have nothing
in common are sums, and nothing cancels, wherever they stand.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from oracles.scene import TYPES
from refimpl.hulls import Hull
from refimpl.integrals import outer, surface_integrals, surface_of
from refimpl.proof.points import root, turned
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    Composite,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    Polyhedron,
    Proxy,
    Sphere,
)

PI = Fraction(314159265358979323846264338327950288419716939937510582097494459, 10**62)
"""Good to 62 digits."""
BITS = 200
"""Of a square root."""

Exact = Any
"""An array of fractions."""


@dataclass(frozen=True)
class Truth:
    """Of a solid of density 1, in fractions.

    Attributes
    ----------
    volume : Fraction
    first : (3,)
        Integral of x.
    second : (3, 3)
        Integral of x xᵀ, about the origin.
    """

    volume: Fraction
    first: Exact
    second: Exact

    @property
    def barycentre(self) -> Exact:
        """Where the mass is balanced (3,)."""
        return self.first / self.volume

    @property
    def central(self) -> Exact:
        """Integral of r rᵀ about the barycentre (3, 3)."""
        return self.second - outer(self.first) / self.volume

    @property
    def inertia(self) -> Exact:
        """Tensor about the barycentre, ∫ (|r|² 1 − r rᵀ) (3, 3)."""
        central = self.central
        return (central[0, 0] + central[1, 1] + central[2, 2]) * _eye() - central

    def __add__(self, other: Truth) -> Truth:
        return Truth(self.volume + other.volume, self.first + other.first, self.second + other.second)


def truth(shape: Proxy) -> Truth:
    """Exact moments of a single bounded solid that has a volume; raises `ValueError` for anything else."""
    if type(shape) not in RULES or shape.batch_shape:
        raise ValueError(f"no exact mass properties of a {type(shape).__name__}")
    return _found(type(shape).__name__, shape.pack().tobytes())


@lru_cache(maxsize=512)
def _found(name: str, content: bytes) -> Truth:
    """The same, remembered: every engine's answers are held against it."""
    kind = TYPES[name]
    found = RULES[kind](kind.unpack(np.frombuffer(content)))
    if found.volume <= 0:
        raise ValueError(f"the {name} has no volume")
    return found


def _eye() -> Exact:
    return np.array([[Fraction(i == j) for j in range(3)] for i in range(3)], dtype=object)


def _exact(array: Any) -> Exact:
    """Doubles as fractions, in an array of the same shape."""
    numbers = np.asarray(array, dtype=np.float64)
    found = np.array([Fraction(x) for x in numbers.ravel().tolist()], dtype=object)
    return found.reshape(numbers.shape)


def _about(volume: Fraction, center: Exact, central: Exact) -> Truth:
    return Truth(volume, volume * center, central + volume * outer(center))


def _frame(rotation: Any) -> Exact:
    """Rotation matrix; exact, for a quaternion's is rational."""
    return np.array(turned(rotation), dtype=object).T


def _sphere(s: Sphere) -> Truth:
    radius = Fraction(float(s.radius))
    volume = PI * radius**3 * Fraction(4, 3)
    return _about(volume, _exact(s.center), volume * radius**2 / 5 * _eye())


def _in_frame(volume: Fraction, squares: Exact, rotation: Any) -> Exact:
    axes = _frame(rotation)
    return volume * sum(squares[i] * outer(axes[:, i]) for i in range(3))


def _ellipsoid(e: Ellipsoid) -> Truth:
    radii = _exact(e.radii)
    volume = PI * radii[0] * radii[1] * radii[2] * Fraction(4, 3)
    return _about(volume, _exact(e.center), _in_frame(volume / 5, radii**2, e.rotation))


def _box(b: Box) -> Truth:
    half = _exact(b.half_extents)
    volume = 8 * half[0] * half[1] * half[2]
    return _about(volume, _exact(b.center), _in_frame(volume / 3, half**2, b.rotation))


def _aabb(b: AABB) -> Truth:
    low, high = _exact(b.lower), _exact(b.upper)
    sides = high - low
    volume = sides[0] * sides[1] * sides[2]
    return _about(volume, (low + high) / 2, volume / 12 * (_eye() * sides**2))


def _round(shape: Capsule | Cylinder) -> Truth:
    """A shaft, and of a capsule two halves of a ball, whose barycentres lie 3/8 of the radius beyond its ends."""
    p, q, radius = _exact(shape.p), _exact(shape.q), Fraction(float(shape.radius))
    way = q - p
    square = sum(way * way)
    length = root(square, BITS)[0]
    shaft = PI * radius**2 * length
    ball = PI * radius**3 * Fraction(4, 3) if isinstance(shape, Capsule) else Fraction(0)
    across = shaft * radius**2 / 4 + ball * radius**2 / 5
    along = shaft * square / 12 + ball * (radius**2 / 5 + square / 4 + length * radius * Fraction(3, 8))
    along_axis = outer(way) / square if square else 0 * _eye()
    central = across * _eye() + (along - across) * along_axis
    return _about(shaft + ball, (p + q) / 2, central)


def _surface(corners: Exact) -> Truth:
    volume, first, second = surface_integrals(corners)
    return Truth(volume, first, second)


def _placed(corners: Exact, position: Any, rotation: Any) -> Exact:
    axes = _frame(rotation)
    return sum(corners[..., i, None] * axes[:, i] for i in range(3)) + _exact(position)


def _polyhedron(p: Polyhedron) -> Truth:
    return _surface(_placed(_exact(p.vertices)[p.triangles], p.position, p.rotation))


def _convex(c: ConvexPolyhedron) -> Truth:
    corners = _exact(c.hull.vertices) if c.given == "vertices" else _corners(c.hull, _exact(c.planes))
    return _surface(_placed(_boundary(c.hull, corners), c.position, c.rotation))


def _kdop(k: KDOP) -> Truth:
    ways, low, high = _exact(k.directions), _exact(k.lower), _exact(k.upper)
    planes = np.concatenate([np.column_stack([ways, -high]), np.column_stack([-ways, low])])
    return _surface(_boundary(k.hull, _corners(k.hull, planes)))


def _corners(hull: Hull, planes: Exact) -> Exact:
    """Corners that the hull rounds: each is where three of the given planes meet that it is on (Cramer's rule)."""
    around: list[set[int]] = [set() for _ in hull.vertices]
    for start, end, left, right in hull.edges.tolist():
        for corner in (start, end):
            around[corner] |= {int(hull.active_planes[left]), int(hull.active_planes[right])}
    found = []
    for names in around:
        for three in combinations(sorted(names), 3):
            rows = planes[list(three)]
            n, k = rows[:, :3], rows[:, 3]
            crosses = [_cross(n[(i + 1) % 3], n[(i + 2) % 3]) for i in range(3)]
            det = sum(n[0] * crosses[0])
            if det:
                found.append(-sum(k[i] * crosses[i] for i in range(3)) / det)
                break
        else:
            raise ValueError("a corner of the polytope is on less than three planes")
    return np.array(found, dtype=object)


def _cross(u: Exact, v: Exact) -> Exact:
    return np.array([u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)], dtype=object)


def _boundary(hull: Hull, corners: Exact) -> Exact:
    """Triangles around a polytope, checked: they are closed, and no corner is in front of any of them."""
    index = surface_of(_numbered(hull))[..., 0].astype(int)
    whole = math.lcm(*(x.denominator for x in corners.ravel()))
    grid = np.array([int(x * whole) for x in corners.ravel()], dtype=object).reshape(corners.shape)
    triangles = grid[index]
    normals = [_cross(b - a, c - a) for a, b, c in triangles]
    real = [i for i, n in enumerate(normals) if any(n)]
    edges = Counter(pair for i in real for pair in _edges(index[i].tolist()))
    if any(edges[v, u] != count for (u, v), count in edges.items()):
        raise ValueError("the faces of the polytope are not closed")
    for i in real:
        if np.any(grid @ normals[i] > triangles[i][0] @ normals[i]):
            raise ValueError("a corner of the polytope is in front of a face")
    return corners[index[real]]


def _edges(face: list[int]) -> list[tuple[int, int]]:
    return [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])]


def _numbered(hull: Hull) -> Hull:
    """The hull with the numbers of its corners in the place of their coordinates."""
    count = np.arange(len(hull.vertices), dtype=np.float64)
    return replace(hull, vertices=np.repeat(count[:, None], 3, axis=1))


def _composite(c: Composite) -> Truth:
    """Sum of the parts, which must have nothing in common."""
    parts = [truth(part) for part in c.parts]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


RULES: dict[type[Proxy], Callable[[Any], Truth]] = {
    Sphere: _sphere,
    Capsule: _round,
    Cylinder: _round,
    AABB: _aabb,
    Box: _box,
    Ellipsoid: _ellipsoid,
    KDOP: _kdop,
    ConvexPolyhedron: _convex,
    Polyhedron: _polyhedron,
    Composite: _composite,
}
