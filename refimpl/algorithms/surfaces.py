"""Points, balls and rays against the solid that a triangle surface bounds.

The searches are scalar kernels (`refimpl.kernels.surface` and what builds on it); here a solid is turned, once, into
the row of numbers that they read. What doubles cannot decide there, exact arithmetic decides here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from refimpl.compiling import buffer, is_compiled, module_for, numbers
from refimpl.kernels.ball_ways import ROUNDS, WAY
from refimpl.kernels.heights import SPOT
from refimpl.kernels.leastmove import PLANE
from refimpl.kernels.surface import NODES, STACK
from refimpl.linear import (
    Array,
    Bools,
    apply,
    apply_inverse,
    cross,
    dot,
    largest,
    norm,
    power_of_two,
    rotation_matrix,
    scale,
    unit_or,
)
from refimpl.meshes import winding_numbers
from refimpl.results import Separation
from refimpl.shapes import Point, Polyhedron, Sphere
from refimpl.shapes.polytopes import USUAL_DIRECTIONS
from refimpl.signs import Indices
from refimpl.solids import Solid

STILL = np.eye(3)
AROUND = USUAL_DIRECTIONS[26] / norm(USUAL_DIRECTIONS[26])[:, None]
WAYS = np.concatenate([AROUND, -AROUND])
FAR = 400
"""Points farther away than 2^FAR times the solid's size are measured in a larger unit, or their squares overflow."""
CELLS = 2**16
"""Points times faces that are looked at together."""
LENGTHS = [0, 4, 5, 6]
"""Of what is said of a point (`refimpl.kernels.heights`), the lengths."""
LOOKS = 16
"""How often a search for a way out asks for a height."""


class Surface(NamedTuple):
    """A solid as the kernels read it, in units of 2^exponent.

    Attributes
    ----------
    row : (k,)
        As `refimpl.kernels.surface` describes it.
    directions : (52, 4)
        Unit vectors, and how far the solid reaches along each.
    lists
        The same as lists of floats, for kernels that are not compiled.
    """

    exponent: int
    row: Array
    directions: Array
    lists: tuple[list[float], list[list[float]]]


_SURFACES: WeakKeyDictionary[Solid, dict[int, Surface]] = WeakKeyDictionary()


def surface_of(solid: Solid, exponent: int) -> Surface:
    """Row of a solid in units of 2^exponent; made once."""
    known = _SURFACES.setdefault(solid, {})
    if exponent not in known:
        row = _row(solid, exponent)
        vertices = np.ldexp(solid.vertices, -exponent)
        reach = np.max(dot(vertices[None], WAYS[:, None]), axis=1)
        directions = np.concatenate([WAYS, reach[:, None]], axis=1)
        known[exponent] = Surface(exponent, row, directions, (row.tolist(), directions.tolist()))
    return known[exponent]


def _row(solid: Solid, exponent: int) -> Array:
    tree = solid.surface
    center, half = (np.concatenate([getattr(level, name) for level in tree.levels]) for name in ("center", "half"))
    nodes = np.ldexp(np.concatenate([center, half], axis=1), -exponent)
    runs = tree.bounds[-1].astype(np.float64)
    faces = face_rows(np.ldexp(solid.corners[tree.order], -exponent), tree.order)
    first = NODES + nodes.size
    head = np.array([float(len(runs) - 1), float(first), float(first + len(runs))])
    return np.concatenate([head, nodes.ravel(), runs, faces.ravel()])


