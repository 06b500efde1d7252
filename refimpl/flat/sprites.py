"""Sprites: images whose solid pixels collide, as in games of two dimensions.

A pixel is a closed unit of the raster and not a square in the plane: sprites overlap when a pixel is solid in both, and
those that lie side by side do not. Columns count to the right and rows downwards, as in images.

An *early reject* compares the boxes of the solid pixels, a second one the tiles that hold any; an *early accept*
compares the row in the middle of what the boxes have in common. Where none can tell, words of bits are compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from refimpl.flat.bitmask import BitMask, common, common_in_row, count, tiles_meet
from refimpl.linear import Array, Bools
from refimpl.shapes import ShapeError

MOST_PIXELS = 1 << 26
"""Of a sprite."""
FARTHEST = 1 << 62
"""Largest coordinate of a position."""
FORMATS = ("PNG", "GIF", "WEBP", "TIFF", "BMP", "TGA")
"""Of image files that are read: those that have an alpha channel, or a colour that is transparent."""
GLANCE = 4
"""Rows in which a first common pixel is looked for, one by one, before it is looked for in all."""

Pixel = tuple[int, int]


@dataclass(frozen=True)
class SpriteContact:
    """Collision data of two sprites.

    Attributes
    ----------
    hit : bool
    area : int
        Pixels that are solid in both.
    pixel : (int, int), optional
        The first of them, row by row from the top, each from the left.
    normal : (2,)
        Unit vector from A to B; zeros without a hit.
    """

    hit: bool
    area: int
    pixel: Pixel | None
    normal: Array


class Sprite:
    """A bit mask with a position.

    Parameters
    ----------
    mask : (height, width) bool
        Which pixels are solid; may be empty, or have no solid pixel at all.
    position : (x, y) int
        Of the pixel in the mask's first row and column.

    Raises
    ------
    ShapeError
        For a mask that is no image of booleans, or too large, and for a position that is no pair of integers.

    Examples
    --------
    >>> ball = Sprite([[False, True], [True, True]])
    >>> overlap_area(ball, ball.moved_to((1, 0)))
    1
    """

    __slots__ = ("_bits", "_bottom", "_left", "_right", "_top", "position", "shape")

    position: Pixel
    shape: tuple[int, int]
    """Height and width of the mask."""

    def __init__(self, mask: ArrayLike, position: Sequence[int] = (0, 0)) -> None:
        solid = _checked_mask(mask)
        self._place(BitMask(solid), (solid.shape[0], solid.shape[1]), _checked_position(position))

    @classmethod
    def from_image(cls, path: str | PathLike[str], position: Sequence[int] = (0, 0), threshold: int = 127) -> Sprite:
        """Read the alpha channel of an image file: pixels above the threshold (0 to 255) are solid.

        Raises
        ------
        ShapeError
            For a file that is no such image, has no alpha, or is too large.
        ImportError
            Without pillow (the extra ``sprites``).
        """
        from refimpl.flat.images import alpha  # noqa: PLC0415

        if not 0 <= threshold <= 255:
            raise ShapeError(f"Sprite.threshold: expected 0 to 255, got {threshold}")
        return cls(alpha(path, MOST_PIXELS, FORMATS) > threshold, position)

    def _place(self, bits: BitMask, shape: tuple[int, int], position: Pixel) -> None:
        """Take a place, with the box of the solid pixels there."""
        self._bits, self.shape, self.position = bits, shape, position
        self._left, self._top = position[0] + bits.left, position[1] + bits.top
        self._right, self._bottom = self._left + bits.width, self._top + bits.height
        if not bits.width:  # what is empty meets nothing
            self._left = self._top = 2 * FARTHEST
            self._right = self._bottom = -2 * FARTHEST

    @property
    def mask(self) -> Bools:
        """The pixels, as they were given."""
        bits, whole = self._bits, np.zeros(self.shape, dtype=bool)
        whole[bits.top : bits.top + bits.height, bits.left : bits.left + bits.width] = bits.solid
        return whole

    @property
    def area(self) -> int:
        """How many pixels are solid."""
        return self._bits.area

    @property
    def box(self) -> tuple[Pixel, Pixel] | None:
        """First column and row of the solid pixels, and the last ones; None where there are none."""
        if not self.area:
            return None
        return (self._left, self._top), (self._right - 1, self._bottom - 1)

    def moved_to(self, position: Sequence[int]) -> Sprite:
        """Return the same mask elsewhere, which costs next to nothing."""
        moved = object.__new__(Sprite)
        moved._place(self._bits, self.shape, _checked_position(position))
        return moved

    def translated(self, offset: Sequence[int]) -> Sprite:
        """Return the same, moved by so many columns and rows."""
        x, y = _checked_position(offset)
        return self.moved_to((self.position[0] + x, self.position[1] + y))

    def __contains__(self, pixel: Sequence[int]) -> bool:
        x, y = pixel
        inside = self._left <= x < self._right and self._top <= y < self._bottom
        return inside and bool(self._bits.solid[y - self._top, x - self._left])

    def __repr__(self) -> str:
        return f"Sprite({self.shape[1]} × {self.shape[0]} pixels, {self.area} of them solid, position={self.position})"


def intersect(a: Sprite, b: Sprite) -> bool:
    """Whether any pixel is solid in both.

    The first two steps take a quarter of a microsecond; they stand here, as calls would take as long again.
    """
    left, top, bottom = a._left, a._top, a._bottom
    right, down = b._left - left, b._top - top
    if not (left < b._right and b._left < a._right and top < b._bottom and b._top < bottom):
        return False
    middle = (down if down > 0 else 0) + (b._bottom if b._bottom < bottom else bottom) - top >> 1
    mine, other = a._bits.rows[middle], b._bits.rows[middle - down]
    if mine >> right & other if right > 0 else other >> -right & mine:
        return True
    return tiles_meet(a._bits, b._bits, right, down) and bool(common(a._bits, b._bits, right, down).max())


def overlap_area(a: Sprite, b: Sprite) -> int:
    """How many pixels are solid in both."""
    return _area_at(a, b, 0, 0)


def common_pixel(a: Sprite, b: Sprite) -> Pixel | None:
    """Return the first pixel that is solid in both, row by row from the top, each from the left; None without one."""
    if not _boxes_meet(a, b):
        return None
    right, down = b._left - a._left, b._top - a._top
    first, last = max(0, down), min(a._bottom, b._bottom) - a._top
    for row in range(first, min(first + GLANCE, last)):
        bits = common_in_row(a._bits, b._bits, right, down, row)
        if bits:
            break
    else:
        if not tiles_meet(a._bits, b._bits, right, down):
            return None
        words = common(a._bits, b._bits, right, down)
        row = first + int(np.argmax(np.bitwise_or.reduce(words, axis=0) != 0))
        bits = common_in_row(a._bits, b._bits, right, down, row)
    return (max(a._left, b._left) + (bits & -bits).bit_length() - 1, a._top + row) if bits else None


def gradient(a: Sprite, b: Sprite) -> Pixel:
    """By how much the common area grows when B moves two pixels: from one to the left to one to the right, and down."""
    right, left = _area_at(a, b, 1, 0), _area_at(a, b, -1, 0)
    return right - left, _area_at(a, b, 0, 1) - _area_at(a, b, 0, -1)


def collide(a: Sprite, b: Sprite) -> SpriteContact:
    """Collision data: whether there is a hit, how much is in common, where, and the normal.

    The normal is where the common area falls fastest as B moves. Where it does not fall to any side, as in the middle
    of something, it is the way along one axis on which the boxes of the solid pixels are separated soonest.
    """
    pixel = common_pixel(a, b)
    if pixel is None:
        return SpriteContact(False, 0, None, np.zeros(2))
    fall = -np.array(gradient(a, b), dtype=np.float64)
    if not fall.any():
        fall = _way_out(a, b)
    return SpriteContact(True, overlap_area(a, b), pixel, fall / np.hypot(fall[0], fall[1]))


def _boxes_meet(a: Sprite, b: Sprite) -> bool:
    """Early reject."""
    return a._left < b._right and b._left < a._right and a._top < b._bottom and b._top < a._bottom


def _area_at(a: Sprite, b: Sprite, right: int, down: int) -> int:
    """Give the common area with B moved by so much."""
    right, down = b._left - a._left + right, b._top - a._top + down
    mine, other = a._bits, b._bits
    if -other.width < right < mine.width and -other.height < down < mine.height:
        return count(common(mine, other, right, down))
    return 0


def _way_out(a: Sprite, b: Sprite) -> Array:
    """Direction along one axis in which B's box leaves A's soonest; of equal ways right, left, down, up."""
    ways = (a._right - b._left, b._right - a._left, a._bottom - b._top, b._bottom - a._top)
    directions = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    return np.array(directions[ways.index(min(ways))])


def _checked_mask(mask: ArrayLike) -> Bools:
    try:
        solid = np.asarray(mask)
    except ValueError:
        raise ShapeError("Sprite.mask: expected rows of equal length") from None
    if solid.size == 0 and solid.ndim <= 2:
        return np.zeros(solid.shape if solid.ndim == 2 else (0, 0), dtype=bool)
    if solid.ndim != 2 or solid.dtype != np.bool_:
        what = f"{solid.dtype} of shape {solid.shape}"
        raise ShapeError(f"Sprite.mask: expected booleans (height, width), as from alpha > 127, got {what}")
    if solid.size > MOST_PIXELS:
        raise ShapeError(f"Sprite.mask: at most {MOST_PIXELS} pixels, got {solid.shape[1]} × {solid.shape[0]}")
    return solid


def _checked_position(position: Sequence[int]) -> Pixel:
    try:
        x, y = position
        x, y = x.__index__(), y.__index__()
    except (TypeError, ValueError, AttributeError):
        raise ShapeError(f"Sprite.position: expected two integers, got {position!r}") from None
    if not (-FARTHEST <= x <= FARTHEST and -FARTHEST <= y <= FARTHEST):
        raise ShapeError(f"Sprite.position: expected at most 2**62, got {(x, y)}")
    return x, y
