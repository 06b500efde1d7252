"""Proxies built around a given point of their surface, so that signed distances are known without any solver.

Let B have the point b on its surface, with the outward normal n there. A has the point a = b − δn on its surface with
the outward normal −n, and holds the ball of radius δ around b. So the planes through a and b hold the two apart up to
δ, and the ball shows that no shorter translation than δ separates them: the depth is δ. With a = b + δn the gap is δ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.linear import apply, cross, dot, quaternion_product, rotation_matrix, scale, unit_or
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Proxy,
    Sphere,
)

Array = Any
AXES = np.eye(3)


@dataclass(frozen=True)
class Wish:
    """What is wanted of a batch: points of the surface, outward normals there, and room for a ball behind them."""

    rng: np.random.Generator
    point: Array
    normal: Array
    room: Array
    size: float = 1.0

    def sizes(self, low: float = 0.3, high: float = 1.5) -> Array:
        """Lengths with room to spare."""
        return self.room + self.size * self.rng.uniform(low, high, len(self.room))

    def ask(self, probability: float = 0.5) -> Array:
        return self.rng.random(len(self.room)) < probability

    def posed(self, local: Array, outward: Array) -> tuple[Array, Array]:
        """Rotation and position that bring a local surface point and its normal to where they are wanted."""
        rotation = turn_onto(self.rng, outward, self.normal)
        return rotation, self.point - apply(rotation_matrix(rotation), local)


def turn_onto(rng: np.random.Generator, u: Array, v: Array) -> Array:
    """Quaternions of rotations that take the unit vectors u to v, with any spin.

    By way of a third direction that is opposite to neither, for two shortest turns are then well conditioned.
    """
    ways = random_units(rng, (16, len(u)))
    best = np.argmax(np.minimum(dot(ways, u), dot(ways, v)), axis=0)
    middle = ways[best, np.arange(len(u))]
    return quaternion_product(_shortest(middle, v), _shortest(u, middle))


def _shortest(u: Array, v: Array) -> Array:
    return np.concatenate([cross(u, v), (1.0 + dot(u, v))[:, None]], axis=-1)


def random_units(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    return unit_or(rng.normal(size=(*shape, 3)), AXES[0])[0]


def _point(w: Wish) -> Proxy:
    assert not np.any(w.room), "a point holds no ball"
    return Point(w.point)


def _sphere(w: Wish) -> Proxy:
    r = w.sizes()
    return Sphere(w.point - scale(r, w.normal), r)


def _capsule(w: Wish) -> Proxy:
    """The ball at p touches; q lies lower or as high."""
    r = w.sizes()
    p = w.point - scale(r, w.normal)
    way = w.size * w.rng.normal(size=p.shape)
    height = dot(way, w.normal)
    level = np.where(w.ask(), height, np.maximum(height, 0.0))
    return Capsule(p, p + way - scale(level + np.where(w.ask(), 0.0, np.abs(height)), w.normal), r)


def _halfspace(w: Wish) -> Proxy:
    length = w.rng.choice([1.0, 0.5, 4.0], len(w.room))
    normal = scale(length, w.normal)
    return HalfSpace(normal, -dot(normal, w.point))


def _box_corner(w: Wish, outward: Array, half: Array) -> Array:
    """A point of the box |y| ≤ half with this normal: anywhere on the face if the normal is that of a face."""
    within = w.rng.uniform(-1.0, 1.0, half.shape) * (half - w.room[:, None])
    return np.where(outward == 0, within, np.sign(outward) * half)


def _local_normals(w: Wish) -> Array:
    """Normals of faces, of edges and of corners; of faces alone where there must be room."""
    v = w.rng.normal(size=w.normal.shape)
    order = np.argsort(w.rng.random(v.shape), axis=-1)
    zeros = np.where(w.room > 0, 2, w.rng.integers(0, 3, len(w.room)))
    return unit_or(np.where(order < zeros[:, None], 0.0, v), AXES[0])[0]


def _box(w: Wish) -> Proxy:
    half = np.stack([w.sizes() for _ in range(3)], axis=-1)
    outward = _local_normals(w)
    rotation, center = w.posed(_box_corner(w, outward, half), outward)
    return Box(center, half, rotation)


def _aabb(w: Wish) -> Proxy:
    half = np.stack([w.sizes() for _ in range(3)], axis=-1)
    assert not np.any((w.room > 0) & (np.max(np.abs(w.normal), axis=-1) < 1)), "a ball needs a whole face"
    corner = _box_corner(w, w.normal, half)
    lower, upper = w.point - (half + corner), w.point + (half - corner)
    faces = (w.normal > 0, w.normal < 0)
    return AABB(np.where(faces[1], w.point, lower), np.where(faces[0], w.point, upper))


def _ellipsoid(w: Wish) -> Proxy:
    """Touching anywhere; with room, at the end of the shortest axis, where the ball of that radius fits."""
    radii = np.stack([w.sizes() for _ in range(3)], axis=-1)
    shortest = AXES[np.argmin(radii, axis=-1)]
    outward = np.where((w.room > 0)[:, None], shortest, random_units(w.rng, w.room.shape))
    local = radii * unit_or(radii * outward, AXES[0])[0]
    rotation, center = w.posed(local, outward)
    return Ellipsoid(center, radii, rotation)


def _cylinder(w: Wish) -> Proxy:
    """Touching with its side, a cap or a rim; the rim has no room. Its own frame's third axis is the cylinder's."""
    radius, half = w.sizes(), w.sizes()
    around = random_units(w.rng, w.room.shape) * np.array([1.0, 1.0, 0.0])
    around = unit_or(around, AXES[0])[0]
    kind = np.where(w.room > 0, w.rng.integers(0, 2, len(w.room)), w.rng.integers(0, 3, len(w.room)))[:, None]
    up = w.rng.choice([-1.0, 1.0], len(w.room))[:, None] * AXES[2]
    slant = unit_or(around + up * w.rng.uniform(0.1, 3.0, len(w.room))[:, None], AXES[2])[0]
    outward = np.where(kind == 0, around, np.where(kind == 1, up, slant))
    inward = w.rng.uniform(0.0, 1.0, (2, len(w.room)))
    along = scale(inward[0] * (half - w.room), up)
    out = scale(inward[1] * (radius - w.room), around)
    on_side, on_cap = scale(radius, around) + along, out + scale(half, up)
    local = np.where(kind == 0, on_side, np.where(kind == 1, on_cap, scale(radius, around) + scale(half, up)))
    rotation, center = w.posed(local, outward)
    reach = scale(half, rotation_matrix(rotation)[..., :, 2])
    return Cylinder(center - reach, center + reach, radius)


def _slabs(w: Wish, more: int) -> tuple[Array, Array, Array, Array]:
    """Directions and sizes of slabs around a ball, the same for the whole batch, and points with their normals.

    They touch with a face, or the whole batch with a corner of the first three slabs, past which the others reach.
    """
    n = len(w.room)
    ball = float(np.max(w.sizes()))
    directions = np.concatenate([AXES, random_units(w.rng, (more,))])
    corner = ball * np.where(w.rng.random(3) < 0.5, -1.0, 1.0)
    if w.rng.random() < 0.5 and not np.any(w.room):
        beyond = 1.01 * np.abs(dot(directions, corner))
        outward = np.abs(w.rng.normal(size=(n, 3))) * np.sign(corner)
        return directions, np.where(np.arange(3 + more) < 3, ball, beyond), corner, unit_or(outward, AXES[0])[0]
    return directions, np.full(3 + more, ball), ball * AXES[0], np.broadcast_to(AXES[0], (n, 3))


def _kdop(w: Wish) -> Proxy:
    directions, reach, local, outward = _slabs(w, 4)
    rotation, position = w.posed(local, outward)
    length = w.rng.choice([1.0, 0.5, 3.0], (len(position), 7))
    turned = scale(length, apply(rotation_matrix(rotation)[:, None], directions))
    middle = dot(turned, position[:, None, :])
    return KDOP(turned, middle - length * reach, middle + length * reach)


def _polyhedron_of_planes(w: Wish) -> Proxy:
    directions, reach, local, outward = _slabs(w, 3)
    length = w.rng.choice([1.0, 0.5, 3.0], reach.shape)
    normals, offsets = scale(length, directions), -(length * reach)[:, None]
    planes = np.concatenate([np.concatenate([n, offsets], axis=1) for n in (normals, -normals)])
    rotation, position = w.posed(local, outward)
    return ConvexPolyhedron(planes, position, rotation)


def _polyhedron_of_vertices(w: Wish) -> Proxy:
    """A box's corners below z = 0 and others that are lower; the batch touches with the face z = 0, or a tip above."""
    n = len(w.room)
    wide, deep = 2.0 * float(np.max(w.sizes())), 2.0 * float(np.max(w.sizes()))
    corners = np.array([[x, y, z] for x in (-wide, wide) for y in (-wide, wide) for z in (0.0, -deep)])
    others = w.size * w.rng.normal(size=(6, 3)) * np.array([1.5, 1.5, 1.0])
    others[:, 2] = -np.abs(others[:, 2])
    local = wide * w.rng.uniform(-0.5, 0.5, (n, 3)) * np.array([1.0, 1.0, 0.0])
    if w.rng.random() < 0.5 and not np.any(w.room):
        others[0] = local[0] + w.size * w.rng.uniform(0.1, 1.0) * AXES[2]
        local = others[:1]
    rotation, position = w.posed(local, np.broadcast_to(AXES[2], (n, 3)))
    return ConvexPolyhedron.from_vertices(np.concatenate([corners, others]), position, rotation)


