"""Rigid bodies in motion: where they are, how they move, and what they oppose to a change of that."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from refimpl.fields import ShapeError
from refimpl.impacts.definite import is_definite
from refimpl.impacts.evaluating import (
    ANGULAR_IMPULSE,
    DIRECTION,
    ENERGY,
    IMPULSE,
    INERTIA,
    INVERSE_MASS,
    LENGTH,
    SPEED,
    TURNING,
    Given,
    batch_shape,
    evaluate,
)
from refimpl.impacts.numbers import Numbers, apply, cross, dot, stack
from refimpl.impacts.reading import Array, at_least_zero, real, refuse
from refimpl.mass import mass_properties
from refimpl.proxy import Proxy, UnsupportedOperation

TAILS: dict[str, tuple[int, ...]] = {
    "position": (3,),
    "velocity": (3,),
    "angular_velocity": (3,),
    "inverse_mass": (),
    "inertia": (3, 3),
}
"""Fields of a body, and their axes beside those of the batch."""


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body, or a batch of them: fields have the same leading axes, or broadcast.

    The numbers stored are the body. Fields given as `fractions.Fraction` stay fractions, and all that is computed from
    the body is then exact.

    Parameters
    ----------
    position : (..., 3), length
        Of the centre of mass.
    velocity : (..., 3), length / time
        Of the centre of mass.
    angular_velocity : (..., 3), radians / time
        In the axes of the world.
    inverse_mass : (...), 1 / mass
        At least 0. 0 is the immovable body: no impulse changes its velocities, which need not be 0.
    inertia : (..., 3, 3), mass · length²
        Tensor about the centre of mass, in the axes of the world; symmetric to the last bit and positive definite.
        Of immovable bodies it is ignored, and if all are it may be left out.

    Raises
    ------
    ShapeError
        A ValueError that names the field and the value.
    """

    position: Array
    velocity: Array
    angular_velocity: Array
    inverse_mass: Array
    inertia: Array | None = None

    if TYPE_CHECKING:  # anything array-like is read

        def __init__(
            self, position: Any, velocity: Any, angular_velocity: Any, inverse_mass: Any, inertia: Any = None
        ) -> None: ...

    def __post_init__(self) -> None:
        found: dict[str, Array] = {}
        for name, tail in TAILS.items():
            value = getattr(self, name)
            if name != "inertia" or value is not None:
                found[name] = real(f"RigidBody.{name}", value, *tail)
        at_least_zero("RigidBody.inverse_mass", found["inverse_mass"])
        _check_inertia(found)
        for name, value in found.items():
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        _ = self.batch_shape

    @classmethod
    def immovable(
        cls, position: Any = (0, 0, 0), velocity: Any = (0, 0, 0), angular_velocity: Any = (0, 0, 0)
    ) -> RigidBody:
        """Give a body of inverse mass 0, which moves as it is told."""
        return cls(position, velocity, angular_velocity, 0)

    @classmethod
    def of(
        cls,
        proxy: Proxy,
        *,
        density: Any = None,
        mass: Any = None,
        velocity: Any = (0, 0, 0),
        angular_velocity: Any = (0, 0, 0),
    ) -> RigidBody:
        """Give the body that a proxy is when it is solid and of uniform density.

        Parameters
        ----------
        proxy : a solid
        density, mass : (...), positive
            One of the two. A mass of infinity makes an immovable body, also of proxies without end, such as the
            half-space; the position of those is the origin, about which they turn if they do.
        velocity, angular_velocity : (..., 3)
        """
        if (density is None) == (mass is None):
            raise ShapeError("RigidBody.of: give either a density or a mass")
        given = np.asarray(density if mass is None else mass, dtype=np.float64)
        name = "density" if mass is None else "mass"
        refuse(name, given, ~(given > 0), "must be positive")
        if mass is None:
            refuse(name, given, ~np.isfinite(given), "must be finite")
        fixed = np.isinf(given)
        try:
            solid = mass_properties(proxy)
        except UnsupportedOperation:
            if not fixed.all():
                raise
            return cls(np.zeros((*proxy.batch_shape, 3)), velocity, angular_velocity, np.zeros(given.shape))
        total = given * solid.volume if mass is None else given
        inertia = solid.of_mass(np.where(fixed, 1.0, total))
        inertia = (inertia + np.swapaxes(inertia, -1, -2)) / 2
        return cls(solid.barycentre, velocity, angular_velocity, np.where(fixed, 0.0, 1.0 / total), inertia)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the leading axes."""
        shapes = {}
        for name, tail in TAILS.items():
            value = getattr(self, name)
            if value is not None:
                shapes[f"RigidBody.{name}"] = value.shape[: value.ndim - len(tail)]
        return batch_shape(shapes)

    def __getitem__(self, index: Any) -> RigidBody:
        """Bodies at `index` of the batch axes."""
        batch = self.batch_shape
        parts: dict[str, Any] = {}
        for name, tail in TAILS.items():
            value = getattr(self, name)
            parts[name] = None if value is None else np.broadcast_to(value, batch + tail)[index]
        return RigidBody(**parts)

    def moved(self, shift: Any) -> RigidBody:
        """Give the same body elsewhere: translated by `shift` (..., 3)."""
        given = {"shift": Given(real("shift", shift, 3), LENGTH, 1), "position": Given(self.position, LENGTH, 1)}
        return replace(self, position=evaluate(_moved, given, (LENGTH,))[0])

    def with_velocities(self, velocity: Any, angular_velocity: Any) -> RigidBody:
        """Give the same body, moving otherwise."""
        return replace(self, velocity=velocity, angular_velocity=angular_velocity)

    def velocity_at(self, point: Any) -> Array:
        """Velocity (..., 3) of the body's matter at a point of the world (..., 3): v + ω × (point − position)."""
        given = {**self.motion(), "point": Given(real("point", point, 3), LENGTH, 1)}
        return evaluate(_velocity_at, given, (SPEED,))[0]

    def momentum(self) -> Array:
        """Linear momentum (..., 3), mass · velocity; immovable bodies have none that is finite, and raise an error."""
        return evaluate(_momentum, self._massive("velocity", "w"), (IMPULSE,))[0]

    def angular_momentum(self, about: Any = (0, 0, 0)) -> Array:
        """Angular momentum (..., 3) about a point of the world (..., 3); immovable bodies raise an error."""
        given = self._massive("position", "velocity", "spin", "w", "inertia")
        given["about"] = Given(real("about", about, 3), LENGTH, 1)
        return evaluate(_angular_momentum, given, (ANGULAR_IMPULSE,))[0]

    def kinetic_energy(self) -> Array:
        """½ m v² + ½ ω·Iω (...); immovable bodies raise an error."""
        return evaluate(_kinetic_energy, self._massive("velocity", "spin", "w", "inertia"), (ENERGY,))[0]

    def motion(self, suffix: str = "") -> dict[str, Given]:
        """Where it is and how it moves, for formulas; the names end in `suffix`."""
        return {
            f"position{suffix}": Given(self.position, LENGTH, 1),
            f"velocity{suffix}": Given(self.velocity, SPEED, 1),
            f"spin{suffix}": Given(self.angular_velocity, TURNING, 1),
        }

    def matter(self, suffix: str = "") -> dict[str, Given]:
        """Inverse mass and inertia, for formulas; where the inertia is ignored it is 0."""
        inertia = np.zeros((3, 3)) if self.inertia is None else self.inertia
        fixed = np.asarray(self.inverse_mass == 0)[..., None, None]
        return {
            f"w{suffix}": Given(self.inverse_mass, INVERSE_MASS),
            f"inertia{suffix}": Given(np.where(fixed, 0, inertia), INERTIA, 2),
        }

    def _massive(self, *names: str) -> dict[str, Given]:
        fixed = self.inverse_mass == 0
        refuse("RigidBody.inverse_mass", self.inverse_mass, fixed, "must not be 0 for momentum and kinetic energy")
        given = {**self.motion(), **self.matter()}
        return {name: given[name] for name in names}


