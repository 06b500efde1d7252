"""Many bodies in one PyBullet world: which of them touch, and whose boxes overlap."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from types import TracebackType
from typing import Self

from oracles.engines.bullet_engine import THINNEST
from oracles.engines.bullet_shapes import place
from oracles.engines.bullet_world import DISTANCE_FIELD, World
from oracles.scene import CONTACTS
from refimpl.proxy import Proxy

BODY_A, BODY_B = 1, 2
"""Places in a contact of PyBullet."""
Pair = tuple[int, int]


class BulletCrowd(World):
    """Proxies as the bodies of one world. Use it as a context manager.

    Parameters
    ----------
    proxies
        Single ones, of types that Bullet holds; a composite's hulls become bodies beside it.
    static
        Which of them cannot move.
    """

    def __init__(self, proxies: Sequence[Proxy], static: Sequence[bool]) -> None:
        super().__init__()
        self._begin()
        self.owner: dict[int, int] = {}
        for number, (proxy, fixed) in enumerate(zip(proxies, static, strict=True)):
            for part in place(type(proxy), proxy.pack().tolist(), THINNEST[CONTACTS]):
                self.owner[self._body(part, 0.0 if fixed else 1.0)] = number

    def touching(self) -> dict[Pair, float]:
        """Pairs (i, j), i < j, with a contact that is none across a gap; to the least distance of their contacts."""
        self.bullet.performCollisionDetection(physicsClientId=self.client)
        found: dict[Pair, float] = {}
        points = self.bullet.getContactPoints(physicsClientId=self.client)
        for body_a, body_b, distance in map(itemgetter(BODY_A, BODY_B, DISTANCE_FIELD), points):
            i, j = sorted((self.owner[body_a], self.owner[body_b]))
            if i != j and distance <= 0:
                found[i, j] = min(distance, found.get((i, j), 0.0))
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.bullet.disconnect(self.client)
