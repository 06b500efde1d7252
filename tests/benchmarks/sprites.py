"""Sprites against pygame's masks, side by side: ``python -m tests.benchmarks.sprites [--size N]``.

Pairs of masks of N × N pixels at fixed offsets, aligned to words and not: whether they overlap, and in how many pixels.
The two take turns, and the least of many short runs counts. Where pygame's scan ends at its first words it takes hardly
more than an interpreter needs to call a function; where there is anything to be scanned, the words decide.
"""

from __future__ import annotations

import argparse
import timeit
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from refimpl.flat.sprites import Sprite, common_pixel, intersect, overlap_area
from refimpl.linear import Bools

CALLS, REPEATS = 50, 60


def masks(size: int) -> dict[str, Bools]:
    """Masks to be asked: what is scanned soon, late, or never to the end."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    far = np.hypot(x, y)
    rng = np.random.default_rng(0)
    return {
        "disc": far <= size / 2,
        "corners": far > size * 0.58,
        "close corners": far > size / 2 + 1,
        "noise": rng.uniform(size=(size, size)) < 0.5,
        "sparse": rng.uniform(size=(size, size)) < 2e-4,
    }


PAIRS = (
    ("disc", "disc"),
    ("disc", "corners"),
    ("disc", "close corners"),
    ("noise", "noise"),
    ("sparse", "sparse"),
    ("noise", "sparse"),
)
OFFSETS = ((0, 0), (3, 0), (64, 0), (37, 19), (-101, -37))


def pygame_mask(solid: Bools) -> Any:
    """The same mask for pygame."""
    import pygame  # noqa: PLC0415

    made = pygame.mask.Mask(solid.shape[::-1])
    for y, x in np.argwhere(solid).tolist():
        made.set_at((x, y))
    return made


def least(*work: Callable[[], object]) -> list[float]:
    """Microseconds of each, in turns."""
    found = [np.inf] * len(work)
    for _ in range(REPEATS):
        for number, one in enumerate(work):
            found[number] = min(found[number], timeit.timeit(one, number=CALLS) / CALLS * 1e6)
    return found


def measured(size: int) -> Table:
    """Measure all pairs and offsets; each answer is compared as well."""
    table = Table(title=f"Masks of {size} × {size} pixels: microseconds a call, pygame / refimpl, and the ratio")
    for column in ("pair", "offset", "in common", "intersect", "overlap_area", "common_pixel"):
        table.add_column(column)
    made = masks(size)
    theirs = {name: pygame_mask(mask) for name, mask in made.items()}
    for first, second in PAIRS:
        for offset in OFFSETS:
            a, b, other, moved = theirs[first], theirs[second], Sprite(made[first]), Sprite(made[second], offset)
            area = a.overlap_area(b, offset)
            assert area == overlap_area(other, moved)
            assert intersect(other, moved) == (a.overlap(b, offset) is not None) == (area > 0)
            times = least(
                lambda a=a, b=b, offset=offset: a.overlap(b, offset),
                lambda other=other, moved=moved: intersect(other, moved),
                lambda a=a, b=b, offset=offset: a.overlap_area(b, offset),
                lambda other=other, moved=moved: overlap_area(other, moved),
                lambda other=other, moved=moved: common_pixel(other, moved),
            )
            ratios = ((times[0], times[1]), (times[2], times[3]), (times[0], times[4]))
            said = [f"{pygame:.2f} / {own:.2f}: {pygame / own:.2f}" for pygame, own in ratios]
            table.add_row(f"{first}, {second}", str(offset), str(area), *said)
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=512)
    Console().print(measured(parser.parse_args().size))
