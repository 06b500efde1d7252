"""Point clouds for the survey of bounding volumes, by regime."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from refimpl.construct import points_of
from refimpl.linear import Array

Random = np.random.Generator

EACH = 2
"""Clouds of each regime."""


class Recipe(NamedTuple):
    """How to make a cloud, why, and in how many dimensions it spreads."""

    why: str
    make: Callable[[Random], Array]
    dimension: int = 3


def _random(rng: Random) -> Array:
    return np.asarray(rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.2, 3, size=3))


def _on_sphere(rng: Random) -> Array:
    way = rng.normal(size=(rng.integers(8, 40), 3))
    return np.asarray(way / np.linalg.norm(way, axis=1)[:, None])


def _corners(rng: Random) -> Array:
    """Corners of a cuboid, of which eight lie on one sphere, in any order."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.asarray(rng.permutation(signs * rng.integers(1, 4, size=3) * 0.1 + rng.normal(size=3)))


def _few(rng: Random) -> Array:
    """A tetrahedron: the least box touches it with no face, only with edges."""
    regular = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    return np.asarray(regular + rng.normal(size=(4, 3)) * rng.choice([0.0, 0.05]))


def _coplanar(rng: Random) -> Array:
    t, s = rng.random(20), rng.random(20)
    return np.stack([t, 1 - t, s], axis=1)


def _collinear(rng: Random) -> Array:
    return np.asarray(rng.integers(-9, 9, size=(10, 1)) * rng.integers(1, 4, size=3) * 0.5)


def _doubled(rng: Random) -> Array:
    return np.asarray(np.repeat(_random(rng)[:8], 4, axis=0))


def _one(rng: Random) -> Array:
    return np.asarray(np.repeat(rng.normal(size=(1, 3)), rng.integers(1, 6), axis=0))


def _thin(rng: Random) -> Array:
    return np.asarray(_random(rng) * [1, 1e-4, 1e-7])


def _far(rng: Random) -> Array:
    return np.asarray(_random(rng) + 1e6)


def _tiny(rng: Random) -> Array:
    return np.asarray(_random(rng) * 1e-9)


def _large(rng: Random) -> Array:
    return np.asarray(_random(rng) * 1e9)


def _bunny(rng: Random) -> Array:
    """Some vertices of a scanned model."""
    import pybullet_data  # noqa: PLC0415

    points = points_of(Path(pybullet_data.getDataPath()) / "bunny.obj")
    return np.asarray(points[np.sort(rng.choice(len(points), 120, replace=False))])


REGIMES: Mapping[str, Recipe] = MappingProxyType(
    {
        "random": Recipe("4 to 40 points, more or less elongated", _random),
        "on a sphere": Recipe("points that all lie on a sphere, up to rounding", _on_sphere),
        "cuboid": Recipe("the corners of a cuboid: more touch the sphere than are needed", _corners),
        "tetrahedron": Recipe("four points, regular or nearly: the least box touches edges only", _few),
        "thin": Recipe("extents of 1, 10⁻⁴ and 10⁻⁷", _thin),
        "doubled": Recipe("each point four times", _doubled),
        "far": Recipe("10⁶ away from the origin", _far),
        "tiny": Recipe("of the size 10⁻⁹", _tiny),
        "large": Recipe("of the size 10⁹", _large),
        "coplanar": Recipe("points in a plane, exactly", _coplanar, 2),
        "collinear": Recipe("points on a line, exactly", _collinear, 1),
        "one point": Recipe("one point, once or several times", _one, 0),
        **(
            {"model": Recipe("vertices of the bunny that PyBullet ships", _bunny)}
            if importlib.util.find_spec("pybullet_data")
            else {}
        ),
    }
)
