"""How two proxies move and where they meet: what the scene of an impact has beside its shapes."""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction
from math import prod
from typing import Any

import numpy as np

from refimpl.linear import Array, cross, dot, largest, norm

BODY = {"position": (3,), "velocity": (3,), "angular_velocity": (3,), "inverse_mass": (), "inertia": (3, 3)}
CONTACT = {"point": (3,), "normal": (3,), "restitution": (), "friction": ()}
"""Shapes of the fields, in the order in which they are packed."""


@dataclass(frozen=True)
class Moving:
    """A rigid body in motion; the numbers are the body, and may be floats or Fractions.

    Attributes
    ----------
    position : (..., 3)
        Centre of mass.
    velocity : (..., 3)
    angular_velocity : (..., 3)
        Axis times radians per time.
    inverse_mass : (...)
        0 of an immovable body.
    inertia : (..., 3, 3)
        About the centre of mass, in the axes of the world; means nothing of an immovable body.
    """

    position: Array
    velocity: Array
    angular_velocity: Array
    inverse_mass: Array
    inertia: Array


@dataclass(frozen=True)
class Motion:
    """Two bodies about to touch in one point.

    Attributes
    ----------
    a, b : Moving
    point : (..., 3)
        Where they touch; of an edge or face that lands flat its middle.
    normal : (..., 3)
        From A to B, of any length but 0.
    restitution, friction : (...)
        The coefficients e, in [0, 1], and μ, at least 0.
    """

    a: Moving
    b: Moving
    point: Array
    normal: Array
    restitution: Array
    friction: Array

    def pack(self) -> Array:
        """Every number, (..., `WIDTH`)."""
        parts = [(getattr(body, name), shape) for body in (self.a, self.b) for name, shape in BODY.items()]
        parts += [(getattr(self, name), shape) for name, shape in CONTACT.items()]
        lead = np.shape(self.restitution)
        return np.concatenate([np.reshape(value, (*lead, prod(shape))) for value, shape in parts], axis=-1)

    @classmethod
    def unpack(cls, numbers: Array) -> Motion:
        """Rebuild from what `pack` gives, of whatever kind the numbers are."""
        at = 0

        def read(shape: tuple[int, ...]) -> Array:
            nonlocal at
            start, at = at, at + prod(shape)
            return numbers[..., start:at].reshape((*numbers.shape[:-1], *shape))

        a, b = (Moving(**{name: read(shape) for name, shape in BODY.items()}) for _ in range(2))
        return cls(a, b, **{name: read(shape) for name, shape in CONTACT.items()})

    def __getitem__(self, rows: Any) -> Motion:
        """Pick rows of a batch, or add an axis to a single one."""
        return Motion.unpack(self.pack()[(*rows, slice(None)) if isinstance(rows, tuple) else rows])

    def __len__(self) -> int:
        """Return the number of rows of a batch."""
        return len(self.restitution)

    def exact(self) -> Motion:
        """The same numbers as Fractions."""
        return Motion.unpack(exact(self.pack()))

    @property
    def approach(self) -> Array:
        """Relative velocity of the two points of contact, B's against A's, (..., 3)."""
        velocities = [b.velocity + cross(b.angular_velocity, self.point - b.position) for b in (self.b, self.a)]
        return np.asarray(velocities[0] - velocities[1])

    @property
    def closing(self) -> Array:
        """Approach along the normal, times its length, (...): negative of bodies that come nearer."""
        return dot(self.approach, self.normal)

    @property
    def speed(self) -> Array:
        """Largest velocity in the scene, (...): of a centre, or due to spin at the distance of the contact."""
        found = []
        for body in (self.a, self.b):
            lever = norm(self.point - body.position)
            found += [largest(body.velocity), largest(body.angular_velocity) * lever]
        return np.asarray(np.max(found, axis=0))

    def to_json(self) -> dict[str, Any]:
        """Plain data, by name, from which `from_json` rebuilds a single one to the bit."""
        bodies = {side: {name: getattr(body, name).tolist() for name in BODY} for side, body in self._sides}
        return bodies | {name: getattr(self, name).tolist() for name in CONTACT}

    @property
    def leaves_the_plane(self) -> bool:
        """Whether anything of a motion is out of the plane z = 0: a place, a velocity, a spin about another axis."""
        level = [self.point, self.normal, *(v for body in self.bodies for v in (body.position, body.velocity))]
        spins = [body.angular_velocity[..., :2] for body in self.bodies]
        return any(np.any(v[..., 2] != 0) for v in level) or any(np.any(spin != 0) for spin in spins)

    @property
    def bodies(self) -> tuple[Moving, Moving]:
        """Both bodies."""
        return self.a, self.b

    @property
    def _sides(self) -> tuple[tuple[str, Moving], ...]:
        return ("a", self.a), ("b", self.b)

    @classmethod
    def from_json(cls, data: Any) -> Motion:
        """Rebuild a single one; raises `ValueError` for data that is none."""
        try:
            a, b = (Moving(**{n: _numbers(data[side][n], n, shape) for n, shape in BODY.items()}) for side in "ab")
            contact = {name: _numbers(data[name], name, shape) for name, shape in CONTACT.items()}
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a motion: {error}") from None
        for name, low, high in (("restitution", 0, 1), ("friction", 0, np.inf)):
            if not low <= contact[name] <= high:
                raise ValueError(f"not a motion: {name} must be from {low} to {high}, got {contact[name]}")
        if a.inverse_mass < 0 or b.inverse_mass < 0:
            raise ValueError("not a motion: inverse_mass must not be negative")
        if not contact["normal"].any():
            raise ValueError("not a motion: normal must not be 0")
        return cls(a, b, **contact)


WIDTH = 2 * sum(prod(shape) for shape in BODY.values()) + sum(prod(shape) for shape in CONTACT.values())
assert [field.name for field in fields(Moving)] == list(BODY)


def _numbers(values: Any, name: str, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"not a motion: {name} must be finite numbers of shape {shape}")
    return array


def exact(numbers: Any) -> Any:
    """Floats as the Fractions that they are, in an array of objects."""
    array = np.asarray(numbers, dtype=np.float64)
    return np.array([Fraction(x) for x in array.ravel().tolist()], dtype=object).reshape(array.shape)
