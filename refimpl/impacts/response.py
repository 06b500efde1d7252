"""From detection to response: overlap-free positions, then the impact at the contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.impacts.bodies import RigidBody
from refimpl.impacts.reading import Array, at_least_zero, refuse, share
from refimpl.impacts.rigid import approach, impact_of_bodies
from refimpl.linear import Bools
from refimpl.results import CollisionData, where


@dataclass(frozen=True)
class Response:
    """Outcome of a response to a collision.

    Attributes
    ----------
    a, b : RigidBody
        Where and how they go on.
    impulse : (..., 3), mass · velocity
        What B received at the contact, and A with the opposite sign; 0 where there was no impact.
    point : (..., 3)
        Contact point after moving; not a number where the proxies do not intersect.
    met : (...) bool
        Whether there was an impact: the proxies intersect, and the bodies approached at the contact.
    """

    a: RigidBody
    b: RigidBody
    impulse: Array
    point: Array
    met: Bools


def respond(found: CollisionData, a: RigidBody, b: RigidBody, restitution: Any, friction: Any = 0) -> Response:
    """Respond to a collision: move both bodies to their safe positions, and let them bounce there.

    Bodies that do not intersect stay and go on as they are. Those that intersect are moved by the shifts of the
    collision data, whose shares come from the inverse masses that `refimpl.collide` was given: give it those of the
    bodies. Those that also approach each other at the contact point, which is the middle of the two moved witness
    points, exchange an impulse along the normal (`impact_of_bodies`); the others separate already, and keep their
    velocities.

    Parameters
    ----------
    found : CollisionData
        Of the proxies of the two bodies.
    a, b : RigidBody
        Their batch shapes broadcast with that of the data.
    restitution : (...), from 0 to 1
    friction : (...), at least 0

    Raises
    ------
    ShapeError
        A ValueError: an overlap without end (two half-spaces), which has no safe positions; a bad argument.
    """
    e, mu = share("restitution", restitution), at_least_zero("friction", friction)
    hit = np.asarray(found.hit)
    lost = hit & ~(np.isfinite(found.shift_a).all(axis=-1) & np.isfinite(found.shift_b).all(axis=-1))
    refuse("found.shift_a", np.asarray(found.shift_a), lost, "must be finite: the overlap has no end")
    shift_a, shift_b, on_a, on_b = (
        where(hit, vector, np.zeros(3)) for vector in (found.shift_a, found.shift_b, found.on_a, found.on_b)
    )
    normal = where(hit, found.normal, np.array([1.0, 0.0, 0.0]))
    point = (on_a + shift_a) / 2 + (on_b + shift_b) / 2
    a, b = a.moved(shift_a), b.moved(shift_b)
    met = hit & np.asarray(approach(a, b, point, normal) < 0, dtype=bool)
    after = impact_of_bodies(a, b, point, normal, e, mu)
    return Response(
        _where(met, after.a, a),
        _where(met, after.b, b),
        where(met, after.impulse, np.zeros_like(after.impulse)),
        where(hit, point, np.full_like(point, np.nan)),
        met[()],
    )


def _where(met: Bools, after: RigidBody, before: RigidBody) -> RigidBody:
    """Velocities of after the impact where there was one."""
    chosen = (
        where(met, new, np.broadcast_to(old, np.shape(new)))
        for new, old in (
            (after.velocity, before.velocity),
            (after.angular_velocity, before.angular_velocity),
        )
    )
    return before.with_velocities(*chosen)
