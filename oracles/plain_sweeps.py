"""Plain sweeps: plain bodies on plain ways, and simpler ways than given ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from oracles.course import Course
from oracles.plain_bodies import plain_pairs
from oracles.scene import Cell, Scene
from oracles.simpler import IDENTITY, simpler_proxies, simpler_rows
from oracles.world import PLANE, world_of
from refimpl import Proxy, ShapeError, UnsupportedOperation
from refimpl.linear import Array, apply, rotation_matrix
from refimpl.motions import RigidMotion

PAIRS = 12
"""Plain pairs that are sent on each of the ways."""
WAYS: tuple[tuple[float, float, float], ...] = (
    (4.0, 0.0, 0.0),
    (0.0, 0.0, 4.0),
    (-4.0, 0.0, 0.0),
    (2.0, 0.0, 0.0),
    (1.0, 0.0, 1.0),
    (16.0, 0.0, 0.0),
    (1000.0, 0.0, 0.0),
)
SPINS = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
NOTHING = np.zeros(3)


def plain_sweeps(cell: Cell) -> Iterator[Scene]:
    """Plain pairs, of which A comes from half a way off and goes half a way beyond; always the same."""
    world = world_of(cell.type_b)
    for way in WAYS:
        if world is PLANE and way[2]:
            continue
        half = world.vectors(np.array(way) / 2)
        for scene in islice(plain_pairs(cell), PAIRS):
            yield replace(scene, a=scene.a.translated(-half), motion=Course.translating(way, NOTHING))


def simpler_courses(course: Course, axes: int = 3) -> Iterator[Course]:
    """One of both at rest, or only their relative motion; no turning; rounder numbers."""
    rest, (a, b) = RigidMotion(NOTHING, NOTHING, NOTHING), course.sides
    yield Course(RigidMotion(a.linear - b.linear, a.angular, a.center), replace_linear(b, NOTHING))
    yield Course(a, rest)
    yield Course(rest, b)
    for side, motion in (("a", a), ("b", b)):
        row = motion.pack()
        straight = [RigidMotion(motion.linear, NOTHING, NOTHING)] if motion.angular.any() else []
        dominant = np.where(np.arange(3) == np.argmax(np.abs(motion.linear)), motion.linear, 0.0)
        straight += [replace_linear(motion, dominant), replace_linear(motion, NOTHING)]
        mask = np.arange(len(row)) < (len(row) if motion.angular.any() else axes)
        rows = [RigidMotion.unpack(numbers) for numbers in simpler_rows(row, mask)]
        for other in (*straight, *rows):
            if not np.array_equal(other.pack(), row):
                yield replace(course, **{side: other})


def replace_linear(motion: RigidMotion, linear: Array) -> RigidMotion:
    """The same with another way."""
    return RigidMotion(linear, motion.angular, motion.center)


def around_sweep(scene: Scene) -> Iterator[Iterator[Scene]]:
    """Candidates around a sweep, the boldest first."""
    course = scene.course
    assert course is not None
    yield plain_sweeps(scene.cell)
    yield (replace(scene, motion=simpler) for simpler in simpler_courses(course, world_of(scene.b).axes))
    yield _elsewhere(scene, course)
    yield (replace(scene, a=a) for a in simpler_proxies(scene.a))
    yield (replace(scene, b=b) for b in simpler_proxies(scene.b))


def _elsewhere(scene: Scene, course: Course) -> Iterator[Scene]:
    """Both at the origin, at another size, or out of A's or B's rotation, with their motions."""
    for shape in (scene.a, scene.b):
        place = shape.reference_point
        for offset in (-place, np.round(place) - place):
            if offset.any():
                yield from _changed(scene, partial(_translated, by=offset), _shifted(course, offset))
    powers = [10.0**k for k in (-2, -1, 1, 2)] + ([1 / scene.size] if scene.size > 0 else [])
    for factor in (*powers, 0.5, 2.0):
        if 0 < factor < np.inf:
            sides = (RigidMotion(factor * m.linear, m.angular, factor * m.center) for m in course.sides)
            yield from _changed(scene, partial(_scaled, by=factor), Course(*sides))
    for shape in (scene.a, scene.b):
        q = getattr(shape, "rotation", None)
        if q is not None and not np.array_equal(q, IDENTITY):
            back = q * np.array([-1.0, -1.0, -1.0, 1.0])
            turn = rotation_matrix(back)
            sides = (RigidMotion(*(apply(turn, v) for v in (m.linear, m.angular, m.center))) for m in course.sides)
            yield from _changed(scene, partial(_rotated, by=back), Course(*sides))


def _translated(shape: Proxy, by: Array) -> Proxy:
    return shape.translated(by)


def _scaled(shape: Proxy, by: float) -> Proxy:
    return shape.scaled(by)


def _rotated(shape: Proxy, by: Array) -> Proxy:
    return shape.rotated(by)


def _shifted(course: Course, offset: Array) -> Course:
    """The same about centres that are elsewhere; what does not turn has none."""
    sides = (RigidMotion(m.linear, m.angular, m.center + offset) if m.angular.any() else m for m in course.sides)
    return Course(*sides)


def _changed(scene: Scene, change: Callable[[Proxy], Proxy], course: Course) -> Iterator[Scene]:
    try:
        with np.errstate(all="ignore"):
            yield replace(scene, a=change(scene.a), b=change(scene.b), motion=course)
    except (ShapeError, UnsupportedOperation, ValueError):
        return
