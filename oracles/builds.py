"""Builds: what the two bodies of a scene are like, before anything is said of where they stand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from oracles.bodies import Body, random_body, round_body
from oracles.draws import Draws, log_uniform
from refimpl import Proxy
from refimpl.linear import Array, scale
from refimpl.shapes import KDOP, ConvexPolyhedron, Polyhedron

Kind = type[Proxy]
Bodies = tuple[Body, Body]
Build = Callable[[Draws, Kind, Kind], Bodies]

FLAT_WHEN_THIN = (KDOP, ConvexPolyhedron)
"""Types that may have no thickness at all, and do so in some slivers."""
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
