"""Where tasks are done: in this process, by a crew of processes, or on a Dask cluster.

A campaign runs on any `concurrent.futures.Executor`. The crew is one that loses a process without loss: a pool of the
standard library breaks as a whole when one of its processes is killed.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.reduction import ForkingPickler
from queue import SimpleQueue
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

TRIES = 3
"""Processes that one task may cost before it is given up."""

THREADS = ("PROXYPROOF_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""A process of a crew keeps to one processor: the others have theirs."""

SPAWN = multiprocessing.get_context("spawn")
"""Nothing is inherited: neither threads, nor locks, nor open files."""


class WorkerLost(RuntimeError):
    """A task has lost its process again and again."""


class Here(Executor):
    """Does each task at once, in this process."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Do it, and return what is done; an interrupt is not caught."""
        future: Future[T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # belongs to the future
            future.set_exception(error)
        return future


@dataclass
class _Job:
    future: Future[Any]
    call: tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]


@dataclass
class _Hand:
    """A process of a crew, started when there is work for it."""

    process: multiprocessing.process.BaseProcess | None = None
    connection: Connection | None = None
    dismissed: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)

    def do(self, call: object) -> tuple[bool, Any]:
        """Have the process make a call: whether it returned, and what it returned or raised.

        Raises
        ------
        EOFError, OSError
            When the process has ended.
        """
        with self.lock:
            if self.dismissed:
                raise EOFError
            if self.process is None:
                self.connection, theirs = SPAWN.Pipe()
                self.process = SPAWN.Process(target=_serve, args=(theirs,), name="proxyproof worker", daemon=True)
                self.process.start()
                theirs.close()
        assert self.connection is not None
        self.connection.send(call)
        answer: tuple[bool, Any] = self.connection.recv()
        return answer

    def bury(self) -> int | None:
        """Forget a process that has ended, and say how; the next call starts another."""
        process, connection = self.process, self.connection
        self.process = self.connection = None
        if process is None or connection is None:
            return None
        connection.close()
        process.kill()
        process.join()
        return process.exitcode

    def dismiss(self) -> None:
        """End the process, whatever it is doing; from any thread."""
        with self.lock:
            self.dismissed = True
            if self.process is not None:
                self.process.kill()


class Crew(Executor):
    """Processes that each do one task at a time.

    One that ends in the middle of a task, by kill −9 for instance, costs nothing but the time: another takes its
    place and the task, which is given up only when it has cost `TRIES` processes.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._hands = [_Hand() for _ in range(size)]
        self._threads = [threading.Thread(target=self._lead, args=(hand,), daemon=True) for hand in self._hands]
        for thread in self._threads:
            thread.start()

    @property
    def processes(self) -> list[int]:
        """Numbers of the processes that there are at this moment."""
        return [hand.process.pid for hand in self._hands if hand.process is not None and hand.process.pid]

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Put a task at the end of the queue."""
        future: Future[T] = Future()
        self._jobs.put(_Job(future, (fn, args, kwargs)))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes: after their tasks, or at once when futures are to be cancelled."""
        if cancel_futures:
            for hand in self._hands:
                hand.dismiss()
        for _ in self._threads:
            self._jobs.put(None)
        if wait:
            for thread in self._threads:
                thread.join()

    def _lead(self, hand: _Hand) -> None:
        """Give one process its tasks, until there are no more."""
        while (job := self._jobs.get()) is not None:
            if hand.dismissed:
                job.future.cancel()
            if job.future.set_running_or_notify_cancel():
                self._do(job, hand)
        if hand.connection is not None:
            hand.connection.close()  # the process ends its engines and itself
        if hand.process is not None:
            hand.process.join()

    @staticmethod
    def _do(job: _Job, hand: _Hand) -> None:
        ends = []
        for _ in range(TRIES):
            try:
                returned, value = hand.do(job.call)
            except (EOFError, OSError):
                ends.append(hand.bury())
                if hand.dismissed:
                    break
                continue
            except Exception as error:  # a call or an answer that cannot be sent
                returned, value = False, error
            if returned:
                job.future.set_result(value)
            else:
                job.future.set_exception(value)
            return
        job.future.set_exception(WorkerLost(f"its process ended {len(ends)} times, with exit status {ends}"))


def room(executor: Executor) -> int:
    """How many tasks an executor should have at once: one for each worker, and one that waits."""
    if isinstance(executor, Here):
        return 1
    size = getattr(executor, "size", None) or os.cpu_count() or 1
    return int(size) + 1


def _serve(connection: Connection) -> None:
    """Make the calls that come, in a process of a crew."""
    os.environ.update(dict.fromkeys(THREADS, "1"))  # before anything that has threads is imported
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the campaign, which then ends this process
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            function, args, kwargs = connection.recv()
            try:
                answer = ForkingPickler.dumps((True, function(*args, **kwargs)))
            except Exception as error:  # belongs to the future
                answer = ForkingPickler.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
            connection.send_bytes(answer)


def _end_with_parent() -> None:
    """Leave no orphan: whatever this process is doing, it ends when the campaign's does."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)