class Moving(NamedTuple):
    """A body in a formula: v and spin ω are its velocities, w its inverse mass."""

    position: Numbers
    velocity: Numbers
    spin: Numbers
    w: Numbers
    inertia: Numbers


def moving(given: dict[str, Numbers], suffix: str) -> Moving:
    """Put together what `RigidBody.motion` and `RigidBody.matter` gave to a formula."""
    return Moving(*(given[name + suffix] for name in Moving._fields))


def inertia_tensor(moments: Any, rotation: Any) -> Array:
    """Inertia tensor in the axes of the world, of a body whose own axes are principal.

    Parameters
    ----------
    moments : (..., 3), at least 0
        Principal moments of inertia.
    rotation : (..., 4)
        Quaternion (x, y, z, w) from the body's axes to the world's, of any length but 0.

    Returns
    -------
    (..., 3, 3)
        R diag(moments) Rᵀ, symmetric to the last bit; exact for fractions.
    """
    diagonal = real("moments", moments, 3)
    refuse("moments", diagonal, (diagonal < 0).any(axis=-1), "must be at least 0")
    q = real("rotation", rotation, 4)
    refuse("rotation", q, (q == 0).all(axis=-1), "must not be zero")
    given = {"moments": Given(diagonal, INERTIA, 1), "q": Given(q, DIRECTION, 1)}
    return evaluate(_turned, given, (INERTIA,))[0]


