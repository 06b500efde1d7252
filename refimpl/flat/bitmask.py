"""Masks of bits, 64 pixels a word, laid out so that a mask shifted by whole pixels is had by slicing.

A word holds 64 pixels of a row, the words of a strip of 64 columns follow each other down the rows, and the strips lie
side by side. A mask that is shifted by 64q + r pixels is the mask shifted by r pixels, q strips further; the 64 copies
are made when they are first needed. What two masks have in common is then one broadcast *and* of two slices, and as a
strip is long, numpy goes through its words as fast as they come from memory.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from refimpl.linear import Bools

Words = NDArray[np.uint64]

TILE = 8
"""Pixels along each side of a tile."""
KEEPING = 1 << 20
"""Pixels of a mask of which all shifted copies are kept, 8 bytes a pixel; of a larger one only the last."""
POPULATION = np.array([number.bit_count() for number in range(256)], dtype=np.uint8)
"""Bits of each byte, where numpy does not count them."""


class BitMask:
    """The pixels of an image that are solid, without the empty rows and columns around them.

    Attributes
    ----------
    left, top : int
        Column and row of the image at which the mask begins.
    width, height : int
        0 where no pixel is solid.
    solid : (height, width) bool
    """

    def __init__(self, solid: Bools) -> None:
        rows, columns = np.flatnonzero(solid.any(axis=1)), np.flatnonzero(solid.any(axis=0))
        self.left, self.top = (int(found[0]) if len(found) else 0 for found in (columns, rows))
        right, bottom = (int(found[-1]) + 1 if len(found) else 0 for found in (columns, rows))
        self.width, self.height = right - self.left, bottom - self.top
        self.solid: Bools = solid[self.top : bottom, self.left : right].copy()
        self.solid.setflags(write=False)
        self._copies: dict[int, Words] = {}
        self._tiles: dict[tuple[int, bool], int] = {}

    @cached_property
    def area(self) -> int:
        """How many pixels are solid."""
        return int(np.count_nonzero(self.solid))

    @cached_property
    def rows(self) -> list[int]:
        """Each row as one number, whose lowest bit is the first column: for a few rows, the fastest there is."""
        packed = np.packbits(self.solid, axis=1, bitorder="little")
        return [int.from_bytes(row, "little") for row in packed]

    @property
    def across(self) -> int:
        """Tiles from left to right."""
        return -(-self.width // TILE)

    def tiles(self, stride: int, *, spread: bool) -> int:
        """Which tiles hold anything, as one number with so many bits a row.

        Parameters
        ----------
        spread
            Give those of the mask that is moved right and down by less than a tile, by any amount.
        """
        found = self._tiles.get((stride, spread))
        if found is None:
            room = ((0, -self.height % TILE), (0, -self.width % TILE))
            blocks = np.pad(self.solid, room).reshape(-(-self.height // TILE), TILE, self.across, TILE)
            some = np.pad(blocks.any(axis=(1, 3)), ((0, 1), (0, stride - self.across)))
            if spread:
                some |= np.roll(some, 1, axis=0)
                some |= np.roll(some, 1, axis=1)  # what is rolled in is empty
            packed = np.packbits(some.reshape(-1), bitorder="little")
            found = self._tiles[stride, spread] = int.from_bytes(packed.tobytes(), "little")
        return found

    def shifted(self, by: int) -> Words:
        """Strips of the mask moved right by 0 to 63 pixels, (strips, rows); the lowest bit is the first column."""
        found = self._copies.get(by)
        if found is None:
            room = -(self.width + by) % 64
            packed = np.packbits(np.pad(self.solid, ((0, 0), (by, room))), axis=1, bitorder="little")
            found = np.ascontiguousarray(packed.view("<u8").T, dtype=np.uint64)
            if self.width * self.height > KEEPING:
                self._copies = {0: self._copies[0]} if 0 in self._copies else {}
            self._copies[by] = found
        return found


def common(a: BitMask, b: BitMask, right: int, down: int) -> Words:
    """Words (strips, rows) of pixels that both masks have, with `b` moved right and down; their boxes must overlap."""
    mine, other, strips = a.shifted(0), b.shifted(right & 63), right >> 6
    first, last = max(0, strips), min(len(mine), strips + len(other))
    top, bottom = max(0, down), min(a.height, down + b.height)
    return mine[first:last, top:bottom] & other[first - strips : last - strips, top - down : bottom - down]


def tiles_meet(a: BitMask, b: BitMask, right: int, down: int) -> bool:
    """Whether the masks may have a pixel in common, as far as tiles can tell."""
    stride = a.across + b.across + 1  # so that nothing that leaves a row comes into another
    mine, other = a.tiles(stride, spread=False), b.tiles(stride, spread=True)
    shift = down // TILE * stride + right // TILE
    return bool(mine >> shift & other if shift > 0 else other >> -shift & mine)


def common_in_row(a: BitMask, b: BitMask, right: int, down: int, row: int) -> int:
    """Bits of one row of `a` that `b` has too; the lowest is the first column of the one that begins further right."""
    mine, other = a.rows[row], b.rows[row - down]
    return mine >> right & other if right > 0 else other >> -right & mine


def _counted(words: Words) -> int:
    return int(np.add.reduce(np.bitwise_count(words).reshape(-1), 0, np.uint32))


def _counted_by_bytes(words: Words) -> int:
    return int(np.sum(POPULATION[words.reshape(-1).view(np.uint8)], dtype=np.int64))


count = _counted if hasattr(np, "bitwise_count") else _counted_by_bytes  # numpy before 2.0
"""How many bits of some words are set."""
