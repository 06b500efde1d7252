"""What is special about a scene's own geometry, whatever regime it came from: part of the name of a bucket.

A scene may be special in several ways; its class is the first of them in the order of `CLASSES`. Shrinking may take
such features away from a scene, and never adds any but the `FREE` ones, which round numbers bring along.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from oracles.claimed_shapes import past
from oracles.course import Course
from oracles.looks import Look, look
from oracles.motion import Motion
from oracles.reference import signed
from oracles.scene import Scene
from oracles.sweep_reference import first_contacts
from oracles.world import world_of
from refimpl import Box, Capsule, HalfSpace, Point, Proxy, Ray
from refimpl.linear import Array, apply, dot, norm, rotation_matrix
from refimpl.supports import support

GENERIC = "generic"
FREE = frozenset({"parallel", "head on"})
"""Features that the simplest scenes have: shrinking may add them."""

CLASSES = (
    "beyond all sizes",
    "huge",
    "tiny",
    "very unequal",
    "far away",
    "thin",
    "parting",
    "turning",
    "fast",
    "slow",
    "grazing",
    "unequal masses",
    "immovable",
    "landing flat",
    "from the surface",
    "from inside",
    "behind",
    "odd direction",
    "concentric",
    "coaxial",
    "touching",
    "nearly parallel",
    "nearly touching",
    "deep",
    "face on face",
    "parallel",
    "head on",
)
"""Every feature, the rarer and more telling ones first."""

ROUNDING = 1e-12
"""What counts as equal, parallel or touching, relative to the sizes of the bodies."""
NEARLY = 1e-3
LARGE, SMALL = 1e3, 1e-3
UNEQUAL = 100.0
FAST, SLOW = 30.0, 0.1
GRAZING = 1e-2
"""Part of the relative motion that is along the normal, of sweeps that graze."""
ENDLESS = 1e30
"""Scenes larger than this, or smaller than its inverse, are about overflow."""


def degeneracy(scene: Scene) -> str:
    """Class of a scene: the first of its features in the order of `CLASSES`, or "generic"."""
    found = features(scene)
    return next((name for name in CLASSES if name in found), GENERIC)


def features(scene: Scene, gaps: tuple[float, ...] = ()) -> frozenset[str]:
    """Everything that is special about a scene, of which the `gaps_of` may be known."""
    if scene.impact is not None:
        return frozenset(_of_impact(scene, scene.impact))
    a, b = look(scene.a), look(scene.b)
    gaps = gaps or gaps_of(scene.a[None], scene.b[None])[0]
    found = {*_of_sizes(scene, a, b), *_of_poses(scene, a, b)}
    found |= set(_of_ray(scene, *gaps) if isinstance(scene.a, Ray) else _of_contact(scene, a, b, *gaps))
    if scene.course is not None:
        found |= set(_of_course(scene, scene.course))
    if "parallel" in found and "nearly touching" in found and _facing(scene, a, b, gaps[0]):
        found.add("face on face")
    return frozenset(found)


def gaps_of(a: Proxy, b: Proxy) -> list[tuple[float, ...]]:
    """Signed distance of each pair of a batch; of a ray that of its start, and of all of it."""
    every = np.ones(len(a), dtype=bool)
    if not isinstance(a, Ray):
        return list(zip(_highest(signed(a, b, every)), strict=True))
    world = world_of(a)
    way, starts = world.rounded(a.origin, a.at(past(a, b)), np.zeros(len(a))), world.point(a.origin)
    return list(zip(_highest(signed(starts, b, every)), _highest(signed(way, b, every)), strict=True))


def _highest(bounds: tuple[Array, Array]) -> list[float]:
    """The upper ends of signed distances: what unions are proven to be apart at most."""
    return [float(x) for x in bounds[1]]


def length_of(scene: Scene) -> float:
    """Size of the larger body; of two that have none, the scene's."""
    sizes = [seen.size for seen in (look(scene.a), look(scene.b)) if 0 < seen.size < math.inf]
    return max(sizes, default=scene.size)


def _of_sizes(scene: Scene, a: Look, b: Look) -> Iterator[str]:
    length, sizes = length_of(scene), [seen.size for seen in (a, b) if 0 < seen.size < math.inf]
    if not 1 / ENDLESS < max(length, scene.size) < ENDLESS:
        yield "beyond all sizes"
    if length > LARGE:
        yield from ("huge", "far away", "very unequal", "thin")  # of what is huge, a part may do
    elif length < SMALL:
        yield from ("tiny", "very unequal", "thin")
    if len(sizes) == 2 and max(sizes) > UNEQUAL * min(sizes):
        yield from ("very unequal", "thin")  # how thin the small one is makes no difference
    if any(seen.size > UNEQUAL * seen.thin for seen in (a, b) if seen.size < math.inf):
        yield "thin"
    places = np.abs([seen.middle for seen in (a, b)]).max(axis=1)
    if places.max() > UNEQUAL * length:
        yield "far away"


def _of_poses(scene: Scene, a: Look, b: Look) -> Iterator[str]:
    """Directions that are parallel or square to each other, and middles and axes that coincide."""
    if len(a.axes) and len(b.axes):
        cosines = np.abs(a.axes @ b.axes.T)
        sines = norm(np.cross(a.axes[:, None], b.axes[None]))
        off = np.minimum(cosines, sines)
        if np.any(off <= ROUNDING):
            yield "parallel"
        if np.any((off > ROUNDING) & (off <= NEARLY)):
            yield "nearly parallel"
    if math.inf in (a.size, b.size):
        return
    apart, length = b.middle - a.middle, length_of(scene)
    if _is_nothing(apart, length):
        yield "concentric"
    for own, other in ((a, b), (b, a)):
        if own.line and _is_nothing(np.cross(own.axes[0], apart), length):
            aligned = other.line and _is_nothing(np.cross(own.axes[0], other.axes[0]), 1.0)
            if aligned or (not len(other.axes) and other.size < math.inf and _within(own, apart)):
                yield "coaxial"


