"""Tiles of 8 × 8 pixels: a mask's coarser picture, which tells of most masks at once that they have nothing in common.

A tile is a word, and all tiles that hold anything are one number with a bit for each. Two masks can only meet in tiles
that both numbers have; what is left is looked at word by word.
"""

from __future__ import annotations

from array import array

import numpy as np

from refimpl.linear import Bools

TILE = 8
"""Pixels along each side."""
ACROSS, INSIDE = 3, TILE - 1
"""A column's tile is column >> ACROSS, and its place in there column & INSIDE."""


class Tiles:
    """A mask, cut into tiles.

    Parameters
    ----------
    solid : (height, width) bool
    right, down : int
        The mask is moved by so much before it is cut, each less than a tile.

    Attributes
    ----------
    across, high : int
        How many tiles there are.
    words : array of high * across numbers of 64 bits
        Of all tiles, row by row; the highest bit is the first pixel, and those of a row follow each other.
    """

    __slots__ = ("_numbers", "_some", "across", "high", "words")

    def __init__(self, solid: Bools, right: int, down: int) -> None:
        height, width = solid.shape[0] + down, solid.shape[1] + right
        padded = np.pad(solid, ((down, -height % TILE), (right, -width % TILE)))
        self.high: int = padded.shape[0] // TILE
        self.across: int = padded.shape[1] // TILE
        rows = np.packbits(padded, axis=1).reshape(self.high, TILE, self.across)
        words = np.ascontiguousarray(rows.transpose(0, 2, 1)).view(">u8")[..., 0].astype(np.uint64)
        self.words: array[int] = array("Q", words.tobytes())
        self._some = words != 0
        self._numbers: dict[int, int] = {}

    def number(self, stride: int) -> int:
        """Which tiles hold anything, as one number with so many bits a row; the lowest bit is the end of the last."""
        found = self._numbers.get(stride)
        if found is None:
            some = np.pad(self._some, ((0, 0), (0, stride - self.across)))
            packed = np.packbits(some).tobytes()
            found = self._numbers[stride] = int.from_bytes(packed, "big") >> -some.size % 8
        return found


def look(a: Tiles, b: Tiles, right: int, down: int, most: int) -> int | None:
    """Row in which both have a pixel, with `b` so many tiles further right and down.

    No row of the tiles above has one, and none of the tile before that row.

    Parameters
    ----------
    most
        How many tiles may be looked at.

    Returns
    -------
    int, optional
        −1 where there is no such row; None where that would take longer.
    """
    stride = a.across + b.across + 1  # so that nothing that leaves a row comes into another
    mine, other = a.number(stride), b.number(stride)
    above = (b.high - a.high + down) * stride + right
    if above > 0:
        found, end, aside = other >> above & mine, a.high * stride, 0
    else:  # places are those of b's number
        found, end, aside = mine >> -above & other, (b.high + down) * stride, right
    while found:
        if not most:
            return None
        most -= 1
        place = found.bit_length()
        row, column = (end - place) // stride, (end - place) % stride + aside
        word = a.words[row * a.across + column] & b.words[(row - down) * b.across + column - right]
        if word:
            return row * TILE + (64 - word.bit_length()) // TILE
        found ^= 1 << place - 1
    return -1
