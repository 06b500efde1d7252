"""How two proxies move during a sweep: what its scene has beside its shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oracles.world import PLANE, is_flat, world_of
from refimpl.linear import Array, Bools, norm, scale
from refimpl.motions import FlatTranslation, Motion, RigidMotion, Translation
from refimpl.shapes import AABB, KDOP, Composite, HalfSpace, Proxy
from refimpl.supports import support

NUMBERS = ("linear", "angular", "center")
"""Fields of one side, in the order in which they are packed."""
SIDE = RigidMotion.width()
WIDTH = 2 * SIDE
LARGEST = 1e150
"""No motion of a scene from a stranger has larger numbers."""


@dataclass(frozen=True)
class Course:
    """The motions of A and B from t = 0 to 1, single or in a batch.

    A side without angular velocity is translated, whatever its centre.
    """

    a: RigidMotion
    b: RigidMotion

    @classmethod
    def translating(cls, linear_a: Any, linear_b: Any) -> Course:
        """Translations by two vectors (..., 3)."""
        a, b = np.broadcast_arrays(np.asarray(linear_a, dtype=float), np.asarray(linear_b, dtype=float))
        return cls(*(RigidMotion(linear, np.zeros_like(linear), np.zeros_like(linear)) for linear in (a, b)))

    def pack(self) -> Array:
        """Every number, (..., `WIDTH`)."""
        return np.concatenate([self.a.pack(), self.b.pack()], axis=-1)

    @classmethod
    def unpack(cls, numbers: Array) -> Course:
        """Rebuild from what `pack` gives."""
        return cls(RigidMotion.unpack(numbers[..., :SIDE]), RigidMotion.unpack(numbers[..., SIDE:]))

    def __getitem__(self, rows: Any) -> Course:
        """Pick rows of a batch, or add an axis to a single one."""
        return Course(self.a[rows], self.b[rows])

    def __len__(self) -> int:
        """Return the number of rows of a batch."""
        return len(self.a)

    @property
    def sides(self) -> tuple[RigidMotion, RigidMotion]:
        """Both motions."""
        return self.a, self.b

    @property
    def motions(self) -> tuple[Motion, Motion]:
        """Both motions as the reference takes them: a translation, where nothing of that side turns."""
        a, b = (side if np.any(side.angular != 0) else Translation(side.linear) for side in self.sides)
        return a, b

    @property
    def flat_motions(self) -> tuple[FlatTranslation, FlatTranslation]:
        """Both motions as the reference takes those of flat proxies."""
        a, b = (FlatTranslation(PLANE.vectors(side.linear)) for side in self.sides)
        return a, b

    def motions_of(self, shape: Proxy) -> tuple[Motion, Motion]:
        """Both motions as the reference takes them, for proxies of the world of `shape`."""
        return self.flat_motions if is_flat(shape) else self.motions

    @property
    def leaves_the_plane(self) -> bool:
        """Whether any of the two moves out of the plane z = 0."""
        return bool(np.any(self.turns) or any(np.any(side.linear[..., 2] != 0) for side in self.sides))

    @property
    def turns(self) -> Bools:
        """Whether any of the two turns, (...)."""
        return np.asarray(np.any(self.a.angular != 0, axis=-1) | np.any(self.b.angular != 0, axis=-1))

    @property
    def reach(self) -> Array:
        """Largest coordinate of the ways and the centres, (...): places are rounded to it."""
        numbers = [np.abs(side.linear).max(axis=-1) for side in self.sides]
        numbers += [
            np.where(np.any(side.angular != 0, axis=-1), np.abs(side.center).max(axis=-1), 0.0) for side in self.sides
        ]
        return np.asarray(np.max(numbers, axis=0))

    def way(self, a: Proxy, b: Proxy) -> Array:
        """How far any two points of A and B move against each other in the whole of the time at most, (...)."""
        found = norm(self.a.linear - self.b.linear)
        for shape, side in ((a, self.a), (b, self.b)):
            if np.any(side.angular != 0):
                found = found + norm(side.angular) * _farthest(shape, side.center)
        return np.asarray(found)

    def at(self, a: Proxy, b: Proxy, t: Any) -> tuple[Proxy, Proxy]:
        """Both as they are at times `t` (...), up to rounding."""
        return placed(a, self.a, t), placed(b, self.b, t)

    def to_json(self) -> dict[str, Any]:
        """Plain data, by name, from which `from_json` rebuilds a single one to the bit."""
        sides = (("a", self.a), ("b", self.b))
        return {name: {field: getattr(side, field).tolist() for field in NUMBERS} for name, side in sides}

    @classmethod
    def from_json(cls, data: Any) -> Course:
        """Rebuild a single one; raises `ValueError` for data that is none."""
        try:
            return cls(*(RigidMotion(*(_vector(data[side][name], name) for name in NUMBERS)) for side in "ab"))
        except (KeyError, TypeError) as error:
            raise ValueError(f"not a course: {error}") from None


def placed(shape: Proxy, motion: RigidMotion, t: Any) -> Proxy:
    """A shape as it is at times `t` (...), up to rounding."""
    if np.any(motion.angular != 0):
        return motion.placed(shape, t)
    return shape.translated(world_of(shape).vectors(scale(np.asarray(t, dtype=float), motion.linear)))


def can_turn(shape: Proxy) -> bool:
    """Whether a shape may turn in a sweep: its axes, or those of all its parts, are its own, and it has an end."""
    if isinstance(shape, Composite):
        return all(can_turn(part) for part in shape.parts)
    return not (is_flat(type(shape)) or isinstance(shape, AABB | KDOP | HalfSpace))


def _farthest(shape: Proxy, center: Array) -> Array:
    """Bound on how far a shape reaches from a point: to the farthest corner of its bounding box."""
    sides = [
        np.maximum(support(shape, axis) - center[..., i], support(shape, -axis) + center[..., i])
        for i, axis in enumerate(np.eye(3))
    ]
    return norm(np.stack(sides, axis=-1))


def _vector(values: Any, name: str) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != (3,) or not (np.abs(array) < LARGEST).all():
        raise ValueError(f"not a course: {name} must be three numbers below {LARGEST:g}")
    return array