def _within(rod: Look, apart: Array) -> bool:
    """Whether a place on the axis of a rod lies within it."""
    return float(norm(apart)) <= rod.size


def _is_nothing(vector: Array, length: float) -> bool:
    return bool(np.abs(vector).max() <= ROUNDING * length)


def _of_contact(scene: Scene, a: Look, b: Look, gap: float) -> Iterator[str]:
    length = length_of(scene)
    rounding = max(ROUNDING * length, 4 * np.finfo(float).eps * scene.size)
    if abs(gap) <= rounding:
        yield "touching"
    if abs(gap) <= NEARLY * length:
        yield "nearly touching"
    if gap < -rounding and not (isinstance(scene.a, Point) or isinstance(scene.b, Point)):
        thinnest = min(seen.thin for seen in (a, b))
        if thinnest < math.inf and -gap >= 2 * thinnest * (1 - ROUNDING):
            yield "deep"


def _of_ray(scene: Scene, start: float, gap: float) -> Iterator[str]:
    ray, length = scene.a, length_of(scene)
    assert isinstance(ray, Ray)
    rounding = max(ROUNDING * length, 4 * np.finfo(float).eps * scene.size)
    if abs(start) <= rounding:
        yield "from the surface"
    elif start < 0:
        yield "from inside"
    elif gap > start - rounding:
        yield "behind"
    if abs(gap) <= rounding and abs(start) > rounding:
        yield "touching"
    if abs(gap) <= NEARLY * length:
        yield "nearly touching"
    if not SMALL <= float(norm(ray.direction)) <= LARGE:
        yield "odd direction"


def _facing(scene: Scene, a: Look, b: Look, gap: float) -> bool:
    """Whether a whole face or edge of each is nearest: the middles differ along a direction of both."""
    if not (len(a.axes) and len(b.axes)) or isinstance(scene.a, Ray):
        return False
    shared = [n for n in a.axes if np.any(norm(np.cross(n, b.axes)) <= ROUNDING)]
    length = length_of(scene)
    for n in shared:
        if isinstance(scene.a, HalfSpace) or isinstance(scene.b, HalfSpace):
            return True
        along = abs(float(dot(n, b.middle - a.middle)))
        if abs(along - _width(scene.a, n) - _width(scene.b, n) - gap) <= ROUNDING * (length + along):
            return True
    return False


def _width(shape: Proxy, n: Array) -> float:
    """Half the width of a bounded proxy along a unit direction, of one that is the same both ways."""
    n = n[: world_of(shape).axes]
    return float(support(shape, n) + support(shape, -n)) / 2


def _of_course(scene: Scene, course: Course) -> Iterator[str]:
    """What is special about the motion of a sweep: against the size of the bodies, and how they meet."""
    length, way = length_of(scene), float(course.way(scene.a, scene.b))
    if bool(course.turns):
        yield "turning"
    if way > FAST * length:
        yield "fast"
    if way < NEARLY * length:
        yield "slow"
    first = first_contacts(scene.a[None], scene.b[None], course[None])
    relative = course.a.linear - course.b.linear
    if first.hit[0] and np.isfinite(first.normal[0]).all():
        normal = world_of(scene.b).fill(first.normal)[0]
        closing = float(dot(relative, normal))
        if abs(closing) <= GRAZING * float(norm(relative)):
            yield "grazing"
        if _is_nothing(np.cross(relative, normal), float(norm(relative)) or 1.0):
            yield "head on"
    elif not first.hit[0]:
        yield "behind"


def _of_impact(scene: Scene, motion: Motion) -> Iterator[str]:
    a, b = look(scene.a), look(scene.b)
    yield from _of_sizes(scene, a, b)
    speed, normal = float(motion.speed), motion.normal / norm(motion.normal)
    closing = float(dot(motion.approach, normal))
    if closing >= 0:
        yield "parting"
    elif -closing < NEARLY * speed:
        yield "grazing"
    if speed > FAST:
        yield "fast"
    if 0 < speed < SLOW:
        yield "slow"
    inverses = [float(body.inverse_mass) for body in motion.bodies]
    if 0.0 in inverses:
        if not (isinstance(scene.a, HalfSpace) or isinstance(scene.b, HalfSpace)):
            yield "immovable"
    elif max(inverses) > UNEQUAL * min(inverses):
        yield "unequal masses"
    if any(_lands_flat(shape, normal) for shape in (scene.a, scene.b)) and HalfSpace in map(type, (scene.a, scene.b)):
        yield "landing flat"
    levers = [motion.point - body.position for body in motion.bodies if body.inverse_mass > 0]
    square = all(_is_nothing(np.cross(lever, normal), float(norm(lever)) or 1.0) for lever in levers)
    if square and _is_nothing(np.cross(motion.approach, normal), speed or 1.0):
        yield "head on"


def _lands_flat(shape: Proxy, normal: Array) -> bool:
    """Whether a whole edge or face meets a plane of this normal."""
    if isinstance(shape, Capsule):
        step = shape.q - shape.p
        return bool(abs(dot(step, normal)) <= NEARLY * NEARLY * norm(step))
    if isinstance(shape, Box):
        along = np.abs(apply(rotation_matrix(shape.rotation).T, normal))
        return bool(along.min() <= NEARLY * NEARLY)
    return False
