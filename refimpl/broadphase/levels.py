"""One level of a grid: objects of about one size, in cells that are as large.

What all kinds of levels share: which of their objects are still in their cells, and how rays go through cells.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from refimpl.broadphase.buckets import Cells
from refimpl.broadphase.protocol import Candidates
from refimpl.broadphase.ranges import pieces, shares, written_out
from refimpl.broadphase.sizes import tame
from refimpl.broadphase.slabs import TINY, WIDER, clipped
from refimpl.linear import Array, Bools, largest, scale
from refimpl.signs import Indices

STEPS = 1024
"""Stretches of a ray at most; longer ones cover several cells each."""


class Level(ABC):
    """Objects in cells.

    Parameters
    ----------
    rows : (m,) int64, m ≥ 1
        The objects; all of them have tame boxes.
    lower, upper : (m, D)
        Their boxes.
    low, high : (m, D) int64
        First and last cells of each.
    cells
        The grid.
    """

    cells: Cells

    def __init__(self, rows: Indices, lower: Array, upper: Array, low: Indices, high: Indices, cells: Cells) -> None:
        self.rows, self.cells, self.low, self.high = rows, cells, low, high
        self.bounds = np.min(lower, axis=0), np.max(upper, axis=0)

    @property
    @abstractmethod
    def memory(self) -> int:
        """Bytes of what finds the objects in cells."""

    @abstractmethod
    def pairs(self, lower: Array, upper: Array) -> Candidates:
        """Propose pairs of the level's objects that may meet; the boxes are those of all rows."""

    @abstractmethod
    def around(self, lower: Array, upper: Array) -> Candidates:
        """Propose query indices and objects near boxes (Q, D)."""

    def hold(self, places: Indices, lower: Array, upper: Array) -> Bools:
        """Whether the objects at these places of `rows` are still in their cells, with other boxes."""
        low, high = self.cells.of(lower), self.cells.of(upper)
        held = np.all((low >= self.low[places]) & (high <= self.high[places]), axis=1) & tame(lower, upper)
        self.bounds = (
            np.minimum(self.bounds[0], np.min(lower[held], axis=0, initial=np.inf)),
            np.maximum(self.bounds[1], np.max(upper[held], axis=0, initial=-np.inf)),
        )
        return np.asarray(held)

    def renumber(self, row: Indices) -> None:
        """Follow new numbers of all rows; −1: taken away."""
        kept = row[self.rows] >= 0
        self.low, self.high, self.rows = self.low[kept], self.high[kept], row[self.rows[kept]]

    def along(self, origin: Array, direction: Array, length: Array) -> Candidates:
        """Query indices and objects near rays (Q, D): around each of the stretches into which a ray is cut.

        A stretch is about a cell long, and its box is rounded outwards.
        """
        first, last, lost = clipped(origin, direction, length, *self.bounds)
        yield from self.everything(np.flatnonzero(lost))
        asked = np.flatnonzero(~lost & (first <= last))
        start, time = first[asked], last[asked] - first[asked]
        steps = np.clip(np.ceil(largest(direction[asked]) * time / self.cells.size), 1, STEPS).astype(np.int64)
        for some in shares(steps):
            which, number = written_out(np.zeros_like(steps[some]), steps[some])
            q = asked[some][which]
            step = (time[some] / steps[some])[which]
            begin, end = (start[some][which] + step * (number + k) for k in (0, 1))
            a, b = (origin[q] + scale(t, direction[q]) for t in (begin, end))
            slack = 4 * WIDER * (np.abs(origin[q]) + scale(end, np.abs(direction[q]))) + TINY
            for stretch, row in self.around(np.minimum(a, b) - slack, np.maximum(a, b) + slack):
                yield q[stretch], row

    def everything(self, asked: Indices) -> Candidates:
        """All objects for each of some queries."""
        count = np.full(len(asked), len(self.rows))
        for q, number in pieces(np.zeros_like(count), count):
            yield asked[q], self.rows[number]
