"""Particles held together by distance constraints: rigid bodies without a rotation of their own.

A body is a handful of particles, linked pair by pair at fixed distances. A time step moves each particle freely and
then repairs, one after the other and several times over, every distance and every contact that the free motion broke;
velocities are what the positions then tell (Verlet's idea). Nothing in it knows of angular velocity or of inertia
tensors, and yet a body that is hit off its centre starts to turn: each repair pushes two particles apart along the line
between them with opposite impulses, so that linear and angular momentum are kept, and the repaired motion is the rigid
one. Each repair is a projection, orthogonal with masses as weights; repeating them in turn comes to the projection onto
all constraints together (von Neumann 1949, Halperin 1962), which is what the rigid formula computes. How many
iterations that takes is shown in `reports/studies`.

T. Jakobsen, Advanced character physics, GDC 2001; M. Müller et al., Position based dynamics, J. Vis. Commun. Image
Represent. 18 (2007), section 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from refimpl.fields import ShapeError
from refimpl.linear import Array, as_floats, cross, dot, norm, scale, unit_or
from refimpl.shapes import HalfSpace

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ParticleBody:
    """Particles with distance constraints between them.

    Attributes
    ----------
    positions, velocities : (..., n, 3)
        Of each particle. Leading axes are batches: the same body in several motions.
    inverse_masses : (n,)
        Not negative; 0 pins a particle down.
    links : (m, 2) int
        Pairs of particles whose distance is fixed.
    lengths : (m,)
        Those distances.
    """

    positions: Array
    velocities: Array
    inverse_masses: Array
    links: Indices
    lengths: Array

    def __post_init__(self) -> None:
        positions, velocities = as_floats(self.positions), as_floats(self.velocities)
        if positions.ndim < 2 or positions.shape[-1] != 3 or not positions.shape[-2]:
            raise ShapeError(f"ParticleBody.positions has shape {positions.shape}, not (..., n, 3)")
        batch = np.broadcast_shapes(positions.shape, velocities.shape)
        inverse_masses, lengths = as_floats(self.inverse_masses), as_floats(self.lengths)
        links: Indices = np.array(self.links, dtype=np.int64).reshape(-1, 2)
        if inverse_masses.shape != positions.shape[-2:-1]:
            raise ShapeError(f"ParticleBody.inverse_masses has shape {inverse_masses.shape}, one for each particle")
        for name, value in (("positions", positions), ("velocities", velocities)):
            if not np.all(np.isfinite(value)):
                raise ShapeError(f"ParticleBody.{name} must be finite, got {value.tolist()!r}")
        if not np.all(np.isfinite(inverse_masses) & (inverse_masses >= 0)):
            raise ShapeError(f"ParticleBody.inverse_masses must be finite and ≥ 0, got {inverse_masses.tolist()!r}")
        if lengths.shape != links.shape[:1] or not np.all(np.isfinite(lengths) & (lengths > 0)):
            raise ShapeError(f"ParticleBody.lengths must be positive, one for each link, got {lengths.tolist()!r}")
        bad: NDArray[np.bool_] = (links < 0) | (links >= len(inverse_masses)) | (links[:, :1] == links[:, 1:])
        if np.any(bad):
            raise ShapeError(
                f"ParticleBody.links: {links[np.any(bad, axis=1)][0].tolist()} does not join two of the particles"
            )
        checked: dict[str, Any] = {
            "positions": np.broadcast_to(positions, batch),
            "velocities": np.broadcast_to(velocities, batch),
            "inverse_masses": inverse_masses,
            "links": links,
            "lengths": lengths,
        }
        for field, numbers in checked.items():
            object.__setattr__(self, field, numbers)

    @classmethod
    def braced(
        cls, positions: Any, masses: Any, velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = (0.0, 0.0, 0.0)
    ) -> Self:
        """Link every particle to every other, and set them in rigid motion.

        Parameters
        ----------
        positions : (n, 3)
            No two equal.
        masses : (n,)
            Positive.
        velocity, angular_velocity : (..., 3)
            Of the centre of mass, and around it.
        """
        points, mass = as_floats(positions), as_floats(masses)
        if mass.shape != points.shape[:1] or not np.all(np.isfinite(mass) & (mass > 0)):
            raise ShapeError(f"masses must be positive, one for each particle, got {mass.tolist()!r}")
        links: Indices = np.array(list(combinations(range(len(points)), 2)), dtype=np.int64).reshape(-1, 2)
        lengths = norm(points[links[:, 0]] - points[links[:, 1]])
        arms = points - _weighted(mass, points) / np.sum(mass)
        turning = cross(as_floats(angular_velocity)[..., None, :], arms)
        return cls(points, as_floats(velocity)[..., None, :] + turning, 1.0 / mass, links, lengths)

    @property
    def masses(self) -> Array:
        """(n,); raises `ValueError` for a body with pinned particles, which takes any impulse and has no momentum."""
        if not np.all(self.inverse_masses > 0):
            raise ValueError("a body with pinned particles (inverse mass 0) has no finite mass, momentum or energy")
        return np.asarray(1.0 / self.inverse_masses)

    @property
    def center(self) -> Array:
        """Centre of mass, (..., 3)."""
        return _weighted(self.masses, self.positions) / np.sum(self.masses)

    @property
    def momentum(self) -> Array:
        """Linear momentum, (..., 3)."""
        return _weighted(self.masses, self.velocities)

    def angular_momentum(self, about: Any = None) -> Array:
        """Angular momentum about a point (..., 3), by default about the centre of mass."""
        pivot = self.center if about is None else as_floats(about)
        return _weighted(self.masses, cross(self.positions - pivot[..., None, :], self.velocities))

    @property
    def kinetic_energy(self) -> Array:
        """(...)."""
        return np.asarray(np.sum(self.masses * dot(self.velocities, self.velocities), axis=-1) / 2)

    @property
    def inertia(self) -> Array:
        """Inertia tensor of the particles about their centre of mass, (..., 3, 3)."""
        arms = self.positions - self.center[..., None, :]
        spread = np.einsum("n,...ni,...nj->...ij", self.masses, arms, arms)
        return np.asarray(np.trace(spread, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - spread)

    @property
    def velocity(self) -> Array:
        """Velocity of the centre of mass, (..., 3)."""
        return self.momentum / np.sum(self.masses)

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity (..., 3) of a rigid body with the same inertia and angular momentum.

        Around a line on which all particles lie it is 0: the least of those that fit.
        """
        return np.asarray((np.linalg.pinv(self.inertia, hermitian=True) @ self.angular_momentum()[..., None])[..., 0])

    @property
    def strain(self) -> Array:
        """Largest relative error of a distance, (...)."""
        i, j = self.links.T
        lengths = norm(self.positions[..., i, :] - self.positions[..., j, :])
        return np.asarray(np.max(np.abs(lengths / self.lengths - 1.0), axis=-1, initial=0.0))


