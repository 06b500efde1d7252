"""Impacts in the plane: along the impact line, with spins that are single numbers, and friction across it.

An impact in the plane is one in space whose bodies stay in the plane z = 0 and turn about axes that stand on it. So
nothing is computed twice: bodies are lifted there, and what `refimpl.impacts` answers is read back. All arguments
broadcast, and fractions give fractions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from refimpl.fields import ShapeError
from refimpl.flat.area import area_properties
from refimpl.impacts import bodies, response, rigid
from refimpl.impacts.reading import Array, real, refuse
from refimpl.linear import Bools
from refimpl.proxy import Proxy
from refimpl.results import CollisionData

UNIT = np.eye(3, dtype=np.int64)


def lifted(vector: Any) -> Array:
    """Vectors (..., 2) in the plane z = 0 (..., 3)."""
    array = np.asarray(vector)
    return np.concatenate([array, 0 * array[..., :1]], axis=-1)


@dataclass(frozen=True, eq=False)
class FlatBody:
    """A rigid body that moves in the plane, or a batch of them: fields have the same leading axes, or broadcast.

    Parameters
    ----------
    position : (..., 2), length
        Of the centre of mass.
    velocity : (..., 2), length / time
    angular_velocity : (...), radians / time
        Anticlockwise.
    inverse_mass : (...), 1 / mass
        At least 0, which is the immovable body.
    moment : (...), mass · length²
        Of inertia about the centre of mass, positive. Of immovable bodies it is ignored.

    Raises
    ------
    ShapeError
        A ValueError that names the field and the value.
    """

    position: Array
    velocity: Array
    angular_velocity: Array
    inverse_mass: Array
    moment: Array | None = None

    if TYPE_CHECKING:  # anything array-like is read

        def __init__(
            self, position: Any, velocity: Any, angular_velocity: Any, inverse_mass: Any, moment: Any = None
        ) -> None: ...

    def __post_init__(self) -> None:
        for name, tail in (("position", (2,)), ("velocity", (2,)), ("angular_velocity", ()), ("inverse_mass", ())):
            object.__setattr__(self, name, real(f"FlatBody.{name}", getattr(self, name), *tail))
        if self.moment is not None:
            moment = real("FlatBody.moment", self.moment)
            refuse("FlatBody.moment", moment, (moment <= 0) & (self.inverse_mass > 0), "must be positive")
            object.__setattr__(self, "moment", moment)
        self.solid()

    @classmethod
    def of(
        cls, proxy: Proxy, *, density: Any = None, mass: Any = None, velocity: Any = (0, 0), angular_velocity: Any = 0
    ) -> FlatBody:
        """Give the body that a flat solid is when its density, mass per area, is uniform.

        Give a density or a mass; a mass of infinity makes an immovable body. A `Segment` without a radius has no area,
        but with a mass it is a thin rod.
        """
        if (density is None) == (mass is None):
            raise ShapeError("FlatBody.of: give either a density or a mass")
        plate = area_properties(proxy)
        size = plate.area if mass is None else plate.gyration
        refuse("FlatBody.of", np.asarray(plate.area), size <= 0, "the proxy must have an area, or a mass and a length")
        huge = np.isinf(plate.area) & (mass is None)
        refuse("FlatBody.of", np.asarray(plate.area), huge, "the area is beyond the largest float: give a mass")
        total = np.asarray(density * plate.area if mass is None else mass, dtype=np.float64)
        refuse("FlatBody.of", total, ~(total > 0), "density and mass must be positive")
        moves = np.isfinite(total)
        moment = np.where(moves, total, 1.0) * plate.gyration
        return cls(plate.centroid, velocity, angular_velocity, np.where(moves, 1.0 / total, 0.0), moment)

    def solid(self) -> bodies.RigidBody:
        """Give the body in the plane z = 0 of space."""
        spin = np.asarray(self.angular_velocity)[..., None]
        inertia = None if self.moment is None else np.asarray(self.moment)[..., None, None] * UNIT
        try:
            return bodies.RigidBody(
                lifted(self.position),
                lifted(self.velocity),
                np.concatenate([0 * spin, 0 * spin, spin], axis=-1),
                self.inverse_mass,
                inertia,
            )
        except ShapeError as error:
            raise ShapeError(
                str(error).replace("RigidBody.inertia", "FlatBody.moment").replace("RigidBody", "FlatBody")
            ) from None

    def _after(self, body: bodies.RigidBody) -> FlatBody:
        """Read a body back into the plane."""
        spin = body.angular_velocity[..., 2]
        return FlatBody(body.position[..., :2], body.velocity[..., :2], spin, self.inverse_mass, self.moment)


@dataclass(frozen=True)
class ImpactLine:
    """The line along which two bodies press on each other: through the contact point, along the normal.

    Attributes
    ----------
    point : (..., 2)
    direction : (..., 2)
        From A to B, of any length but 0.
    """

    point: Array
    direction: Array

    @classmethod
    def of(cls, found: CollisionData) -> ImpactLine:
        """Impact line of a collision, at the overlap-free positions; not a number where there is none."""
        point = (found.on_a + found.shift_a) / 2 + (found.on_b + found.shift_b) / 2
        hit = np.asarray(found.hit)[..., None]
        return cls(np.where(hit, point, np.nan), np.where(hit, found.normal, np.nan))

    def lever(self, body: FlatBody) -> Array:
        """Lever arm r × n (...) of a body: what an impulse of 1 along the direction gives it as angular momentum.

        The impact is central where that is 0 for both bodies: the line passes through their centres of mass, and
        without friction neither starts to spin; else it is eccentric.
        """
        r = self.point - body.position
        return np.asarray(r[..., 0] * self.direction[..., 1] - r[..., 1] * self.direction[..., 0])


@dataclass(frozen=True)
class FlatImpact:
    """Outcome of an impact in the plane.

    Attributes
    ----------
    a, b : FlatBody
        After the impact, where they were, or where a response moved them.
    impulse : (..., 2), mass · velocity
        What B receives at the point, and A with the opposite sign.
    point : (..., 2)
    happened : (...) bool
        For a response, whether there was an impact: the proxies intersect, and the bodies approached.
    """

    a: FlatBody
    b: FlatBody
    impulse: Array
    point: Array
    happened: Bools


def impact_in_plane(a: FlatBody, b: FlatBody, line: ImpactLine, restitution: Any, friction: Any = 0) -> FlatImpact:
    """Impact of two bodies in the plane along their impact line, with Coulomb friction across it.

    The law is that of `refimpl.impacts.impact_of_bodies`. Without friction the impulse is −(1 + e) u_n / (w_a + w_b +
    l_a² / I_a + l_b² / I_b) along a unit normal, with the inverse masses w, the lever arms l, and the speed u_n at
    which the points of contact part.
    """
    point = real("line.point", line.point, 2)
    normal = lifted(real("line.direction", line.direction, 2))
    found = rigid.impact_of_bodies(a.solid(), b.solid(), lifted(point), normal, restitution, friction)
    happened = np.ones(found.sticks.shape, dtype=bool)
    return FlatImpact(a._after(found.a), b._after(found.b), found.impulse[..., :2], point, happened)


def respond(found: CollisionData, a: FlatBody, b: FlatBody, restitution: Any, friction: Any = 0) -> FlatImpact:
    """Respond to a collision of flat proxies as `refimpl.impacts.respond` does: overlap-free positions, then impact."""
    vectors = {name: lifted(getattr(found, name)) for name in ("normal", "on_a", "on_b", "shift_a", "shift_b")}
    solid = CollisionData(hit=found.hit, depth=found.depth, least=found.least, **vectors)
    answer = response.respond(solid, a.solid(), b.solid(), restitution, friction)
    after = a._after(answer.a), b._after(answer.b)
    return FlatImpact(*after, answer.impulse[..., :2], answer.point[..., :2], answer.met)
