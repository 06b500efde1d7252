"""Regimes: named recipes that turn random numbers into scenes.

Random poses alone do not find what matters: engines fail where things touch, line up, degenerate or leave the
middle scale. Each regime works for every pair of types; its docstring says why it exists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oracles.draws import Draws, log_uniform, quaternions
from refimpl import AABB, Box, Capsule, HalfSpace, Point, Proxy, Ray, Sphere, distance
from refimpl.linear import Array, apply, dot, norm, quaternion_product, rotation_matrix, scale

Z_AXIS = np.array([0.0, 0.0, 1.0])
IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
QUARTER_TURNS = np.array(
    [
        [0, 0, 0, 1],
        [1, 0, 0, 1],
        [0, 1, 0, 1],
        [0, 0, 1, 1],
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [0, 0, 1, 0],
        [1, 1, 1, 1],
    ],
    dtype=np.float64,
)
ROUND_SIZES = (1.0, 0.5, 2.0, 1.5, 0.25)
ROUND_PLACES = (0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 1.5, -1.5, 3.0, -3.0)


@dataclass(frozen=True)
class Body:
    """A proxy in the making, of no type yet: place, half extents, rotation, and how far back a ray starts."""

    place: Array
    extents: Array
    rotation: Array
    back: Array
    length: Array

    def make(self, kind: type[Proxy]) -> Proxy:
        """Build a proxy of this type with this body's place, size and pose; its axis is the body's z axis."""
        axis = apply(rotation_matrix(self.rotation), np.broadcast_to(Z_AXIS, self.place.shape))
        reach = scale(self.extents[:, 2], axis)
        made: dict[type[Proxy], Callable[[], Proxy]] = {
            Point: lambda: Point(self.place),
            Ray: lambda: Ray(self.place - scale(self.back, reach), scale(self.length, reach)),
            Sphere: lambda: Sphere(self.place, self.extents[:, 0]),
            Capsule: lambda: Capsule(self.place - reach, self.place + reach, self.extents[:, 0]),
            HalfSpace: lambda: HalfSpace(scale(self.length, axis), -self.length * dot(axis, self.place)),
            AABB: lambda: AABB(self.place - self.extents, self.place + self.extents),
            Box: lambda: Box(self.place, self.extents, self.rotation),
        }
        return made[kind]()


Pair = tuple[Proxy, Proxy]
Regime = Callable[[Draws, type[Proxy], type[Proxy]], Pair]
REGIMES: dict[str, Regime] = {}


def regime(function: Regime) -> Regime:
    """Register a regime under its function's name."""
    REGIMES[function.__name__] = function
    return function


def reasons() -> dict[str, str]:
    """Why each regime exists: the first line of its docstring."""
    return {name: (function.__doc__ or "").strip().splitlines()[0] for name, function in REGIMES.items()}


def random_body(draws: Draws, spread: float = 2.0) -> Body:
    """Any place, size and pose at the middle scale."""
    return Body(
        place=draws.uniform(-spread, spread, 3),
        extents=draws.uniform(0.2, 1.5, 3),
        rotation=quaternions(draws),
        back=draws.uniform(0.0, 6.0),
        length=draws.uniform(0.25, 4.0),
    )


def round_body(draws: Draws) -> Body:
    """Round numbers and quarter turns."""
    return Body(
        place=draws.choice(ROUND_PLACES, 3),
        extents=draws.choice(ROUND_SIZES, 3),
        rotation=QUARTER_TURNS[draws.choice(range(len(QUARTER_TURNS))).astype(int)],
        back=draws.choice((0.0, 1.0, 2.0, 4.0, 6.0)),
        length=draws.choice((1.0, 2.0, 0.5)),
    )


def _signed_gap(a: Proxy, b: Proxy) -> tuple[Array, Array]:
    """Signed distance and normal; a ray counts as a segment that reaches past the other."""
    if isinstance(a, Ray):
        far = 2.0 + (norm(b.reference_point - a.origin) + 4.0 * b.magnitude) / norm(a.direction)
        a = Capsule(a.origin, a.at(far), np.zeros(len(a)))
    found = distance(a, b)
    return found.distance, found.normal


def _at_gap(a: Proxy, b: Proxy, gap: Array) -> Pair:
    """Move B along the normal until the signed distance is about `gap`; pairs without end stay."""
    sigma, normal = _signed_gap(a, b)
    finite = np.isfinite(sigma)
    move = scale(np.where(finite, gap - np.where(finite, sigma, 0.0), 0.0), np.where(finite[:, None], normal, 0.0))
    return a, b.translated(move)


def _facing(a: Proxy, b: Proxy) -> Pair:
    """Turn a second half-space exactly against the first: only then is their distance finite."""
    if isinstance(a, HalfSpace) and isinstance(b, HalfSpace):
        place = b.reference_point
        normal = -2.0 * a.normal
        return a, HalfSpace(normal, -dot(normal, place))
    return a, b


