"""Batches of unions of few atoms, answered by the scalar kernels (`refimpl.kernels.unions`)."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from refimpl.compiling import is_compiled, module_for, numbers
from refimpl.escapes import Pairs
from refimpl.kernels import atom_pairs as rooms
from refimpl.kernels import atoms, expanding
from refimpl.kernels.bodies import VERTICES
from refimpl.kernels.boxes import FRAME, PLACED
from refimpl.kernels.gjk import SIMPLEX
from refimpl.kernels.polytopes import FACTOR, N_VERTICES
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.kernels.polytopes_pair import FEATURES
from refimpl.linear import Array, Bools, power_of_two
from refimpl.packing import Packed, fixed_rows, packed_pair
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.signs import Indices


def _room(x: Packed, y: Packed) -> tuple[list[Any], list[int]]:
    """Scratch rows of floats as they are at first, or their lengths, and the lengths of those of whole numbers."""
    box, line, point = fixed_rows()
    count_a, count_b = x.atoms.shape[1], y.atoms.shape[1]
    width = max(x.shapes.shape[1], y.shapes.shape[1], len(box))
    curved = any(np.any(np.isin(z.atoms[..., atoms.KIND], (atoms.ELLIPSOID, atoms.CYLINDER))) for z in (x, y))
    corners = max(8, *(int(z.shapes[:, N_VERTICES].max(initial=0.0)) for z in (x, y)))
    body = VERTICES + 3 * corners if curved else 0
    floats: list[Any] = [0] * rooms.ROWS
    floats[atoms.BOXES_A], floats[atoms.BOXES_B] = 6 * count_a, 6 * count_b
    floats[rooms.PLACED_A] = floats[rooms.PLACED_B] = max(width, PLACED)
    floats[rooms.SIMPLEX] = max(ROOM, SIMPLEX)
    floats[rooms.LISTED_A] = floats[rooms.LISTED_B] = width + FEATURES
    floats[rooms.FRAME_A] = floats[rooms.FRAME_B] = FRAME
    floats[rooms.POSE_B] = FACTOR + 1
    floats[rooms.GEOMETRY_A] = floats[rooms.GEOMETRY_B] = box
    floats[rooms.LINE_A] = floats[rooms.LINE_B] = line
    floats[rooms.DOT] = point
    for row in (rooms.BODY_A, rooms.BODY_B, rooms.FACE_A, rooms.FACE_B):
        floats[row] = body
    floats[rooms.POINTS], floats[rooms.PLANES] = (expanding.POINTS, expanding.PLANES) if curved else (0, 0)
    floats[rooms.GAPS] = count_a * count_b
    whole = [0] * rooms.WHOLE
    whole[rooms.FACETS], whole[rooms.MARKS] = (expanding.FACETS, expanding.SCRATCH) if curved else (0, 0)
    whole[rooms.ORDER] = count_a * count_b
    return floats, whole


def _rows_of_room(sizes: list[Any], module: ModuleType, dtype: type) -> Any:
    """Scratch rows: one array when compiled, lists of their own lengths when not."""
    lengths = [size if isinstance(size, int) else len(size) for size in sizes]
    if not is_compiled(module):
        return [[dtype(0)] * size if isinstance(size, int) else size.tolist() for size in sizes]
    rows = np.zeros((len(sizes), max(lengths)), dtype=np.float64 if dtype is float else np.int64)
    for row, size in zip(rows, sizes, strict=True):
        if not isinstance(size, int):
            row[: len(size)] = size
    return rows


class SmallScene:
    """A batch of pairs of unions of few atoms, ready to be asked.

    Parameters
    ----------
    a, b : Proxy with one batch axis, of the same length
    """

    def __init__(self, a: Proxy, b: Proxy) -> None:
        self.exponent = power_of_two(np.maximum(a.magnitude, b.magnitude))
        x, y = packed_pair(a, b, self.exponent)
        self.pair_count = x.atoms.shape[1] * y.atoms.shape[1]
        self.across = y.atoms.shape[1]
        self.module = module_for("unions", len(a))
        if not is_compiled(self.module):
            x, y = x.alone(), y.alone()
        floats, whole = _room(x, y)
        self.batch = self.module.Batch(
            *(numbers(rows, self.module) for rows in (x.atoms, y.atoms, x.shapes, y.shapes)),
            _rows_of_room(floats, self.module, float),
            _rows_of_room(whole, self.module, int),
            numbers(np.zeros((2 * self.pair_count, atoms.ANSWER)), self.module),
        )

    def nearest(self) -> Separation:
        """The nearest pair of atoms of each row, or the deepest of those that overlap."""
        answers = numbers(np.zeros((len(self.exponent), 10)), self.module)
        self.module.separations(self.batch, answers)
        return _separation(np.asarray(answers), self.exponent)

    def meetings(self) -> Bools:
        """Whether unions have a point in common, row by row."""
        hits = numbers(np.zeros(len(self.exponent), dtype=bool), self.module)
        self.module.meetings(self.batch, hits)
        return np.asarray(hits)

    def pairs(self, rows: Indices, moves: Array, within: Array | float = 0.0) -> Pairs:
        """Pairs whose boxes meet, or are so near, after B has moved in some rows; they count these rows from 0."""
        exponent = self.exponent[rows]
        asked = (
            rows,
            np.ldexp(moves, -exponent[:, None]),
            np.ldexp(np.broadcast_to(within, len(rows)), -exponent),
        )
        asked = tuple(numbers(np.ascontiguousarray(column), self.module) for column in asked)
        none = numbers(np.zeros((0, atoms.ANSWER + 1)), self.module)
        count = self.module.near_pairs(self.batch, *asked, none)
        answers = numbers(np.zeros((count, atoms.ANSWER + 1)), self.module)
        self.module.near_pairs(self.batch, *asked, answers)
        found = np.asarray(answers).reshape(count, atoms.ANSWER + 1)
        question, key = found[:, atoms.ANSWER].astype(np.int64), found[:, 0].astype(np.int64)
        return Pairs(question, key // self.across, key % self.across, _separation(found[:, 1:], exponent[question]))


def _separation(rows: Array, exponent: Array) -> Separation:
    """Scale answers back."""
    with np.errstate(over="ignore"):
        lengths = np.ldexp(rows[:, [0, 4, 5, 6, 7, 8, 9]], exponent[:, None])
    return Separation(lengths[:, 0], lengths[:, 1:4], lengths[:, 4:7], rows[:, 1:4])
