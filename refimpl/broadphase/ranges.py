"""Many runs of consecutive numbers, written out: how candidates are listed without a loop over objects."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from refimpl.signs import Indices

PIECE = 1 << 20
"""Candidates that are held in memory at a time, or as many as a single run has."""


def written_out(start: Indices, count: Indices) -> tuple[Indices, Indices]:
    """Owner and number of every member of the runs start[k], ..., start[k] + count[k] − 1, run after run.

    Parameters
    ----------
    start, count : (n,) int64, count ≥ 0

    Returns
    -------
    two arrays of sum(count) int64
        Index k of the run, and the number.
    """
    owner = np.repeat(np.arange(len(count)), count)
    shift = start - (np.cumsum(count) - count)
    return owner, np.arange(len(owner)) + shift[owner]


def pieces(start: Indices, count: Indices, most: int = PIECE) -> Iterator[tuple[Indices, Indices]]:
    """Give the same in pieces of at most `most` members; runs that are longer are cut too."""
    ends = np.cumsum(count)
    total = int(ends[-1]) if len(ends) else 0
    for begin in range(0, total, most):
        end = min(begin + most, total)
        a, b = np.searchsorted(ends, [begin, end - 1], side="right")
        some = slice(int(a), int(b) + 1)
        skipped = np.maximum(begin - (ends[some] - count[some]), 0)
        beyond = np.maximum(ends[some] - end, 0)
        owner, number = written_out(start[some] + skipped, count[some] - skipped - beyond)
        yield owner + a, number


def shares(count: Indices, most: int = PIECE) -> Iterator[slice]:
    """Cut owners of so many members into runs with at most `most` members, or with a single owner."""
    ends = np.cumsum(count)
    begin = 0
    while begin < len(count):
        before = int(ends[begin - 1]) if begin else 0
        end = max(int(np.searchsorted(ends, before + most, side="right")), begin + 1)
        yield slice(begin, end)
        begin = end