@regime
def generic(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Any pose at the middle scale: what a demonstration shows, and where engines are best."""
    return random_body(draws).make(kind_a), random_body(draws).make(kind_b)


@regime
def aligned(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Axis-aligned with round numbers: levels are built so, and determinants vanish exactly."""
    return round_body(draws).make(kind_a), round_body(draws).make(kind_b)


@regime
def touching(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """At distance 0 up to rounding: resting contact, where a boolean flips."""
    a, b = generic(draws, kind_a, kind_b)
    return _at_gap(a, b, np.zeros(draws.n))


@regime
def nearly_touching(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Gaps and overlaps of 1e-1 to 1e-15: below an engine's tolerances and margins."""
    a, b = generic(draws, kind_a, kind_b)
    gap = 10.0 ** -draws.choice(range(1, 16)) * draws.choice((1.0, -1.0)) * draws.uniform(1.0, 9.0)
    return _at_gap(a, b, gap)


@regime
def deep(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """One inside the other or nearly so: many faces compete for the least depth."""
    a, b = random_body(draws), random_body(draws)
    offset = scale(draws.uniform(0.0, 0.5), draws.uniform(-1.0, 1.0, 3)) * a.extents
    return a.make(kind_a), replace(b, place=a.place + offset).make(kind_b)


@regime
def concentric(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Equal centres, equal or turned poses, equal or other sizes: no direction is preferred."""
    a, b = round_body(draws), random_body(draws)
    same_size, same_pose = draws.choice((1.0, 0.0)) == 1, draws.choice((1.0, 0.0)) == 1
    extents = np.where(same_size[:, None], a.extents, b.extents)
    rotation = np.where(same_pose[:, None], a.rotation, b.rotation)
    return a.make(kind_a), replace(b, place=a.place, extents=extents, rotation=rotation).make(kind_b)


def _nearly_parallel(draws: Draws, rotation: Array) -> Array:
    """Turn by a quarter, by nothing, or by a tiny angle about one of the body's axes."""
    angle = draws.choice((0.0, 1e-1, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13, 1e-15, 1.0))
    axis = np.eye(3)[draws.choice((0, 1, 2)).astype(int)]
    turn = np.concatenate([scale(angle / 2, axis), np.ones((draws.n, 1))], axis=-1)
    return quaternion_product(rotation, turn)


@regime
def parallel_edges(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Edges parallel or at angles down to 1e-15: cross products vanish or lose their digits."""
    a, b = random_body(draws), random_body(draws)
    upright = draws.choice((0.0, 1.0)) == 1
    rotation = np.where(upright[:, None], IDENTITY, a.rotation)
    turned = _nearly_parallel(draws, rotation)
    near = a.place + scale(draws.choice((1.0, 2.0, 0.0)), b.place)
    pair = replace(a, rotation=rotation).make(kind_a), replace(b, rotation=turned, place=near).make(kind_b)
    gap = draws.choice((0.0, 1.0, 1e-9, -1e-9, 1e-3, -1e-3)) * draws.uniform(0.1, 1.0)
    loose = draws.choice((0.0, 1.0)) == 1
    a2, b2 = _facing(*pair)
    moved = _at_gap(a2, b2, gap)[1]
    return a2, type(b2).unpack(np.where(loose[:, None], b2.pack(), moved.pack()))


@regime
def face_on_face(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Stacked squarely, with a gap or overlap of 0 or a little: whole faces are nearest."""
    a, b = round_body(draws), round_body(draws)
    axis = draws.choice((2, 0, 1)).astype(int)
    offset = np.where(np.arange(3) == axis[:, None], scale(draws.choice((1.0, -1.0)), a.extents + b.extents), 0.0)
    slide = np.where(np.arange(3) == axis[:, None], 0.0, draws.choice((0.0, 0.5, -0.25, 1.0), 3))
    gap = draws.choice((0.0, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3, 0.5))
    stacked = replace(b, place=a.place + offset + slide, rotation=np.broadcast_to(IDENTITY, b.rotation.shape))
    first = replace(a, rotation=np.broadcast_to(IDENTITY, a.rotation.shape))
    return _at_gap(*_facing(first.make(kind_a), stacked.make(kind_b)), gap)


@regime
def sliver(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Extents a thousand to a billion times smaller in some directions: needles, sheets, hairs."""
    a, b = random_body(draws), random_body(draws)
    thin_a, thin_b = (np.where(draws.choice((1.0, 0.0), 3) == 1, log_uniform(draws, -9, -3, 3), 1.0) for _ in range(2))
    pair = (
        replace(a, extents=a.extents * thin_a).make(kind_a),
        replace(b, extents=b.extents * thin_b).make(kind_b),
    )
    near = draws.choice((0.0, 1.0)) == 1
    moved = _at_gap(*pair, draws.uniform(-0.1, 0.1))[1]
    return pair[0], type(moved).unpack(np.where(near[:, None], moved.pack(), pair[1].pack()))


def _scaled_pair(draws: Draws, pair: Pair, low: float, high: float) -> Pair:
    factor = log_uniform(draws, low, high)
    return pair[0].scaled(factor), pair[1].scaled(factor)


@regime
def huge(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Everything 1e3 to 1e9 times larger: absolute tolerances become too strict."""
    return _scaled_pair(draws, generic(draws, kind_a, kind_b), 3, 9)


@regime
def tiny(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Everything 1e3 to 1e9 times smaller: absolute tolerances and margins swallow the scene."""
    return _scaled_pair(draws, generic(draws, kind_a, kind_b), -9, -3)


@regime
def size_ratio(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """One proxy 1e3 to 1e6 times larger than the other, near its surface: a coin on a planet."""
    a, b = random_body(draws), random_body(draws)
    factor = log_uniform(draws, 3, 6) * 1.0
    large_first = draws.choice((0.0, 1.0)) == 1
    size_a, size_b = np.where(large_first, factor, 1.0), np.where(large_first, 1.0, factor)
    pair = (
        replace(a, extents=scale(size_a, a.extents)).make(kind_a),
        replace(b, extents=scale(size_b, b.extents)).make(kind_b),
    )
    return _at_gap(*pair, draws.uniform(-1.0, 1.0))


@regime
def far_away(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Sizes of 1e-3 to 1 at coordinates of 1e3 to 1e6: only relative positions should count."""
    a, b = _scaled_pair(draws, generic(draws, kind_a, kind_b), -3, 0)
    offset = scale(log_uniform(draws, 3, 6), draws.uniform(-1.0, 1.0, 3))
    return a.translated(offset), b.translated(offset)