BUILDERS: dict[str, tuple[type[Proxy], Callable[[Wish], Proxy]]] = {
    "Point": (Point, _point),
    "Sphere": (Sphere, _sphere),
    "Capsule": (Capsule, _capsule),
    "HalfSpace": (HalfSpace, _halfspace),
    "AABB": (AABB, _aabb),
    "Box": (Box, _box),
    "KDOP": (KDOP, _kdop),
    "Ellipsoid": (Ellipsoid, _ellipsoid),
    "Cylinder": (Cylinder, _cylinder),
    "ConvexPolyhedron": (ConvexPolyhedron, _polyhedron_of_planes),
    "ConvexPolyhedron.from_vertices": (ConvexPolyhedron, _polyhedron_of_vertices),
}


def known_pair(
    holder: str, other: str, signed: Array, rng: np.random.Generator, size: float = 1.0
) -> tuple[Proxy, Proxy]:
    """Proxies (A, B) whose signed distances are `signed`; A, built by `holder`, holds the balls of the depths."""
    n = len(signed)
    normal = random_units(rng, (n,))
    along_axes = AXES[rng.integers(0, 3, n)] * rng.choice([-1.0, 1.0], n)[:, None]
    normal = np.where((rng.random(n) < (1.0 if holder == "AABB" else 0.25))[:, None], along_axes, normal)
    b = size * rng.uniform(-2.0, 2.0, (n, 3))
    a = b + scale(signed, normal)
    made_a = BUILDERS[holder][1](Wish(rng, a, -normal, np.maximum(-signed, 0.0), size))
    made_b = BUILDERS[other][1](Wish(rng, b, normal, np.zeros(n), size))
    return made_a, made_b


def scale_of(a: Proxy, b: Proxy, signed: Array, size: float = 1.0) -> Array:
    """Size s of the scenes, in which the touching points count: a half-space's own numbers do not show them."""
    return np.maximum(np.maximum(np.maximum(a.magnitude, b.magnitude), np.abs(signed)), 2.0 * size)
