"""Models in scenes: posed as hulls, solids and composites, and the simple proxies that people put around them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oracles.bodies import IDENTITY, QUARTER_TURNS, Z_AXIS
from oracles.draws import Draws, quaternions
from oracles.library import Library
from oracles.models import COMPOSITE, HULL, SOLID, Model
from oracles.solids import K_DIRECTIONS
from refimpl.bounds import aabb
from refimpl.linear import Array, Bools, apply, dot, norm, rotation_matrix, scale
from refimpl.shapes import (
    AABB,
    KDOP,
    Box,
    Capsule,
    ConvexPolyhedron,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Point,
    Proxy,
    Ray,
    Sphere,
)

FORM_OF = {"Polyhedron": SOLID, "Composite": COMPOSITE}
"""Forms of the types that are not made from a model's hull."""


@dataclass(frozen=True)
class Posed:
    """One model in the poses x ↦ position + R(rotation)·x of a batch.

    Attributes
    ----------
    form
        The model in its own frame.
    middle, half
        The box around it there, (3,).
    """

    form: Proxy
    middle: Array
    half: Array
    position: Array
    rotation: Array
    draws: Draws

    @property
    def size(self) -> float:
        """Half the diagonal of the model's box."""
        return float(norm(self.half))

    @property
    def center(self) -> Array:
        """Middle of the model's box in the scenes, (n, 3)."""
        return self._out(self.middle)

    def _out(self, points: Array) -> Array:
        """Points (..., 3) of the model's frame in the scenes, (n, ..., 3)."""
        matrix = rotation_matrix(self.rotation)
        extra = (1,) * (points.ndim - 1)
        matrix = matrix.reshape(matrix.shape[0], *extra, 3, 3)
        return self.position.reshape(-1, *extra, 3) + apply(matrix, points)

    @property
    def corners(self) -> Array:
        """Vertices of the hull in the scenes, (n, m, 3)."""
        assert isinstance(self.form, ConvexPolyhedron)
        return self._out(self.form.numbers)

    @property
    def axis(self) -> Array:
        """The model's z axis in the scenes."""
        return apply(rotation_matrix(self.rotation), np.broadcast_to(Z_AXIS, self.position.shape))

    @property
    def spine(self) -> tuple[Array, Array, Array]:
        """Ends and radius of a capsule or cylinder along the longest side of the box, around the box's sides."""
        long = int(np.argmax(self.half))
        ends = [self.middle + sign * np.where(np.arange(3) == long, self.half, 0.0) for sign in (-1.0, 1.0)]
        radius = float(np.hypot(*np.delete(self.half, long)))
        return self._out(ends[0]), self._out(ends[1]), np.full(len(self.position), radius)

    def make(self, kind: type[Proxy]) -> Proxy:
        """The model as a proxy of this type, or the simple proxy of the type that one would put around it."""
        made: dict[str, Callable[[], Proxy]] = {
            "Point": lambda: Point(self._one_corner()),
            "Ray": self._ray,
            "Sphere": lambda: Sphere(self.center, np.max(norm(self.corners - self.center[:, None]), axis=-1)),
            "Capsule": lambda: Capsule(*self.spine),
            "HalfSpace": lambda: HalfSpace(self.axis, -dot(self.axis, self._one_corner())),
            "AABB": lambda: AABB(self.corners.min(axis=1), self.corners.max(axis=1)),
            "Box": lambda: Box(self.center, self.half, self.rotation),
            "KDOP": self._kdop,
            "Ellipsoid": lambda: Ellipsoid(self.center, np.sqrt(3.0) * self.half, self.rotation),
            "Cylinder": lambda: Cylinder(*self.spine),
        }
        if kind.__name__ in made:
            return made[kind.__name__]()
        return self.form.rotated(self.rotation).translated(self.position)

    def _one_corner(self) -> Array:
        """A vertex of the model, another in each scene."""
        corners = self.corners
        index = (self.draws.uniform(0.0, 1.0) * corners.shape[1]).astype(int)
        return np.asarray(corners[np.arange(len(corners)), np.minimum(index, corners.shape[1] - 1)])

    def _ray(self) -> Ray:
        """A ray that is aimed at a vertex or at the middle."""
        at_corner = self.draws.choice((0.0, 1.0)) == 1
        goal = np.where(at_corner[:, None], self._one_corner(), self.center)
        back = self.draws.uniform(0.0, 6.0) * self.size
        return Ray(goal - scale(back, self.axis), scale(self.draws.uniform(0.25, 4.0), self.axis))

    def _kdop(self) -> KDOP:
        """The 26-DOP around the model."""
        directions = np.broadcast_to(K_DIRECTIONS[26], (len(self.position), 13, 3))
        reach = dot(directions[:, :, None, :], self.corners[:, None, :, :])
        return KDOP(directions, reach.min(axis=-1), reach.max(axis=-1))


def box_around(form: Proxy) -> tuple[Array, Array]:
    """Middle and half extents of the box around a single proxy."""
    box = aabb(form)
    return box.lower / 2 + box.upper / 2, box.upper / 2 - box.lower / 2


def posed(draws: Draws, model: Model, form: str, middle: Array) -> Posed:
    """Poses of a model: as it was made, in quarter turns or turned anyhow, with its middle about `middle` (n, 3)."""
    shape = model.form(form)
    own, half = box_around(shape)
    sort = draws.choice((0.0, 1.0, 2.0))[:, None]
    quarter = QUARTER_TURNS[draws.choice(range(len(QUARTER_TURNS))).astype(int)]
    rotation = np.where(sort == 0, IDENTITY, np.where(sort == 1, quarter, quaternions(draws)))
    position = middle - apply(rotation_matrix(rotation), np.broadcast_to(own, middle.shape))
    return Posed(shape, own, half, position, rotation, draws)


def placed_pair(
    draws: Draws, library: Library, kind_a: type[Proxy], kind_b: type[Proxy]
) -> tuple[Proxy, Proxy, Array, Bools]:
    """Two models, or simple proxies around models, near each other.

    Returns
    -------
    a, b
        One model each for the whole batch.
    gap : (n,)
        Where the pair is to stand: touching, or up to a tenth of the smaller model apart or inside.
    moved : (n,) bool
        Whether it is to stand so; the others stay as they are, deep in each other or apart.
    """
    forms = [FORM_OF.get(kind.__name__, HULL) for kind in (kind_a, kind_b)]
    first, second = (library.pick(draws, form) for form in forms)
    draws.about = f" of {first.label} and {second.label}"
    a = posed(draws, first, forms[0], np.zeros((draws.n, 3)))
    aside = draws.uniform(-1.0, 1.0, 3)
    b = posed(draws, second, forms[1], a.center + scale(np.full(draws.n, a.size), aside))
    near = draws.choice((0.0, 1.0)) * draws.uniform(-0.1, 0.1)
    moved = draws.choice((1.0, 1.0, 0.0)) == 1
    return a.make(kind_a), b.make(kind_b), near * min(a.size, b.size), moved
