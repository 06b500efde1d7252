"""Geometry for the types that have no fixed form: directions of k-DOPs, hulls, and small concave meshes.

All of it stands in the cube from −1 to 1, which a body's half extents then stretch, so that a hull or mesh fills
about the box that the body would be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from oracles.draws import Draws
from refimpl.linear import Array

Triangles = NDArray[np.int64]
Mesh = tuple[Array, Triangles]

AXES = np.eye(3)
CORNERS = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]], dtype=np.float64)
EDGES = np.array([[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]], dtype=np.float64)

K_DIRECTIONS: dict[int, Array] = {
    6: AXES,
    14: np.concatenate([AXES, CORNERS]),
    18: np.concatenate([AXES, EDGES]),
    26: np.concatenate([AXES, CORNERS, EDGES]),
}
"""The usual k-DOPs, by their number of planes: half of that in directions."""

ROUND_STEPS = (1.0, -1.0, 0.0, 0.5, -0.5)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
TETRAHEDRON = CUBE[[0, 3, 5, 6]]
MOST_VERTICES = 16


def pick(draws: Draws, values: Sequence[float]) -> float:
    """One of some values for the whole batch: all proxies of a batch have one form."""
    return float(draws.choice(values)[0])


def slab_directions(draws: Draws, even: bool) -> Array:
    """Directions of a k-DOP: one of the usual sets, or the axes and a few odd ones, shape (n, k, 3)."""
    k = int(pick(draws, (*K_DIRECTIONS, 0)))
    if k:
        return np.broadcast_to(K_DIRECTIONS[k], (draws.n, k // 2, 3))
    odd = int(pick(draws, (1, 2, 4)))
    drawn = draws.choice((1.0, 2.0, -1.0, 3.0), 3 * odd) if even else draws.uniform(-1.0, 1.0, 3 * odd)
    drawn = drawn.reshape(draws.n, odd, 3)
    drawn = np.where(np.abs(drawn).max(axis=-1, keepdims=True) < 1e-3, np.array([1.0, 2.0, 3.0]), drawn)
    return np.concatenate([np.broadcast_to(AXES, (draws.n, 3, 3)), drawn], axis=1)


def hull_vertices(draws: Draws, even: bool) -> Array:
    """Vertices of a hull, shape (n, m, 3) with m from 4 to 16: random ones, a box, a prism, a tetrahedron and more."""
    sort = int(pick(draws, (0, 1, 2, 3)))
    if sort == 0:
        return np.broadcast_to(CUBE, (draws.n, 8, 3))
    if sort == 1:
        ring = polygon(int(pick(draws, (3, 4, 5, 6, 8))), even)
        ends = [np.column_stack([ring, np.full(len(ring), z)]) for z in (-1.0, 1.0)]
        return np.broadcast_to(np.concatenate(ends), (draws.n, 2 * len(ring), 3))
    more = int(pick(draws, (0, 1, 4, 8, MOST_VERTICES - 4)))
    first = np.broadcast_to(TETRAHEDRON, (draws.n, 4, 3))
    if sort == 2 and not even:
        first = first * draws.uniform(0.1, 1.0, 12).reshape(draws.n, 4, 3)
    if not more:
        return np.asarray(first)
    drawn = draws.choice(ROUND_STEPS, 3 * more) if even else draws.uniform(-1.0, 1.0, 3 * more)
    return np.concatenate([first, drawn.reshape(draws.n, more, 3)], axis=1)


def polygon(sides: int, even: bool) -> Array:
    """Convex polygon in the square from −1 to 1; with even numbers, one whose corners are round numbers."""
    if even or sides == 4:
        corners = [(1, 0), (0.5, 0.75), (0, 1), (-0.5, 0.75), (-1, 0), (-0.5, -0.75), (0, -1), (0.5, -0.75)]
        keep = {3: (0, 2, 5), 4: (0, 2, 4, 6), 5: (0, 2, 4, 5, 7), 6: (0, 1, 3, 4, 5, 7), 8: range(8)}[sides]
        return np.array([corners[i] for i in keep], dtype=np.float64)
    angles = [2 * math.pi * i / sides for i in range(sides)]
    return np.array([(math.cos(a), math.sin(a)) for a in angles])


def cuts(draws: Draws, even: bool) -> tuple[Array, Array]:
    """Planes that cut corners off a box: directions (n, k, 3), and how much of its width each leaves, (n, k)."""
    k = int(pick(draws, (0, 1, 3, 6)))
    if even:
        normals, left = draws.choice((1.0, -1.0, 0.0, 2.0), 3 * k or 3), draws.choice((0.75, 0.5, 1.0), k or 1)
    else:
        normals, left = draws.uniform(-1.0, 1.0, 3 * k or 3), draws.uniform(0.3, 1.0, k or 1)
    normals = normals.reshape(draws.n, -1, 3)
    none = np.abs(normals).max(axis=-1, keepdims=True) < 1e-3
    return np.where(none, np.array([1.0, 1.0, 0.0]), normals)[:, :k], left[:, :k]


# -- meshes: extruded polygons, whose ends are triangulated by hand ---------------------------------------------


def extruded(outline: Sequence[tuple[float, float]], cap: Sequence[tuple[int, int, int]]) -> Mesh:
    """Solid between z = −1 and z = 1 over an anticlockwise outline; `cap` are its anticlockwise triangles."""
    m = len(outline)
    flat = np.array(outline, dtype=np.float64)
    vertices = np.concatenate([np.column_stack([flat, np.full(m, z)]) for z in (-1.0, 1.0)])
    faces = [(i + m, j + m, k + m) for i, j, k in cap] + [(i, k, j) for i, j, k in cap]
    for i in range(m):
        j = (i + 1) % m
        faces += [(i, j, j + m), (i, j + m, i + m)]
    return vertices, np.array(faces, dtype=np.int64)


def l_shape(width: float) -> Mesh:
    """Two arms of a width along the lower and the left side of the square."""
    w = width - 1.0
    outline = [(-1, -1), (1, -1), (1, w), (w, w), (w, 1), (-1, 1)]
    return extruded(outline, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])


def u_shape(width: float) -> Mesh:
    """A trough: three sides of the square; the reflex corners are 4 and 5."""
    w = 1.0 - width / 2
    outline = [(-1, -1), (1, -1), (1, 1), (w, 1), (w, -w), (-w, -w), (-w, 1), (-1, 1)]
    return extruded(outline, [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4), (0, 5, 6), (0, 6, 7)])


def star(inner: float) -> Mesh:
    """A four-pointed star: its waist is `inner` wide, and both ends have their middle as a corner."""
    points = [(1, 0), (inner, inner), (0, 1), (-inner, inner), (-1, 0), (-inner, -inner), (0, -1), (inner, -inner)]
    flat = np.array(points, dtype=np.float64)
    ring = [np.column_stack([flat, np.full(8, z)]) for z in (-1.0, 1.0)]
    vertices = np.concatenate([*ring, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    faces = []
    for i in range(8):
        j = (i + 1) % 8
        faces += [(i, j, j + 8), (i, j + 8, i + 8), (17, i + 8, j + 8), (16, j, i)]
    return vertices, np.array(faces, dtype=np.int64)


def frame(inner: float) -> Mesh:
    """A square ring: a solid with a hole through it."""
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
    rings = [np.column_stack([s * square, np.full(4, z)]) for s in (1.0, inner) for z in (-1.0, 1.0)]
    low, high, low_in, high_in = 0, 4, 8, 12
    faces = []
    for i in range(4):
        j = (i + 1) % 4
        quads = [
            (low + i, low + j, high + j, high + i),
            (low_in + j, low_in + i, high_in + i, high_in + j),
            (high + i, high + j, high_in + j, high_in + i),
            (low + j, low + i, low_in + i, low_in + j),
        ]
        for a, b, c, d in quads:
            faces += [(a, b, c), (a, c, d)]
    return np.concatenate(rings), np.array(faces, dtype=np.int64)


def wedge(_: float) -> Mesh:
    """A tetrahedron: the least solid."""
    return TETRAHEDRON.copy(), np.array([(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)], dtype=np.int64)


def block(_: float) -> Mesh:
    """A cube."""
    return extruded([(-1, -1), (1, -1), (1, 1), (-1, 1)], [(0, 1, 2), (0, 2, 3)])


MESHES: tuple[Callable[[float], Mesh], ...] = (l_shape, block, u_shape, star, frame, wedge)


def mesh(draws: Draws, even: bool) -> Mesh:
    """Vertices (m, 3) and triangles (t, 3) of one of the meshes; all proxies of a batch have the same."""
    make = MESHES[int(pick(draws, range(len(MESHES))))]
    width = pick(draws, (0.5, 0.25, 0.75)) if even else float(draws.uniform(0.2, 0.8)[0])
    return make(width)
