"""The board: shared memory with a batch of scenes, what became of each, and the answers.

Worker, guard and hand see the same pages, so an answer is safe as soon as it is written, and nothing is copied
between the processes. It is no file of any disk, and cannot be shrunk under the feet of the others.
"""

from __future__ import annotations

import fcntl
import mmap
import os
import sys
import tempfile
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from oracles.engine import COLUMNS, WIDTH, Array, Kind, Status

PENDING = -1
"""Status of a scene that was not asked yet."""
REMARKED = 64
"""Added to the status of an answered scene that has a text all the same."""
ASKABLE = [int(Status.ANSWERED), int(Status.ERROR), int(Status.UNSUPPORTED)]
"""What a scene has become that a hand has dealt with; losses and gaps are the guard's to tell."""
NOWHERE_YET = -1
TEXT = 640
"""Bytes for the text of one scene."""
LONGEST_TEXT = 300
"""Characters of what an engine says or raises that are quoted."""
CAREFUL_FOR = 1000
"""So many scenes of a cell are asked one by one after a call was found to leave something changed, or a hand was lost:
what is lost is often lost again in the same cell. At 15 µs a scene that costs about as much as one more loss would, for
which a block has to be asked again, by two fresh hands: some 10 ms."""
HEADER = 64


class Phase(IntEnum):
    """What the hand is at."""

    WAITING = 0
    MAKING = 1
    """A solver for the cell is being made: a loss is that of all scenes."""
    ASKING = 2


@dataclass(frozen=True)
class Job:
    """Scenes of one cell; their numbers are on the board."""

    query: str
    A: Kind
    B: Kind
    size: int
    width_a: int
    width_b: int
    give_up_after: int | None
    renewed: bool = False
    """Whether a fresh hand is wanted, which was not asked anything before."""


