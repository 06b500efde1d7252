"""Study: energy and momentum of a ball over a thousand bounces in a box, reference beside engine."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

import refimpl
from oracles.engines.bullet_motion import Balls
from refimpl import HalfSpace, Ray
from refimpl.impacts import impact_of_particles
from refimpl.linear import Array, norm, rotation_matrix
from reports.studies.plots import COLOURS, figure

BOUNCES = 1000
RADIUS, HALF_SIDE = 0.1, 1.0
START, VELOCITY = np.zeros(3), np.array([5.0, 3.0, 2.0])
TIME_STEP = 1 / 240
MOST_STEPS = 60_000
AXES = rotation_matrix(np.array([0.1, 0.2, 0.3, 0.9])).T
"""Of the box, which stands askew: so every bounce has to be rounded."""
NORMALS = np.concatenate([AXES, -AXES])
"""Of the six walls, into the room."""


class Course(NamedTuple):
    """Who simulates, kinetic energy, and the momentum's parts along the box's axes without sign, after each bounce."""

    who: str
    energy: list[float]
    momenta: list[Array]


def by_formula() -> Course:
    """Reference: the next wall by casting a ray, the bounce by the formula for particles."""
    walls = HalfSpace(NORMALS, np.full(6, HALF_SIDE - RADIUS))  # moved in by the radius: the centre is a point
    position, velocity = START, VELOCITY
    course = Course("the formula", [], [])
    while len(course.energy) < BOUNCES:
        times = refimpl.raycast(Ray(position, velocity), walls).t
        approaching = NORMALS @ velocity < 0
        wall = int(np.argmin(np.where(approaching, times, np.inf)))
        position = position + times[wall] * velocity
        after = impact_of_particles(np.zeros(3), velocity, 0.0, 1.0, NORMALS[wall], 1.0)
        velocity = after.velocity_b
        _note(course, velocity, 1)
    return course


def by_engine(defaults: bool) -> Course:
    """PyBullet, with its default settings or with those under which it solves the formula."""
    walls = [(-HALF_SIDE * n, n) for n in NORMALS]
    course = Course("PyBullet by default" if defaults else "PyBullet, set to the formula", [], [])
    with Balls(RADIUS, [START], [VELOCITY], walls, 1.0, TIME_STEP, defaults) as world:
        before = VELOCITY
        for _ in range(MOST_STEPS):
            velocity = world.step()[0]
            _note(course, velocity, int(np.sum((AXES @ velocity) * (AXES @ before) < 0)))
            before = velocity
            if len(course.energy) >= BOUNCES:
                break
    return course


def _note(course: Course, velocity: Array, bounces: int) -> None:
    course.energy.extend([float(velocity @ velocity) / 2] * bounces)
    course.momenta.extend([np.abs(AXES @ velocity)] * bounces)


def courses() -> list[Course]:
    """Simulate with all three."""
    return [by_formula(), by_engine(defaults=False), by_engine(defaults=True)]


def draw(found: list[Course], path: Path) -> None:
    """Energy, and what became of the momentum, against bounces."""
    with figure(path, columns=2, width=9.0) as axes:
        for i, course in enumerate(found):
            bounces = np.arange(1, len(course.energy) + 1)
            shares = np.array(course.energy) / (VELOCITY @ VELOCITY / 2)
            first = np.abs(AXES @ VELOCITY)
            bend = [float(norm(p - first) / norm(first)) for p in course.momenta]
            style = {"color": COLOURS[i], "label": course.who, "linestyle": ("-", "--", "-.")[i]}
            axes[0].semilogx(bounces, shares, **style)
            axes[1].loglog(bounces, np.maximum(bend, 1e-17), **style)
        axes[0].set_ylabel("kinetic energy, share of the first")
        axes[1].set_ylabel("relative change of the momentum's parts")
        for axis in axes:
            axis.set_xlabel("bounces")
        axes[0].legend(fontsize="small")


def told(found: list[Course]) -> str:
    """Markdown table of what was left."""
    lines = ["| | bounces | energy left after 10 | after the last | parts of the momentum off by |", "| --- " * 5 + "|"]
    parts = np.abs(AXES @ VELOCITY)
    first = float(VELOCITY @ VELOCITY) / 2
    for course in found:
        shares = [energy / first for energy in course.energy]
        off = float(norm(course.momenta[-1] - parts) / norm(parts))
        left = f"{shares[min(9, len(shares) - 1)]:.3g} | {shares[-1]:.3g}"
        lines.append(f"| {course.who} | {len(shares)} | {left} | {off:.0e} |")
    return "\n".join(lines)
