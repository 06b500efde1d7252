"""Frames: at what scale, where and how turned a whole scene is; which changes nothing but the numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from oracles.bodies import Body
from oracles.builds import Kind, in_common
from oracles.draws import Draws, log_uniform, quaternions
from refimpl.linear import Array, apply, quaternion_product, rotation_matrix, scale

Framed = tuple[Body, Body, Array]
"""Both bodies, and the length that the unit has become."""
Frame = Callable[[Draws, tuple[Body, Body], tuple[Kind, Kind]], Framed]

FARTHEST = 1e14
"""No body is farther away than so many times its least extent: beyond, rounding would leave nothing of it."""


def unit(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """As it is, around the origin."""
    del kinds
    return *bodies, np.ones(draws.n)


def huge(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """Everything 1e3 to 1e9 times larger: absolute tolerances become too strict."""
    return _scaled(log_uniform(draws, 3, 9), bodies, kinds)


def tiny(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """Everything 1e3 to 1e9 times smaller: absolute tolerances and margins swallow the scene."""
    return _scaled(log_uniform(draws, -9, -3), bodies, kinds)


def far_away(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """Sizes of 1e-3 to 1 at coordinates of 1e3 to 1e6: only relative positions should count."""
    a, b, length = _scaled(log_uniform(draws, -3, 0), bodies, kinds)
    return *_moved(scale(log_uniform(draws, 3, 6), draws.uniform(-1.0, 1.0, 3)), a, b), length


def single_precision(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """At 2^20 to 2^26 times the size: where single precision has a digit left for the scene, or none."""
    del kinds
    a, b = bodies
    size = np.maximum(a.extents, b.extents).max(axis=1)
    away = np.exp2(draws.choice((24.0, 23.0, 25.0, 20.0, 26.0))) * size
    side = draws.choice((1.0, -1.0, 0.0, 0.3), 3)
    return *_moved(scale(away, side), a, b), np.ones(draws.n)


def turned(draws: Draws, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    """Turned as a whole: what was exactly parallel or round is so up to rounding only."""
    del kinds
    turn = quaternions(draws)
    a, b = (
        replace(
            body,
            place=apply(rotation_matrix(turn), body.place),
            rotation=quaternion_product(turn, body.rotation),
        )
        for body in bodies
    )
    return a, b, np.ones(draws.n)


def _scaled(factor: Array, bodies: tuple[Body, Body], kinds: tuple[Kind, Kind]) -> Framed:
    factor = in_common(factor, *kinds)
    a, b = (replace(x, place=scale(factor, x.place), extents=scale(factor, x.extents)) for x in bodies)
    return a, b, factor


def _moved(offset: Array, a: Body, b: Body) -> tuple[Body, Body]:
    """Both moved alike, and no farther than leaves them their least extent."""
    extents = np.concatenate([a.extents, b.extents], axis=1)
    least = np.where(extents > 0, extents, np.inf).min(axis=1)
    far = np.abs(offset).max(axis=1)
    share = np.minimum(1.0, FARTHEST * least / np.where(far > 0, far, 1.0))
    offset = scale(share, offset)
    return replace(a, place=a.place + offset), replace(b, place=b.place + offset)


FRAMES: dict[str, Frame] = {frame.__name__: frame for frame in (unit, turned, huge, tiny, far_away, single_precision)}
