"""What a call can leave changed in its process, to the harm of the calls after it.

Each scene is to be asked as the first one was: with numbers rounded to the nearest, with numpy's own error state,
with the decimal point of the locale. So the hand compares after each block of scenes, and when something differs,
sets it back and asks the block again, from then on comparing after every scene. An engine's answer is the one that
it gives in the state that it finds; what it does to that state *during* its call is its own affair, and so is what
it left changed when it was imported: every call of a user's program finds that too. What no later answer depends on
(environment, file mode mask, random numbers of its own) is not looked at.
"""

from __future__ import annotations

import ctypes
import decimal
import fcntl
import gc
import locale
import os
import signal
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

ONE, HALF, MORE, TINY = 1.0, 2.0**-53, 3 * 2.0**-54, 1e-310
"""One, a half and three quarters of the gap above it, and a number too small to have all its digits."""
ROUNDINGS = {
    (True, True, True): "to the nearest",
    (False, True, True): "upward",
    (True, False, False): "downward",
    (True, True, False): "toward zero",
}
TIMERS = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)
FENV_BYTES = 256
"""More than any system needs to keep the state of its floating-point unit."""
HIGH = 200
"""Copies of standard input, output and error have numbers from here on."""


def rounding() -> str:
    """How sums are rounded, as sums show."""
    shown = ONE + HALF == ONE, -ONE - HALF == -ONE, ONE + MORE > ONE
    return ROUNDINGS.get(shown, "in no known way")


def tiny_numbers() -> str:
    """Whether numbers under the smallest normal one are kept."""
    return "kept" if TINY * 0.5 > 0.0 else "taken for zero"


@dataclass(frozen=True)
class Aspect:
    """One thing that a call can leave changed."""

    name: str
    read: Callable[[], Any]
    write: Callable[[Any], object]
    shown: bool = False
    """Whether a value says something to a reader."""


class State:
    """The state of a process when this was made."""

    def __init__(self) -> None:
        self.aspects = aspects()
        self.readers = [aspect.read for aspect in self.aspects]
        self.first = [read() for read in self.readers]

    def restore(self) -> tuple[list[str], bool]:
        """Say what differs from the first state, set it back, and tell whether that went well."""
        if self._unchanged():
            return [], True
        found = self._different()
        for aspect, first, _ in found:
            with suppress(Exception):
                aspect.write(first)
        said = [f"{a.name} ({now})" if a.shown else a.name for a, _, now in found]
        return said, not (found and self._different())

    def _unchanged(self) -> bool:
        """Whether all is as it was: the usual case, and asked after every scene once a hand was lost."""
        try:
            return [read() for read in self.readers] == self.first
        except Exception:  # what cannot even be read
            return False

    def _different(self) -> list[tuple[Aspect, Any, Any]]:
        now = [_read(aspect) for aspect in self.aspects]
        return [
            (a, first, value) for a, first, value in zip(self.aspects, self.first, now, strict=True) if first != value
        ]


def _read(aspect: Aspect) -> object:
    try:
        return aspect.read()
    except Exception as error:  # no folder, no descriptor, no such locale: a state of its own
        return type(error).__name__


def aspects() -> list[Aspect]:
    """List what is compared."""
    units = _floating_point_unit()
    return [
        Aspect("the rounding of numbers", rounding, units, shown=True),
        Aspect("the treatment of tiny numbers", tiny_numbers, units, shown=True),
        Aspect("numpy's error state", np.geterr, lambda saved: np.seterr(**saved)),
        Aspect("the decimal context", _decimal_context, _to_context(decimal.getcontext().copy())),
        Aspect("the locale", lambda: locale.setlocale(locale.LC_ALL), lambda s: locale.setlocale(locale.LC_ALL, s)),
        Aspect("the working directory", os.getcwd, os.chdir),
        Aspect("the recursion limit", sys.getrecursionlimit, sys.setrecursionlimit, shown=True),
        Aspect("the filters of warnings", lambda: list(warnings.filters), _set_filters),
        Aspect("the garbage collector", gc.isenabled, lambda on: gc.enable() if on else gc.disable()),
        Aspect("a timer", lambda: [signal.getitimer(t)[0] > 0 for t in TIMERS], _stop_timers),
        Aspect("the standard streams", lambda: [sys.stdin, sys.stdout, sys.stderr], _set_streams),
        Aspect("a standard descriptor", _standard_files, _back_to(_copies())),
    ]


def _floating_point_unit() -> Callable[[Any], object]:
    """Keep the unit's state as it is now, and return what brings it back."""
    libc, kept = ctypes.CDLL(None), ctypes.create_string_buffer(FENV_BYTES)
    if not (hasattr(libc, "fegetenv") and hasattr(libc, "fesetenv")):
        return lambda _: None
    libc.fegetenv(kept)
    return lambda _: libc.fesetenv(kept)


def _decimal_context() -> tuple[object, ...]:
    c = decimal.getcontext()
    return c.prec, c.rounding, c.Emin, c.Emax, c.traps[decimal.Inexact], c.traps[decimal.Rounded]


def _to_context(kept: decimal.Context) -> Callable[[Any], None]:
    return lambda _: decimal.setcontext(kept.copy())


def _set_filters(saved: list[Any]) -> None:
    warnings.filters[:] = saved  # type: ignore[index]


def _stop_timers(_: object) -> None:
    for timer in TIMERS:
        signal.setitimer(timer, 0.0)


def _set_streams(saved: list[Any]) -> None:
    sys.stdin, sys.stdout, sys.stderr = saved


def _standard_files() -> list[tuple[int, int]]:
    return [(known.st_dev, known.st_ino) for known in map(os.fstat, range(3))]


def _copies() -> list[int]:
    return [fcntl.fcntl(one, fcntl.F_DUPFD_CLOEXEC, HIGH) for one in range(3)]


def _back_to(copies: list[int]) -> Callable[[Any], None]:
    def write(_: object) -> None:
        for number, copy in enumerate(copies):
            os.dup2(copy, number)

    return write
