"""How far the reference's way out of overlapping unions is from the shortest: ``python -m tests.depths [n] [seed]``.

Small unions of polytopes, held against exact truth (`tests.truth.depths`).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from refimpl import AABB, Box, Composite, ConvexPolyhedron, Proxy
from refimpl.contacts import contacts
from tests.truth.bodies import body_of
from tests.truth.depths import shortest_way_out

SAME = 1e-9
"""Relative difference of lengths that are taken for equal."""


@dataclass(frozen=True)
class Depth:
    """The interval of one overlap, and the truth."""

    least: float
    truth: float
    depth: float
    scene: tuple[list[Proxy], list[Proxy]]

    @property
    def holds(self) -> bool:
        """Whether the truth lies in the interval, but for rounding."""
        rounding = 1e-12 * max(float(part.magnitude) for side in self.scene for part in side)
        return self.least - rounding <= self.truth <= self.depth + rounding


def part(rng: np.random.Generator, even: bool) -> Proxy:
    """A box, or a hull of few points, of round numbers or of any."""
    if even:
        center, half, turn = rng.integers(-8, 9, 3) / 8, rng.integers(2, 9, 3) / 8, rng.integers(-2, 3, 4) + 0.0
    else:
        center, half, turn = rng.uniform(-1, 1, 3), rng.uniform(0.25, 1, 3), rng.uniform(-1, 1, 4)
    turn = turn if turn.any() else np.array([0.0, 0, 0, 1])
    kind = rng.integers(3)
    if kind == 0:
        return Box(center, half, turn)
    if kind == 1:
        return AABB(center - half, center + half)
    corners = np.concatenate([np.eye(3), -np.ones((1, 3)), rng.integers(-4, 5, (2, 3)) / 4]) * half
    return ConvexPolyhedron.from_vertices(corners, center, turn)


def overlaps(n: int, seed: int) -> Iterator[Depth]:
    """Overlapping ones among `n` pairs of unions of up to three parts, half of them of round numbers."""
    rng = np.random.default_rng(seed)
    for i in range(n):
        a, b = ([part(rng, i % 2 == 0) for _ in range(rng.integers(1, most + 1))] for most in (3, 2))
        known = contacts(Composite(a), Composite(b))
        if known.separation.distance < 0:
            truth, _ = shortest_way_out([body_of(x) for x in a], [body_of(x) for x in b])
            least, depth = known.depth_interval.tolist()
            yield Depth(least, float(truth), depth, (a, b))


def main(arguments: list[str]) -> None:
    """Measure, and say how often the way out is the shortest, and how much longer it is at worst."""
    n, seed = [*map(int, arguments), *(400, 1)[len(arguments) :]]
    found = list(overlaps(n, seed))
    above = np.array([x.depth / x.truth for x in found if x.truth > 0])
    below = np.array([x.least / x.truth for x in found if x.truth > 0])
    print(f"{len(found)} overlaps; the truth is outside of the interval in {sum(not x.holds for x in found)}")
    print(f"way out: the shortest in {np.mean(above <= 1 + SAME):.1%}, else up to {above.max():.3f} times as long")
    longer = " and ".join(f"by more than {by:.0%} in {np.mean(above > 1 + by):.1%}" for by in (0.01, 0.05))
    print(f"         longer {longer}")
    print(f"least: the truth in {np.mean(below >= 1 - SAME):.1%}, else down to {below.min():.3f} of it")


if __name__ == "__main__":
    main(sys.argv[1:])