def face_rows(corners: Array, order: Indices) -> Array:
    """Corners, frames and sizes of faces; see `refimpl.kernels.surface`."""
    sides = norm(np.roll(corners, -1, axis=1) - corners)
    turn = (np.argmax(sides, axis=1)[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn[:, :, None], axis=1)
    a, b, c = (corners[:, i] for i in range(3))
    along, length = unit_or(b - a, STILL[0])
    rise = c - a
    for _ in range(2):  # the second time takes away what rounding left of the first
        rise = rise - scale(dot(rise, along), along)
    up, height = unit_or(rise, STILL[1])
    outward = unit_or(cross(along, up), STILL[2])[0]
    sizes = np.stack([length, height, dot(c - a, along), order.astype(np.float64)], axis=1)
    return np.concatenate([corners.reshape(-1, 9), along, up, outward, sizes], axis=1)


def _by_unit(solid: Solid, points: Array) -> Iterator[tuple[Indices, Surface]]:
    """Points that are measured in one unit, and the solid in it. Nearly always all in that of the solid's size."""
    own = int(power_of_two(np.asarray(solid.extent)))
    far = power_of_two(largest(points)) - FAR
    if np.all(far <= own):
        yield np.arange(len(points)), surface_of(solid, own)
        return
    exponents = np.where(far > own, (far + FAR - 1) // FAR * FAR, own)
    for exponent in np.unique(exponents).tolist():
        yield np.flatnonzero(exponents == exponent), surface_of(solid, exponent)


def points_surface(solid: Solid, points: Array) -> tuple[Array, Array, Array]:
    """Signed distances of points from a solid, the nearest points of its surface, and the unit normals there.

    Inside, the nearest point of the surface is where the shortest way out ends, so this is exact on both sides. Where
    a point is on the surface, the normal is its face's.

    Parameters
    ----------
    solid : Solid
    points : (n, 3)
        In the solid's frame.
    """
    found = np.empty((len(points), SPOT))
    for rows, surface in _by_unit(solid, points):
        spots = _spots(solid, surface, np.ldexp(points[rows], -surface.exponent))
        spots[:, LENGTHS] = np.ldexp(spots[:, LENGTHS], surface.exponent)
        found[rows] = spots
    return found[:, 0], found[:, 4:7], found[:, 1:4]


def _spots(solid: Solid, surface: Surface, points: Array) -> Array:
    """What is near points, in the surface's unit; see `refimpl.kernels.heights`."""
    found = _heights(surface, points, np.zeros(len(points), dtype=np.int64))
    unsure = np.flatnonzero(found[:, 7] == 0)
    if len(unsure):
        inside = _inside(solid, np.ldexp(points[unsure], surface.exponent))
        found[unsure] = _heights(surface, points[unsure], np.where(inside, -1, 1))
    return found


def _heights(surface: Surface, points: Array, sides: Any) -> Array:
    module = module_for("heights", len(points))
    row = surface.row if is_compiled(module) else surface.lists[0]
    answers = numbers(np.zeros((len(points), SPOT)), module)
    module.heights(row, numbers(points, module), numbers(sides, module), answers, buffer(STACK, module))
    return np.array(answers).reshape(len(points), SPOT)


def _inside(solid: Solid, points: Array) -> Bools:
    """Whether points are inside, exactly."""
    step = max(1, CELLS // len(solid.triangles))
    parts = [
        winding_numbers(solid.corners, points[i : i + step], solid.face_bounds) for i in range(0, len(points), step)
    ]
    return np.asarray(np.concatenate(parts) > 0)


def faces_on_the_way(solid: Solid, origin: Array, direction: Array) -> tuple[Indices, Indices]:
    """Rays, by their places in the batch, and faces that they may meet; all others they miss for certain.

    Parameters
    ----------
    solid : Solid
    origin, direction : (n, 3)
        In the solid's frame.
    """
    ray, face = [], []
    for rows, surface in _by_unit(solid, origin):
        rays = np.concatenate([np.ldexp(origin[rows], -surface.exponent), direction[rows]], axis=1)
        module = module_for("windings", len(rows))
        row, room = (surface.row if is_compiled(module) else surface.lists[0]), 8 * len(rows)
        while True:
            found = buffer(2 * room, module, whole=True)
            count = module.faces_on_the_way(row, numbers(rays, module), found, buffer(STACK, module))
            if count <= room:
                break
            room = count
        pairs = np.array(found[: 2 * count], dtype=np.int64).reshape(count, 2)
        ray.append(rows[pairs[:, 0]])
        face.append(pairs[:, 1])
    none = np.zeros(0, dtype=np.int64)
    return np.concatenate([none, *ray]), np.concatenate([none, *face])


# ------------------------------------------------------------------------------------------- placed


def mesh_heights(p: Array, mesh: Polyhedron) -> Separation:
    """Signed distances of points from polyhedra, exact on both sides of the surface; points first."""
    turn = rotation_matrix(mesh.rotation)
    gap, foot, outward = points_surface(mesh.solid, apply_inverse(turn, p - mesh.position))
    return Separation(gap, p, apply(turn, foot) + mesh.position, -apply(turn, outward))


def points_mesh(point: Point, mesh: Polyhedron) -> tuple[Separation, Array]:
    """Signed distances of points and polyhedra, and the depths of those that are inside; else 0."""
    found = mesh_heights(point.position, mesh)
    return found, np.maximum(0.0, -found.distance)


def points_faces(point: Point, mesh: Polyhedron) -> tuple[Separation, Array]:
    """Distances of points from the surfaces of polyhedra, which have no inside; and 0, for depths there are none."""
    found = mesh_heights(point.position, mesh)
    inside = found.distance < 0
    normal = np.where(inside[:, None], -found.normal, found.normal)
    return Separation(np.abs(found.distance), found.on_a, found.on_b, normal), np.zeros(len(point))


def balls_mesh(ball: Sphere, mesh: Polyhedron) -> tuple[Separation, Array]:
    """Signed distances of balls and polyhedra, and lengths below which no translation separates them.

    Apart, that of the centre less the radius. Overlapping, minus the length of the shortest translation found; it is
    the depth itself over a face, and wherever else the two lengths agree.
    """
    turn, solid = rotation_matrix(mesh.rotation), mesh.solid
    balls = np.concatenate([apply_inverse(turn, ball.center - mesh.position), ball.radius[:, None]], axis=1)
    found = np.empty((len(ball), WAY))
    for rows, surface in _by_unit(solid, balls):
        answers = _balls(solid, surface, np.ldexp(balls[rows], -surface.exponent))
        answers[:, :5] = np.ldexp(answers[:, :5], surface.exponent)
        found[rows] = answers
    gap, normal, on_b = found[:, 0], -apply(turn, found[:, 5:8]), apply(turn, found[:, 2:5]) + mesh.position
    over = scale(ball.radius, normal)
    on_a = np.where((gap < 0)[:, None], on_b - scale(gap, normal), ball.center + over)
    return Separation(gap, on_a, on_b, normal), found[:, 1]


def _balls(solid: Solid, surface: Surface, balls: Array) -> Array:
    """Signed distances of balls from a solid, least lengths of ways out, points of the surface, outward normals."""
    spots = _spots(solid, surface, balls[:, :3])
    gap = spots[:, 0] - balls[:, 3]
    found = np.concatenate([gap[:, None], np.maximum(0.0, -gap)[:, None], spots[:, 4:7], spots[:, 1:4]], axis=1)
    deep = np.flatnonzero(gap < 0)
    if len(deep):
        ways = _ways_out(surface, balls[deep], spots[deep])
        found[deep, 0], found[deep, 1:5] = -ways[:, 0], ways[:, 1:5]
        found[deep, 5:8] = unit_or(ways[:, 5:8], found[deep, 5:8])[0]
    return found


def _ways_out(surface: Surface, balls: Array, spots: Array) -> Array:
    module = module_for("ball_ways", LOOKS * len(balls))
    row, directions = (surface.row, surface.directions) if is_compiled(module) else surface.lists
    answers = numbers(np.zeros((len(balls), WAY)), module)
    room = buffer(PLANE * ROUNDS, module), buffer(ROUNDS, module, whole=True), buffer(STACK, module)
    module.ways_out(row, numbers(balls, module), numbers(spots, module), directions, answers, *room)
    return np.array(answers).reshape(len(balls), WAY)
