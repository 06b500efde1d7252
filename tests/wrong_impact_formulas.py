"""Formulas of impacts that are wrong on purpose, and scenes on which each breaks a law."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from refimpl.impacts import RigidBody, impact_of_bodies, impact_of_particles
from tests.impact_scenes import Scene

F = Fraction


def array(*numbers: Any) -> Any:
    return np.array([F(x) for x in numbers], dtype=object)


def against(scene: Scene) -> tuple[RigidBody, RigidBody]:
    """The impulse with the other sign."""
    after = impact_of_bodies(*scene.question)
    both = zip((scene.a, scene.b), (after.a, after.b), strict=True)
    a, b = (
        old.with_velocities(2 * old.velocity - new.velocity, 2 * old.angular_velocity - new.angular_velocity)
        for old, new in both
    )
    return a, b


def without_restitution(scene: Scene) -> tuple[RigidBody, RigidBody]:
    after = impact_of_bodies(*scene.question[:4], 0, scene.friction)
    return after.a, after.b


def pushed(scene: Scene, impulse: Any) -> tuple[RigidBody, RigidBody]:
    """What an impulse on B, and its opposite on A, does."""
    found = []
    for body, p in ((scene.a, -impulse), (scene.b, impulse)):
        moment = np.cross(scene.point - body.position, p)
        turned = solved(body.inertia, moment) if body.inverse_mass else 0 * moment
        velocities = body.velocity + body.inverse_mass * p, body.angular_velocity + turned
        found.append(body.with_velocities(*velocities))
    return found[0], found[1]


def solved(matrix: Any, v: Any) -> Any:
    """Solve by Gauss and Jordan, in fractions."""
    rows = [[*row, x] for row, x in zip(matrix.tolist(), v.tolist(), strict=True)]
    for i in range(3):
        rows[i] = [x / rows[i][i] for x in rows[i]]
        rows = [
            row if j == i else [x - row[i] * y for x, y in zip(row, rows[i], strict=True)] for j, row in enumerate(rows)
        ]
    return np.array([row[3] for row in rows], dtype=object)


def with_masses_swapped(scene: Scene) -> tuple[RigidBody, RigidBody]:
    a, b = scene.a, scene.b
    p = impact_of_bodies(*scene.question).impulse
    after = impact_of_bodies(*scene.question)
    return (
        a.with_velocities(a.velocity - b.inverse_mass * p, after.a.angular_velocity),
        b.with_velocities(b.velocity + a.inverse_mass * p, after.b.angular_velocity),
    )


def without_lever(scene: Scene) -> tuple[RigidBody, RigidBody]:
    """As if all bodies were particles."""
    a, b = scene.a, scene.b
    after = impact_of_particles(a.velocity, b.velocity, a.inverse_mass, b.inverse_mass, scene.normal, scene.restitution)
    return (
        a.with_velocities(after.velocity_a, a.angular_velocity),
        b.with_velocities(after.velocity_b, b.angular_velocity),
    )


def give(scene: Scene) -> Any:
    """Effective mass matrix K: change of the relative velocity at the point by unit impulses, column by column."""
    columns = []
    for unit in np.array([[F(int(i == j)) for j in range(3)] for i in range(3)], dtype=object):
        a, b = pushed(scene, unit)
        change = b.velocity_at(scene.point) - a.velocity_at(scene.point)
        columns.append(change - (scene.b.velocity_at(scene.point) - scene.a.velocity_at(scene.point)))
    return np.array(columns, dtype=object).T


def full_stick(scene: Scene) -> tuple[RigidBody, RigidBody]:
    """Newton's e along the normal, and an impulse that ends all sliding."""
    n = scene.normal
    u = scene.b.velocity_at(scene.point) - scene.a.velocity_at(scene.point)
    wanted = -scene.restitution * (n @ u) / (n @ n) * n
    return pushed(scene, solved(give(scene), wanted - u))


def friction_forward(scene: Scene) -> tuple[RigidBody, RigidBody]:
    """Friction that drives the sliding instead of stopping it."""
    smooth = impact_of_bodies(*scene.question[:5]).impulse
    rough = impact_of_bodies(*scene.question).impulse
    return pushed(scene, 2 * smooth - rough)


EXAMPLE = Scene(
    RigidBody(array(0, 0, 0), array(1, 0, 2), array(0, 1, 0), F(1), np.diag(array(1, 2, 3)) * F(1)),
    RigidBody(array(1, 1, 2), array(-1, 0, -1), array(0, 0, 1), F(1, 3), np.diag(array(2, 3, 4)) * F(1)),
    array(F(1, 2), 0, 1),
    array(0, 0, 2),
    F(1, 2),
    F(1, 4),
)

KANE = Scene(
    RigidBody.immovable(*(array(0, 0, 0) for _ in range(3))),
    RigidBody(array(-1, 0, 1), array(-3, 0, -5), array(0, 0, 0), F(1), np.diag(array(1, F(2, 3), 1)) * F(1)),
    array(0, 0, 0),
    array(0, 0, 1),
    F(9, 10),
    F(1),
)
"""A rod slides and falls onto a floor with the end on which it leans forward (Kane and Levinson, Dynamics, 1985)."""
