"""Builds: what the two bodies of a scene are like, before anything is said of where they stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from oracles.bodies import Body, random_body, round_body
from oracles.draws import Draws, log_uniform
from refimpl import Proxy
from refimpl.flat import Rectangle, Segment
from refimpl.linear import Array, scale
from refimpl.shapes import AABB, KDOP, Box, Capsule, ConvexPolyhedron, HalfSpace, Polyhedron

Kind = type[Proxy]
Bodies = tuple[Body, Body]
Build = Callable[[Draws, Kind, Kind], Bodies]

FLAT_WHEN_THIN = (KDOP, ConvexPolyhedron)
"""Types that may have no thickness at all, and do so in some slivers."""
NOTHING_AT_ALL = (Capsule, AABB, Box, Rectangle, Segment)
"""Types whose sizes may all be 0."""
SHARED = {
    "place": (0.0, 1.0, 3.0),
    "extents": (0.0, 2.0, 3.0),
    "rotation": (0.0, 2.0, 4.0),
    "back": (0.0, 2.0),
    "length": (0.0, 2.0),
}
"""What each sort of sibling has of the body before it."""
FACTORS = (1.0, 2.0, 0.5, 10.0, 0.1, 1.1, 0.9, 1.01, 0.99)
"""Parts of an engine's threshold at which it is tried."""


def generic(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """Any pose at the middle scale: what a demonstration shows, and where engines are best."""
    del kind_a, kind_b
    return random_body(draws), random_body(draws)


def aligned(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """Axis-aligned with round numbers: levels are built so, and determinants vanish exactly."""
    del kind_a, kind_b
    return round_body(draws), round_body(draws)


def half_aligned(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """One body in round numbers, the other anyhow: half of the special cases at a time."""
    del kind_a, kind_b
    return round_body(draws), random_body(draws)


def sliver(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """Extents a thousand to a billion times smaller in some directions: needles, sheets, hairs."""
    bodies = random_body(draws), random_body(draws)
    thin_a, thin_b = (np.where(draws.choice((1.0, 0.0), 3) == 1, log_uniform(draws, -9, -3, 3), 1.0) for _ in bodies)
    thin_a, thin_b = _flattened(draws, thin_a, kind_a), _flattened(draws, thin_b, kind_b)
    a, b = (replace(body, extents=body.extents * thin) for body, thin in zip(bodies, (thin_a, thin_b), strict=True))
    return a, b


def _flattened(draws: Draws, thin: Array, kind: Kind) -> Array:
    """Make some bodies quite flat along one axis, where their type allows that."""
    if kind not in FLAT_WHEN_THIN:
        return thin
    flat = draws.choice((-1.0, -1.0, 0.0, 1.0, 2.0))
    return np.where(np.arange(3) == flat[:, None], 0.0, thin)


def size_ratio(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """One proxy 1e3 to 1e6 times larger than the other, near its surface: a coin on a planet."""
    a, b = random_body(draws), random_body(draws)
    factor = in_common(log_uniform(draws, 3, 6), kind_a, kind_b)
    large_first = in_common(draws.choice((0.0, 1.0)), kind_a, kind_b) == 1
    size_a, size_b = np.where(large_first, factor, 1.0), np.where(large_first, 1.0, factor)
    return replace(a, extents=scale(size_a, a.extents)), replace(b, extents=scale(size_b, b.extents))


def degenerate(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """Sizes of 0 where the type has them, planes through the origin; normals, directions, quaternions of any length."""
    a, b = (_at_the_edge(draws, random_body(draws), kind) for kind in (kind_a, kind_b))
    return a, b


def _at_the_edge(draws: Draws, body: Body, kind: Kind) -> Body:
    """Make a body an edge case of what its type allows."""
    none = draws.choice((1.0, 0.0), 3) == 1
    if kind in FLAT_WHEN_THIN:
        none = np.arange(3) == draws.choice((0.0, 1.0, 2.0, -1.0))[:, None]
    extents = np.where(none, 0.0, body.extents) if kind in (*NOTHING_AT_ALL, *FLAT_WHEN_THIN) else body.extents
    through_origin = (draws.choice((1.0, 0.0)) == 1) & (kind is HalfSpace)
    return replace(
        body,
        place=np.where(through_origin[:, None], 0.0, body.place),
        extents=extents,
        rotation=scale(log_uniform(draws, -3, 3), body.rotation),
        length=log_uniform(draws, -3, 3),
    )


def siblings(draws: Draws, kind_a: Kind, kind_b: Kind) -> Bodies:
    """Scenes in a row that share bodies, sizes, poses or corners: what an engine keeps of the last one is no help."""
    del kind_a, kind_b
    first, second = random_body(draws), random_body(draws)
    return _like_the_last(draws, first), _like_the_last(draws, second)


def _like_the_last(draws: Draws, body: Body) -> Body:
    """Every other body shares with the one before it: all, the place, sizes and turn, place and sizes, or a corner."""
    last, odd = np.arange(draws.n) // 2 * 2, np.arange(draws.n) % 2 == 1
    sort = draws.choice((0.0, 1.0, 2.0, 3.0, 4.0))
    shared = {name: np.isin(sort, sorts) & odd for name, sorts in SHARED.items()}
    old = {name: getattr(body, name)[last] for name in shared}
    columns = {
        name: np.where(rows[:, None] if old[name].ndim > 1 else rows, old[name], getattr(body, name))
        for name, rows in shared.items()
    }
    cornered = ((sort == 4) & odd)[:, None]
    corner = old["place"] - old["extents"]
    columns["place"] = np.where(cornered, corner + columns["extents"], columns["place"])
    return replace(body, **columns)


def at_thresholds(draws: Draws, lengths: Mapping[str, float]) -> tuple[Body, Body, Array]:
    """Bodies of which some have sizes at the thresholds of an engine, and a gap that is at one, or none.

    A number counts as at a threshold from a tenth to ten times of it: just beside it is where a branch is wrong.
    """
    a, b = random_body(draws), random_body(draws)
    length = draws.choice(tuple(lengths.values())) * draws.choice(FACTORS)
    sort, axis = draws.choice((0.0, 1.0, 2.0, 3.0)), draws.choice((0, 1, 2))
    small = (sort == 2)[:, None] | ((sort == 3)[:, None] & (np.arange(3) == axis[:, None]))
    b = replace(b, extents=np.where(small, length[:, None], b.extents))
    at_size = draws.choice((0.0, 1.0, -1.0)) * length
    gap = np.where(sort == 0, length, np.where(sort == 1, -length, at_size))
    return a, b, gap


def in_common(values: Array, *kinds: Kind) -> Array:
    """Numbers drawn for each body of a batch, or the first one's for all, where they share a mesh."""
    return np.broadcast_to(values[:1], values.shape) if Polyhedron in kinds else values
