"""Batches of unions, answered by the scalar kernels (`refimpl.kernels.unions`)."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from refimpl.compiling import is_compiled, module_for, numbers
from refimpl.kernels import atom_pairs as rooms
from refimpl.kernels import atoms, expanding, nearby
from refimpl.kernels.bodies import VERTICES
from refimpl.kernels.boxes import FRAME, PLACED
from refimpl.kernels.escapes import RESULT
from refimpl.kernels.gjk import SIMPLEX
from refimpl.kernels.polytopes import FACTOR, N_VERTICES
from refimpl.kernels.polytopes_nearest import ROOM
from refimpl.kernels.polytopes_pair import FEATURES
from refimpl.linear import Array, Bools, power_of_two
from refimpl.packing import Packed, atom_count, fixed_rows, packed_pair
from refimpl.proxy import Proxy
from refimpl.results import Separation
from refimpl.searches import search_room
from refimpl.signs import Indices

ROUNDING = 1e-12
"""Part of a scene's size by which the depth of a pair may be rounding."""
MOST_PAIRS = 4096
"""Room for so many pairs of atoms that are near each other is made at first."""
MUCH = 4
"""So many pairs of atoms make one pair of unions as much work as two, and worth compiling for accordingly."""
CHUNK = 65536
"""Most atoms of the unions that are packed together."""


class Contact(NamedTuple):
    """Overlapping pairs of convex atoms of two unions: their numbers, and each pair as if it were alone."""

    part_a: Indices
    part_b: Indices
    found: Separation

    @classmethod
    def none(cls) -> Contact:
        """No pair."""
        numbers = np.zeros(0, dtype=np.int64)
        return cls(numbers, numbers, _separation(np.zeros((0, 10)), numbers))


def _room(x: Packed, y: Packed, room: int) -> tuple[list[Any], list[int]]:
    """Scratch rows of floats as they are at first, or their lengths, and the lengths of those of whole numbers."""
    box, line, point = fixed_rows()
    count_a, count_b = x.atoms.shape[1], y.atoms.shape[1]
    width = max(x.shapes.shape[1], y.shapes.shape[1], len(box))
    curved = any(np.any(np.isin(z.atoms[..., atoms.KIND], (atoms.ELLIPSOID, atoms.CYLINDER))) for z in (x, y))
    corners = max(8, *(int(z.shapes[:, N_VERTICES].max(initial=0.0)) for z in (x, y)))
    body = VERTICES + 3 * corners if curved else 0
    floats: list[Any] = [0] * rooms.ROWS
    floats[nearby.BOXES_A], floats[nearby.BOXES_B] = 6 * count_a, 6 * count_b
    for row, count in ((nearby.NODES_A, count_a), (nearby.NODES_B, count_b)):
        floats[row] = 6 * (2 << nearby.levels_of(count)) if count_a * count_b > nearby.FEW else 0
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
    floats[rooms.GAPS] = count_a * count_b if count_a * count_b <= room else 0
    whole = [0] * rooms.WHOLE
    whole[nearby.STACK] = 4 * (nearby.levels_of(count_a) + nearby.levels_of(count_b) + 1)
    whole[rooms.FACETS], whole[rooms.MARKS] = (expanding.FACETS, expanding.SCRATCH) if curved else (0, 0)
    whole[rooms.KEYS] = whole[rooms.ORDER] = room
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


class Scenes:
    """A batch of pairs of unions, ready to be asked.

    Parameters
    ----------
    a, b : Proxy with one batch axis, of the same length
    """

    def __init__(self, a: Proxy, b: Proxy) -> None:
        size = np.maximum(a.magnitude, b.magnitude)
        self.exponent = power_of_two(size)
        self.size = np.ldexp(size, -self.exponent)
        x, y = packed_pair(a, b, self.exponent)
        pairs = x.atoms.shape[1] * y.atoms.shape[1]
        self.module = module_for("unions", len(a) * (1 + pairs // MUCH))
        self.atoms = (x, y) if is_compiled(self.module) else (x.alone(), y.alone())
        self.pairs, self.room = pairs, min(pairs, MOST_PAIRS)
        self.batch = self._batch()

    def _batch(self) -> Any:
        x, y = self.atoms
        floats, whole = _room(x, y, self.room)
        return self.module.Batch(
            *(numbers(rows, self.module) for rows in (x.atoms, y.atoms, x.shapes, y.shapes)),
            _rows_of_room(floats, self.module, float),
            _rows_of_room(whole, self.module, int),
            numbers(np.zeros((2 * self.room, atoms.ANSWER)), self.module),
        )

    def _enlarge(self) -> None:
        self.room *= 2
        self.batch = self._batch()

    def separations(self, ways: bool = True) -> tuple[Separation, Array, Array, Array]:
        """Signed distances, lengths below which no translation separates, a point of the deepest pair, its depth.

        Without `ways` overlapping ones are answered by their deepest pair.
        """
        count = len(self.exponent)
        answers, tolerances = (numbers(c, self.module) for c in (np.zeros((count, RESULT)), ROUNDING * self.size))
        done = 0
        while done < count:
            search = search_room(self.pairs, self.room, self.module)
            done = self.module.separations(self.batch, search, tolerances, ways, done, answers)
            if done < count:
                self._enlarge()
        found = np.asarray(answers).reshape(count, RESULT)
        lower, deepest = (np.ldexp(found[:, column], self.exponent) for column in (10, 14))
        middle = np.ldexp(found[:, 11:14], self.exponent[:, None])
        return _separation(found, self.exponent), lower, middle, deepest

    def meetings(self) -> Bools:
        """Whether unions have a point in common, row by row."""
        hits = numbers(np.zeros(len(self.exponent), dtype=np.int64), self.module)
        done = 0
        while done < len(hits):
            done = self.module.meetings(self.batch, done, hits)
            if done < len(hits):
                self._enlarge()
        return np.asarray(hits) > 0

    def contacts(self) -> Contact:
        """Overlapping pairs of the only row, the deepest first."""
        overlapping, _ = self.module.contacts(self.batch)
        while overlapping < 0:
            self._enlarge()
            overlapping, _ = self.module.contacts(self.batch)
        found = np.asarray([self.batch.pairs[k] for k in range(overlapping)]).reshape(overlapping, atoms.ANSWER)
        part_a, part_b = np.divmod(found[:, 0].astype(np.int64), self.atoms[1].atoms.shape[1])
        return Contact(part_a, part_b, _separation(found[:, 1:], np.repeat(self.exponent, overlapping)))


def scenes(a: Proxy, b: Proxy) -> Iterator[Scenes]:
    """Two batches of unions, in slices that are packed one after the other."""
    step = max(1, CHUNK // (atom_count(a) + atom_count(b)))
    for start in range(0, max(len(a), 1), step):  # an empty batch is one of no rows
        yield Scenes(a[start : start + step], b[start : start + step])


def _separation(rows: Array, exponent: Any) -> Separation:
    """Scale answers back."""
    with np.errstate(over="ignore"):
        lengths = np.ldexp(rows[:, [0, 4, 5, 6, 7, 8, 9]], exponent[:, None])
    return Separation(lengths[:, 0], lengths[:, 1:4], lengths[:, 4:7], rows[:, 1:4])
