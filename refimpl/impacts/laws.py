"""The laws of impacts as proofs: certificates of given velocities, row by row.

What has to be believed is in `refimpl.proof.impacts`, which needs only the standard library; here arrays become what it
reads.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from refimpl.impacts.bodies import RigidBody
from refimpl.impacts.evaluating import batch_shape
from refimpl.impacts.reading import Array, real
from refimpl.proof.impacts import Impact, ImpactCertificate, MovingBody, Outcome, certify_impact


def certify(
    a: RigidBody,
    b: RigidBody,
    point: Any,
    normal: Any,
    restitution: Any,
    friction: Any = 0,
    *,
    after_a: RigidBody,
    after_b: RigidBody,
) -> ImpactCertificate | list[Any]:
    """Make the certificate of an impact: the exact residuals of its laws.

    Parameters
    ----------
    a, b, point, normal, restitution, friction
        As in `impact_of_bodies`.
    after_a, after_b : RigidBody
        The bodies after the impact, of which only the velocities are read: from `impact_of_bodies`, or an engine.

    Returns
    -------
    ImpactCertificate
        For `refimpl.proof.impacts.check_impact`. Of a batch: lists of them, nested as the batch is.
    """
    columns: dict[str, tuple[Array, int]] = {
        "point": (real("point", point, 3), 1),
        "normal": (real("normal", normal, 3), 1),
        "restitution": (real("restitution", restitution), 0),
        "friction": (real("friction", friction), 0),
        "velocity_a": (after_a.velocity, 1),
        "angular_velocity_a": (after_a.angular_velocity, 1),
        "velocity_b": (after_b.velocity, 1),
        "angular_velocity_b": (after_b.angular_velocity, 1),
    }
    shapes = {name: value.shape[: value.ndim - axes] for name, (value, axes) in columns.items()}
    batch = batch_shape({**shapes, "a": a.batch_shape, "b": b.batch_shape})
    found = np.empty(batch, dtype=object)
    for index in np.ndindex(batch):
        row = {name: _row(value, axes, batch, index) for name, (value, axes) in columns.items()}
        outcome = Outcome(*(row.pop(name) for name in list(row)[4:]))
        impact = Impact(_body(a, batch, index), _body(b, batch, index), **row)
        found[index] = certify_impact(impact, outcome)
    certificates: ImpactCertificate | list[Any] = found.tolist()
    return certificates


def _body(body: RigidBody, batch: tuple[int, ...], index: tuple[int, ...]) -> MovingBody:
    inertia = None if body.inertia is None else _row(body.inertia, 2, batch, index)
    position, velocity, spin = (_row(v, 1, batch, index) for v in (body.position, body.velocity, body.angular_velocity))
    return MovingBody(position, velocity, spin, _row(body.inverse_mass, 0, batch, index), inertia)


def _row(value: Array, axes: int, batch: tuple[int, ...], index: tuple[int, ...]) -> Any:
    """One row as numbers or nested tuples of Python's."""
    tail = value.shape[value.ndim - axes :]
    return _tuples(
        np.broadcast_to(value, batch + tail)[index].tolist() if tail else np.broadcast_to(value, batch)[index]
    )


def _tuples(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_tuples(v) for v in value)
    return value.item() if isinstance(value, np.generic) else value