def _weighted(weights: Array, vectors: Array) -> Array:
    return np.asarray(np.sum(weights[:, None] * vectors, axis=-2))


@dataclass(frozen=True, eq=False)
class Contact:
    """Constraint Σ weightᵢ · normal·xᵢ ≥ least on some particles: a point stays in front of another, or of a plane.

    Attributes
    ----------
    normal : (..., 3)
        Unit vector.
    particles : (k,) int
    weights : (k,)
        A point among particles has weights that sum to 1; the point that it must stay in front of enters with −1.
    least : (...)
    holds : (...) bool
        Where it is an equation: during an impact the two neither come nearer nor part earlier.
    """

    normal: Array
    particles: Indices
    weights: Array
    least: Any
    holds: Any = False

    def height(self, positions: Array) -> Array:
        """Σ weightᵢ · normal·xᵢ, (...)."""
        return dot(self.normal, _weighted(self.weights, positions[..., self.particles, :]))


def solve(body: ParticleBody, positions: Array, contacts: Sequence[Contact], iterations: int) -> Array:
    """Repair positions: every distance and every contact in turn, several times over (Gauss–Seidel).

    Parameters
    ----------
    body : ParticleBody
        Its links, lengths and masses.
    positions : (..., n, 3)
        Where the particles would be without constraints.
    contacts : sequence of Contact
    iterations : int

    Returns
    -------
    (..., n, 3)
    """
    x, inverse = positions.copy(), body.inverse_masses
    lengths = [float(length) for length in body.lengths]
    for _ in range(iterations):
        for (i, j), length in zip(body.links.tolist(), lengths, strict=True):
            shared = inverse[i] + inverse[j]
            if shared > 0:
                way, distance = unit_or(x[..., j, :] - x[..., i, :], np.eye(3)[0])
                push = scale((distance - length) / shared, way)
                x[..., i, :] += inverse[i] * push
                x[..., j, :] -= inverse[j] * push
        for contact in contacts:
            moves = inverse[contact.particles] * contact.weights
            ease = float(np.sum(moves * contact.weights))
            if ease > 0:
                short = contact.least - contact.height(x)
                short = np.where(contact.holds, short, np.maximum(short, 0.0))
                x[..., contact.particles, :] += moves[:, None] * scale(short / ease, contact.normal)[..., None, :]
    return x


def step(
    body: ParticleBody,
    time_step: float,
    iterations: int,
    acceleration: Any = (0.0, 0.0, 0.0),
    planes: Sequence[HalfSpace] = (),
) -> ParticleBody:
    """Advance by one time step; particles stay outside of half-spaces, into which they come without a bounce.

    Parameters
    ----------
    body : ParticleBody
    time_step : float
    iterations : int
        Rounds of repairs: more of them make the body stiffer.
    acceleration : (..., 3)
        Gravity, for instance.
    planes : sequence of HalfSpace

    Returns
    -------
    ParticleBody
    """
    _check(time_step, iterations)
    free = (body.inverse_masses > 0)[:, None]
    start = body.positions
    moving = np.where(free, body.velocities + time_step * as_floats(acceleration)[..., None, :], body.velocities)
    contacts = []
    for plane in planes:
        normal, length = unit_or(plane.normal, np.eye(3)[0])
        each = [np.array([i]) for i in range(len(body.inverse_masses))]
        contacts += [Contact(normal, i, np.ones(1), -plane.k / length) for i in each]
    return _moved(body, start, solve(body, start + time_step * moving, contacts, iterations), time_step)


