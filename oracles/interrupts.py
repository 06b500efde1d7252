"""Ctrl-C and SIGTERM come at any moment: within a block that must be whole they wait until its end."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

STOPS = (signal.SIGINT, signal.SIGTERM)
"""Only the main thread gets them."""
AGAIN = 1.0
"""Seconds after which one that has had no effect comes again."""


@contextmanager
def held() -> Iterator[None]:
    """Let signals that end the run take effect at the end of the block."""
    came: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        came.append(number)

    with _handled(note):
        yield
    if came:
        signal.raise_signal(came[0])


@contextmanager
def ignored() -> Iterator[None]:
    """Let them have no effect: what was found is being written, which takes a second."""
    with _handled(signal.SIG_IGN):
        yield


@contextmanager
def one_stop() -> Iterator[None]:
    """Let the first of them raise KeyboardInterrupt; while that is on its way out, those after it have no effect.

    Some libraries catch whatever comes while they import what they can do without, and the exception is lost. So the
    signal comes again and again until the block ends, and raises wherever nothing is on its way.
    """
    again: list[threading.Timer] = []
    over = False

    def stop(number: int, _: FrameType | None) -> None:
        if over:
            return
        for timer in again:
            timer.cancel()
        again[:] = [threading.Timer(AGAIN, os.kill, (os.getpid(), number))]
        again[0].daemon = True
        again[0].start()
        if not _on_its_way(sys.exc_info()[1]):
            raise KeyboardInterrupt(signal.Signals(number).name)

    with _handled(stop):
        try:
            yield
        finally:
            over = True
            for timer in again:
                timer.cancel()
                timer.join()


def _on_its_way(error: BaseException | None) -> bool:
    """Whether a KeyboardInterrupt is being handled, or an exception that came of one."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


@contextmanager
def remembered() -> Iterator[list[int]]:
    """Keep what came: where an exception meets a callback, of the garbage collector for instance, it is lost.

    The list within the block is to be looked at now and then; whatever is in it at the end raises KeyboardInterrupt.
    """
    came: list[int] = []
    handlers: dict[int, Any] = {number: signal.getsignal(number) for number in STOPS}
    raising = [number for number in STOPS if callable(handlers[number])]

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)
        handlers[number](number, frame)

    with _handled(note, raising):
        yield came
    if came:
        raise KeyboardInterrupt(signal.Signals(came[0]).name)


@contextmanager
def _handled(handler: Any, numbers: Sequence[signal.Signals] = STOPS) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old if old is not None else signal.SIG_DFL)
