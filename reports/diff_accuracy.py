"""Accuracy of two runs: the cells whose errors are clearly larger or smaller than they were."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from oracles.accuracy import Accuracy, CellKey, Errors

FLOOR = 1e-15
"""Relative errors below are rounding, and equal."""

RANKS = (("median", 3.0, 100), ("p99", 10.0, 1000))
"""Which errors by rank are compared, how many times they have to differ, and the fewest answers that allow it.

Other scenes have other errors. The worst is not compared, as one scene decides on it.
"""


@dataclass(frozen=True)
class Shift:
    """Relative errors of one cell, by rank, that have become larger or smaller."""

    cell: CellKey
    rank: str
    before: float
    after: float

    @property
    def worse(self) -> bool:
        """Whether they are larger now."""
        return self.after > self.before


def shifts(before: Accuracy, after: Accuracy) -> Iterator[Shift]:
    """Cells that both runs measured and whose errors differ clearly, the first rank that does."""
    known = {row.cell: row for row in before.errors if row.pair and not row.regime}
    for row in after.errors:
        if row.pair and not row.regime and row.cell in known:
            found = next(_shifted(known[row.cell], row), None)
            if found is not None:
                yield found


def _shifted(before: Errors, after: Errors) -> Iterator[Shift]:
    if before.relative is None or after.relative is None:
        return
    for rank, factor, fewest in RANKS:
        one, other = (max(FLOOR, getattr(row, rank)) for row in (before.relative, after.relative))
        enough = min(before.valued, after.valued) >= fewest
        if enough and max(one, other) >= factor * min(one, other):
            yield Shift(after.cell, rank, one, other)
