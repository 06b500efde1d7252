"""Where the time goes: seconds of named kinds of work in one process, each without what it had others do."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class Stopwatch:
    """Clocks of nested kinds of work, of which only the innermost runs."""

    def __init__(self) -> None:
        self._spent: defaultdict[str, float] = defaultdict(float)
        self._running: list[str] = []
        self._since = 0.0

    @contextmanager
    def timed(self, what: str) -> Iterator[None]:
        """Let the clock of `what` run within the block, and that of the block around it stand still."""
        self._switch()
        self._running.append(what)
        try:
            yield
        finally:
            self._switch()
            self._running.pop()

    def _switch(self) -> None:
        now = time.perf_counter()
        if self._running:
            self._spent[self._running[-1]] += now - self._since
        self._since = now

    def taken(self) -> dict[str, float]:
        """Seconds of each kind since they were taken last."""
        self._switch()
        spent = dict(self._spent)
        self._spent.clear()
        return spent


watch = Stopwatch()
"""The stopwatch of this process: a worker does one task at a time."""

timed = watch.timed
