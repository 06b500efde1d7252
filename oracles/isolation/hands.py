"""Hands as the guard has them: one at a time, made by the fork server, ended with all that they started."""

from __future__ import annotations

import os
import select
import signal
import time
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from multiprocessing.reduction import send_handle

from oracles.engine import Status
from oracles.isolation.board import Board, Job
from oracles.isolation.hand import DONE
from oracles.isolation.lookout import Family, Fate, Lookout, in_words
from oracles.isolation.output import Output
from oracles.isolation.processes import below, end_all_below, process
from oracles.isolation.server import READY, be_the_server

LOOK = 0.01
"""Seconds between looks at clock, memory and processes."""
IDLE_LOOK = 0.25
ATTEMPTS = 3
"""An import that somebody kills is tried again so often."""
TELLING = 5.0
"""Seconds within which the fork server answers, or is ended itself."""


ENDED = select.POLLHUP | select.POLLERR | select.POLLNVAL


class NoEngine(Exception):
    """The engine cannot be started; the text says why."""


class ParentLeft(Exception):
    """The parent closed the connection, or ended."""


@dataclass(frozen=True)
class Limits:
    """Seconds for one scene; bytes beyond those that the imported engine takes; seconds for the import."""

    call: float
    memory: int
    start: float


@dataclass
class Hands:
    """The fork server, and the hand that it made last."""

    spec: str
    limits: Limits
    board: Board
    parent: Connection
    output: Output = field(default_factory=Output)
    starts: int = 0
    """How often the engine was imported."""
    import_killed: bool = False
    server: Connection | None = None
    family: Family = field(default_factory=lambda: Family(os.getpid(), 0))
    hand: Connection | None = None
    lookout: Lookout | None = None
    memory_at_first: int = 0
    above: int = field(default_factory=os.getppid)

    # -- the fork server -------------------------------------------------------------------------------------

    def start(self) -> Connection:
        """Have the engine imported; raises `NoEngine` when that fails, or takes too much time or memory."""
        for _ in range(ATTEMPTS):
            server = self._import()
            refused = self._first_words(server)
            if not refused:
                known = process(self.family.server)
                self.memory_at_first = 0 if known is None else known.memory
                kept = frozenset(p.number for p in self.family.strangers())
                self.family = Family(self.family.guard, self.family.server, kept)
                return server
            self.end()
            if not self.import_killed:
                break
        raise NoEngine(refused)

    def _import(self) -> Connection:
        """Make the fork server, which begins to import the engine."""
        self.starts += 1
        self.import_killed = False
        self.output.forget()
        server, theirs = Pipe()
        guard, number = os.getpid(), os.fork()
        if not number:
            server.close()
            self.parent.close()
            os.close(self.output.reading)
            for standard in (1, 2):
                os.dup2(self.output.writing, standard)
            be_the_server(self.spec, self.board, theirs, self.limits.memory, guard)
        theirs.close()
        self.server, self.family = server, Family(guard, number)
        return server

    def _first_words(self, server: Connection) -> str:
        """Wait for what the server says of the engine; empty when it is ready."""
        deadline = time.monotonic() + self.limits.start
        while server not in self._wait([server]):
            if time.monotonic() > deadline:
                return f"{self.spec} did not start within {self.limits.start:g} s{self._quoted()}"
            if sum(p.memory for p in below((os.getpid(),))) > self.limits.memory:
                return f"{self.spec} used more than {in_words(self.limits.memory)} to start{self._quoted()}"
        try:
            said = server.recv_bytes()
        except (EOFError, OSError):
            code = os.waitstatus_to_exitcode(os.waitpid(self.family.server, 0)[1])
            self.import_killed = code == -signal.SIGKILL
            return f"{self.spec} cannot be started: {how_it_ended('the process', code)}{self._quoted()}"
        return "" if said == READY else said.decode("utf-8", "replace")

    # -- the hand --------------------------------------------------------------------------------------------

    def give(self, job: Job) -> Fate | None:
        """Have a job done by the hand, by a new one where there is none; say how the hand was lost, if it was."""
        try:
            hand, lookout, server = self._working()
            lookout.reset()
            with suppress(BrokenPipeError, ConnectionResetError):  # the server says how it ended
                hand.send(job)
            return self._watch(hand, lookout, server)
        except (EOFError, OSError):
            self.end()
            return Fate(Status.CRASHED, f"the process that had imported the engine was lost{self._quoted()}")

    def _working(self) -> tuple[Connection, Lookout, Connection]:
        """Return the hand, what watches it, and the fork server, each made where it is missing."""
        server = self.server or self.start()
        if self.hand is None or self.lookout is None:
            self.hand, theirs = Pipe()
            with theirs:
                send_handle(server, theirs.fileno(), self.family.server)
                number = int(self._word_of(server))
            limits = self.limits.call, self.limits.memory, self.memory_at_first
            self.lookout = Lookout(self.board, number, self.family, *limits)
            self.output.forget()
        return self.hand, self.lookout, server

    def _watch(self, hand: Connection, lookout: Lookout, server: Connection) -> Fate | None:
        """Wait until the hand has done its job, has ended, or has to be ended."""
        listened, next_look = [hand, server], time.monotonic() + LOOK
        while True:
            ready = self._wait(listened)
            if server in ready:
                fate = Fate(Status.CRASHED, how_it_ended("the process", int(server.recv_bytes())) + self._quoted())
                self._clear_up()
                return fate
            if hand in ready:
                word = self._heard(hand)
                if DONE in word:
                    return None
                if not word:
                    listened.remove(hand)  # an engine may close what it likes: how the hand ends is what counts
            if time.monotonic() >= next_look:
                next_look = time.monotonic() + LOOK
                if (excess := lookout.too_long() or lookout.too_large()) is not None:
                    fate = Fate(excess.status, excess.text + self._quoted())
                    self.dismiss()
                    return fate

    @staticmethod
    def _heard(hand: Connection) -> bytes:
        try:
            return os.read(hand.fileno(), 64)
        except OSError:
            return b""

    def dismiss(self) -> None:
        """End the hand, if there is one, and all that it started."""
        if self.lookout is not None and self.server is not None:
            with suppress(ProcessLookupError):
                os.kill(self.lookout.hand, signal.SIGKILL)
            try:
                self._word_of(self.server)
            except (EOFError, OSError):
                self.end()
        self._clear_up()

    def _clear_up(self) -> None:
        """End what a hand has left."""
        if self.hand is not None:
            self.hand.close()
        self.hand = self.lookout = None
        self.family.end_strangers()

    def end(self) -> None:
        """End everything below this process."""
        if self.server is not None:
            self.server.close()
        self.server = None
        self._clear_up()
        end_all_below((os.getpid(),))

    # -- waiting ---------------------------------------------------------------------------------------------

    def _word_of(self, server: Connection) -> bytes:
        """Wait for the next that the fork server says."""
        deadline = time.monotonic() + TELLING
        while server not in self._wait([server]):
            if time.monotonic() > deadline:
                raise OSError("the fork server is silent")
        return server.recv_bytes()

    def _wait(self, connections: list[Connection]) -> list[Connection]:
        """Wait a moment for something to read, and see to the engine's output and to the parent all the while."""
        self.board.beat[0] += 1
        ready = self._readable([*connections, self.output], LOOK)
        return [c for c in connections if c in ready]

    def _readable(self, sources: list[Connection | Output], seconds: float) -> list[Connection | Output]:
        """Those of several sources that can be read, or have ended, as soon as there is one.

        Raises
        ------
        ParentLeft
            When the parent has closed the connection, or ended.
        """
        poll = select.poll()
        poll.register(self.parent.fileno(), 0)  # no events: its end is told all the same
        for source in sources:
            poll.register(source.fileno(), select.POLLIN)
        ready = dict(poll.poll(seconds * 1000))
        if ready.get(self.parent.fileno(), 0) & ENDED or os.getppid() != self.above:
            raise ParentLeft
        if self.output.reading in ready:
            self.output.drain()
        return [source for source in sources if source.fileno() in ready]

    def idle(self) -> bool:
        """Wait a moment for a job while there is nothing to do; whether there is one."""
        return self.parent in self._readable([self.parent, self.output], IDLE_LOOK)

    def rest(self) -> None:
        """Begin to watch a hand that has nothing to do."""
        if self.lookout is not None:
            self.lookout.reset()

    def left_behind(self) -> str:
        """Say what the hand keeps going while it has nothing to do, if anything."""
        if self.lookout is None:
            return ""
        excess = self.lookout.too_large()
        return self.lookout.left_behind() if excess is None else excess.text

    def _quoted(self) -> str:
        """What was printed last."""
        words = self.output.last_words()
        return f": {words}" if words else ""


def how_it_ended(what: str, code: int) -> str:
    """Say how a process ended whose exit status this is, or minus the signal that ended it."""
    if code >= 0:
        return f"{what} ended with exit status {code}"
    names = {number.value: number.name for number in signal.Signals}
    return f"{what} was ended by {names.get(-code, f'signal {-code}')} ({signal.strsignal(-code)})"
