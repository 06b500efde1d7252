"""The protocol of every broad-phase structure: which of N boxes meet each other, a box, a point, a ray.

A structure knows boxes only (`refimpl.broadphase.proxies` makes them of proxies). What it proposes are *candidates*;
here, in one place, candidates are held against the boxes themselves, so that every structure answers the same: exactly
the pairs of closed boxes that have a point in common. A structure may propose too much and twice, but nothing less.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Self

import numpy as np

from refimpl.broadphase.boxes import as_boxes, as_flags, as_points, as_rays
from refimpl.broadphase.corners import Corners, meeting
from refimpl.broadphase.proxies import Numbered
from refimpl.broadphase.slabs import around_rays, rays_meet
from refimpl.linear import Array, Bools
from refimpl.proxy import Proxy
from refimpl.shapes import Ray
from refimpl.signs import Indices

Candidates = Iterator[tuple[Indices, Indices]]
"""Pieces of bounded size: two arrays of equal length."""


class BroadPhase(ABC):
    """N closed boxes in 2 or 3 dimensions, static or moving, each with an id that stays its own.

    Attributes
    ----------
    ids : (n,) int64, ascending
        Of the objects that are there. `build` counts from 0, `insert` counts on, and no id is ever given twice.
    lower, upper : (n, D)
        Their boxes, in this order: *row* r is the object `ids[r]`. They may be infinite, and may have no extent.
    static : (n,) bool
        Objects that do not move by themselves: two of them are no pair.
    """

    ids: Indices
    lower: Array
    upper: Array
    static: Bools
    _by_axis: Corners | None = None

    def __init__(self) -> None:
        self._next = 0
        self._set(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=bool))

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.lower.shape[1])

    # -- what a user calls -----------------------------------------------------------------------------------

    def build(self, lower: Any, upper: Any, static: Any = None) -> Self:
        """Begin anew with these objects, whose ids are 0, 1, ..., N − 1.

        Parameters
        ----------
        lower, upper : (N, D), D = 2 or 3
            Corners. −inf and inf mean without end; N may be 0.
        static : (N,) bool or a single one, optional
            Which objects are static; none by default.

        Raises
        ------
        ShapeError
            For NaN, lower > upper, a box that lies at infinity, and arrays that do not fit together.
        """
        low, up = as_boxes(lower, upper)
        flags = as_flags(static, len(low))
        self._next = len(low)
        self._set(np.arange(len(low), dtype=np.int64), low, up, flags)
        self._rebuild()
        return self

    @classmethod
    def of(cls, proxies: Proxy | Iterable[Proxy], static: Any = None, **options: Any) -> Self:
        """Build for the bounding boxes of proxies, numbered as by `refimpl.broadphase.pairs`."""
        return cls(**options).build(*Numbered.of(proxies).boxes(), static)

    def insert(self, lower: Any, upper: Any, static: Any = None) -> Indices:
        """Add objects, and give their ids; arguments as for `build`."""
        low, up = as_boxes(lower, upper, self.dimension if self._next else None)
        flags = as_flags(static, len(low))
        if self._next == 0:
            self.build(low, up, flags)
            return self.ids.copy()
        new = np.arange(self._next, self._next + len(low), dtype=np.int64)
        self._next += len(low)
        self._set(
            np.concatenate([self.ids, new]),
            np.concatenate([self.lower, low]),
            np.concatenate([self.upper, up]),
            np.concatenate([self.static, flags]),
        )
        self._inserted(len(new))
        return new

    def update(self, ids: Any, lower: Any, upper: Any) -> None:
        """Give some objects new boxes.

        What it costs depends on the structure. Where all objects move by a tenth of their size, a BVH is refitted
        twelve times as fast as it is built, for its tree stays; octree, k-d tree and BSP tree take in about a third of
        the time what has left its cell. Grids and columns are made anew when more than a sixteenth of all objects have
        left their cells, and sort-and-sweep sorts again: building them takes no longer than mending would. Where one
        object in a hundred moves, grids follow seventy times as fast as they are built.

        Parameters
        ----------
        ids : (m,) int, each once
        lower, upper : (m, D)

        Raises
        ------
        LookupError
            For an id that is not there; ValueError for one that occurs twice.
        """
        rows = self._rows(ids)
        low, up = as_boxes(lower, upper, self.dimension)
        if len(low) != len(rows):
            raise ValueError(f"update: {len(rows)} ids, but {len(low)} boxes")
        self.lower[rows], self.upper[rows] = low, up
        self._by_axis = None
        self._updated(rows)

    def remove(self, ids: Any) -> None:
        """Take some objects away; the others keep their ids. Errors as for `update`."""
        rows = self._rows(ids)
        kept = np.ones(len(self), dtype=bool)
        kept[rows] = False
        self._set(self.ids[kept], self.lower[kept], self.upper[kept], self.static[kept])
        self._removed(kept)

    def pairs(self) -> Indices:
        """All pairs of objects whose closed boxes have a point in common, except of two static ones.

        Returns
        -------
        (M, 2) int64
            Ids i < j, sorted by i, then j.
        """
        return self.ids[self._sorted(self._true_pairs(), len(self))]

    def query_boxes(self, lower: Any, upper: Any) -> Indices:
        """All objects, static ones too, that meet each of some boxes (Q, D).

        Returns
        -------
        (K, 2) int64
            Query index and id, sorted.
        """
        low, up = as_boxes(lower, upper, self.dimension)
        boxes, asked = self._corners(), Corners.of(low, up)
        return self._found(self._near_boxes, (low, up), lambda q, rows: meeting(asked, q, boxes, rows))

    def query_points(self, points: Any) -> Indices:
        """All objects whose boxes contain each of some points (Q, D), finite ones; returns as `query_boxes`."""
        where = as_points(points, self.dimension)
        return self.query_boxes(where, where)

    def query_rays(self, origin: Any, direction: Any, length: Any = np.inf) -> Indices:
        """All objects whose boxes have a point in common with {origin + t·direction, 0 ≤ t ≤ length}.

        Decided exactly, for the numbers as they are stored: grazing counts, missing by a rounding error does not.

        Parameters
        ----------
        origin, direction : (Q, D)
            Finite, the direction not zero.
        length : (Q,) or a single number, at least 0, optional
            In units of the direction's length; infinite by default.

        Returns
        -------
        (K, 2) int64
            Query index and id, sorted.
        """
        start, way, end = as_rays(origin, direction, length, self.dimension)

        def hit(q: Indices, rows: Indices) -> Indices:
            return np.flatnonzero(rays_meet(start[q], way[q], end[q], self.lower[rows], self.upper[rows]))

        return self._found(self._near_rays, (start, way, end), hit)

    def query(self, proxies: Proxy | Iterable[Proxy]) -> Indices:
        """All objects whose boxes meet the bounding box of each of some proxies, or the proxy itself if it is a ray.

        Returns
        -------
        (K, 2) int64
            Number of the proxy and id, sorted.
        """
        asked = Numbered.of(proxies)
        lower, upper = asked.boxes()
        parts = [np.empty((0, 2), dtype=np.int64)]
        for which, x in enumerate(asked.batches):
            mine = np.flatnonzero(asked.batch == which)
            if isinstance(x, Ray):
                found = self.query_rays(x.origin[asked.place[mine]], x.direction[asked.place[mine]])
            else:
                found = self.query_boxes(lower[mine], upper[mine])
            parts.append(np.stack([mine[found[:, 0]], found[:, 1]], axis=-1))
        every = np.concatenate(parts)
        return every[np.lexsort((every[:, 1], every[:, 0]))]

    # -- what a structure supplies, in rows -------------------------------------------------------------------

    @abstractmethod
    def _rebuild(self) -> None:
        """Make the structure for the boxes that are there; there may be none."""

    def _updated(self, rows: Indices) -> None:  # noqa: ARG002
        """Follow the boxes of these rows, which have changed."""
        self._rebuild()

    def _inserted(self, count: int) -> None:  # noqa: ARG002
        """Take in the last `count` rows, which are new."""
        self._rebuild()

    def _removed(self, kept: Bools) -> None:  # noqa: ARG002
        """Follow the removal of the rows that were not `kept`, of those there had been; rows have moved up."""
        self._rebuild()

    @abstractmethod
    def _near_pairs(self) -> Candidates:
        """Propose pairs of rows that may meet, in pieces: every pair that meets, in either order, once or more."""

    @abstractmethod
    def _near_boxes(self, lower: Array, upper: Array) -> Candidates:
        """Propose query indices and rows that may meet, in pieces."""

    def _near_rays(self, origin: Array, direction: Array, length: Array) -> Candidates:
        """Propose query indices and rows that may meet, in pieces: unless overridden, all around the ray's box."""
        return self._near_boxes(*around_rays(origin, direction, length))

    # -- candidates and answers --------------------------------------------------------------------------------

    def _true_pairs(self) -> Iterator[Indices]:
        """Keys of the candidates that are pairs."""
        count, boxes = len(self), self._corners()
        for i, j in self._near_pairs() if count else ():
            true = meeting(boxes, i, boxes, j)
            a, b = i[true], j[true]
            moving = (a != b) & ~(self.static[a] & self.static[b])
            a, b = a[moving], b[moving]
            yield np.minimum(a, b) * count + np.maximum(a, b)

    def _found(
        self, near: Callable[..., Candidates], asked: tuple[Array, ...], true: Callable[[Indices, Indices], Indices]
    ) -> Indices:
        """Query indices and ids of the candidates near what is asked for, those at the places that are true."""
        count = len(self)

        def keys() -> Iterator[Indices]:
            for q, rows in near(*asked) if count else ():
                kept = true(q, rows)
                yield q[kept] * count + rows[kept]

        found = self._sorted(keys(), count)
        found[:, 1] = self.ids[found[:, 1]]
        return found

    @staticmethod
    def _sorted(keys: Iterable[Indices], count: int) -> Indices:
        """Two columns of keys first · count + second, sorted, each once."""
        key = np.sort(np.concatenate([np.empty(0, dtype=np.int64), *keys]))
        first = np.ones(len(key), dtype=bool)
        np.not_equal(key[1:], key[:-1], out=first[1:])
        return np.stack(np.divmod(key[first], max(count, 1)), axis=-1)

    def _set(self, ids: Indices, lower: Array, upper: Array, static: Bools) -> None:
        self.ids, self.lower, self.upper, self.static = ids, lower, upper, static
        self._by_axis = None

    def _corners(self) -> Corners:
        """All boxes, axis by axis; kept until one changes."""
        if self._by_axis is None:
            self._by_axis = Corners.of(self.lower, self.upper)
        return self._by_axis

    def _rows(self, ids: Any) -> Indices:
        """Rows of ids."""
        wanted = np.atleast_1d(np.asarray(ids))
        if wanted.size and wanted.dtype.kind not in "iu":
            raise TypeError(f"ids must be integers, got {wanted.dtype}")
        wanted = wanted.reshape(-1).astype(np.int64)
        rows = np.searchsorted(self.ids, wanted)
        there = rows < len(self)
        there[there] = self.ids[rows[there]] == wanted[there]
        if not there.all():
            raise LookupError(f"no object with id {int(wanted[~there][0])}")
        once = np.zeros(len(self), dtype=bool)
        once[rows] = True
        if np.count_nonzero(once) != len(rows):
            raise ValueError("an id occurs twice")
        return rows
