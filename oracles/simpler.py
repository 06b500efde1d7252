"""Simpler scenes than a given one: every change that shrinking tries, each small enough that a fault may survive it.

Numbers are changed in packed rows, so that one rule serves all types. Rounding destroys a gap of 1e-9: what has been
changed is also offered with B moved back to the old gap.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from oracles.clumsiness import PLAIN
from oracles.degeneracy import length_of
from oracles.scene import Scene
from oracles.solids import CUBE, TETRAHEDRON, block, wedge
from refimpl import KDOP, Box, Composite, ConvexPolyhedron, Ellipsoid, Proxy, ShapeError, UnsupportedOperation
from refimpl.linear import Array
from refimpl.shapes import Capsule, Cylinder, HalfSpace, Polyhedron, Ray

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
FORMED = (ConvexPolyhedron, Polyhedron, Composite)
DECIMALS = (0, 1, 2, 3)
NUDGES, NUDGED = (1e-1, 1e-2, 1e-3), 4
"""Steps by which a number is changed, relative to the larger body, and digits to which it then is rounded."""
MOST_PARTS = 24
"""Vertices, planes, slabs or parts that are left out one by one."""


def simpler_numbers(x: float) -> list[float]:
    """Numbers to put in the place of one, the simplest first."""
    if x in PLAIN and x != 0:
        return [0.0] if x == 1 else [0.0, 1.0]
    signed = [0.0, 1.0, -1.0, 0.5, 2.0]
    digits = [float(f"{x:.{k}e}") for k in DECIMALS]
    whole = float(np.round(x)) if abs(x) < 1e15 else x
    apart = x - whole
    farther = [whole + factor * apart for factor in (3.0, 10.0, 100.0)] if 0 < abs(apart) < 1e-2 else []
    return [y for y in dict.fromkeys([*signed, whole, *digits, *farther]) if y != x]


def powers_of_ten(row: Array) -> Array:
    """The nearest power of ten of each number, with its sign."""
    sizes = np.where(row == 0, 1.0, np.abs(row))
    return np.asarray(np.where(row == 0, 0.0, np.sign(row) * 10.0 ** np.round(np.log10(sizes))))


def changeable(shape: Proxy) -> NDArray[np.bool_]:
    """Which numbers of a packed row say what a proxy is, and not how the row is to be read."""
    if isinstance(shape, Composite):
        parts = [np.concatenate([[False, False], changeable(part)]) for part in shape.parts]
        return np.concatenate([[False], *parts])
    mask = np.ones(shape.pack().shape[-1], dtype=bool)
    mask[: shape.header] = False
    if isinstance(shape, Polyhedron):
        mask[2 + shape.vertices.size : -7] = False
    return mask


def rebuilt(shape: Proxy, row: Array) -> Proxy | None:
    """A proxy of other numbers; none where they make none."""
    try:
        with np.errstate(all="ignore"):
            return type(shape).unpack(row)
    except (ShapeError, ValueError):
        return None


def with_sides(scene: Scene, a: Proxy | None, b: Proxy | None) -> Iterator[Scene]:
    """The scene with other proxies, unless one of them could not be made."""
    if a is not None and b is not None:
        yield replace(scene, a=a, b=b)


def nudged(scene: Scene) -> Iterator[Scene]:
    """The scene with one number a little larger or smaller: where a slight error begins, it may grow."""
    length = length_of(scene)
    for share in NUDGES:
        for shape in (scene.a, scene.b):
            row = shape.pack()
            for i in np.flatnonzero(changeable(shape)):
                for step in (share * length, -share * length):
                    changed = row.copy()
                    changed[i] = float(f"{row[i] + step:.{NUDGED}g}")
                    made = rebuilt(shape, changed)
                    a, b = (made, scene.b) if shape is scene.a else (scene.a, made)
                    yield from with_sides(scene, a, b)


# -- the whole scene -----------------------------------------------------------------------------------------


def moved(scene: Scene) -> Iterator[Scene]:
    """Both at once: to the origin, to the unit of size, out of A's or B's rotation."""
    yield from _translated(scene)
    yield from _scaled(scene)
    yield from _unturned(scene)


def _translated(scene: Scene) -> Iterator[Scene]:
    places = [shape.reference_point for shape in (scene.a, scene.b)]
    axes = np.arange(len(places[0]))
    offsets = [-place for place in places]
    offsets += [np.where(axes == i, -place, 0.0) for place in places for i in axes if place[i] != 0]
    offsets += [np.round(place) - place for place in places]
    rows = [shape.pack()[changeable(shape)] for shape in (scene.a, scene.b)]
    offsets += [np.where(axes == i, -x, 0.0) for row in rows for x in row[:6].tolist() for i in axes]
    for offset in {tuple(o.tolist()): o for o in offsets if np.any(o != 0)}.values():
        yield from _of_both(scene, lambda shape, by=offset: shape.translated(by))


def _scaled(scene: Scene) -> Iterator[Scene]:
    sizes = [abs(x) for s in (scene.a, scene.b) for x in s.pack()[changeable(s)].tolist() if x not in PLAIN]
    powers = [10.0**k for k in (-2, -1, 1, 2)] + [1 / scene.size if scene.size > 0 else 1.0]
    for factor in dict.fromkeys([*powers, *(1 / x for x in sizes[:8]), 0.5, 2.0]):
        if 0 < factor < np.inf:
            yield from _of_both(scene, lambda shape, by=factor: shape.scaled(by))


def _unturned(scene: Scene) -> Iterator[Scene]:
    for shape in (scene.a, scene.b):
        q = getattr(shape, "rotation", None)
        if q is not None and not np.array_equal(q, IDENTITY):
            yield from _of_both(scene, lambda s, by=q * [-1, -1, -1, 1]: s.rotated(by))


def _of_both(scene: Scene, change: object) -> Iterator[Scene]:
    try:
        with np.errstate(all="ignore"):
            yield from with_sides(scene, change(scene.a), change(scene.b))  # type: ignore[operator]
    except (ShapeError, UnsupportedOperation, ValueError):
        return


# -- one proxy -----------------------------------------------------------------------------------------------


def simpler_proxies(shape: Proxy) -> Iterator[Proxy]:
    """Everything simpler that one proxy can be made into, the boldest first."""
    yield from fewer_parts(shape)
    yield from _along_axes(shape)
    for row in simpler_rows(shape.pack(), changeable(shape)):
        made = rebuilt(shape, row)
        if made is not None:
            yield made


def simpler_rows(row: Array, mask: NDArray[np.bool_]) -> Iterator[Array]:
    """Rows with all numbers rounded, and with one number changed."""
    rounded = [np.round(row, decimals) for decimals in DECIMALS]
    rounded += [np.array([float(f"{x:.{digits}e}") for x in row]) for digits in (0, 1)]
    for numbers in [powers_of_ten(row), *rounded]:
        changed = np.where(mask, numbers, row)
        if not np.array_equal(changed, row):
            yield changed
    for i in np.flatnonzero(mask):
        for x in simpler_numbers(float(row[i])):
            changed = row.copy()
            changed[i] = x
            yield changed


def _along_axes(shape: Proxy) -> Iterator[Proxy]:
    """Identity rotations, directions along the nearest axis, bodies as long as wide."""
    made: list[Proxy | None] = []
    row = shape.pack()
    if isinstance(shape, (Box, Ellipsoid, ConvexPolyhedron, Polyhedron)):
        made += [rebuilt(shape, np.concatenate([row[:-4], q])) for q in (IDENTITY, _sharpened(row[-4:]))]
    if isinstance(shape, (Box, Ellipsoid)):
        for size in (1.0, float(row[3:6].max()), float(row[3:6].min())):
            made.append(rebuilt(shape, np.concatenate([row[:3], np.full(3, size), row[6:]])))
    if isinstance(shape, (Capsule, Cylinder)):
        middle, half = shape.reference_point, (shape.q - shape.p) / 2
        for step in (_dominant(half), *(np.eye(3)[i] for i in range(3)), 10 * half, 100 * half):
            made += [rebuilt(shape, np.concatenate([middle - step, middle + step, row[6:]]))]
            made += [rebuilt(shape, np.concatenate([shape.p, shape.p + 2 * step, row[6:]]))]
            made += [rebuilt(shape, np.concatenate([shape.q - 2 * step, shape.q, row[6:]]))]
    if isinstance(shape, Ray):
        for step in (_dominant(shape.direction), np.sign(_dominant(shape.direction)), np.sign(shape.direction)):
            made.append(rebuilt(shape, np.concatenate([shape.origin, step])))
    if isinstance(shape, HalfSpace):
        length = float(np.linalg.norm(shape.normal))
        for normal in (np.sign(_dominant(shape.normal)), _dominant(shape.normal)):
            k = shape.k / length * np.linalg.norm(normal)
            made += [rebuilt(shape, np.concatenate([normal, [value]])) for value in (k, 0.0, np.round(k))]
    yield from (other for other in made if other is not None and not np.array_equal(other.pack(), row))


def _dominant(vector: Array) -> Array:
    """The vector's largest coordinate, and 0 for the others."""
    return np.where(np.arange(len(vector)) == np.argmax(np.abs(vector)), vector, 0.0)


