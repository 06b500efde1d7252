"""Sprites against pygame's masks, side by side: ``python -m tests.benchmarks.sprites [--size N]``.

Two masks of N × N pixels at many offsets, one call for each: in how many pixels they overlap, whether they do, and a
first common pixel. Offsets are drawn where the boxes overlap, hits and misses apart, or lie on the way of one mask past
the other, two pixels a step. pygame is handed masks and an offset, refimpl two sprites. All take turns, and the least
of many rounds counts. Of refimpl first as it is, then with kernels compiled by numba.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from itertools import repeat
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from oracles.surveys.sprites_engines import pygame_mask
from refimpl.flat import scanning
from refimpl.flat.sprites import Sprite, common_pixel, intersect, overlap_area
from refimpl.linear import Bools

Offset = tuple[int, int]

DRAWN, ROUNDS = 60, 15
QUESTIONS = ("overlap_area", "intersect", "common_pixel")


def masks(size: int) -> dict[str, Bools]:
    """Masks to be asked: what is scanned soon, late, or never to the end."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    far = np.hypot(x, y)
    rng = np.random.default_rng(0)
    return {
        "full": np.ones((size, size), dtype=bool),
        "disc": far <= size / 2,
        "ring": (far <= size / 2) & (far > size * 0.47),
        "corners": far > size * 0.58,
        "close corners": far > size / 2 + 1,
        "noise": rng.uniform(size=(size, size)) < 0.5,
        "thin": rng.uniform(size=(size, size)) < 0.02,
        "sparse": rng.uniform(size=(size, size)) < 2e-4,
    }


PAIRS = (
    ("full", "full"),
    ("disc", "disc"),
    ("ring", "ring"),
    ("disc", "ring"),
    ("disc", "corners"),
    ("disc", "close corners"),
    ("noise", "noise"),
    ("noise", "disc"),
    ("thin", "thin"),
    ("noise", "sparse"),
    ("disc", "sparse"),
    ("sparse", "sparse"),
)


class Places(NamedTuple):
    """Offsets of one kind."""

    kind: str
    offsets: list[Offset]


def places(a: Any, b: Any, size: int) -> Iterator[Places]:
    """Hits, misses, ways past each other, and the same place; of all but the last as many as there are, up to 60."""
    rng = np.random.default_rng(1)
    drawn = [(int(x), int(y)) for x, y in rng.integers(1 - size, size, (20 * DRAWN, 2))]
    hit = [a.overlap(b, offset) is not None for offset in drawn]
    yield Places("hits", [offset for offset, found in zip(drawn, hit, strict=True) if found][:DRAWN])
    yield Places("misses", [offset for offset, found in zip(drawn, hit, strict=True) if not found][:DRAWN])
    yield Places("passing", [(x, x // 3 - size // 4) for x in range(-size, size, 2)])
    yield Places("the same place", [(0, 0)] * DRAWN)


def calls(question: Callable[..., object], first: Any, second: Sequence[Any]) -> float:
    """Microseconds a call."""
    start = perf_counter()
    for _ in map(question, repeat(first), second):
        pass
    return (perf_counter() - start) / len(second) * 1e6


def measured(a: Bools, b: Bools, theirs: tuple[Any, Any], offsets: list[Offset]) -> dict[str, list[float]]:
    """Times of each question: pygame, refimpl, and refimpl compiled."""
    mask, other = theirs
    own, second = Sprite(a), Sprite(b)
    moved = [second.moved_to(offset) for offset in offsets]
    for sprite, offset in zip(moved, offsets, strict=True):
        pixel = common_pixel(own, sprite)
        assert mask.overlap_area(other, offset) == overlap_area(own, sprite)
        assert (mask.overlap(other, offset) is not None) == intersect(own, sprite) == (pixel is not None)
    questions = dict(zip(QUESTIONS, (overlap_area, intersect, common_pixel), strict=True))
    kernels = {name: getattr(scanning.COMPILED, name) for name in scanning.Compiled.__slots__}
    found = {question: [np.inf] * 3 for question in QUESTIONS}
    for _ in range(ROUNDS):
        for name, question in questions.items():
            asked = mask.overlap_area if name == "overlap_area" else mask.overlap
            scanning.COMPILED.forget()
            times = [_pygame(asked, other, offsets), calls(question, own, moved)]
            for kernel, compiled in kernels.items():
                setattr(scanning.COMPILED, kernel, compiled)
            times.append(calls(question, own, moved))
            found[name] = [min(pair) for pair in zip(found[name], times, strict=True)]
    return found


def _pygame(asked: Callable[..., object], other: Any, offsets: list[Offset]) -> float:
    start = perf_counter()
    for _ in map(asked, repeat(other), offsets):
        pass
    return (perf_counter() - start) / len(offsets) * 1e6


def table(size: int) -> Table:
    """Measure all pairs and places; each answer is compared as well."""
    shown = Table(
        title=f"Masks of {size} × {size} pixels: pygame's microseconds a call, and how often refimpl is as fast"
    )
    for column in ("pair", "places", *QUESTIONS):
        shown.add_column(column)
    made = masks(size)
    theirs = {name: pygame_mask(mask) for name, mask in made.items()}
    scanning.compile_scans()
    for first, second in PAIRS:
        for kind, offsets in places(theirs[first], theirs[second], size):
            if offsets:
                times = measured(made[first], made[second], (theirs[first], theirs[second]), offsets)
                said = [f"{p:.2f}: {p / own:.2f}, {p / fast:.2f}" for p, own, fast in times.values()]
                shown.add_row(f"{first}, {second}", f"{len(offsets)} {kind}", *said)
    return shown


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=512)
    Console(width=120).print(table(parser.parse_args().size))
