"""The guard: a process that has an engine asked by a child of its own, and outlives that child.

Run by `oracles.worker`. The guard imports the engine and forks the *hand*, which makes the calls and writes each
answer, and the number of the scene it is at, into shared memory. So nothing is lost when the hand crashes, and a
new hand is there in a few milliseconds. The guard watches the clock, and never calls into the engine itself.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import signal
import struct
import sys
import time
import traceback
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from oracles.engine import (
    WIDTH,
    Array,
    Engine,
    EngineUnavailable,
    Kind,
    Row,
    Solver,
    Status,
    UnsupportedCell,
    faults,
)
from oracles.engines import load_engine

CHUNK = 4096
"""Scenes handed over at once: the size of the shared memory."""
LOOK = 0.01
"""Seconds between looks at the clock."""
PATIENCE = 5.0
"""On a busy machine a call may take this many limits of wall time, as long as it gets no processor time."""
LONGEST_LOG = 1 << 20
LONGEST_TEXT = 300
ROW = struct.Struct(f"{WIDTH}d")
PR_SET_PDEATHSIG = 1


@dataclass(frozen=True)
class Job:
    """Scenes of one cell, with groups that are given up after so many time-outs."""

    query: str
    A: Kind
    B: Kind
    rows_a: Array
    rows_b: Array
    groups: NDArray[np.int64]
    give_up_after: int | None


@dataclass(frozen=True)
class Result:
    """What became of a job's scenes."""

    status: NDArray[np.int8]
    table: Array
    errors: dict[int, str]


class Board:
    """Memory shared with the hand: where it is, what became of each scene of a chunk, and the answers."""

    def __init__(self) -> None:
        self.memory = mmap.mmap(-1, 8 + CHUNK + CHUNK * ROW.size)
        self.at = np.frombuffer(self.memory, np.int64, 1)
        self.status = np.frombuffer(self.memory, np.int8, CHUNK, 8)
        self.start = 8 + CHUNK
        self.table = np.frombuffer(self.memory, np.float64, CHUNK * WIDTH, self.start).reshape(CHUNK, WIDTH)

    def clear(self, size: int) -> None:
        """Make ready for a chunk of that size."""
        self.status[:size] = Status.ANSWERED
        self.table[:size] = np.nan

    def write(self, i: int, answer: Sequence[float]) -> None:
        """Put down an answer; raises what `struct` raises when it is not `WIDTH` numbers."""
        ROW.pack_into(self.memory, self.start + i * ROW.size, *answer)


# -- the hand ------------------------------------------------------------------------------------------------


def be_the_hand(engine: Engine, board: Board, connection: Connection) -> NoReturn:
    """Answer chunks until the connection closes; never returns into the guard's code."""
    try:
        _end_with_parent()
        solvers: dict[tuple[str, Kind, Kind], Solver] = {}
        while True:
            query, A, B, rows_a, rows_b, first = connection.recv()
            try:
                solve = solvers.get((query, A, B)) or engine.solver(query, A, B)
            except Exception as error:  # whatever an engine raises is its answer
                connection.send((None, said(error)))
                continue
            solvers[query, A, B] = solve
            _answer(solve, board, connection, first, rows_a.tolist(), rows_b.tolist())
            connection.send(None)
    except (EOFError, OSError):
        os._exit(0)
    except SystemExit as left:
        os._exit(left.code if isinstance(left.code, int) else 1)
    except Exception:
        traceback.print_exc()
    finally:
        os._exit(1)


def _answer(
    solve: Solver, board: Board, connection: Connection, first: int, rows_a: list[Row], rows_b: list[Row]
) -> None:
    at, status = board.at, board.status
    for i, (a, b) in enumerate(zip(rows_a, rows_b, strict=True), first):
        at[0] = i
        if status[i] == Status.SKIPPED:
            continue
        try:
            answer = solve(a, b)
        except UnsupportedCell as error:
            status[i] = Status.UNSUPPORTED
            connection.send((i, said(error)))
            continue
        except Exception as error:  # whatever an engine raises is its answer
            status[i] = Status.ERROR
            connection.send((i, said(error)))
            continue
        try:
            board.write(i, answer)
        except (TypeError, ValueError, OverflowError, struct.error):
            status[i] = Status.ERROR
            connection.send((i, f"answered {answer!r}"[:LONGEST_TEXT]))


def said(error: BaseException) -> str:
    """Type and text of an exception, cut short."""
    return f"{type(error).__name__}: {error}"[:LONGEST_TEXT]


