"""Largest balls in what is left of a solid."""

from __future__ import annotations

import numpy as np

from refimpl.construct.medial import inscribed_radii
from refimpl.linear import Array, norm, scale
from refimpl.solids import Solid

PLACES = 8
"""From so many of the roomiest places a ball grows at once."""
LOOKS = 12
"""Directions in which each looks for more room, in each round."""
ROUNDS = 20
SHRINK = 0.7
APART = 2.0**-40  # of the solid's size, between any two balls


def packed_balls(solid: Solid, balls: tuple[Array, Array], count: int, seed: int) -> tuple[Array, Array]:
    """Balls inside a solid without common points: centres (k, 3) and radii (k,), in falling order nearly.

    Fewer than `count` only where none of many places has any room left.

    Parameters
    ----------
    solid : Solid
    balls : centres and radii
        Of balls inside it to begin with.
    """
    random = np.random.default_rng(seed)
    places, room = balls
    centers, radii = np.zeros((0, 3)), np.zeros(0)
    for _ in range(count):
        first = np.argsort(-room, kind="stable")[:PLACES]
        at, radius = _grown(solid, places[first], room[first], (centers, radii), random)
        best = int(np.argmax(radius))
        if not radius[best] > 0:
            break
        centers, radii = np.concatenate([centers, at[best : best + 1]]), np.append(radii, radius[best])
        room = np.minimum(room, _beside((at[best : best + 1], radius[best : best + 1]), places, solid.extent))
    return centers, radii


def _grown(
    solid: Solid, at: Array, radius: Array, balls: tuple[Array, Array], random: np.random.Generator
) -> tuple[Array, Array]:
    """Places with more room near some, found by steps that become shorter in directions at random."""
    step = np.maximum(radius, 0.0)
    rows = np.arange(len(at))
    for _ in range(ROUNDS):
        way = random.standard_normal((len(at), LOOKS, 3))
        way /= norm(way)[..., None]
        there = (at[:, None] + scale(step[:, None] * random.random((len(at), LOOKS)), way)).reshape(-1, 3)
        room = np.minimum(inscribed_radii(solid, there), _beside(balls, there, solid.extent)).reshape(len(at), LOOKS)
        best = np.argmax(room, axis=1)
        better = room[rows, best] > radius
        at = np.where(better[:, None], there.reshape(len(at), LOOKS, 3)[rows, best], at)
        radius = np.where(better, room[rows, best], radius)
        step = SHRINK * step
    return at, radius


def _beside(balls: tuple[Array, Array], points: Array, size: float) -> Array:
    """Radii of the largest balls about points that do not touch any of some balls."""
    centers, radii = balls
    gaps = norm(points[:, None] - centers) - radii
    return np.asarray(np.min(gaps, axis=1, initial=np.inf) - APART * size)