def _check_inertia(found: dict[str, Array]) -> None:
    moves = np.asarray(found["inverse_mass"] > 0, dtype=bool)
    if not moves.any():
        return
    name = "RigidBody.inertia"
    if "inertia" not in found:
        raise ShapeError(f"{name}: needed, as not all bodies are immovable")
    inertia = found["inertia"]
    batch = batch_shape({"RigidBody.inverse_mass": moves.shape, name: inertia.shape[:-2]})
    every, moves = np.broadcast_to(inertia, (*batch, 3, 3)), np.broadcast_to(moves, batch)
    refuse(
        name,
        every,
        moves & (every != np.swapaxes(every, -1, -2)).any(axis=(-1, -2)),
        "must be symmetric, to the last bit: take (I + Iᵀ) / 2",
    )
    refuse(name, every, moves & ~np.broadcast_to(is_definite(inertia), batch), "must be positive definite")


def _moved(position: Numbers, shift: Numbers) -> tuple[Numbers]:
    return (position + shift,)


def _velocity_at(position: Numbers, velocity: Numbers, spin: Numbers, point: Numbers) -> tuple[Numbers]:
    return (velocity + cross(spin, point - position),)


def _momentum(velocity: Numbers, w: Numbers) -> tuple[Numbers]:
    return (1 / w * velocity,)


def _angular_momentum(
    position: Numbers, velocity: Numbers, spin: Numbers, w: Numbers, inertia: Numbers, about: Numbers
) -> tuple[Numbers]:
    return (apply(inertia, spin) + 1 / w * cross(position - about, velocity),)


def _kinetic_energy(velocity: Numbers, spin: Numbers, w: Numbers, inertia: Numbers) -> tuple[Numbers]:
    return ((dot(velocity, velocity) / w + dot(spin, apply(inertia, spin))) / 2,)


def _turned(moments: Numbers, q: Numbers) -> tuple[Numbers]:
    """R = 1 + 2 (w [q] + [q][q]) / |q|² by columns; then Σ moment · column columnᵀ."""
    vector, w = q[:3], q[3]
    double = 2 / (dot(vector, vector) + w * w)
    tensor: Numbers = 0
    for axis in range(3):
        unit = stack([moments[axis] * 0 + int(i == axis) for i in range(3)])
        once = cross(vector, unit)
        column = unit + double * (w * once + cross(vector, once))
        tensor = stack([moments[axis] * column[i] * column for i in range(3)]) + tensor
    return ((tensor + stack([tensor[:, i] for i in range(3)])) / 2,)
