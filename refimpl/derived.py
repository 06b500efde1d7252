"""What is derived from the polytopes of a batch: one hull for each geometry, and which one belongs to whom.

Batches often hold one geometry in many poses, and questions scale every row by its own power of two. So hulls are
kept unscaled in a table, and slices, copies and scalings only change two numbers a row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any, Self

import numpy as np

from refimpl.hulls import Hull, Indices, solid_of_planes, solid_of_vertices
from refimpl.linear import Array, largest, power_of_two
from refimpl.proxy import ShapeError, shifted


@dataclass(frozen=True, eq=False)
class Derived:
    """Hulls of a batch of polytopes: that of each is table[which], scaled by 2^exponent.

    Attributes
    ----------
    table : Hull with one batch axis
        One for each different geometry, unscaled; shared by all copies of the batch.
    digests : (g, 2)
        Numbers that tell the geometries of all tables apart.
    which : (...) int
    exponent : (...) int
    """

    table: Hull
    digests: Array
    which: Indices
    exponent: Indices

    def mapped(self, change: Callable[[Any, int], Any]) -> Self:
        """Apply one change of batch axes."""
        return type(self)(self.table, self.digests, change(self.which, 0), change(self.exponent, 0))

    def times_power(self, exponent: Any) -> Self:
        """Scale by 2^exponent."""
        total = self.exponent + np.asarray(exponent)
        return type(self)(self.table, self.digests, np.broadcast_to(self.which, total.shape), total)

    def broadcast_to(self, batch: tuple[int, ...]) -> Self:
        """Repeat along new batch axes, without copying."""
        return self.mapped(lambda a, _: np.broadcast_to(a, batch))

    @property
    def hull(self) -> Hull:
        """The hulls themselves; not copied as long as all of the batch share one."""
        if repeats(self.which, 0) and repeats(self.exponent, 0):
            first = (0,) * self.which.ndim
            alone = type(self)(self.table, self.digests, self.which[first], self.exponent[first])
            return alone.hull.broadcast_to(self.which.shape)
        return self.table.mapped(lambda a, _: a[self.which]).times_power(self.exponent)

    @property
    def marks(self) -> Array:
        """Three numbers (..., 3) that are the same for the same geometry, alone or in any batch."""
        return np.concatenate([self.digests[self.which], self.exponent[..., None].astype(np.float64)], axis=-1)

    @property
    def size(self) -> Array:
        """Largest absolute coordinate of a corner (...)."""
        return np.asarray(np.ldexp(self.table.size[self.which], self.exponent))

    @property
    def middle(self) -> Array:
        """Mean of the corners (..., 3)."""
        return shifted(self.table.middle[self.which], self.exponent, 1)


def repeats(numbers: Any, ends: int) -> bool:
    """Whether an array with `ends` trailing axes has batch axes along which it repeats without being copied."""
    axes = numbers.ndim - ends
    steps = [step for step, n in zip(numbers.strides[:axes], numbers.shape, strict=False) if n > 1]
    return axes > 0 and numbers.size > 0 and not any(steps)


def of_planes(planes: Array) -> Derived:
    """Hulls of the sets behind all planes (..., k, 4), normal·x + k ≤ 0, with normals of any non-zero length.

    Raises
    ------
    ShapeError
        Where a set is empty or unbounded: which of the two, and where in the batch.
    """
    if repeats(planes, 2):
        return of_planes(planes[(0,) * (planes.ndim - 2)]).broadcast_to(planes.shape[:-2])
    own = power_of_two(largest(planes[..., :3]))
    with np.errstate(over="ignore"):
        offsets = np.ldexp(planes[..., 3], -own)
    _refuse(~np.isfinite(np.max(np.abs(offsets), axis=-1, initial=0.0)), "a plane lies")
    size = power_of_two(np.max(np.abs(offsets), axis=-1, initial=0.0))
    level = np.concatenate([shifted(planes[..., :3], -own, 1), shifted(offsets, -size, 1)[..., None]], axis=-1)
    found = _of_batch(level, size, solid_of_planes)
    with np.errstate(over="ignore"):
        _refuse(~np.isfinite(found.size), "a corner lies")
    return found


def _refuse(beyond: Any, what: str) -> None:
    if np.any(beyond):
        where = tuple(int(i) for i in np.argwhere(beyond)[0])
        raise ShapeError(f"{what} beyond the largest float{f', at index {where}' if where else ''}")


def of_vertices(vertices: Array) -> Derived:
    """Hulls of points (..., m, 3), of which any may be equal, collinear or coplanar."""
    if repeats(vertices, 2):
        return of_vertices(vertices[(0,) * (vertices.ndim - 2)]).broadcast_to(vertices.shape[:-2])
    size = power_of_two(np.max(np.abs(vertices), axis=(-2, -1), initial=0.0))
    return _of_batch(shifted(vertices, -size, 2), size, solid_of_vertices)


def of_hulls(hulls: Hull) -> Derived:
    """Wrap hulls that need no search, one for each of a batch."""
    batch = hulls.dimension.shape
    count = int(np.prod(batch, dtype=int))
    table = hulls.mapped(lambda a, ends: a.reshape((count, *a.shape[a.ndim - ends :])))
    digests = np.zeros((count, 2))  # nobody asks: boxes are told apart by their own numbers
    return Derived(table, digests, np.arange(count).reshape(batch), np.zeros(batch, dtype=np.int64))


def hull_of_planes(planes: Array) -> Hull:
    """Hulls of the sets behind planes; see `of_planes`."""
    return of_planes(np.asarray(planes, dtype=np.float64)).hull


def hull_of_vertices(vertices: Array) -> Hull:
    """Hulls of points; see `of_vertices`."""
    return of_vertices(np.asarray(vertices, dtype=np.float64)).hull


def _of_batch(numbers: Array, exponent: Any, single: Callable[[bytes, int], Hull]) -> Derived:
    """Hulls of the geometries (..., n, w) of a batch, each found once, scaled back by 2^exponent."""
    batch = numbers.shape[:-2]
    place: dict[bytes, int] = {}
    hulls: list[Hull] = []
    which = np.zeros(batch, dtype=np.int64)
    for where in np.ndindex(*batch):
        content = numbers[where].tobytes()
        if content not in place:
            place[content] = len(hulls)
            hulls.append(_found(single, content, numbers.shape[-2], where))
        which[where] = place[content]
    digests = np.array([_digest(content, numbers.shape[-1]) for content in place]).reshape(-1, 2)
    return Derived(_stacked(hulls), digests, which, np.asarray(exponent, dtype=np.int64))


def _digest(content: bytes, width: int) -> tuple[float, float]:
    """Two doubles that tell geometries apart: by their numbers, and by how many of these make a plane or a vertex."""
    digest = blake2b(content, digest_size=12, salt=bytes([width])).digest()
    return float(int.from_bytes(digest[:6], "big")), float(int.from_bytes(digest[6:], "big"))


def _found(single: Callable[[bytes, int], Hull], content: bytes, count: int, where: tuple[int, ...]) -> Hull:
    try:
        return single(content, count)
    except ShapeError as error:
        at = f", at index {where}" if where else ""
        raise ShapeError(f"{error}{at}") from None


def _stacked(hulls: list[Hull]) -> Hull:
    """One batch of single hulls; the shorter lists repeat their last item."""
    columns: list[Any] = []
    for name in ("vertices", "planes", "edges", "active_planes", "active_vertices", "dimension"):
        parts = [getattr(h, name) for h in hulls]
        if name != "dimension":
            longest = max((len(p) for p in parts), default=0)
            index = np.arange(longest)
            parts = [p if len(p) == longest else _padded(p, index) for p in parts]
        columns.append(np.stack(parts) if parts else np.zeros((0, *_EMPTY_TAILS[name]), dtype=_dtype(name)))
    return Hull(*columns)


def _dtype(name: str) -> type:
    return np.float64 if name in ("vertices", "planes") else np.int64


_EMPTY_TAILS = {
    "vertices": (1, 3),
    "planes": (1, 4),
    "edges": (1, 4),
    "active_planes": (1,),
    "active_vertices": (1,),
    "dimension": (),
}


def _padded(part: Any, index: Any) -> Any:
    if not len(part):  # a point among others: its only corner to itself
        return np.zeros((len(index), *part.shape[1:]), dtype=part.dtype)
    return part[np.minimum(index, len(part) - 1)]
