"""Images of impacts under maps that the laws of mechanics do not notice, and how velocities are brought back.

Each map is exact, or its rows say that they are not: multiplying by powers of two, giving axes other places, adding
where nothing is rounded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from oracles.engine import VELOCITIES, Answers
from oracles.images import Axes, moved, sum_error
from oracles.motion import Motion, Moving
from oracles.promises import Bounds
from oracles.related import Asked, Image, Velocities
from oracles.scene import IMPACT, Cell
from refimpl.linear import Array, largest, power_of_two, scale
from refimpl.shapes import Proxy

Rows = NDArray[np.int_]
Undo = Callable[[Answers, Rows], Velocities]


def _of(
    asked: Asked, a: Proxy, b: Proxy, motion: Motion, undo: Undo, *, factor: float = 1.0, error: Array | None = None
) -> Image:
    n = len(asked)
    cell = Cell(IMPACT, type(a), type(b))
    lost = np.zeros(n) if error is None else error
    return Image(
        cell,
        a,
        b,
        (None, None),
        lambda _, shape: (shape, np.zeros(n)),
        (lost, np.zeros(n)),
        Bounds.none(n),
        motion,
        factor,
        undo=undo,
    )


def _told(answers: Answers, rows: Rows | None = None) -> Velocities:
    del rows
    return tuple(getattr(answers, name) for name in VELOCITIES)


def _motion(asked: Asked) -> Motion:
    assert isinstance(asked.motion, Motion)
    return asked.motion


def exchanged(asked: Asked) -> Image:
    """A becomes B, and the normal points the other way."""
    motion = _motion(asked)
    image = replace(motion, a=motion.b, b=motion.a, normal=-motion.normal + 0.0)

    def undo(answers: Answers, rows: Rows) -> Velocities:
        del rows
        found = _told(answers)
        return found[2:] + found[:2]

    return _of(asked, asked.b, asked.a, image, undo)


def by_axes(asked: Asked, axes: Axes) -> Image:
    """Axes change places; spins are vectors of rotation."""
    motion = _motion(asked)

    def body(of: Moving) -> Moving:
        return Moving(
            axes.places(of.position),
            axes.places(of.velocity),
            axes.spins(of.angular_velocity),
            of.inverse_mass,
            axes.tensors(of.inertia),
        )

    image = replace(
        motion, a=body(motion.a), b=body(motion.b), point=axes.places(motion.point), normal=axes.places(motion.normal)
    )
    back = axes.inverse

    def undo(answers: Answers, rows: Rows) -> Velocities:
        del rows
        change = back.places, back.spins, back.places, back.spins
        return tuple(f(v) for f, v in zip(change, _told(answers), strict=True))

    return _of(asked, axes(asked.a), axes(asked.b), image, undo)


def at_another_size(asked: Asked, factor: float) -> Image:
    """Lengths and velocities times a power of two, moments of inertia times its square; spins stay."""
    motion = _motion(asked)

    def body(of: Moving) -> Moving:
        return replace(
            of, position=factor * of.position, velocity=factor * of.velocity, inertia=factor * factor * of.inertia
        )

    image = replace(motion, a=body(motion.a), b=body(motion.b), point=factor * motion.point)

    def undo(answers: Answers, rows: Rows) -> Velocities:
        del rows
        change = (1 / factor, 1.0, 1 / factor, 1.0)
        return tuple(f * v for f, v in zip(change, _told(answers), strict=True))

    return _of(asked, asked.a.scaled(factor), asked.b.scaled(factor), image, undo, factor=factor)


def elsewhere(asked: Asked, offset: Array) -> Image:
    """Everything is moved, where no coordinate is rounded."""
    motion = _motion(asked)
    lost = largest(sum_error(motion.point, offset))
    for of in motion.bodies:
        lost = lost + largest(sum_error(of.position, offset))
    a, b = moved(asked.a, offset), moved(asked.b, offset)
    lost = np.where(lost + a.error + b.error == 0, 0.0, np.inf)
    bodies = [replace(of, position=of.position + offset) for of in motion.bodies]
    image = replace(motion, a=bodies[0], b=bodies[1], point=motion.point + offset)
    return _of(asked, a.shape, b.shape, image, _told, error=lost)


def seen_from_a_train(asked: Asked) -> Image:
    """The same velocity is added to both bodies: Galileo's principle; nothing immovable may be among them."""
    motion = _motion(asked)
    speed = np.ldexp(1.0, power_of_two(np.maximum(asked.size, np.finfo(float).tiny)))
    train = scale(speed, asked.world.level(np.array([2.0, -1.0, 4.0])))
    lost = np.zeros(len(asked))
    for of in motion.bodies:
        lost = np.where(of.inverse_mass > 0, lost + largest(sum_error(of.velocity, train)), np.inf)
    bodies = [replace(of, velocity=of.velocity + train) for of in motion.bodies]

    def undo(answers: Answers, rows: Rows) -> Velocities:
        a, spin_a, b, spin_b = _told(answers)
        return a - train[rows], spin_a, b - train[rows], spin_b

    return _of(asked, asked.a, asked.b, replace(motion, a=bodies[0], b=bodies[1]), undo, error=lost)


def heavier(asked: Asked, factor: float) -> Image:
    """Masses and moments of inertia times a power of two: impulses grow with them, velocities do not."""
    motion = _motion(asked)
    bodies = [replace(of, inverse_mass=of.inverse_mass / factor, inertia=factor * of.inertia) for of in motion.bodies]
    return _of(asked, asked.a, asked.b, replace(motion, a=bodies[0], b=bodies[1]), _told)


def quicker(asked: Asked, factor: float) -> Image:
    """Velocities and spins times a power of two: an impact is linear in them."""
    motion = _motion(asked)
    bodies = [
        replace(of, velocity=factor * of.velocity, angular_velocity=factor * of.angular_velocity)
        for of in motion.bodies
    ]

    def undo(answers: Answers, rows: Rows) -> Velocities:
        del rows
        return tuple(velocity / factor for velocity in _told(answers))

    return _of(asked, asked.a, asked.b, replace(motion, a=bodies[0], b=bodies[1]), undo, factor=factor)
