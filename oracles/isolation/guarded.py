"""The guard as the worker has it: started, spoken to, found dead, started again."""

from __future__ import annotations

import json
import os
import secrets
import socket
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import asdict
from multiprocessing.connection import Connection

from oracles.engine import EngineUnavailable
from oracles.isolation.board import Board, Job, anonymous_file
from oracles.isolation.hands import Limits, how_it_ended
from oracles.isolation.processes import end_marked

STALLED = 20.0
"""Seconds without any sign of life after which a guard is given up: something has stopped it."""
LOOK = 1.0
ATTEMPTS = 3
"""A guard that is killed while it starts is started again so often."""
PARTING = 3.0
"""Seconds that a guard has to end what is below it before it is ended itself."""
MARK = "PROXYPROOF_GUARD"
"""Every process below a guard has this in its environment, with a value of the worker's own."""
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "PROXYPROOF_THREADS")
"""Threads would be lost in every fork, and are of no use to a solver of one scene."""
BOOT = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from oracles.isolation.guard import Limits, main
main(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4], Limits(**json.loads(sys.argv[5])))
"""


class GuardLost(Exception):
    """The guard ended, or was stopped; the text says how."""


class Guarded:
    """A guard process, and the board that it shares with us."""

    def __init__(self, spec: str, limits: Limits) -> None:
        self.spec, self.limits = spec, limits
        self.board = Board()
        self.mark = secrets.token_hex(8)
        self.owner = os.getpid()
        self.process: subprocess.Popen[bytes] | None = None
        self.connection: Connection | None = None
        self.log = -1
        self.leaving = False
        """Whether the guard was told to go: then it is not started again."""

    def start(self) -> None:
        """Start the guard, and wait until it has the engine.

        Raises
        ------
        EngineUnavailable
            When there is no engine; the text says why.
        """
        for attempt in range(ATTEMPTS):
            self._clear_up()
            self._launch()
            try:
                self.listen(self.limits.start + STALLED)
            except GuardLost as how:
                if attempt == ATTEMPTS - 1 or not self._was_killed():
                    self._clear_up()
                    raise EngineUnavailable(f"{self.spec} cannot be started: {how}") from None
            except BaseException:
                self._clear_up()
                raise
            else:
                return

    def _was_killed(self) -> bool:
        """Whether the guard was ended by someone else's signal."""
        return not self.leaving and self.process is not None and (self.process.poll() or 0) < 0

    def _launch(self) -> None:
        """Start the process in a session of its own, which no Ctrl-C of the terminal reaches."""
        if self.leaving:
            raise EngineUnavailable(f"the worker of {self.spec} is closed")
        ours, theirs = socket.socketpair()
        with theirs:
            self.log = anonymous_file()
            self.connection = Connection(ours.detach())
            passed = theirs.fileno(), self.board.descriptor
            arguments = [json.dumps(sys.path), *map(str, passed), self.spec, json.dumps(asdict(self.limits))]
            self.process = subprocess.Popen(
                [sys.executable, "-c", BOOT, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=self.log,
                stderr=self.log,
                env={**os.environ, **dict.fromkeys(THREADS, "1"), MARK: self.mark},
                pass_fds=passed,
                start_new_session=True,
            )

    def ask(self, job: Job) -> None:
        """Have the job on the board done; a guard that is gone is found out by `listen`."""
        if self.connection is not None:
            with suppress(OSError):
                self.connection.send(job)

    def listen(self, patience: float | None = None) -> list[str]:
        """Wait until the guard is ready for the next job; what happened meanwhile, in sentences.

        Raises
        ------
        GuardLost
            When it was lost before that, or gave no sign of life for some seconds.
        EngineUnavailable
            When the guard has no engine, and says why.
        """
        if self.connection is None:
            raise GuardLost("there is no guard")
        beat, since = -1, time.monotonic()
        try:
            while not self.connection.poll(LOOK):
                if int(self.board.beat[0]) != beat:
                    beat, since = int(self.board.beat[0]), time.monotonic()
                elif time.monotonic() - since > (patience or STALLED):
                    raise GuardLost(f"the guard of the engine's process did nothing for {patience or STALLED:g} s")
            said = json.loads(self.connection.recv_bytes())
        except (EOFError, OSError):
            raise GuardLost(self._how_it_ended()) from None
        if said["refused"] is not None:
            raise EngineUnavailable(said["refused"])
        incidents: list[str] = said["incidents"]
        return incidents

    def _how_it_ended(self) -> str:
        """Say how the guard ended, with the last that it printed itself."""
        assert self.process is not None
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(PARTING)
        how = how_it_ended("the guard of the engine's process", self.process.returncode or 0)
        with open(self.log, "rb", closefd=False) as log:
            words = log.read()[-1000:].decode("utf-8", "replace").strip()
        return f"{how}: {words}" if words else how

    def interrupt(self) -> None:
        """End the guard at once, and what depends on it; from any thread. It is not started again."""
        self.leaving = True
        process = self.process
        if process is not None and process.poll() is None:
            with suppress(ProcessLookupError):
                process.kill()

    def end(self) -> None:
        """End the guard and everything below it, and wait for that; in the process that started it."""
        self.leaving = True
        if os.getpid() == self.owner:
            self._clear_up()
            if self.board.descriptor >= 0:
                os.close(self.board.descriptor)
                self.board.descriptor = -1

    def _clear_up(self) -> None:
        """Let the guard end what is below it, or find that without it."""
        if self.connection is not None:
            self.connection.close()  # the guard takes that as the word to go
        if self.process is not None:
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(PARTING)
            self.process.kill()
            if self.process.wait() != 0:
                end_marked(f"{MARK}={self.mark}")
        if self.log >= 0:
            os.close(self.log)
        self.connection, self.process, self.log = None, None, -1
