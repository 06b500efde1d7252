"""A body of a world, and the state of all of them as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from refimpl.fields import IDENTITY
from refimpl.impacts.bodies import RigidBody
from refimpl.linear import Array, Bools, apply, as_floats, quaternion_product, rotation_matrix, scale
from refimpl.mass import MassProperties, mass_properties
from refimpl.proxy import Proxy, ShapeError
from refimpl.signs import Indices
from refimpl.volumes import bounding_volume, require_around


@dataclass(frozen=True, eq=False, init=False)
class Body:
    """What can collide: a collider with a bounding volume around it, where it is, and how it moves.

    Parameters
    ----------
    collider : Proxy
        A single solid, in a frame of its own.
    volume : Proxy, optional
        Contains the collider, in the same frame; tested first. A ball, if none is given. An `AABB` is fitted anew
        wherever the body is.
    position : (3,), rotation : (4,)
        Where that frame is: x ↦ R(rotation) x + position, a quaternion (x, y, z, w) of any length but 0.
    velocity, angular_velocity : (3,)
        Of the centre of mass; in the axes of the world, radians / time.
    mass : float
        Positive; infinite for a static body, which no impulse moves: it keeps its velocities.
    matter : MassProperties, optional
        Over what the mass is spread, in the same frame; evenly over the collider, if nothing else is given.

    Raises
    ------
    ShapeError
        Names the field and the value.
    """

    collider: Proxy
    volume: Proxy
    position: Array
    rotation: Array
    velocity: Array
    angular_velocity: Array
    mass: float
    matter: MassProperties | None

    def __init__(
        self,
        collider: Proxy,
        volume: Proxy | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = IDENTITY,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        mass: float = np.inf,
        matter: MassProperties | None = None,
    ) -> None:
        if not (isinstance(collider, Proxy) and collider.is_solid and not collider.batch_shape):
            raise ShapeError(f"Body.collider: expected a single solid, got {collider!r}")
        if not mass > 0:
            raise ShapeError(f"Body.mass must be positive, or infinite for a static body, got {mass!r}")
        around = bounding_volume(collider) if volume is None else volume
        require_around(around, collider)
        vectors = {
            "position": _finite("position", position, 3),
            "rotation": _finite("rotation", rotation, 4),
            "velocity": _finite("velocity", velocity, 3),
            "angular_velocity": _finite("angular_velocity", angular_velocity, 3),
        }
        for name, value in {"collider": collider, "volume": around, **vectors, "mass": mass, "matter": matter}.items():
            object.__setattr__(self, name, value)


def _finite(name: str, given: ArrayLike, size: int) -> Array:
    value = as_floats(given)
    if value.shape != (size,) or not np.all(np.isfinite(value)) or (name == "rotation" and not value.any()):
        raise ShapeError(f"Body.{name}: expected {size} finite numbers, got {given!r}")
    return value


@dataclass
class State:
    """Where all bodies of a world are and how they move: arrays over the bodies, which change as the world does.

    Attributes
    ----------
    center, velocity, spin : (n, 3)
        Centre of mass and its velocity; angular velocity.
    rotation : (n, 4)
    inverse_mass : (n,)
    arm : (n, 3), inertia : (n, 3, 3)
        Centre of mass and inertia tensor about it in the body's own frame; of static bodies the origin, and nothing.
    """

    center: Array
    velocity: Array
    spin: Array
    rotation: Array
    inverse_mass: Array
    arm: Array
    inertia: Array
    movable: Bools = field(init=False)

    def __post_init__(self) -> None:
        self.movable = self.inverse_mass > 0

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> State:
        """Take over where bodies are."""
        count = len(bodies)
        arm, inertia = np.zeros((count, 3)), np.zeros((count, 3, 3))
        for number, body in enumerate(bodies):
            if np.isfinite(body.mass):
                found = mass_properties(body.collider) if body.matter is None else body.matter
                arm[number], inertia[number] = found.barycentre, found.of_mass(body.mass)
        fields = {"position": 3, "velocity": 3, "angular_velocity": 3, "rotation": 4}
        position, velocity, spin, rotation = (
            np.array([getattr(body, name) for body in bodies]).reshape(count, width) for name, width in fields.items()
        )
        center = position + apply(rotation_matrix(rotation), arm)
        return cls(center, velocity, spin, rotation, np.array([1.0 / body.mass for body in bodies]), arm, inertia)

    @property
    def position(self) -> Array:
        """Origins (n, 3) of the bodies' own frames."""
        return self.center - apply(rotation_matrix(self.rotation), self.arm)

    def advance(self, dt: float, gravity: Array) -> None:
        """Let time pass: velocities change first, then places by the new velocities (semi-implicit Euler)."""
        self.velocity = self.velocity + np.where(self.movable[:, None], dt * gravity, 0.0)
        self.center = self.center + dt * self.velocity
        turns = np.any(self.spin != 0, axis=1)
        if turns.any():
            turned = quaternion_product(_turn(dt * self.spin[turns]), self.rotation[turns])
            self.rotation[turns] = turned / np.sqrt(np.sum(turned * turned, axis=1))[:, None]

    def rigid(self, ids: Indices) -> RigidBody:
        """Some of the bodies, as the response takes them."""
        matrix = rotation_matrix(self.rotation[ids])
        tensor = matrix @ self.inertia[ids] @ np.swapaxes(matrix, -1, -2)
        tensor = np.where(self.movable[ids, None, None], (tensor + np.swapaxes(tensor, -1, -2)) / 2, np.eye(3))
        return RigidBody(self.center[ids], self.velocity[ids], self.spin[ids], self.inverse_mass[ids], tensor)

    def put(self, ids: Indices, after: RigidBody) -> None:
        """Take over where some bodies are after a response; static ones stay."""
        some = self.movable[ids]
        for name, value in (("center", after.position), ("velocity", after.velocity), ("spin", after.angular_velocity)):
            getattr(self, name)[ids[some]] = value[some]


def _turn(w: Array) -> Array:
    """Quaternions (n, 4) of rotations about vectors (n, 3) by their lengths in radians."""
    half = np.sqrt(np.sum(w * w, axis=1)) / 2
    return np.concatenate([scale(np.sinc(half / np.pi) / 2, w), np.cos(half)[:, None]], axis=1)