class Board:
    """Shared memory, laid out for one job at a time.

    Attributes
    ----------
    at, since, careful, phase, says, beat, asked, spent : (1,) of int
        The scene being asked; the first since the hand last made sure that nothing was left changed; how many scenes
        are yet to be made sure of one by one; `Phase`; the columns that the engine promises, one bit each;
        a number that the guard counts up while it lives; how many scenes of the job were asked to the end, and the
        nanoseconds of processor time that the hand took for them.
    status : (n,)
        `PENDING` or `Status`, perhaps with `REMARKED`.
    groups, rows_a, rows_b, table
        Labels, packed proxies and answers.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self.descriptor = anonymous_file() if descriptor is None else descriptor
        self.memory = mmap.mmap(-1, mmap.PAGESIZE)
        self.mapped = 0
        self.layout = (-1, 0, 0)
        self.open(0, 0, 0)

    def open(self, size: int, width_a: int, width_b: int) -> None:
        """Lay out for a job, mapping more memory where it needs more."""
        if (size, width_a, width_b) == self.layout:
            return
        self.layout = size, width_a, width_b
        place, offsets = HEADER, []
        for item in (8 * size, 8 * size * width_a, 8 * size * width_b, 8 * size * WIDTH, size, size * TEXT):
            offsets.append(place)
            place += item
        if place > self.mapped:
            self._map(place)
        header = np.frombuffer(self.memory, np.int64, HEADER // 8)
        fields = [header[k : k + 1] for k in range(HEADER // 8)]
        self.at, self.since, self.careful, self.phase, self.says, self.beat, self.asked, self.spent = fields
        groups, a, b, table, status, self.texts = offsets
        self.answers_start = table
        self.status_start = status
        self.groups = np.frombuffer(self.memory, np.int64, size, groups)
        self.rows_a = np.frombuffer(self.memory, np.float64, size * width_a, a).reshape(size, width_a)
        self.rows_b = np.frombuffer(self.memory, np.float64, size * width_b, b).reshape(size, width_b)
        self.table = np.frombuffer(self.memory, np.float64, size * WIDTH, table).reshape(size, WIDTH)
        self.status = np.frombuffer(self.memory, np.int8, size, status)

    def _map(self, size: int) -> None:
        pages = -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
        if os.fstat(self.descriptor).st_size < pages:
            os.ftruncate(self.descriptor, pages)
        self.memory, self.mapped = mmap.mmap(self.descriptor, pages), pages

    def fill(self, rows_a: Array, rows_b: Array, groups: NDArray[np.int64], careful: int = 0) -> None:
        """Put down the scenes of a new job, none of them asked yet; the first `careful` are to be made sure of."""
        self.open(len(rows_a), rows_a.shape[1], rows_b.shape[1])
        self.rows_a[:], self.rows_b[:], self.groups[:] = rows_a, rows_b, groups
        self.status[:] = PENDING
        self.careful[0] = careful
        self.at[0], self.since[0], self.phase[0], self.says[0] = NOWHERE_YET, NOWHERE_YET, Phase.WAITING, 0
        self.asked[0], self.spent[0] = 0, 0

    def still_careful(self) -> int:
        """How many more scenes are to be made sure of; whatever stands there by now, not more than after a loss."""
        return min(max(int(self.careful[0]), 0), CAREFUL_FOR)

    def pending(self) -> NDArray[np.intp]:
        """Return the numbers of the scenes that are not asked yet, in their order."""
        return np.flatnonzero(self.status == PENDING)

    def ask_again(self, first: int, end: int) -> None:
        """Take back what was answered in a range of scenes."""
        part = self.status[first:end]
        part[np.isin(part & ~REMARKED, ASKABLE)] = PENDING

    def pin(self, i: int, status: int, text: str) -> None:
        """Put down what became of a scene that has no answer, or what is to be said of one that has."""
        self.write_text(i, text)
        self.status[i] = status

    def write_text(self, i: int, text: str) -> None:
        """Put down a text, cut where there is no more room."""
        data = text.encode("utf-8", "replace")[: TEXT - 2]
        start = self.texts + i * TEXT
        self.memory[start : start + 2] = len(data).to_bytes(2, "little")
        self.memory[start + 2 : start + 2 + len(data)] = data

    def text(self, i: int) -> str:
        """Read a text; whatever the bytes are by now, it is a short one."""
        start = self.texts + i * TEXT
        length = min(int.from_bytes(self.memory[start : start + 2], "little"), TEXT - 2)
        return self.memory[start + 2 : start + 2 + length].decode("utf-8", "ignore")

    def results(self) -> tuple[NDArray[np.int8], Array, dict[int, str]]:
        """Return copies of the statuses and answers, and the texts; nothing that stands there is trusted."""
        status, table = self.status.copy(), self.table.copy()
        if not status.any():
            return status, table, {}
        remarked = (status > 0) & (status & REMARKED != 0)
        status[remarked] -= REMARKED
        strange = ~np.isin(status, [int(s) for s in Status])
        status[strange] = Status.CRASHED
        table[status != Status.ANSWERED] = np.nan
        told = np.flatnonzero(remarked | ~np.isin(status, [int(Status.ANSWERED), int(Status.SKIPPED)]))
        texts = {int(i): OVERWRITTEN if strange[i] else self.text(int(i)) for i in told}
        return status, table, texts

    def promised(self) -> frozenset[str]:
        """Return the names of the columns that the engine promises."""
        bits = int(self.says[0])
        return frozenset(name for k, name in enumerate(COLUMNS) if bits >> k & 1)

    def promise(self, names: frozenset[str]) -> None:
        """Put down the names of the columns that the engine promises."""
        self.says[0] = sum(1 << k for k, name in enumerate(COLUMNS) if name in names)


OVERWRITTEN = "the engine's process wrote over the memory that it shares with the harness"


def anonymous_file() -> int:
    """Open a file that no folder has: in memory, and never to be shrunk, where the system has such files."""
    if sys.platform == "linux":
        descriptor = os.memfd_create("proxyproof", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        fcntl.fcntl(descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)
        return descriptor
    descriptor, path = tempfile.mkstemp()
    os.unlink(path)
    return descriptor
