"""Ctrl-C and SIGTERM come at any moment: within a block that must be whole they wait until its end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

STOPS = (signal.SIGINT, signal.SIGTERM)
"""Only the main thread gets them."""


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
    """Let the first of them raise KeyboardInterrupt, and those after it have no effect: the end is under way."""

    def stop(number: int, _: FrameType | None) -> None:
        for other in STOPS:
            signal.signal(other, signal.SIG_IGN)
        raise KeyboardInterrupt(signal.Signals(number).name)

    with _handled(stop):
        yield


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
