"""Batches of unions of few atoms, answered by the scalar kernels (`refimpl.kernels.unions`)."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from refimpl.compiling import is_compiled, module_for, numbers
from refimpl.kernels import atom_pairs as rooms
from refimpl.kernels import atoms, expanding
from refimpl.kernels.bodies import VERTICES
from refimpl.kernels.boxes import FRAME, PLACED
from refimpl.kernels.gjk import SIMPLEX
from refimpl.kernels.polytopes import FACTOR, N_VERTICES
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.kernels.polytopes_pair import FEATURES
from refimpl.linear import power_of_two
from refimpl.packing import Packed, fixed_rows, packed_pair
from refimpl.proxy import Proxy


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


def separations(a: Proxy, b: Proxy) -> Any:
    exponent = power_of_two(np.maximum(a.magnitude, b.magnitude))
    x, y = packed_pair(a, b, exponent)
    pairs = x.atoms.shape[1] * y.atoms.shape[1]
    module = module_for("unions", len(a))
    if not is_compiled(module):
        x, y = x.alone(), y.alone()
    floats, whole = _room(x, y)
    answers = numbers(np.zeros((len(a), 10)), module)
    module.separations(
        *(numbers(rows, module) for rows in (x.atoms, y.atoms, x.shapes, y.shapes)),
        _rows_of_room(floats, module, float),
        _rows_of_room(whole, module, int),
        numbers(np.zeros((2 * pairs, atoms.ANSWER)), module),
        answers,
    )
    return np.asarray(answers), exponent
