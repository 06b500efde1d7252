"""Alpha channels of image files, which may be anybody's: formats and sizes are limited before anything is decoded."""

from __future__ import annotations

import warnings
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from refimpl.shapes import ShapeError


def alpha(path: str | PathLike[str], most: int, formats: tuple[str, ...]) -> NDArray[np.uint8]:
    """Read how opaque each pixel of an image's first frame is, (height, width), 0 to 255.

    Raises
    ------
    ShapeError
        For a file that is no image of these formats, has no alpha, or more than `most` pixels.
    ImportError
        Without pillow.
    """
    try:
        from PIL import Image, UnidentifiedImageError  # noqa: PLC0415
    except ImportError as error:
        raise ImportError("reading images needs pillow: pip install pillow (the extra 'sprites')") from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path, formats=formats) as image:
                if image.width * image.height > most:
                    raise ShapeError(f"{path}: at most {most} pixels, got {image.width} × {image.height}")
                if not image.has_transparency_data:
                    raise ShapeError(f"{path}: the image has no alpha; pass a mask of your own")
                return np.asarray(image.convert("RGBA").getchannel("A"))
    except (UnidentifiedImageError, Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        raise ShapeError(f"{path}: no image that can be read: {error}") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise ShapeError(f"{path}: cannot be read: {error}") from None
