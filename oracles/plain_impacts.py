"""Plain impacts: bodies of round numbers that touch exactly, along the axes, with round velocities and masses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from oracles.flat_stages import LEVEL, UPRIGHT
from oracles.motion import Motion, Moving
from oracles.scene import IMPACT, Cell, Scene
from oracles.world import is_flat, world_of
from refimpl import flat
from refimpl.linear import Array
from refimpl.shapes import Box, Capsule, HalfSpace, Proxy, Sphere

EACH = 60
"""Motions of each pair of bodies."""
ROUND = (0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.5, 2.0)
SHARES = (1.0, 0.0, 0.5)
LENGTHS = (1.0, 1.0, 2.0, 0.5)
"""Of the normal, which may have any."""
NEARLY_ONE = 1e-6
INERTIAS = (
    np.eye(3),
    np.eye(3),
    np.diag([1.0, 2.0, 2.0]),
    np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]]),
)
INVERSE_MASSES = (1.0, 1.0, 0.5, 2.0)
TINY = 1e-2
PARTING = 6
"""One in so many is left as drawn, and may part."""

UNIT = [0.0, 0.0, 0.0, 1.0]
TURNED = [0.0, 0.0, 0.5, 1.0]
ON_A_CORNER = [1.0, 1.0, 0.0, 2.0]
"""Turns a box of half extents 0.5, 0.5 and 1 so that it stands on one corner, at (−0.5, 0.5, −1)."""
FLOOR = HalfSpace([0.0, 0.0, 1.0], 1.0)


@dataclass(frozen=True)
class Touch:
    """Two bodies that touch in a point; the normal points from A to B.

    Attributes
    ----------
    flat
        Whether they touch in a whole edge or face: then nothing may tip them.
    """

    a: Proxy
    b: Proxy
    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    flat: bool = False

    def with_normal(self, length: float) -> Touch:
        """The same, with a normal of this length."""
        x, y, z = self.normal
        return replace(self, normal=(length * x, length * y, length * z))


BALL = Sphere([0.0, 0.0, 0.0], 1.0)
CUBE = Box([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], UNIT)
ROD = Capsule([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], 1.0)
DOWN, AHEAD = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)

TOUCHES: dict[tuple[type[Proxy], type[Proxy]], tuple[Touch, ...]] = {
    (Sphere, Sphere): (
        Touch(BALL, Sphere([2.0, 0.0, 0.0], 1.0), (1.0, 0.0, 0.0), AHEAD),
        Touch(Sphere([0.0, 0.0, 0.0], 0.5), Sphere([0.0, 0.0, -1.0], 0.5), (0.0, 0.0, -0.5), DOWN),
    ),
    (Sphere, HalfSpace): (Touch(BALL, FLOOR, DOWN, DOWN),),
    (Sphere, Box): (
        Touch(Sphere([0.0, 0.0, 2.0], 1.0), CUBE, (0.0, 0.0, 1.0), DOWN),
        Touch(Sphere([0.5, 0.0, 2.0], 1.0), CUBE, (0.5, 0.0, 1.0), DOWN),
        Touch(Sphere([0.0, 0.5, 2.0], 1.0), Box([0.0] * 3, [2.0, 0.5, 1.0], UNIT), (0.0, 0.5, 1.0), DOWN),
        Touch(Sphere([0.5, 0.0, 2.0], 1.0), Box([0.0] * 3, [2.0, 0.5, 1.0], TURNED), (0.5, 0.0, 1.0), DOWN),
    ),
    (Sphere, Capsule): (
        Touch(Sphere([2.0, 0.0, 0.0], 1.0), ROD, (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        Touch(Sphere([2.0, 0.0, 0.5], 1.0), ROD, (1.0, 0.0, 0.5), (-1.0, 0.0, 0.0)),
    ),
    (Capsule, HalfSpace): (
        Touch(Capsule([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], 1.0), FLOOR, DOWN, DOWN),
        Touch(Capsule([0.0, 0.0, 0.0], [0.0, 1.0, 2.0], 1.0), FLOOR, DOWN, DOWN),
        Touch(Capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0), FLOOR, DOWN, DOWN, flat=True),
    ),
    (HalfSpace, Box): (
        Touch(FLOOR, Box([0.0] * 3, [0.5, 0.5, 1.0], ON_A_CORNER), (-0.5, 0.5, -1.0), (0.0, 0.0, 1.0)),
        Touch(FLOOR, CUBE, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), flat=True),
    ),
}


DISC, OTHER_DISC = flat.Disc([0.0, 0.0], 1.0), flat.Disc([2.0, 0.0], 1.0)
SQUARE = flat.Rectangle([-1.0, -1.0], [1.0, 1.0])
DIAMOND = flat.ConvexPolygon.from_vertices([[1.0, 0.0], [2.0, -1.0], [3.0, 0.0], [2.0, 1.0]])
BLOCK = flat.ConvexPolygon.from_vertices([[1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [1.0, 1.0]])
TOUCHES |= {
    (flat.Disc, flat.Disc): (Touch(DISC, OTHER_DISC, (1.0, 0.0, 0.0), AHEAD),),
    (flat.Disc, flat.Segment): (
        Touch(DISC, flat.Segment([1.0, -1.0], [1.0, 1.0]), (1.0, 0.0, 0.0), AHEAD),
        Touch(DISC, flat.Segment([2.0, 0.0], [2.0, 2.0], 1.0), (1.0, 0.0, 0.0), AHEAD),
    ),
    (flat.Disc, flat.Rectangle): (
        Touch(DISC, flat.Rectangle([1.0, -1.0], [3.0, 1.0]), (1.0, 0.0, 0.0), AHEAD),
        Touch(DISC, flat.Rectangle([1.0, -0.5], [3.0, 1.5]), (1.0, 0.0, 0.0), AHEAD),
    ),
    (flat.Disc, flat.ConvexPolygon): (
        Touch(DISC, BLOCK, (1.0, 0.0, 0.0), AHEAD),
        Touch(DISC.translated([0.0, 0.5]), BLOCK, (1.0, 0.5, 0.0), AHEAD),
    ),
    (flat.Rectangle, flat.ConvexPolygon): (
        Touch(SQUARE, DIAMOND, (1.0, 0.0, 0.0), AHEAD),
        Touch(SQUARE, DIAMOND.translated([0.0, 0.5]), (1.0, 0.5, 0.0), AHEAD),
    ),
}


def plain_impacts(cell: Cell) -> Iterator[Scene]:
    """Impacts of a cell, the simplest motions first; always the same."""
    for number, touch in enumerate(TOUCHES.get((cell.type_a, cell.type_b), ())):
        random = np.random.Generator(np.random.Philox(np.random.SeedSequence([number])))
        for k in range(EACH):
            yield Scene(IMPACT, touch.a, touch.b, "plain", "plain", _motion(random, touch, k))


def _motion(random: np.random.Generator, touch: Touch, k: int) -> Motion:
    """One of ever richer motions: first along the normal, then in any direction, then with spin and friction."""
    normal = np.array(touch.normal)
    spins, rubs = k >= EACH // 3 and not touch.flat, k >= EACH // 2 and not touch.flat
    bodies = []
    for shape in (touch.a, touch.b):
        velocity = random.choice(ROUND) * normal if k < EACH // 6 else random.choice(ROUND, 3)
        spin = random.choice(ROUND, 3) if spins else np.zeros(3)
        inverse = random.choice(INVERSE_MASSES) if k % 5 else random.choice((0.0, 1.0))
        fixed = isinstance(shape, HalfSpace)
        still = fixed or inverse == 0
        place = np.zeros(3) if fixed else world_of(shape).fill(shape.reference_point)
        none = np.zeros(3)
        inertia = np.eye(3) if still else INERTIAS[random.integers(len(INERTIAS))]
        if is_flat(shape):
            velocity, spin, inertia = velocity * LEVEL, spin * UPRIGHT, np.eye(3)
        velocity, spin = (none, none) if still else (velocity + 0.0, spin + 0.0)
        bodies.append(Moving(place, velocity, spin, np.asarray(0.0 if fixed else inverse), inertia))
    share, friction = random.choice(SHARES), random.choice(SHARES) if rubs else 0.0
    point = np.array(touch.point)
    motion = Motion(
        bodies[0], bodies[1], point, random.choice(LENGTHS) * normal, np.asarray(share), np.asarray(friction)
    )
    return motion if k % PARTING == 0 or motion.closing < 0 else reversed_motion(motion)


def reversed_motion(motion: Motion) -> Motion:
    """The same with all velocities the other way."""

    def back(body: Moving) -> Moving:
        return replace(body, velocity=0.0 - body.velocity, angular_velocity=0.0 - body.angular_velocity)

    return replace(motion, a=back(motion.a), b=back(motion.b))


def simpler_motions(motion: Motion) -> Iterator[Motion]:
    """The motion with something at rest, of unit mass and inertia, or in rounder numbers."""
    for side in ("a", "b"):
        body: Moving = getattr(motion, side)
        if body.inverse_mass == 0:
            continue
        none, one = np.zeros(3), np.asarray(1.0)
        for change in (
            {"velocity": none, "angular_velocity": none},
            {"velocity": none},
            {"angular_velocity": none},
            {"inverse_mass": one, "inertia": np.eye(3)},
            {"inverse_mass": one},
            {"inertia": np.eye(3)},
            *({"velocity": np.round(body.velocity, k)} for k in (0, 1, 2)),
            *({"angular_velocity": np.round(body.angular_velocity, k)} for k in (0, 1, 2)),
            *_one_changed("velocity", body.velocity),
            *_one_changed("angular_velocity", body.angular_velocity),
        ):
            changed = replace(body, **change)
            yield replace(motion, a=changed) if side == "a" else replace(motion, b=changed)
    for x in (0.0, 1.0, 0.5):
        yield replace(motion, restitution=np.asarray(x))
        if motion.friction != 0:  # where there is none, it might tip what lands flat
            yield replace(motion, friction=np.asarray(x))


def _one_changed(name: str, vector: Array) -> Iterator[dict[str, Array]]:
    """One coordinate rounder; a tiny one also larger, by up to two decades."""
    for i, old in enumerate(vector.tolist()):
        larger = (10.0 * old, 100.0 * old, math.copysign(10.0 ** round(math.log10(abs(old))), old)) if old else ()
        for x in (0.0, 1.0, -1.0, 0.5, 2.0, *(larger if abs(old) < TINY else ())):
            if old not in (0.0, x):
                yield {name: np.where(np.arange(3) == i, x, vector)}


def restaged(scene: Scene) -> Iterator[Scene]:
    """The same motion, as seen along the normal, of the plain bodies of the cell: rounded, or closing as fast.

    Or up to a hundred times as fast, for errors that grow with it; along a normal of length 1, or of one like its own.
    """
    motion = scene.impact
    assert motion is not None
    own = float(np.linalg.norm(motion.normal))
    closing = float(motion.closing / own)
    lengths = [1.0] if abs(own - 1) < NEARLY_ONE else [1.0, 0.5 if own < 1 else 2.0]
    touches = TOUCHES.get((type(scene.a), type(scene.b)), ())
    for touch in (touch.with_normal(length) for length in lengths for touch in touches):
        for decimals in (0, 1, 2):
            yield replace(scene, a=touch.a, b=touch.b, motion=_on_plain_bodies(motion, touch, decimals))
        for decimals in (0, 1, 15):
            staged = _on_plain_bodies(motion, touch, decimals)
            for factor in (1.0, 10.0, 100.0):
                yield replace(scene, a=touch.a, b=touch.b, motion=_closing_at(staged, factor * closing))


def _on_plain_bodies(motion: Motion, touch: Touch, decimals: int) -> Motion:
    """The motion turned to another normal, of unit inertia, and rounded."""
    turn, bodies = _turn(motion.normal, np.array(touch.normal)), []
    for body, shape in zip(motion.bodies, (touch.a, touch.b), strict=True):
        fixed = isinstance(shape, HalfSpace)
        spin = np.round(turn @ body.angular_velocity, decimals) * (0.0 if touch.flat else 1.0)
        inverse = np.asarray(float(f"{float(body.inverse_mass):.{min(decimals, 2)}e}"))
        place = np.zeros(3) if fixed else world_of(shape).fill(shape.reference_point)
        bodies.append(Moving(place, np.round(turn @ body.velocity, decimals) + 0.0, spin + 0.0, inverse, np.eye(3)))
    friction = np.asarray(0.0 if touch.flat else np.round(motion.friction, max(decimals, 1)))
    share = np.round(motion.restitution, max(decimals, 1))
    return Motion(bodies[0], bodies[1], np.array(touch.point), np.array(touch.normal), share, friction)


def _closing_at(motion: Motion, speed: float) -> Motion:
    """The motion with one movable body faster or slower along the normal, so that the two close at a speed."""
    normal = motion.normal / np.linalg.norm(motion.normal)
    lacking = (speed - float(motion.approach @ normal)) * normal
    if motion.b.inverse_mass != 0:
        return replace(motion, b=replace(motion.b, velocity=motion.b.velocity + lacking))
    return replace(motion, a=replace(motion.a, velocity=motion.a.velocity - lacking))


def _turn(old: Array, new: Array) -> Array:
    """A rotation that takes one direction to another: two reflections."""
    u, v = old / np.linalg.norm(old), new / np.linalg.norm(new)
    if np.allclose(u, -v):
        aside = np.eye(3)[np.argmin(np.abs(u))]
        w = aside - (aside @ u) * u
        return np.asarray(2 * np.outer(w, w) / (w @ w) - np.eye(3))  # half a turn about w
    middle = u + v
    return np.asarray(2 * np.outer(middle, middle) / (middle @ middle) - np.eye(3))
