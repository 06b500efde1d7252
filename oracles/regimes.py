"""Regimes: named recipes that turn random numbers into scenes.

Random poses alone do not find what matters: engines fail where things touch, line up, degenerate or leave the
middle scale. Each regime works for every pair of types; its docstring says why it exists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from oracles.bodies import IDENTITY, random_body, round_body
from oracles.draws import Draws, log_uniform
from oracles.library import current
from oracles.placed import placed_pair
from oracles.reference import UNIONS
from refimpl import Capsule, HalfSpace, Proxy, Ray, distance
from refimpl.linear import Array, Bools, dot, norm, quaternion_product, scale
from refimpl.shapes import KDOP, ConvexPolyhedron, Polyhedron

FLAT_WHEN_THIN = (KDOP, ConvexPolyhedron)
"""Types that may have no thickness at all, and do so in some slivers."""
STEPS = 4
"""Unions are moved in so many steps: past one piece, there may be the next."""

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


def _signed_gap(a: Proxy, b: Proxy) -> tuple[Array, Array]:
    """Signed distance and normal; a ray counts as a segment that reaches past the other."""
    if isinstance(a, Ray):
        far = 2.0 + (norm(b.reference_point - a.origin) + 4.0 * b.magnitude) / norm(a.direction)
        a = Capsule(a.origin, a.at(far), np.zeros(len(a)))
    found = distance(a, b)
    return found.distance, found.normal


def at_gap(a: Proxy, b: Proxy, gap: Array, which: Bools | None = None) -> Pair:
    """Move B along the normal until the signed distance is about `gap`; pairs without end, or not `which`, stay."""
    steps = STEPS if isinstance(a, UNIONS) or isinstance(b, UNIONS) else 1
    for _ in range(steps):
        sigma, normal = _signed_gap(a, b)
        moves = np.isfinite(sigma) if which is None else np.isfinite(sigma) & which
        move = np.where(moves, gap - np.where(moves, sigma, 0.0), 0.0)
        b = b.translated(scale(move, np.where(moves[:, None], normal, 0.0)))
        if np.all(np.abs(move) <= 1e-12 * b.magnitude):
            break
    return a, b


def _common(values: Array, *kinds: type[Proxy]) -> Array:
    """Numbers drawn for each body of a batch, or the first one's for all, where they share a mesh."""
    return np.broadcast_to(values[:1], values.shape) if Polyhedron in kinds else values


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
    return at_gap(a, b, np.zeros(draws.n))


@regime
def nearly_touching(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Gaps and overlaps of 1e-1 to 1e-15: below an engine's tolerances and margins."""
    a, b = generic(draws, kind_a, kind_b)
    gap = 10.0 ** -draws.choice(range(1, 16)) * draws.choice((1.0, -1.0)) * draws.uniform(1.0, 9.0)
    return at_gap(a, b, gap)


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
    return at_gap(*_facing(*pair), gap, ~loose)


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
    return at_gap(*_facing(first.make(kind_a), stacked.make(kind_b)), gap)


@regime
def sliver(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Extents a thousand to a billion times smaller in some directions: needles, sheets, hairs."""
    a, b = random_body(draws), random_body(draws)
    thin_a, thin_b = (np.where(draws.choice((1.0, 0.0), 3) == 1, log_uniform(draws, -9, -3, 3), 1.0) for _ in range(2))
    thin_a, thin_b = _flattened(draws, thin_a, kind_a), _flattened(draws, thin_b, kind_b)
    pair = (
        replace(a, extents=a.extents * thin_a).make(kind_a),
        replace(b, extents=b.extents * thin_b).make(kind_b),
    )
    near = draws.choice((0.0, 1.0)) == 1
    return at_gap(*pair, draws.uniform(-0.1, 0.1), near)


def _flattened(draws: Draws, thin: Array, kind: type[Proxy]) -> Array:
    """Make some bodies quite flat along one axis, where their type allows that."""
    if kind not in FLAT_WHEN_THIN:
        return thin
    flat = draws.choice((-1.0, -1.0, 0.0, 1.0, 2.0))
    return np.where(np.arange(3) == flat[:, None], 0.0, thin)


def _scaled_pair(draws: Draws, pair: Pair, low: float, high: float) -> Pair:
    factor = _common(log_uniform(draws, low, high), *map(type, pair))
    if Polyhedron in map(type, pair):
        factor = factor[0]
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
    factor = _common(log_uniform(draws, 3, 6), kind_a, kind_b)
    large_first = _common(draws.choice((0.0, 1.0)), kind_a, kind_b) == 1
    size_a, size_b = np.where(large_first, factor, 1.0), np.where(large_first, 1.0, factor)
    pair = (
        replace(a, extents=scale(size_a, a.extents)).make(kind_a),
        replace(b, extents=scale(size_b, b.extents)).make(kind_b),
    )
    return at_gap(*pair, draws.uniform(-1.0, 1.0))


@regime
def far_away(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Sizes of 1e-3 to 1 at coordinates of 1e3 to 1e6: only relative positions should count."""
    a, b = _scaled_pair(draws, generic(draws, kind_a, kind_b), -3, 0)
    offset = scale(log_uniform(draws, 3, 6), draws.uniform(-1.0, 1.0, 3))
    return a.translated(offset), b.translated(offset)


@regime
def models(draws: Draws, kind_a: type[Proxy], kind_b: type[Proxy]) -> Pair:
    """Meshes of robots, tools and toys, touching and overlapping: many faces, no two alike, as users have them."""
    a, b, gap, moved = placed_pair(draws, current(), kind_a, kind_b)
    return at_gap(*_facing(a, b), gap, moved)
