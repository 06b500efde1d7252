"""Sprites: images whose solid pixels collide, as in games of two dimensions.

A pixel is a closed unit of the raster and not a square in the plane: sprites overlap when a pixel is solid in both, and
those that lie side by side do not. Columns count to the right and rows downwards, as in images.

An *early reject* compares the boxes of the solid pixels, a second one the tiles that hold any; an *early accept*
compares one row. Where none can tell, words of bits are compared. Once `refimpl.flat.scanning.compile_scans` was called
and numba is installed, compiled kernels compare all words instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from refimpl.flat.bitmask import BitMask
from refimpl.flat.scanning import COMPILED, area, compile_scans, first_row, some_row
from refimpl.linear import Array, Bools
from refimpl.shapes import ShapeError
from refimpl.signs import Indices

MOST_PIXELS = 1 << 26
"""Of a sprite."""
FARTHEST = 1 << 62
"""Largest coordinate of a position."""
FORMATS = ("PNG", "GIF", "WEBP", "TIFF", "BMP", "TGA")
"""Of image files that are read: those that have an alpha channel, or a colour that is transparent."""

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

    __slots__ = ("_bits", "_bottom", "_left", "_placed", "_right", "_top", "position", "shape")

    position: Pixel
    shape: tuple[int, int]
    """Height and width of the mask."""

    def __init__(self, mask: ArrayLike, position: Sequence[int] = (0, 0)) -> None:
        solid = _checked_mask(mask)
        self._put(BitMask(solid), (solid.shape[0], solid.shape[1]), _checked_position(position))

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

    def _put(self, bits: BitMask, shape: tuple[int, int], position: Pixel) -> None:
        """Take a place, with the box of the solid pixels there."""
        self._bits, self.shape, self.position = bits, shape, position
        self._left, self._top = position[0] + bits.left, position[1] + bits.top
        self._right, self._bottom = self._left + bits.width, self._top + bits.height
        if not bits.width:  # what is empty meets nothing
            self._left = self._top = 2 * FARTHEST - 2
            self._right = self._bottom = 2 - 2 * FARTHEST
        self._placed = (bits.words, self._left, self._top, self._right, self._bottom)

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
        moved._put(self._bits, self.shape, _checked_position(position))
        return moved

    def translated(self, offset: Sequence[int]) -> Sprite:
        """Return the same, moved by so many columns and rows."""
        x, y = _checked_position(offset)
        return self.moved_to((self.position[0] + x, self.position[1] + y))

    def __contains__(self, pixel: Sequence[int]) -> bool:
        x, y = _checked_position(pixel, "pixel")
        inside = self._left <= x < self._right and self._top <= y < self._bottom
        return inside and bool(self._bits.solid[y - self._top, x - self._left])

    def __repr__(self) -> str:
        return f"Sprite({self.shape[1]} × {self.shape[0]} pixels, {self.area} of them solid, position={self.position})"


def intersect(a: Sprite, b: Sprite) -> bool:
    """Whether any pixel is solid in both.

    The first two steps take a quarter of a microsecond; they stand here, as calls would take as long again.
    """
    if (compiled := COMPILED.meet) is not None:
        return compiled(a._placed, b._placed)
    top, right = a._top, a._right
    down, over = b._top - top, b._right - right
    if not (a._left < b._right and b._left < right and top < b._bottom and b._top < a._bottom):
        return False
    mine, others = a._bits, b._bits.rows
    row = mine.likely
    if not 0 <= row - down < len(others):
        row = (down if down > 0 else 0) + (b._bottom if b._bottom < a._bottom else a._bottom) - top >> 1
    if others[row - down] >> over & mine.rows[row] if over > 0 else mine.rows[row] >> -over & others[row - down]:
        return True
    return some_row(mine, b._bits, b._left - a._left, down) >= 0


def overlap_area(a: Sprite, b: Sprite) -> int:
    """How many pixels are solid in both."""
    if (compiled := COMPILED.area) is not None:
        return compiled(a._placed, b._placed)
    return _area_at(a, b, 0, 0)


def overlap_areas(a: Sprite, b: Sprite, positions: ArrayLike) -> Indices:
    """How many pixels are solid in both, with B at many positions (..., 2); (...).

    Many of them are counted by compiled kernels, if numba is installed; so is what is asked in this process from then
    on (`refimpl.flat.scanning.compile_scans`).
    """
    places = np.asarray(positions)
    if places.shape[-1:] != (2,) or not (places.dtype.kind in "iu" or places.size == 0):
        raise ShapeError(f"positions: expected integers (..., 2), got {places.dtype} of shape {places.shape}")
    (x, y), flat = b.position, places.reshape(-1, 2).tolist()
    if any(max(abs(column), abs(row)) > FARTHEST for column, row in flat):
        raise ShapeError("positions: expected at most 2**62")
    compile_scans(len(flat))
    areas = [_area_at(a, b, column - x, row - y) for column, row in flat]
    return np.array(areas, dtype=np.int64).reshape(places.shape[:-1])


def common_pixel(a: Sprite, b: Sprite) -> Pixel | None:
    """Return the first pixel that is solid in both, row by row from the top, each from the left; None without one."""
    if (compiled := COMPILED.first_pixel) is not None:
        return compiled(a._placed, b._placed)
    top, right = a._top, a._right
    down, over = b._top - top, b._right - right
    if not (a._left < b._right and b._left < right and top < b._bottom and b._top < a._bottom):
        return None
    mine, others = a._bits.rows, b._bits.rows
    row = down if down > 0 else 0
    bits = others[row - down] >> over & mine[row] if over > 0 else mine[row] >> -over & others[row - down]
    if not bits:
        row = first_row(a._bits, b._bits, b._left - a._left, down)
        if row < 0:
            return None
        bits = others[row - down] >> over & mine[row] if over > 0 else mine[row] >> -over & others[row - down]
    return (right if over > 0 else b._right) - bits.bit_length(), top + row


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


def _area_at(a: Sprite, b: Sprite, right: int, down: int) -> int:
    """Give the common area with B moved by so much."""
    if (compiled := COMPILED.area) is not None:
        moved = b._bits.words, b._left + right, b._top + down, b._right + right, b._bottom + down
        return compiled(a._placed, moved)
    right, down = b._left - a._left + right, b._top - a._top + down
    mine, other = a._bits, b._bits
    if -other.width < right < mine.width and -other.height < down < mine.height:
        return area(mine, other, right, down)
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


def _checked_position(position: Sequence[int], name: str = "position") -> Pixel:
    try:
        x, y = position
        x, y = x.__index__(), y.__index__()
    except (TypeError, ValueError, AttributeError):
        raise ShapeError(f"Sprite.{name}: expected two integers, got {position!r}") from None
    if not (-FARTHEST <= x <= FARTHEST and -FARTHEST <= y <= FARTHEST):
        raise ShapeError(f"Sprite.{name}: expected at most 2**62, got {(x, y)}")
    return x, y
