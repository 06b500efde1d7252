"""Crowds of many types, thrown into a room so densely that each body touches one or two others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from refimpl.bodies import Body
from refimpl.linear import Array, Bools, rotation_matrix
from refimpl.mass import mass_properties
from refimpl.queries import distance
from refimpl.shapes import Box, Capsule, Composite, ConvexPolyhedron, Cylinder, HalfSpace, Proxy, Sphere
from refimpl.volumes import is_endless

ROOM_EACH = 1.5
"""Side of the cube that each body has on average; bodies extend over 0.4 to 2."""
STATIC_SHARE = 0.2
CLOSE_SHARE = 0.25
"""Bodies that are moved until they are about to touch another one."""
GAPS = (0.0, 1e-9, -1e-9, 5e-4, -5e-4, 2e-3, -2e-3, 1e-2, -1e-2)

Random = np.random.Generator


@dataclass(frozen=True, eq=False)
class Crowd:
    """Proxies side by side.

    Attributes
    ----------
    proxies
        Single ones, where they are.
    static : (n,) bool
        Those that cannot move.
    """

    proxies: tuple[Proxy, ...]
    static: Bools

    def bodies(self) -> list[Body]:
        """Give each as a body of a world; the colliders keep their numbers, to the bit."""
        return [
            Body(proxy) if fixed else Body(proxy, mass=1.0, matter=mass_properties(proxy, allowed_overlap=np.inf))
            for proxy, fixed in zip(self.proxies, self.static, strict=True)
        ]

    def __len__(self) -> int:
        return len(self.proxies)


def thrown(count: int, seed: int, kinds: Mapping[str, Callable[[Random, Array], Proxy]] | None = None) -> Crowd:
    """Throw so many bodies into a room on a static ground; a quarter of them touches another one or nearly does."""
    rng = np.random.default_rng(seed)
    make = list((KINDS if kinds is None else kinds).values())
    side = ROOM_EACH * np.cbrt(count)
    found: list[Proxy] = [HalfSpace([0.0, 0.0, 1.0], 0.0)]
    while len(found) < count:
        place = rng.uniform([-side / 2, -side / 2, 0.0], [side / 2, side / 2, side])
        found.append(make[len(found) % len(make)](rng, place))
    static = rng.uniform(size=count) < STATIC_SHARE
    static[:1] = True
    for number in np.flatnonzero(rng.uniform(size=count) < CLOSE_SHARE).tolist():
        other = int(rng.integers(count))
        if other != number and not is_endless(found[number]):
            found[number] = _close_to(found[other], found[number], float(rng.choice(GAPS)))
    return Crowd(tuple(found), static)


def _close_to(other: Proxy, body: Proxy, gap: float) -> Proxy:
    """Move a body along the normal until it is at this signed distance from another."""
    found = distance(other, body)
    return body.translated((gap - found.distance) * found.normal)


def _turn(rng: Random) -> Array:
    q = rng.normal(size=4)
    return np.asarray(q / np.sqrt(q @ q))


def _ends(rng: Random, place: Array) -> tuple[Array, Array]:
    half = rotation_matrix(_turn(rng))[:, 2] * rng.uniform(0.2, 0.6)
    return place - half, place + half


def _hull(rng: Random, place: Array) -> Proxy:
    way = rng.normal(size=(12, 3))
    return ConvexPolyhedron.from_vertices(0.7 * way / np.linalg.norm(way, axis=1)[:, None], place, _turn(rng))


def _dumb_bell(rng: Random, place: Array) -> Proxy:
    p, q = _ends(rng, place)
    return Composite([Sphere(p, 0.3), Capsule(p, q, 0.15), Box(q, [0.3, 0.25, 0.2], _turn(rng))])


KINDS: Mapping[str, Callable[[Random, Array], Any]] = MappingProxyType(
    {
        "Sphere": lambda rng, place: Sphere(place, rng.uniform(0.2, 0.7)),
        "Box": lambda rng, place: Box(place, rng.uniform(0.2, 0.7, 3), _turn(rng)),
        "Capsule": lambda rng, place: Capsule(*_ends(rng, place), rng.uniform(0.15, 0.4)),
        "Cylinder": lambda rng, place: Cylinder(*_ends(rng, place), rng.uniform(0.2, 0.5)),
        "ConvexPolyhedron": _hull,
        "Composite": _dumb_bell,
    }
)
"""The types that Bullet and the reference both hold as solids, each at a place with random sizes and pose."""
