"""Large batches in several threads, where compiled kernels do the work and let go of Python's lock.

Rows of a batch do not know of each other, so that it makes no difference to the answers which thread gives them. The
environment variable PROXYPROOF_THREADS says how many there may be; otherwise there are as many as this process has
processors, and one in processes that were started to share the work already.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from itertools import pairwise
from typing import TypeVar

SETTING = "PROXYPROOF_THREADS"
SHARE = 2048
"""Rows that are worth a thread."""
AHEAD = 64
"""Rows that go ahead: what they compile, derive and keep is there for the others."""

T = TypeVar("T")
R = TypeVar("R")

_shared: ContextVar[bool] = ContextVar("_shared", default=False)


def allowed_threads() -> int:
    """How many threads a batch may be shared by.

    Raises
    ------
    ValueError
        If the environment asks for what is no positive whole number.
    """
    asked = os.environ.get(SETTING, "")
    if asked:
        if not asked.isascii() or not asked.isdigit() or int(asked) == 0:
            raise ValueError(f"{SETTING} must be a positive whole number, got {asked!r}")
        return int(asked)
    if multiprocessing.parent_process() is not None:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shares(rows: int) -> Iterator[slice]:
    """Parts of a batch for threads: few rows that go ahead, and a part for each; all of it in one if it is small."""
    count = 1 if rows < 2 * SHARE or _shared.get() else min(allowed_threads(), rows // SHARE)
    if count == 1:
        yield slice(0, rows)
        return
    yield slice(0, AHEAD)
    ends = [AHEAD + (rows - AHEAD) * i // count for i in range(count + 1)]
    yield from (slice(start, end) for start, end in pairwise(ends))


def in_threads(work: Callable[[T], R], parts: Iterable[T]) -> list[R]:
    """Apply `work` to the first part, then to all others at once; results in their order."""

    def alone(part: T) -> R:
        _shared.set(True)
        return work(part)

    first, *others = parts
    found = [work(first)]
    if others:
        with ThreadPoolExecutor(len(others)) as pool:  # not kept: it would be of no use to a fork of this process
            running = [pool.submit(copy_context().run, alone, part) for part in others]
            found += [task.result() for task in running]
    return found


@contextmanager
def products_in_one_thread() -> Iterator[None]:
    """Keep matrix products within this block from being shared among threads.

    A search that makes thousands of small ones waits longer for the threads than it computes, the threads spin
    meanwhile, and how many there are decides the last bits of a sum. It holds for the whole process while it lasts.
    """
    from threadpoolctl import threadpool_limits  # noqa: PLC0415  only searches need it

    with threadpool_limits(1, user_api="blas"):
        yield