def _sharpened(q: Array) -> Array:
    """The quaternion in quarters of its largest part."""
    return np.asarray(np.round(2 * q / np.abs(q).max()) / 2)


def fewer_parts(shape: Proxy) -> Iterator[Proxy]:
    """Without some vertices, planes, slabs or parts, or one; or the least of its kind."""
    made: list[Proxy | None] = []
    with np.errstate(all="ignore"):
        if isinstance(shape, ConvexPolyhedron):
            made += list(_fewer_corners(shape))
        elif isinstance(shape, Polyhedron):
            half = (shape.vertices.max(axis=0) - shape.vertices.min(axis=0)) / 2
            for vertices, triangles in (wedge(0.0), block(0.0)):
                if len(vertices) < len(shape.vertices):
                    made += [_mesh(vertices * size, triangles, shape) for size in (np.ones(3), half)]
        elif isinstance(shape, KDOP) and len(shape.lower) > 3:
            for k in _some_left(len(shape.lower), 3):
                made.append(_or_none(lambda k=k: KDOP(shape.directions[k], shape.lower[k], shape.upper[k])))
        elif isinstance(shape, Composite):
            for k in _some_left(len(shape.parts), 1):
                made.append(Composite([shape.parts[i] for i in np.flatnonzero(k)]))
            for i, part in enumerate(shape.parts):
                rest = shape.parts
                made += [
                    Composite([*rest[:i], other, *rest[i + 1 :]]) for other in (*fewer_parts(part), *_along_axes(part))
                ]
    yield from (other for other in made if other is not None)


