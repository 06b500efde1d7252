"""Views: the same scene with a feature of it at the origin and its own directions along the axes.

Where two bodies are and how they are turned as a whole is no part of a fault. Seen from an end of one of them, along
its axis, most of their numbers are 0; and each of those that are left says something of the scene, so that it can be
made simpler without spoiling the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from oracles.clumsiness import PLAIN, clumsiness, odd_numbers
from oracles.forms import batch_of
from oracles.looks import look
from oracles.placements import signed_gap
from oracles.scene import Scene
from oracles.simpler import IDENTITY, changeable, rebuilt, with_sides
from oracles.world import is_flat
from refimpl import Proxy, ShapeError, UnsupportedOperation
from refimpl.linear import Array, cross, norm, perpendicular, unit_or
from refimpl.principal import quaternion_of
from refimpl.shapes import AABB, Capsule, Cylinder

MOST = 12
"""Views that are tried, those of the fewest odd numbers."""
AXES = 2
"""Directions of each body that are looked along: a third one is square to two."""
ASKEW = 1e-9
"""Directions that differ by less are one."""
NOISE = 1e-14
"""What is less than this, relative to the scene's largest number, is what rounding a turn leaves of 0."""
DIGITS = 12
"""A number that has few digits but for what comes behind so many is taken for that."""
FEW = 6


def views(scene: Scene) -> list[Scene]:
    """The scene from where it has fewer numbers to read, the simplest first; none where there is no such place."""
    if is_flat(scene.b):
        return []
    origins, turns = np.array(_origins(scene)), np.array([IDENTITY, *_turns(scene)])
    offsets, turns = -np.repeat(origins, len(turns), axis=0), np.tile(turns, (len(origins), 1))
    try:
        with np.errstate(all="ignore"):
            sides = [_seen(shape, offsets, turns) for shape in (scene.a, scene.b)]
    except (ShapeError, UnsupportedOperation):
        return []
    odd = sum(_odd_numbers(shape, rows) for shape, rows in zip((scene.a, scene.b), sides, strict=True))
    seen: dict[bytes, Scene] = {}
    for i in np.argsort(odd, kind="stable")[: 2 * MOST]:
        made = [tidy(rebuilt(shape, rows[i])) for shape, rows in zip((scene.a, scene.b), sides, strict=True)]
        for view in with_sides(scene, *made):
            seen.setdefault(b"".join(row.tobytes() for row in view.rows), view)
    simpler = [view for view in seen.values() if odd_numbers(view) < odd_numbers(scene)]
    return sorted(simpler, key=clumsiness)[:MOST]


def _seen(shape: Proxy, offsets: Array, turns: Array) -> Array:
    """Rows of a proxy that is moved and then turned in each of these ways."""
    moved = batch_of([shape] * len(offsets)).translated(offsets)
    return (moved if np.array_equal(turns[0], turns[-1]) else moved.rotated(turns)).pack()


def _odd_numbers(shape: Proxy, rows: Array) -> Array:
    """How many numbers of each row are not plain, but for rounding."""
    numbers = rows[:, changeable(shape)]
    apart = np.abs(numbers[..., None] - sorted(PLAIN)).min(axis=-1)
    largest = np.abs(numbers).max(axis=-1, keepdims=True, initial=1.0)
    return np.asarray(np.count_nonzero(apart > NOISE * largest, axis=-1))


def _origins(scene: Scene) -> list[Array]:
    """The middle of each body, and its ends or corners."""
    found = []
    for shape in (scene.a, scene.b):
        found.append(shape.reference_point)
        if isinstance(shape, (Capsule, Cylinder)):
            found += [shape.p, shape.q]
        if isinstance(shape, AABB):
            found += [shape.lower, shape.upper]
    return found


def _turns(scene: Scene) -> Iterator[Array]:
    """Turns that bring one direction to the first axis, and another into the plane of the first two."""
    if any(isinstance(shape, AABB) for shape in (scene.a, scene.b)):
        return
    directions = _directions(scene)
    aside = [(direction, perpendicular(direction)) for direction in directions]
    for first, second in [*permutations(directions, 2), *aside]:
        third, _ = unit_or(cross(first, second), np.zeros(3))
        if np.any(third):
            yield quaternion_of(np.stack([first, cross(third, first), third]))


def _directions(scene: Scene) -> list[Array]:
    """Unit vectors along the axes of both bodies and the normal between them, but for those that are parallel."""
    _, normal = signed_gap(scene.a[None], scene.b[None])
    found: list[Array] = []
    for axis in (*look(scene.a).axes[:AXES], *look(scene.b).axes[:AXES], normal[0]):
        direction, length = unit_or(axis, np.zeros(3))
        if np.isfinite(length) and length > 0 and all(norm(cross(direction, other)) > ASKEW for other in found):
            found.append(direction)
    return found


def tidy(shape: Proxy | None) -> Proxy | None:
    """The proxy without what rounding a turn or a move leaves: nothing instead of 1e-17, 2 instead of 2 + 4e-16."""
    if shape is None:
        return None
    row = shape.pack().copy()
    mask = changeable(shape)
    if hasattr(shape, "rotation"):  # of any length
        row[-4:] /= row[-4:][np.argmax(np.abs(row[-4:]))]
    largest = float(np.abs(row[mask]).max(initial=0.0))
    for i in np.flatnonzero(mask):
        row[i] = _tidied(float(row[i]), largest)
    return rebuilt(shape, row)


def _tidied(x: float, largest: float) -> float:
    if abs(x) <= NOISE * largest:
        return 0.0
    short = float(f"{x:.{DIGITS}g}")
    return short if short == float(f"{x:.{FEW}g}") else x
