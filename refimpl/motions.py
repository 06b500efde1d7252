"""Motions over the time from 0 to 1: translations, and rigid motions with constant velocities.

The numbers stored are the motion: a translation by a vector of doubles has one exact meaning, whatever the place of
the shape that it moves. `None` in place of a motion means rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from refimpl.fields import vector
from refimpl.linear import Array, apply, as_floats, rotation_matrix, scale, unit_or
from refimpl.proxy import Proxy
from refimpl.record import Record

AXIS = np.array([1.0, 0.0, 0.0])

P = TypeVar("P", bound=Proxy)


@dataclass(frozen=True, eq=False, repr=False)
class Translation(Record):
    """The motion x(t) = x + t·vector.

    Parameters
    ----------
    vector : (..., 3)
        The way of the whole motion, from t = 0 to 1; zero is rest.
    """

    vector: Array = vector()

    if TYPE_CHECKING:

        def __init__(self, vector: ArrayLike) -> None: ...

    def carried(self, points: Any, t: Any) -> Array:
        """Give the places of points (..., 3) at times `t` (...)."""
        return as_floats(points) + scale(as_floats(t), self.vector)

    def placed(self, shape: P, t: Any) -> P:
        """Give a shape as it is at times `t` (...), up to rounding."""
        return shape.translated(scale(as_floats(t), self.vector))


@dataclass(frozen=True, eq=False, repr=False)
class FlatTranslation(Translation):
    """The motion x(t) = x + t·vector in the plane.

    Parameters
    ----------
    vector : (..., 2)
        The way of the whole motion, from t = 0 to 1; zero is rest.
    """

    vector: Array = vector(width=2)


@dataclass(frozen=True, eq=False, repr=False)
class RigidMotion(Record):
    """The motion x(t) = center + t·linear + R(t·angular)·(x − center), with constant velocities.

    R(w) is the rotation about w by ‖w‖ radians, counter-clockwise seen against w.

    Parameters
    ----------
    linear : (..., 3)
        Velocity of the centre.
    angular : (..., 3)
        Angular velocity, in radians; zero makes a translation.
    center : (..., 3)
        The point about which the shape turns, where it is at t = 0.
    """

    linear: Array = vector()
    angular: Array = vector()
    center: Array = vector()

    if TYPE_CHECKING:

        def __init__(self, linear: ArrayLike, angular: ArrayLike, center: ArrayLike) -> None: ...

    def rotation(self, t: Any) -> Array:
        """Give the unit quaternion (x, y, z, w) of R(t·angular) at times `t` (...)."""
        axis, rate = unit_or(self.angular, AXIS)
        half = 0.5 * as_floats(t) * rate
        return np.concatenate([scale(np.sin(half), axis), np.cos(half)[..., None]], axis=-1)

    def carried(self, points: Any, t: Any) -> Array:
        """Give the places of points (..., 3) at times `t` (...)."""
        turned = apply(rotation_matrix(self.rotation(t)), as_floats(points) - self.center)
        return self.center + scale(as_floats(t), self.linear) + turned

    def placed(self, shape: P, t: Any) -> P:
        """Give a shape as it is at times `t` (...), up to rounding."""
        moved = shape.translated(-self.center).rotated(self.rotation(t))
        return moved.translated(self.center + scale(as_floats(t), self.linear))


Motion: TypeAlias = Translation | RigidMotion

REST = Translation(np.zeros(3))
FLAT_REST = FlatTranslation(np.zeros(2))


def as_motion(motion: Motion | None, dimension: int = 3) -> Motion:
    """Read a motion of a proxy of space, or of the plane; `None` is rest."""
    if motion is None:
        return REST if dimension == 3 else FLAT_REST
    if not isinstance(motion, Translation | RigidMotion):
        raise TypeError(f"a motion is a Translation, a RigidMotion or None, got {type(motion).__name__}: {motion!r}")
    if isinstance(motion, FlatTranslation) != (dimension == 2):
        wanted = "of a flat proxy is a FlatTranslation" if dimension == 2 else "in space is no FlatTranslation"
        raise TypeError(f"a motion {wanted}, got {motion!r}")
    return motion
