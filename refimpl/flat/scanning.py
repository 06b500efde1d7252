"""What two masks of bits have in common, wherever their boxes overlap: some row, the first row, and how many pixels.

Tiles answer first, then some rows, and then all words are scanned by numpy. Compiled kernels (`refimpl.kernels.masks`)
need none of that: they look at all words in the time that numpy takes to be called.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from refimpl.compiling import WORTH_COMPILING, is_compiled, module_for
from refimpl.flat.bitmask import BitMask, Words
from refimpl.flat.tiles import ACROSS, INSIDE, TILE, look

LOOKS = 4
"""Tiles that are looked at, one by one, before rows are."""
ROWS = 24
"""Rows that are asked, one by one, before all words are scanned."""
POPULATION = np.array([number.bit_count() for number in range(256)], dtype=np.uint8)
"""Bits of each byte, where numpy does not count them."""

Placed = tuple[NDArray[np.int64], int, int, int, int]
"""Words of a mask, the columns and rows at which it begins, and those at which it is over: left, top, right, bottom."""


class Compiled:
    """Kernels on two masks, once they are compiled."""

    __slots__ = ("area", "first_pixel", "meet")

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Go on without."""
        self.meet: Callable[[Placed, Placed], bool] | None = None
        self.first_pixel: Callable[[Placed, Placed], tuple[int, int] | None] | None = None
        self.area: Callable[[Placed, Placed], int] | None = None


COMPILED = Compiled()


def compile_scans(calls: int = WORTH_COMPILING) -> bool:
    """Compile the kernels for this process, if so many calls are worth it and numba is installed; whether they are.

    It takes half a second, and two more when that has not been done before on this machine.
    """
    if COMPILED.meet is None and is_compiled(module := module_for("masks", calls)):
        for name in Compiled.__slots__:
            setattr(COMPILED, name, _entry(getattr(module, name)))
    return COMPILED.meet is not None


def _entry(kernel: Any) -> Any:
    """The compiled function behind a kernel: to tell the types of what is passed takes as long as the call."""
    pixel = (np.ones(1, dtype=np.int64), 0, 0, 1, 1)
    kernel(pixel, pixel)
    (compiled,) = kernel.overloads.values()
    return compiled.entry_point


def some_row(a: BitMask, b: BitMask, right: int, down: int) -> int:
    """Row of `a` in which `b`, moved right and down, has a pixel too, or −1."""
    row = _looked(a, b, right, down)
    if row is None:
        top, bottom = max(0, down), min(a.height, b.height + down)
        row = _in_rows(a, b, right, down, range(top, bottom, (bottom - top) // ROWS + 1))
        if row < 0:
            row = _scanned(a, b, right, down)
    if row >= 0:
        a.likely = row
    return row


def first_row(a: BitMask, b: BitMask, right: int, down: int) -> int:
    """First row of `a` in which `b`, moved right and down, has a pixel too, or −1."""
    row = _looked(a, b, right, down)
    top, bottom = max(0, down), min(a.height, b.height + down)
    if row is None:
        row = _in_rows(a, b, right, down, range(top, min(top + ROWS, bottom)))
        return row if row >= 0 else _scanned(a, b, right, down)
    before = _in_rows(a, b, right, down, range(max(top, row - row % TILE), row))
    return row if before < 0 else before


def _looked(a: BitMask, b: BitMask, right: int, down: int) -> int | None:
    """A row in which both have a pixel, of which only rows of the same tile may be sooner; −1; or None: not known."""
    return look(a.tiles(0, 0), b.tiles(right & INSIDE, down & INSIDE), right >> ACROSS, down >> ACROSS, LOOKS)


def _in_rows(a: BitMask, b: BitMask, right: int, down: int, rows: Iterable[int]) -> int:
    """The first of some rows in which both have a pixel, or −1."""
    mine, others, over = a.rows, b.rows, right + b.width - a.width
    for row in rows:
        if others[row - down] >> over & mine[row] if over > 0 else mine[row] >> -over & others[row - down]:
            return row
    return -1


def _scanned(a: BitMask, b: BitMask, right: int, down: int) -> int:
    """The first row in which both have a pixel, or −1."""
    words = common(a, b, right, down)
    if not words.max():
        return -1
    return max(0, down) + int(np.argmax(np.bitwise_or.reduce(words, axis=0) != 0))


def area(a: BitMask, b: BitMask, right: int, down: int) -> int:
    """Pixels that both have, with `b` moved right and down."""
    return count(common(a, b, right, down))


def common(a: BitMask, b: BitMask, right: int, down: int) -> Words:
    """Words (strips, rows) of pixels that both masks have, with `b` moved right and down."""
    mine, other, strips = a.shifted(0), b.shifted(right & 63), right >> 6
    first, last = max(0, strips), min(len(mine), strips + len(other))
    top, bottom = max(0, down), min(a.height, down + b.height)
    return mine[first:last, top:bottom] & other[first - strips : last - strips, top - down : bottom - down]


def _counted(words: Words) -> int:
    return int(np.add.reduce(np.bitwise_count(words).reshape(-1), 0, np.uint32))


def _counted_by_bytes(words: Words) -> int:
    return int(np.sum(POPULATION[words.reshape(-1).view(np.uint8)], dtype=np.int64))


count = _counted if hasattr(np, "bitwise_count") else _counted_by_bytes  # numpy before 2.0
"""How many bits of some words are set."""