def _fewer_corners(shape: ConvexPolyhedron) -> Iterator[Proxy | None]:
    rows, vertices = shape.numbers, shape.given == "vertices"
    make = ConvexPolyhedron.from_vertices if vertices else ConvexPolyhedron
    if vertices:
        half = (rows.max(axis=0) - rows.min(axis=0)) / 2
        for corners in (TETRAHEDRON, CUBE):
            if len(corners) < len(rows):
                for size in (np.ones(3), half):
                    yield _or_none(lambda c=corners * size: make(c, shape.position, shape.rotation))
    for k in _some_left(len(rows), 4):
        yield _or_none(lambda k=k: make(rows[k], shape.position, shape.rotation))


def _some_left(count: int, fewest: int) -> Iterator[NDArray[np.bool_]]:
    """Which of so many parts are left: without half of them, without a quarter, and without one."""
    for left_out in dict.fromkeys([count // 2, count // 4, 1]):
        if left_out and count - left_out >= fewest:
            for start in range(0, min(count, MOST_PARTS * left_out), left_out):
                yield (np.arange(count) < start) | (np.arange(count) >= start + left_out)


def _mesh(vertices: Array, triangles: NDArray[np.int64], like: Polyhedron) -> Proxy | None:
    return _or_none(lambda: Polyhedron(vertices, triangles, like.position, like.rotation))


def _or_none(make: object) -> Proxy | None:
    try:
        found: Proxy = make()  # type: ignore[operator]
    except (ShapeError, ValueError):
        return None
    return found
