"""Study: how the angular velocity of a body made of particles comes to that of the rigid formula."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from refimpl.impacts import RigidBody, impact_of_bodies
from refimpl.impacts.constraints import ParticleBody, impact_with_plane
from refimpl.linear import Array, norm
from reports.studies.plots import COLOURS, MARKS, figure

ITERATIONS = (1, 2, 4, 8, 16, 32, 64, 128)
TIME_STEPS = (1e-2, 1e-4, 1e-6)
UP = np.array([0.0, 0.0, 1.0])
RESTITUTION = 0.5


class Course(NamedTuple):
    """Relative errors of the angular velocity after the impact, for each number of iterations."""

    body: str
    time_step: float
    errors: list[float]


def _bodies() -> dict[str, Array]:
    cube = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5], indexing="ij"), axis=-1).reshape(8, 3)
    tetrahedron = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 2
    return {"tetrahedron, 6 links": tetrahedron, "cube, 28 links": cube, "beam 1:1:4, 28 links": cube * [1, 1, 4]}


def rigid(body: ParticleBody, corner: int) -> Array:
    """Angular velocity after the impact of a corner with the plane, by the formula for rigid bodies."""
    floor = RigidBody([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0)
    mass = np.sum(body.masses)
    falling = RigidBody(body.center, body.velocity, body.angular_velocity, 1.0 / mass, body.inertia)
    after = impact_of_bodies(floor, falling, body.positions[corner], UP, RESTITUTION)
    return np.asarray(after.b.angular_velocity, dtype=np.float64)


def courses() -> list[Course]:
    """Measure all bodies, time steps and numbers of iterations."""
    found = []
    for name, points in _bodies().items():
        body = ParticleBody.braced(points, np.full(len(points), 1 / len(points)), [0.3, 0.1, -1.0], [0.2, -0.4, 0.5])
        weights = np.eye(len(points))[0]
        aim = rigid(body, 0)
        for time_step in TIME_STEPS:
            after = [impact_with_plane(body, weights, UP, RESTITUTION, time_step, n) for n in ITERATIONS]
            errors = [float(norm(b.angular_velocity - aim) / norm(aim)) for b in after]
            found.append(Course(name, time_step, errors))
    return found


def draw(found: list[Course], path: Path) -> None:
    """Error against iterations, log-log; one panel a body, one line a time step."""
    names = list(dict.fromkeys(course.body for course in found))
    with figure(path, columns=len(names), width=9.0, height=3.2) as axes:
        for axis, name in zip(axes, names, strict=True):
            for i, course in enumerate(c for c in found if c.body == name):
                label = f"time step {course.time_step:g}"
                axis.loglog(ITERATIONS, course.errors, color=COLOURS[i], marker=MARKS[i], markersize=4, label=label)
            axis.set_title(name, fontsize="medium")
            axis.set_xlabel("iterations")
        axes[0].set_ylabel("relative error of ω")
        axes[0].legend(fontsize="small")


def told(found: list[Course]) -> str:
    """Markdown: what was measured, as a table."""
    lines = ["| body | time step | " + " | ".join(f"{n}" for n in ITERATIONS) + " |"]
    lines.append("| --- " * (len(ITERATIONS) + 2) + "|")
    for course in found:
        cells = " | ".join(f"{error:.0e}" for error in course.errors)
        lines.append(f"| {course.body} | {course.time_step:g} | {cells} |")
    return "\n".join(lines)
