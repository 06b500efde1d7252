"""Convex bodies about their pivots: what a rigid motion turns, and how far it swings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from refimpl.bounds import bounding_sphere
from refimpl.linear import Array, apply, apply_inverse, cross, largest, norm, rotation_matrix, scale, unit_or
from refimpl.motions import AXIS, Motion, RigidMotion, Translation
from refimpl.proxy import Proxy
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
    Sphere,
)
from refimpl.supports import support

STILL = np.array([0.0, 0.0, 0.0, 1.0])
SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@dataclass(frozen=True)
class Turning:
    """A batch of convex bodies of one type, each about its own pivot.

    Attributes
    ----------
    shape : Proxy with one batch axis
        In coordinates about the pivot, as it is at t = 0; of a type that can be turned.
    motion : RigidMotion with one batch axis
    reach, swing : (n,)
        Largest distance of a point of the body's core from the pivot, and from the axis through it: of a sphere or
        capsule only its centre or segment swings.
    size : (n,)
        Largest number that rounding errors are relative to.
    """

    shape: Proxy
    motion: RigidMotion
    reach: Array
    swing: Array
    size: Array

    def __getitem__(self, index: Any) -> Turning:
        """Bodies at `index`."""
        chosen = self.reach[index], self.swing[index], self.size[index]
        return Turning(self.shape[index], self.motion[index], *chosen)

    def __len__(self) -> int:
        return len(self.reach)

    def placed(self, t: Array) -> Proxy:
        """The bodies at times t, about their pivots."""
        return self.shape.rotated(self.motion.rotation(t))

    def pivot(self, t: Array) -> Array:
        """Where the pivots are at times t."""
        return np.asarray(self.motion.center + scale(t, self.motion.linear))

    def velocity(self, arm: Array) -> Array:
        """Velocity of points `arm` off the pivot."""
        return np.asarray(self.motion.linear + cross(self.motion.angular, arm))

    def height(self, n: Array, t: Array) -> Array:
        """How far the bodies reach along n, from their pivots, at times t."""
        return support(self.shape, apply_inverse(rotation_matrix(self.motion.rotation(t)), n))

    def outward(self, t: Array) -> Array:
        """Unit normals of half-spaces at times t."""
        assert isinstance(self.shape, HalfSpace)
        return apply(rotation_matrix(self.motion.rotation(t)), unit_or(self.shape.normal, AXIS)[0])

    @property
    def level(self) -> Array:
        """How far the planes of half-spaces are from the pivots."""
        assert isinstance(self.shape, HalfSpace)
        return np.asarray(-self.shape.k / norm(self.shape.normal))

    @property
    def rate(self) -> Array:
        """Angular speed."""
        return norm(self.motion.angular)


def as_rigid(motion: Motion) -> RigidMotion:
    """A translation as a rigid motion that does not turn."""
    if isinstance(motion, Translation):
        return RigidMotion(motion.vector, np.zeros(3), np.zeros(3))
    return motion


def turning(shape: Proxy, motion: Motion) -> Turning:
    """Bodies about their pivots.

    Without a rotation there is no pivot: the body is taken about its own place, where its numbers are small.
    """
    rigid = as_rigid(motion)
    solid = turnable(shape)
    still = np.all(rigid.angular == 0, axis=-1)[..., None]
    about = RigidMotion(rigid.linear, rigid.angular, np.where(still, _place(shape), rigid.center))
    relative: Proxy = solid.translated(-about.center)
    points, extra = CORES[type(relative)](relative)
    axis, rate = unit_or(about.angular, AXIS)
    reach = np.max(norm(points), axis=-1) + extra
    round_about = extra
    if isinstance(relative, Cylinder):  # about its own axis it turns into itself
        round_about = np.where(np.all(cross(rigid.angular, solid.q - solid.p) == 0, axis=-1), 0.0, extra)
    swing = np.where(rate > 0, np.max(norm(cross(axis[..., None, :], points)), axis=-1) + round_about, 0.0)
    size = np.maximum(relative.magnitude, reach)
    if isinstance(relative, HalfSpace):
        size = size + largest(about.center)
    return Turning(relative, about, reach, swing, size)


def _place(shape: Proxy) -> Array:
    return np.zeros(3) if isinstance(shape, HalfSpace) else shape.reference_point


def turnable(shape: Proxy) -> Any:
    """The same set as a type that turns without deriving anything again."""
    if isinstance(shape, AABB):
        return shape.to_box()
    if isinstance(shape, KDOP):
        normals = np.concatenate([shape.directions, -shape.directions], axis=-2)
        offsets = np.concatenate([-shape.upper, shape.lower], axis=-1)
        planes = np.concatenate([normals, offsets[..., None]], axis=-1)
        rest = np.zeros((*shape.batch_shape, 3)), np.broadcast_to(STILL, (*shape.batch_shape, 4))
        shape.derived()  # what it has derived serves the other type too
        return ConvexPolyhedron._trusted(planes, *rest)._deriving_as(shape, lambda derived: derived)
    return shape


def _corners(box: Box) -> Array:
    local = SIGNS * box.half_extents[..., None, :]
    return np.asarray(box.center[..., None, :] + apply(rotation_matrix(box.rotation)[..., None, :, :], local))


def _vertices(c: ConvexPolyhedron) -> Array:
    return np.asarray(c.position[..., None, :] + apply(rotation_matrix(c.rotation)[..., None, :, :], c.hull.vertices))


def _ends(shape: Any) -> Array:
    return np.stack([shape.p, shape.q], axis=-2)


def _ellipsoid(e: Ellipsoid) -> tuple[Array, Array]:
    """Of a ball only the centre swings."""
    even = np.all(e.radii == e.radii[..., :1], axis=-1)
    return e.center[..., None, :], np.where(even, 0.0, largest(e.radii))


CORES: dict[type[Proxy], Callable[[Any], tuple[Array, Any]]] = {
    Point: lambda p: (p.position[..., None, :], 0.0),
    Sphere: lambda s: (s.center[..., None, :], 0.0),
    Capsule: lambda c: (_ends(c), 0.0),
    HalfSpace: lambda h: (h.reference_point[..., None, :], 0.0),
    Box: lambda b: (_corners(b), 0.0),
    Ellipsoid: _ellipsoid,
    Cylinder: lambda c: (_ends(c), c.radius),
    ConvexPolyhedron: lambda c: (_vertices(c), 0.0),
}
"""Points of the core of a body, and a radius about them in which the rest of it lies."""


def earliest(a: Proxy, b: Proxy, motion_a: Motion, motion_b: Motion) -> Array:
    """Times before which pairs of bounded convex bodies do not meet; inf for never.

    Balls about the pivots do not turn, and the gap at t = 0 closes no faster than both bodies can move.
    """
    x, y = turning(a, motion_a), turning(b, motion_b)
    balls = [bounding_sphere(z.shape) for z in (x, y)]
    middles = (y.motion.center + balls[1].center) - (x.motion.center + balls[0].center)
    gap = norm(middles) - (balls[0].radius + balls[1].radius)
    speed = norm(y.motion.linear - x.motion.linear) + x.rate * x.swing + y.rate * y.swing
    size = x.size + y.size + norm(middles)
    sure = gap - 2.0**-40 * (size + speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        time = np.where(sure > 0, sure / speed, 0.0)
    return np.where(time > 1, np.inf, time)