def impact_with_plane(
    body: ParticleBody, weights: Any, normal: Any, restitution: float, time_step: float, iterations: int
) -> ParticleBody:
    """Impact of a point of the body with an immovable plane, without friction.

    One time step with the contact as a constraint: after it the point leaves the plane with e times the speed at
    which it came.

    Parameters
    ----------
    body : ParticleBody
    weights : (n,)
        Which point of the body touches: weights of the particles, which sum to 1.
    normal : (3,)
        Out of the plane, of any length but 0.
    restitution : float
        e in [0, 1].
    time_step : float
        The shorter, the less the step bends the motion: velocities err in proportion to it.
    iterations : int

    Returns
    -------
    ParticleBody
        After the step. A body that already leaves moves freely.
    """
    return _impact(body, _point("weights", weights, body), normal, restitution, time_step, iterations)


def impact_between(
    a: ParticleBody,
    b: ParticleBody,
    weights_a: Any,
    weights_b: Any,
    normal: Any,
    restitution: float,
    time_step: float,
    iterations: int,
) -> tuple[ParticleBody, ParticleBody]:
    """Impact of a point of A with a point of B, without friction: as `impact_with_plane`.

    Parameters
    ----------
    a, b : ParticleBody
    weights_a, weights_b : (n,), (m,)
        Which points touch: one particle, a point of an edge or of a face.
    normal : (3,)
        From A to B, of any length but 0.
    restitution : float
        e in [0, 1].
    time_step, iterations

    Returns
    -------
    a, b : ParticleBody
    """
    count = len(a.inverse_masses)
    signed = np.concatenate([-_point("weights_a", weights_a, a), _point("weights_b", weights_b, b)])
    together = ParticleBody(
        _side_by_side(a.positions, b.positions),
        _side_by_side(a.velocities, b.velocities),
        np.concatenate([a.inverse_masses, b.inverse_masses]),
        np.concatenate([a.links, b.links + count]),
        np.concatenate([a.lengths, b.lengths]),
    )
    after = _impact(together, signed, normal, restitution, time_step, iterations)
    return (
        replace(a, positions=after.positions[..., :count, :], velocities=after.velocities[..., :count, :]),
        replace(b, positions=after.positions[..., count:, :], velocities=after.velocities[..., count:, :]),
    )


def _side_by_side(u: Array, v: Array) -> Array:
    batch = np.broadcast_shapes(u.shape[:-2], v.shape[:-2])
    return np.concatenate([np.broadcast_to(x, batch + x.shape[-2:]) for x in (u, v)], axis=-2)


def _impact(
    body: ParticleBody, weights: Array, normal: Any, restitution: float, time_step: float, iterations: int
) -> ParticleBody:
    _check(time_step, iterations)
    if not 0 <= restitution <= 1:
        raise ValueError(f"restitution must be between 0 and 1, got {restitution!r}")
    direction = as_floats(normal)
    if direction.shape[-1:] != (3,) or not np.all(np.isfinite(direction)) or not np.all(np.any(direction, axis=-1)):
        raise ValueError(f"normal must be a finite vector other than 0, got {direction.tolist()!r}")
    n, _ = unit_or(direction, np.eye(3)[0])
    particles = np.flatnonzero(weights)
    contact = Contact(n, particles, weights[particles], 0.0)
    speed = contact.height(body.velocities)
    leaving = contact.height(body.positions) - restitution * time_step * speed
    contact = replace(contact, least=np.where(speed < 0, leaving, -np.inf), holds=speed < 0)
    there = solve(body, body.positions + time_step * body.velocities, [contact], iterations)
    return _moved(body, body.positions, there, time_step)


def _moved(body: ParticleBody, start: Array, there: Array, time_step: float) -> ParticleBody:
    return replace(body, positions=there, velocities=(there - start) / time_step)


def _point(name: str, weights: Any, body: ParticleBody) -> Array:
    value = as_floats(weights)
    if value.shape != body.inverse_masses.shape or not np.all(np.isfinite(value)) or abs(np.sum(value) - 1) > 1e-9:
        raise ValueError(f"{name} must be one for each particle and sum to 1, got {value.tolist()!r}")
    return value


def _check(time_step: float, iterations: int) -> None:
    if not (np.isfinite(time_step) and time_step > 0):
        raise ValueError(f"time_step must be positive and finite, got {time_step!r}")
    if iterations < 0:
        raise ValueError(f"iterations must not be negative, got {iterations!r}")
