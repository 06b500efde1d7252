"""What two masks of bits have in common, word by word.

A word holds 64 pixels of a row, the lowest bit the first; the words of a strip of 64 columns follow each other down the
rows, strip after strip. They are signed, for only then do Python's integers and those of a machine have the same bits.
A mask is its words, and the columns and rows at which it begins and at which it is over: left, top, right, bottom.
"""

from __future__ import annotations

from collections.abc import Sequence

from . import brief, inlined

Words = Sequence[int]
Mask = tuple[Words, int, int, int, int]

WORD = 64
ROWS = 32
"""Words that are looked at before one asks whether any of them held something: machines take several at once."""
FEW = 8
"""Rows that are looked at first for the first pixel; then four times as many, and so on."""
PLACES = 0xFFFFFFFF
"""No index has more bits; that none is negative is what compilers must see to take several words at once."""


@inlined
def _boxes_meet(a: Mask, b: Mask) -> bool:
    return a[1] < b[3] and b[1] < a[3] and a[2] < b[4] and b[2] < a[4]


@inlined
def _strips(mask: Mask) -> int:
    return (mask[3] - mask[1] + WORD - 1) >> 6


@inlined
def _lowest(bits: int) -> int:
    """A word whose lowest bits are set, one of them at least."""
    return -1 if bits == WORD else (1 << bits) - 1


@inlined
def _first(mine: Words, other: Words, here: int, there: int, aside: int, count: int) -> int:
    """Number of the first word of `mine` that has a pixel of another one `aside` columns to the right, or `count`."""
    one, two, both = max(0, aside), max(0, -aside), _lowest(WORD - abs(aside))
    row = 0
    while row < count:
        i, j, many = (here + row) & PLACES, (there + row) & PLACES, min(ROWS, count - row)
        some = 0
        for k in range(many):
            some |= (mine[i + k] >> one) & (other[j + k] >> two)
        if some & both != 0:
            while (mine[i] >> one) & (other[j] >> two) & both == 0:
                i, j, row = i + 1, j + 1, row + 1
            return row
        row += many
    return count


@brief
def meet(a: Mask, b: Mask) -> bool:
    """Whether two masks have a pixel in common."""
    if not _boxes_meet(a, b):
        return False
    mine, other = a[0], b[0]
    right, down, high, low = b[1] - a[1], b[2] - a[2], a[4] - a[2], b[4] - b[2]
    top = max(0, down)
    count = min(high, down + low) - top
    for strip in range(max(0, right >> 6), _strips(a)):
        for second in range(max(0, (strip * WORD - right) >> 6), _strips(b)):
            aside = second * WORD + right - strip * WORD
            if aside >= WORD:
                break
            if _first(mine, other, strip * high + top, second * low + top - down, aside, count) < count:
                return True
    return False


@brief
def first_pixel(a: Mask, b: Mask) -> tuple[int, int] | None:
    """Column and row of the first pixel that two masks have in common, row by row from the top, each from the left."""
    if not _boxes_meet(a, b):
        return None
    mine, other = a[0], b[0]
    right, down, high, low = b[1] - a[1], b[2] - a[2], a[4] - a[2], b[4] - b[2]
    top = max(0, down)
    count = min(high, down + low) - top
    start, many = 0, FEW
    while start < count:  # no row below the first hit is looked at for long
        best = end = min(start + many, count)
        column, word = 0, 0
        for strip in range(max(0, right >> 6), _strips(a)):
            if best == start:
                break
            for second in range(max(0, (strip * WORD - right) >> 6), _strips(b)):
                aside = second * WORD + right - strip * WORD
                if aside >= WORD:
                    break
                here, there = strip * high + top, second * low + top - down
                row = start + _first(mine, other, here + start, there + start, aside, best - start)
                if row < best:
                    best, column = row, strip * WORD + max(0, aside)
                    word = (mine[here + row] >> max(0, aside)) & (other[there + row] >> max(0, -aside))
        if best < end:
            while word & 1 == 0:
                word >>= 1
                column += 1
            return a[1] + column, a[2] + top + best
        start, many = end, 4 * many
    return None


@brief
def area(a: Mask, b: Mask) -> int:
    """How many pixels two masks have in common.

    The bits of a word are added in pairs, fours and eights at once. Warren, Hacker's Delight, 5.1.
    """
    total = 0
    if not _boxes_meet(a, b):
        return total
    mine, other = a[0], b[0]
    right, down, high, low = b[1] - a[1], b[2] - a[2], a[4] - a[2], b[4] - b[2]
    top = max(0, down)
    for strip in range(max(0, right >> 6), _strips(a)):
        for second in range(max(0, (strip * WORD - right) >> 6), _strips(b)):
            aside = second * WORD + right - strip * WORD
            if aside >= WORD:
                break
            one, two, both = max(0, aside), max(0, -aside), _lowest(WORD - abs(aside))
            i, j = (strip * high + top) & PLACES, (second * low + top - down) & PLACES
            for k in range(min(high, down + low) - top):
                word = (mine[i + k] >> one) & (other[j + k] >> two) & both
                word -= (word >> 1) & 0x5555555555555555
                word = (word & 0x3333333333333333) + ((word >> 2) & 0x3333333333333333)
                word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0F
                total += ((word * 0x0101010101010101) >> 56) & 0xFF
    return total
