"""Engines answer in another process: a crash or a hang becomes the scene's status, and the campaign goes on."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import weakref
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import IO, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from oracles.engine import Answers, Array, EngineUnavailable, Kind
from oracles.guard import Job, Result
from oracles.motion import WIDTH
from oracles.scene import IMPACT, Scene

START_LIMIT = 120.0
"""Seconds until a worker must have imported its engine."""

BOOT = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from oracles.guard import main
main(int(sys.argv[2]), sys.argv[3], float(sys.argv[4]))
"""


class EngineWorker:
    """One engine in a process of its own, with a time limit for each call.

    Parameters
    ----------
    engine_spec : str
        Name of a shipped engine, ``module:attribute`` or ``path/to/file.py:attribute``.
    call_limit : float
        Seconds of processor time for one scene; five times as long for one that waits. On a busy machine a slow call
        is no hang.

    Raises
    ------
    EngineUnavailable
        When the engine cannot be started; the text says why.

    Notes
    -----
    A scene that crashes or hangs costs its own answer only. Each gets its status, the text of what happened in
    `Answers.errors`, and a fresh process takes the next scene. Neither what the engine prints nor Ctrl-C
    gets through: the process has no terminal. Use as a context manager, or `close`.
    """

    def __init__(self, engine_spec: str, call_limit: float = 1.0) -> None:
        if not hasattr(os, "fork"):
            raise EngineUnavailable(f"engines are run in forked processes, which {sys.platform} does not have")
        if not 0 < call_limit < float("inf"):
            raise ValueError(f"call_limit must be a positive number of seconds, got {call_limit!r}")
        self.engine_spec = engine_spec
        self._busy = False
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  lives as long as the worker
        fcntl.fcntl(self._log, fcntl.F_SETFL, fcntl.fcntl(self._log, fcntl.F_GETFL) | os.O_APPEND)
        self._process, self._connection = _start(engine_spec, call_limit, self._log)
        self._end = weakref.finalize(self, _end, self._process, self._connection, self._log)
        self._greet()

    def answer(
        self,
        query: str,
        A: Kind,
        B: Kind,
        rows_a: ArrayLike,
        rows_b: ArrayLike,
        *,
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> Answers:
        """Have a batch of scenes of one cell answered.

        Parameters
        ----------
        rows_a, rows_b : (n, width)
            Packed proxies; of impacts, the motion's numbers behind A's.
        groups : (n,) of int, optional
            Label of each scene's group; all one group by default.
        give_up_after : int, optional
            Skip what is left of a group in this batch after so many time-outs.
        """
        self.submit(query, A, B, rows_a, rows_b, groups=groups, give_up_after=give_up_after)
        return self.result()

    def ask(self, scene: Scene) -> Answers:
        """Have one scene answered."""
        rows = (row[None] for row in scene.rows)
        return self.answer(scene.query, type(scene.a), type(scene.b), *rows)

    def submit(
        self,
        query: str,
        A: Kind,
        B: Kind,
        rows_a: ArrayLike,
        rows_b: ArrayLike,
        *,
        groups: ArrayLike | None = None,
        give_up_after: int | None = None,
    ) -> None:
        """Start on a batch, as `answer` does, and return at once; `result` waits for it."""
        a = _rows(A, rows_a, "rows_a", WIDTH if query == IMPACT else 0)
        b = _rows(B, rows_b, "rows_b")
        labels = np.zeros(len(a), np.int64) if groups is None else np.asarray(groups).astype(np.int64)
        if not len(a) == len(b) == len(labels) or labels.ndim != 1:
            raise ValueError(f"one group and one row of each side per scene, got {len(a)}, {len(b)}, {labels.shape}")
        if self._busy:
            raise RuntimeError("the worker is at work on another batch: take its result first")
        self._send(Job(query, A, B, a, b, labels, give_up_after))
        self._busy = True

    def result(self) -> Answers:
        """Wait for the batch that was submitted."""
        if not self._busy:
            raise RuntimeError("nothing was submitted")
        result = self._receive()
        self._busy = False
        assert isinstance(result, Result)
        return Answers.from_table(result.status, result.table, result.errors)

    def interrupt(self) -> None:
        """End the worker's processes at once; from any thread. What waits for a result raises."""
        _kill(self._process)

    def close(self) -> None:
        """End the worker's processes and wait for that; closing twice does no harm."""
        self._end()

    def __enter__(self) -> Self:
        """Return the worker."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self.close()

    def _greet(self) -> None:
        """Wait until the engine is imported."""
        late = f"{self.engine_spec} did not start within {START_LIMIT:g} s"
        try:
            refused = self._receive() if self._connection.poll(START_LIMIT) else late
        except BaseException:
            self.close()
            raise
        if refused is not None:
            self.close()
            raise EngineUnavailable(refused)

    def _send(self, job: Job) -> None:
        try:
            self._connection.send(job)
        except OSError:
            raise self._lost() from None

    def _receive(self) -> Any:
        try:
            return self._connection.recv()
        except (EOFError, OSError):
            raise self._lost() from None

    def _lost(self) -> EngineUnavailable:
        """Say how the guard ended, with the last that it printed."""
        if not self._end.alive:
            return EngineUnavailable(f"the worker of {self.engine_spec} is closed")
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(5.0)
        self._log.seek(max(0, os.fstat(self._log.fileno()).st_size - 1000))
        words = self._log.read().decode("utf-8", "replace").strip()
        return EngineUnavailable(
            f"the worker of {self.engine_spec} ended (exit status {self._process.poll()}) {words}".rstrip()
        )


def _rows(kind: Kind, rows: ArrayLike, name: str, behind: int = 0) -> Array:
    array = np.ascontiguousarray(rows, dtype=np.float64)
    if array.ndim == 2 and kind.header:  # rows that say their own size
        return array
    if array.ndim != 2 or array.shape[1] != kind.width() + behind:
        raise ValueError(f"{name}: a {kind.__name__} is a row of {kind.width() + behind} numbers, got {array.shape}")
    return array


def _start(spec: str, call_limit: float, log: IO[bytes]) -> tuple[subprocess.Popen[bytes], Connection]:
    """Start the guard in a session of its own, which no Ctrl-C of the terminal reaches."""
    ours, theirs = socket.socketpair()
    with theirs:
        command = [sys.executable, "-c", BOOT, json.dumps(sys.path), str(theirs.fileno()), spec, repr(call_limit)]
        # Threads of a linear algebra library would be lost in every fork, and are of no use to a solver.
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env=environment,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
    return process, Connection(ours.detach())


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End the guard and its hand: all of their session."""
    if process.poll() is None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)


def _end(process: subprocess.Popen[bytes], connection: Connection, log: IO[bytes]) -> None:
    _kill(process)
    process.wait()
    connection.close()
    log.close()
