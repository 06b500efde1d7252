"""Signals that end a run: none is lost, and none comes between when the end is under way."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress

import pytest

from oracles import interrupts
from oracles.interrupts import held, ignored, one_stop


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "AGAIN", 0.02)


def send() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def linger(seconds: float = 5.0) -> None:
    """Wait as an engine's answer is waited for: until something is raised."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.005)


def test_an_interrupt_that_a_library_catches_comes_again() -> None:
    """As some packages do around the import of another one."""

    def interrupted() -> None:
        with one_stop():
            with suppress(BaseException):
                send()
                linger()
            linger()
            pytest.fail("it was lost")

    with pytest.raises(KeyboardInterrupt):
        interrupted()


def test_one_that_was_made_another_exception_comes_again() -> None:
    def interrupted() -> None:
        with one_stop():
            with suppress(RuntimeError):
                try:
                    send()
                    linger()
                except BaseException as error:
                    raise RuntimeError from error
            linger()
            pytest.fail("it was lost")

    with pytest.raises(KeyboardInterrupt):
        interrupted()


def test_nothing_comes_between_while_the_end_is_under_way() -> None:
    ended = False

    def interrupted() -> None:
        nonlocal ended
        with one_stop():
            try:
                send()
                linger()
            finally:
                send()  # a person presses twice
                linger(0.1)  # and it comes again by itself
                ended = True

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert ended


def test_nothing_comes_while_what_was_found_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "AGAIN", 0.3)
    with one_stop():
        with suppress(KeyboardInterrupt):
            send()
            linger()
        with ignored():
            linger(0.4)


def test_nothing_comes_after_the_end() -> None:
    with suppress(KeyboardInterrupt), one_stop():
        send()
        linger()
    linger(0.1)


def test_one_that_comes_in_a_whole_block_takes_effect_at_its_end() -> None:
    whole = False

    def interrupted() -> None:
        nonlocal whole
        with one_stop():
            with held():
                send()
                linger(0.1)
                whole = True
            linger()

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert whole