def _end_with_parent() -> None:
    """Ask Linux to kill this process when the guard ends, even if the engine hangs by then."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


# -- the guard -----------------------------------------------------------------------------------------------


@dataclass
class Guard:
    """Does jobs with hands that may be lost."""

    engine: Engine
    call_limit: float
    parent: Connection
    board: Board = field(default_factory=Board)
    connection: Connection | None = None
    hand_id: int = 0

    def serve(self) -> None:
        """Do what the parent sends until it closes the connection."""
        try:
            while True:
                job = self.parent.recv()
                _forget_log()
                self.parent.send(self.do(job))
        except (EOFError, OSError, ParentLeft):
            pass
        finally:
            self._dismiss()

    def do(self, job: Job) -> Result:
        """Have all scenes of a job answered, chunk by chunk."""
        n = len(job.rows_a)
        result = Result(np.zeros(n, np.int8), np.full((n, WIDTH), np.nan), {})
        timeouts: Counter[int] = Counter()
        for start in range(0, n, CHUNK):
            part = slice(start, min(start + CHUNK, n))
            size, errors = part.stop - start, self._chunk(job, part, timeouts)
            result.status[part], result.table[part] = self.board.status[:size], self.board.table[:size]
            result.errors.update({start + i: text for i, text in errors.items()})
        for i, text in self._faults(job, result.table).items():
            if result.status[i] == Status.ANSWERED:
                result.status[i], result.errors[i] = Status.ERROR, text
        result.table[result.status != Status.ANSWERED] = np.nan
        return result

    def _faults(self, job: Job, table: Array) -> dict[int, str]:
        try:
            says = self.engine.says(job.query, job.A, job.B)
        except Exception as error:  # one's own engine may raise anything
            return dict.fromkeys(range(len(table)), said(error))
        return faults(job.query, says, table)

    def _chunk(self, job: Job, part: slice, timeouts: Counter[int]) -> dict[int, str]:
        """Have one chunk answered, with as many hands as it takes."""
        board, groups = self.board, job.groups[part]
        errors: dict[int, str] = {}
        size, first = len(groups), 0
        board.clear(size)
        while first < size:
            if job.give_up_after is not None:
                lost = [group for group, count in timeouts.items() if count >= job.give_up_after]
                board.status[first:size][np.isin(groups[first:], lost)] = Status.SKIPPED
            board.at[0] = first
            rows = job.rows_a[part][first:], job.rows_b[part][first:]
            fate, text = self._watch((job.query, job.A, job.B, *rows, first), errors)
            if fate == Status.ANSWERED:
                break
            if fate == Status.ERROR:
                board.status[first:size] = Status.ERROR
                errors.update(dict.fromkeys(range(first, size), text))
                break
            i = int(board.at[0])
            board.status[i], errors[i] = fate, text
            timeouts[int(groups[i])] += fate == Status.TIMED_OUT
            first = i + 1
        return errors

    def _watch(self, chunk: tuple[Any, ...], errors: dict[int, str]) -> tuple[Status, str]:
        """Give a chunk to the hand, and answer what ended it: all answered, no solver, or a lost hand."""
        seen, since, before = -1, 0.0, 0.0
        try:
            hand = self._hand()
            hand.send(chunk)
            while True:
                ready = wait([hand, self.parent], LOOK)
                _shorten_log()
                if self.parent in ready:
                    raise ParentLeft
                if hand in ready:
                    message = hand.recv()
                    if message is None:
                        return Status.ANSWERED, ""
                    i, text = message
                    if i is None:
                        return Status.ERROR, text
                    errors[i] = text
                    continue
                at, now, spent = int(self.board.at[0]), time.monotonic(), processor_time(self.hand_id)
                if at != seen:
                    seen, since, before = at, now, spent
                elif self._too_long(now - since, spent - before):
                    self._dismiss()
                    return Status.TIMED_OUT, f"no answer within {self.call_limit:g} s"
        except (EOFError, OSError):
            return Status.CRASHED, self._bury()

    def _too_long(self, wall: float, processor: float) -> bool:
        """Whether a call is over its limit of processor time, or has waited for several times as long."""
        return processor >= self.call_limit or wall >= PATIENCE * self.call_limit

    def _hand(self) -> Connection:
        """Give the hand, forking one when there is none or it ended while it had nothing to do."""
        if self.connection is not None and os.waitid(os.P_PID, self.hand_id, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            self._reap()
        if self.connection is None:
            self.connection, theirs = Pipe()
            self.hand_id = os.fork()
            if not self.hand_id:
                self.parent.close()
                self.connection.close()
                be_the_hand(self.engine, self.board, theirs)
            theirs.close()
        return self.connection

    def _bury(self) -> str:
        """Say how the hand ended."""
        status = self._reap()
        if os.WIFSIGNALED(status):
            number = os.WTERMSIG(status)
            ended = f"the process was ended by {signal.Signals(number).name} ({signal.strsignal(number)})"
        else:
            ended = f"the process ended with exit status {os.waitstatus_to_exitcode(status)}"
        words = last_words()
        _forget_log()
        return f"{ended}: {words}" if words else ended

    def _dismiss(self) -> None:
        """End the hand, if there is one, whatever it is doing."""
        if self.connection is not None:
            with suppress(ProcessLookupError):
                os.kill(self.hand_id, signal.SIGKILL)
            self._reap()

    def _reap(self) -> int:
        assert self.connection is not None
        self.connection.close()
        self.connection = None
        return os.waitpid(self.hand_id, 0)[1]


class ParentLeft(Exception):
    """The parent closed the connection in the middle of a job."""


def processor_time(process: int) -> float:
    """Seconds of processor that a process has used; NaN, which is no small number, where no one tells."""
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as stat:
            fields = stat.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, IndexError, ValueError):
        return float("nan")


# -- what the engine prints: standard output and error are one file, which only this process cuts ---------------


def _forget_log() -> None:
    os.ftruncate(1, 0)


def _shorten_log() -> None:
    if os.fstat(1).st_size > LONGEST_LOG:
        _forget_log()


def last_words() -> str:
    """What was printed last, on one line: its beginning, which names an error, and its end."""
    size = os.fstat(1).st_size
    text = os.pread(1, 4000, max(0, size - 4000)).decode("utf-8", "replace")
    line = " | ".join(line.strip() for line in text.splitlines() if line.strip())
    return line if len(line) <= LONGEST_TEXT else f"{line[: LONGEST_TEXT * 3 // 4]} … {line[-LONGEST_TEXT // 4 :]}"


def main(descriptor: int, spec: str, call_limit: float) -> None:
    """Load the engine, tell the parent how that went, and serve."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = Connection(descriptor)
    try:
        engine = load_engine(spec)
        engine.warm()
    except EngineUnavailable as error:
        parent.send(str(error))
    except Exception as error:  # one's own engine may raise anything
        parent.send(f"{spec} cannot be started: {said(error)}")
    else:
        parent.send(None)
        Guard(engine, call_limit, parent).serve()
