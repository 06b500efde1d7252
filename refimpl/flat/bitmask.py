"""Masks of bits: rows as numbers, and words of 64 pixels laid out so that a shifted mask is had by slicing.

A word holds 64 pixels of a row, the words of a strip of 64 columns follow each other down the rows, and the strips lie
side by side. A mask that is shifted by 64q + r pixels is the mask shifted by r pixels, q strips further; the 64 copies
are made when they are first needed. What two masks have in common is then one broadcast *and* of two slices, and as a
strip is long, a machine goes through its words as fast as they come from memory.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from refimpl.flat.tiles import TILE, Tiles
from refimpl.linear import Bools

Words = NDArray[np.uint64]

KEEPING = 1 << 20
"""Pixels of a mask of which all shifted copies and tiles are kept, 16 bytes a pixel; of a larger one only the last."""


class BitMask:
    """The pixels of an image that are solid, without the empty rows and columns around them.

    Attributes
    ----------
    left, top : int
        Column and row of the image at which the mask begins.
    width, height : int
        0 where no pixel is solid.
    solid : (height, width) bool
    rows : list of int
        Each row as one number, whose lowest bit is the last column: for a few rows the fastest there is, and the first
        pixel that is set is told by how many bits the number has.
    area : int
        How many pixels are solid.
    words : (strips * height,) int64
        The strips one after the other, as compiled code reads them.
    likely : int
        Row that is asked first: the fullest, or where the mask was hit last, as what meets will mostly meet again
        nearby. No answer depends on it.
    """

    __slots__ = (
        "_strips",
        "_tiles",
        "area",
        "height",
        "left",
        "likely",
        "rows",
        "solid",
        "top",
        "width",
        "words",
    )

    def __init__(self, solid: Bools) -> None:
        rows, columns = np.flatnonzero(solid.any(axis=1)), np.flatnonzero(solid.any(axis=0))
        self.left, self.top = (int(found[0]) if len(found) else 0 for found in (columns, rows))
        right, bottom = (int(found[-1]) + 1 if len(found) else 0 for found in (columns, rows))
        self.width, self.height = right - self.left, bottom - self.top
        self.solid: Bools = solid[self.top : bottom, self.left : right].copy()
        self.solid.setflags(write=False)
        packed, room = np.packbits(self.solid, axis=1), -self.width % 8
        self.rows = [int.from_bytes(row.tobytes(), "big") >> room for row in packed]
        counts = [row.bit_count() for row in self.rows]
        self.area = sum(counts)
        self.likely = counts.index(max(counts)) if counts else 0
        self._strips: dict[int, Words] = {}
        self._tiles: dict[int, Tiles] = {}
        self.words: NDArray[np.int64] = self.shifted(0).reshape(-1).view(np.int64)

    def tiles(self, right: int, down: int) -> Tiles:
        """Tiles of the mask moved by less than a tile."""
        which = right * TILE + down
        found = self._tiles.get(which)
        if found is None:
            if self.width * self.height > KEEPING:
                self._tiles = {0: self._tiles[0]} if 0 in self._tiles else {}
            found = self._tiles[which] = Tiles(self.solid, right, down)
        return found

    def shifted(self, by: int) -> Words:
        """Strips of the mask moved right by 0 to 63 pixels, (strips, rows); the lowest bit is the first column."""
        found = self._strips.get(by)
        if found is None:
            room = -(self.width + by) % 64
            packed = np.packbits(np.pad(self.solid, ((0, 0), (by, room))), axis=1, bitorder="little")
            found = np.ascontiguousarray(packed.view("<u8").T, dtype=np.uint64)
            if self.width * self.height > KEEPING:
                self._strips = {0: self._strips[0]} if by else {}
            self._strips[by] = found
        return found
