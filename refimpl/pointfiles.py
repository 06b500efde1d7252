"""Points as files hold them: a line of text for each, numpy's array, or the vertices of a mesh file; with limits."""

from __future__ import annotations

import io

import numpy as np

from refimpl.linear import Array
from refimpl.meshfiles import FORMATS, FileError, geometries

TEXT = ("xyz", "txt", "csv")
CLOUDS = (*TEXT, "npy")
"""Formats of points alone."""


def points_in(data: bytes, form: str) -> Array:
    """Points (n, 3) of a file's content; raises `FileError` where it holds none, or is broken.

    Parameters
    ----------
    data, form
        The content, and one of `CLOUDS` or `refimpl.meshfiles.FORMATS`. Text has three or more numbers in a line,
        between blanks, commas or semicolons, of which the first three count; ``#`` begins a comment. An ``.npy`` file
        is an array (n, 3) of numbers, and never of objects.
    """
    if form in FORMATS:
        clouds = [np.asarray(found.vertices) for found in geometries(data, form)]
        points = np.concatenate([np.zeros((0, 3)), *(cloud for cloud in clouds if cloud.shape[1:] == (3,))])
    else:
        points = _of_array(data) if form == "npy" else _of_text(data)
    if not len(points):
        raise FileError("holds no point")
    bad = np.argwhere(~np.isfinite(points))
    if len(bad):
        raise FileError(f"is broken: point {int(bad[0, 0])} is not finite")
    return points


def _of_text(data: bytes) -> Array:
    text = data.decode("utf-8", errors="replace").replace(",", " ").replace(";", " ")
    if not any(line.partition("#")[0].strip() for line in text.splitlines()):
        return np.zeros((0, 3))
    try:
        return np.loadtxt(io.StringIO(text), usecols=(0, 1, 2), ndmin=2)
    except ValueError as error:
        raise FileError(f"is broken: expected three numbers in each line ({str(error)[:120]})") from None


def _of_array(data: bytes) -> Array:
    """Numbers of an ``.npy`` file, whose header is believed only as far as there are bytes."""
    file = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, by_columns, sort = read(file)
    except (ValueError, EOFError) as error:
        raise FileError(f"is broken: {str(error)[:120]}") from None
    if len(shape) != 2 or shape[0] < 0 or shape[1] != 3 or sort.kind not in "fiu":
        raise FileError(f"is broken: expected an array (n, 3) of numbers, got one {shape} of {sort}")
    if shape[0] * 3 * sort.itemsize > len(data) - file.tell():
        raise FileError(f"is broken: it ends before the {shape[0]} points that it announces")
    numbers = np.frombuffer(data, sort, 3 * shape[0], file.tell())
    return numbers.reshape(shape, order="F" if by_columns else "C").astype(np.float64)
