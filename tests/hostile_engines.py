"""An engine that does its process whatever harm a scene asks for: the first coordinate of A is the number of a trick.

Other scenes, with a negative coordinate, are innocent; those under −100 also raise unless their process is as fresh as
at the start.
"""

from __future__ import annotations

import ctypes
import decimal
import gc
import itertools
import locale
import mmap
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from oracles.engine import AnswerRow, Kind, Row, Solver, answer_row
from tests.wrong_engines import Honest, ball_ball, of_query

FE_TONEAREST, FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO = 0x0, 0x400, 0x800, 0xC00
SPARE_MEMORY = 1500 << 20
"""A leak ends by itself here, should nobody end it."""
TRICKS: dict[str, Callable[[AnswerRow], Any]] = {}


def trick(function: Callable[[AnswerRow], Any]) -> Callable[[AnswerRow], Any]:
    TRICKS[function.__name__] = function
    return function


def number_of(name: str) -> float:
    return 1000.0 + list(TRICKS).index(name)


class Hostile(Honest):
    """Right, but for the tricks."""

    name: ClassVar[str] = "hostile"

    def solver(self, query: str, A: Kind, B: Kind) -> Solver:
        self.require(query, A, B)
        names = list(TRICKS)

        def solve(a: Row, b: Row) -> Any:
            if a[0] < -100:
                require_freshness()
            answer = answer_row(**of_query(query, ball_ball(a, b)))
            return TRICKS[names[int(a[0]) - 1000]](answer) if a[0] >= 1000 else answer

        return solve


def require_freshness() -> None:
    """Raise unless what later scenes could suffer from is as it was."""
    found = {
        "rounding": ctypes.CDLL(None).fegetround() == FE_TONEAREST,
        "tiny numbers": float("1e-310") * float("0.5") > 0,
        "numpy": np.geterr()["divide"] == "warn",
        "decimal": decimal.getcontext().prec == 28,
        "locale": locale.localeconv()["decimal_point"] == ".",
        "folder": os.getcwd() == HOME,
        "recursion": sys.getrecursionlimit() >= 1000,
        "streams": sys.stdout is not None,
        "collector": gc.isenabled(),
        "timer": signal.getitimer(signal.ITIMER_REAL)[0] == 0,
        "warnings": ("error", None, Warning, None, 0) not in warnings.filters,
        "descriptors": all(os.fstat(n) for n in range(3)),
    }
    stale = [name for name, fresh in found.items() if not fresh]
    if stale:
        raise RuntimeError(f"not fresh: {', '.join(stale)}")


HOME = os.getcwd()

# -- ends its process ----------------------------------------------------------------------------------------


@trick
def kills_itself(_: AnswerRow) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@trick
def sends_itself_a_nameless_signal(_: AnswerRow) -> None:
    os.kill(os.getpid(), signal.SIGRTMIN + 5)


@trick
def kills_its_group(_: AnswerRow) -> None:
    os.killpg(0, signal.SIGKILL)


@trick
def kills_its_parent(_: AnswerRow) -> None:
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(60)


@trick
def aborts(_: AnswerRow) -> None:
    os.abort()


@trick
def reads_at_zero(_: AnswerRow) -> None:
    ctypes.string_at(0)


@trick
def overflows_the_stack(_: AnswerRow) -> None:
    callback = ctypes.CFUNCTYPE(None)

    def deeper() -> None:
        callback(deeper)()

    sys.setrecursionlimit(1 << 30)
    deeper()


@trick
def leaves_at_once(_: AnswerRow) -> None:
    os._exit(0)


@trick
def leaves(_: AnswerRow) -> None:
    sys.exit(0)


@trick
def leaves_with_words(_: AnswerRow) -> None:
    sys.exit("so long")


@trick
def rubbish_then_abort(_: AnswerRow) -> None:
    os.write(1, bytes(range(256)) * 40 + b"\x1b[31m\x1b]0;title\x07\x1b[2J\n")
    os.abort()


# -- does not end --------------------------------------------------------------------------------------------


@trick
def stops_itself(answer: AnswerRow) -> AnswerRow:
    os.kill(os.getpid(), signal.SIGSTOP)
    return answer


@trick
def sleeps(_: AnswerRow) -> None:
    time.sleep(3600)


@trick
def spins(_: AnswerRow) -> None:
    while True:
        pass


@trick
def waits_for_a_lock(_: AnswerRow) -> None:
    lock = threading.Lock()
    lock.acquire()
    signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 32))
    while True:
        lock.acquire(timeout=3600)


@trick
def endless_text(_: AnswerRow) -> object:
    class Endless(list[float]):
        def __iter__(self) -> Iterator[float]:
            return itertools.repeat(0.5)

    return Endless([0.5])


@trick
def endless_float(_: AnswerRow) -> object:
    class Slow:
        def __float__(self) -> float:
            while True:
                pass

    return [Slow()] * 27


@trick
def takes_its_time(answer: AnswerRow) -> AnswerRow:
    time.sleep(1)
    return answer


@trick
def takes_until_it_is_killed(answer: AnswerRow) -> AnswerRow:
    """So long that whoever is to kill it in time does, however slow the machine."""
    time.sleep(40)
    return answer


# -- raises --------------------------------------------------------------------------------------------------


class UnspeakableError(Exception):
    def __str__(self) -> str:
        raise ZeroDivisionError


class LongError(Exception):
    def __str__(self) -> str:
        return "long " * 2_000_000


def raising(error: BaseException) -> Callable[[AnswerRow], None]:
    def raises(_: AnswerRow) -> None:
        raise error

    return raises


TRICKS |= {
    f"raises_{type(error).__name__}": raising(error)
    for error in (
        BaseException("bare"),
        KeyboardInterrupt("pressed"),
        GeneratorExit("generated"),
        MemoryError("full"),
        UnspeakableError(),
        LongError(),
        StopIteration(1),
        BaseExceptionGroup("many", [KeyboardInterrupt(), ValueError()]),
    )
}


@trick
def recurses(answer: AnswerRow) -> Any:
    return recurses(answer)


# -- answers nonsense ----------------------------------------------------------------------------------------


class Complaining(list[float]):
    def __len__(self) -> int:
        raise OSError("no length")

    def __iter__(self) -> Iterator[float]:
        raise OSError("no numbers")

    def __repr__(self) -> str:
        raise OSError("no text")


class Unfloatable:
    def __float__(self) -> float:
        raise KeyboardInterrupt

    def __repr__(self) -> str:
        raise SystemError


def answering(value: Any) -> Callable[[AnswerRow], Any]:
    return lambda _: value


NONSENSE: dict[str, tuple[Any, str]] = {
    "none": (None, "answered None"),
    "text": ("far away", "answered 'far away'"),
    "long_text": ("far " * 1_000_000, "answered a str of 4000000, not 27 numbers"),
    "dict": ({"distance": 1.0}, "answered {'distance': 1.0}"),
    "number": (1.0, "answered 1.0"),
    "true": (True, "answered True"),
    "complex": ([1j] * 27, "answered [1j, 1j"),
    "nested": ([[1.0] * 3] * 9, "answered [[1.0, 1.0, 1.0]"),
    "deep": ([*[0.0] * 26, [[[[]]]]], "answered [0.0"),
    "matrix": (np.zeros((27, 1)), "answered an array of shape (27, 1) of float64"),
    "complex_array": (np.zeros(27, complex), "answered an array of shape (27,) of complex128"),
    "short_array": (np.zeros(3), "answered an array of shape (3,) of float64"),
    "scalar_array": (np.array(1.0), "answered an array of shape () of float64"),
    "million": ([0.5] * 1_000_000, "answered a list of 1000000, not 27 numbers"),
    "huge_int": ([10**400] * 27, "answered [1000000"),
    "unspeakable_int": ([10**5000] * 27, "answered a list whose text cannot be had"),
    "endless_generator": (itertools.repeat(0.5), "answered a repeat"),
    "complaining": (Complaining([0.5] * 27), "answered a Complaining"),
    "unfloatable": ([Unfloatable()] * 27, "answered a list whose text cannot be had"),
    "unfloatable_alone": (Unfloatable(), "answered a Unfloatable"),
    "a_type": (float, "answered a type"),
    "not_a_number": ([float("nan")] * 27, "answered distance = nan"),
}
TRICKS |= {f"answers_{name}": answering(value) for name, (value, _) in NONSENSE.items()}


# -- leaves something changed --------------------------------------------------------------------------------


def changing(change: Callable[[], object]) -> Callable[[AnswerRow], AnswerRow]:
    def changes(answer: AnswerRow) -> AnswerRow:
        change()
        return answer

    return changes


def flush_tiny_numbers() -> None:
    """Set the bits FTZ and DAZ of MXCSR by a few bytes of machine code: sub rsp,8; stmxcsr; or; ldmxcsr; ret."""
    code = bytes.fromhex("4883ec08 0fae1c24 810c2440800000 0fae1424 4883c408 c3")
    memory = mmap.mmap(-1, len(code), prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    memory.write(code)
    KEPT.append(memory)
    ctypes.CFUNCTYPE(None)(ctypes.addressof(ctypes.c_char.from_buffer(memory)))()


KEPT: list[Any] = []
CHANGES: dict[str, tuple[Callable[[], object], str]] = {
    "upward": (lambda: ctypes.CDLL(None).fesetround(FE_UPWARD), r"the rounding of numbers \(upward\)"),
    "downward": (lambda: ctypes.CDLL(None).fesetround(FE_DOWNWARD), r"the rounding of numbers \(downward\)"),
    "toward_zero": (lambda: ctypes.CDLL(None).fesetround(FE_TOWARDZERO), r"the rounding of numbers \(toward zero\)"),
    "flushing": (flush_tiny_numbers, r"the treatment of tiny numbers \(taken for zero\)"),
    "numpy": (lambda: np.seterr(all="raise"), "numpy's error state"),
    "decimal": (lambda: decimal.setcontext(decimal.Context(prec=3)), "the decimal context"),
    "folder": (lambda: os.chdir("/"), "the working directory"),
    "recursion": (lambda: sys.setrecursionlimit(200), r"the recursion limit \(200\)"),
    "stdout": (lambda: setattr(sys, "stdout", None), "the standard streams"),
    "collector": (gc.disable, "the garbage collector"),
    "warnings": (lambda: warnings.simplefilter("error"), "the filters of warnings"),
    "timer": (lambda: signal.setitimer(signal.ITIMER_REAL, 30.0), "a timer"),
    "closed": (lambda: os.closerange(0, 3), "a standard descriptor"),
    "redirected": (lambda: os.dup2(os.open("/dev/null", os.O_RDWR), 1), "a standard descriptor"),
}
TRICKS |= {f"changes_{name}": changing(change) for name, (change, _) in CHANGES.items()}
UNSEEN: dict[str, Callable[[], object]] = {
    "environment": lambda: os.environ.update(LD_PRELOAD="nowhere.so", PYTHONPATH="/nowhere"),
    "umask": lambda: os.umask(0o777),
    "sigterm": lambda: [signal.signal(s, signal.SIG_IGN) for s in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)],
    "sigchld": lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN),
    "all_descriptors": lambda: os.closerange(3, 4096),
    "modules": lambda: [sys.modules.pop(name) for name in list(sys.modules) if name.startswith("oracles")],
    "builtins": lambda: setattr(__builtins__, "len", None) if hasattr(__builtins__, "len") else None,
}
"""Changes that no later answer depends on."""
TRICKS |= {f"changes_{name}": changing(change) for name, change in UNSEEN.items()}


@trick
def writes_over_shared_memory(answer: AnswerRow) -> AnswerRow:
    for line in Path("/proc/self/maps").read_text().splitlines():
        if "memfd:proxyproof" in line:
            start, end = (int(word, 16) for word in line.split()[0].split("-"))
            ctypes.memset(start, 0x55, end - start)
    return answer


# -- starts others -------------------------------------------------------------------------------------------


@trick
def forks(answer: AnswerRow) -> AnswerRow:
    if not os.fork():
        time.sleep(3600)
    return answer


@trick
def forks_a_spinning_child(answer: AnswerRow) -> AnswerRow:
    if not os.fork():
        while True:
            pass
    return answer


@trick
def forks_a_daemon(answer: AnswerRow) -> AnswerRow:
    child = os.fork()
    if not child:
        os.setsid()
        if not os.fork():
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            os.closerange(0, 4096)
            time.sleep(3600)
        os._exit(0)
    os.waitpid(child, 0)
    return answer


@trick
def starts_a_program(answer: AnswerRow) -> AnswerRow:
    KEPT.append(subprocess.Popen(["sleep", "3600"], start_new_session=True, env={}))
    return answer


@trick
def forks_and_both_return(answer: AnswerRow) -> AnswerRow:
    os.fork()
    return answer


@trick
def forks_many(answer: AnswerRow) -> AnswerRow:
    for _ in range(100):
        if not os.fork():
            time.sleep(3600)
    time.sleep(3600)
    return answer


@trick
def a_thread_spins(answer: AnswerRow) -> AnswerRow:
    def spin() -> None:
        while True:
            pass

    threading.Thread(target=spin, daemon=True).start()
    return answer


# -- uses memory ---------------------------------------------------------------------------------------------


@trick
def leaks(answer: AnswerRow) -> AnswerRow:
    while len(KEPT) << 23 < SPARE_MEMORY:
        KEPT.append(bytearray(1 << 23))
        KEPT[-1][:: mmap.PAGESIZE] = bytes(len(KEPT[-1][:: mmap.PAGESIZE]))
    return answer


@trick
def leaks_in_a_child(answer: AnswerRow) -> AnswerRow:
    child = os.fork()
    if not child:
        leaks(answer)
        os._exit(0)
    os.waitpid(child, 0)
    return answer


@trick
def leaks_shared_memory(answer: AnswerRow) -> AnswerRow:
    memory = mmap.mmap(-1, SPARE_MEMORY)
    for start in range(0, SPARE_MEMORY, mmap.PAGESIZE):
        memory[start] = 1
    KEPT.append(memory)
    return answer


@trick
def asks_for_too_much(answer: AnswerRow) -> AnswerRow:
    KEPT.append(bytearray(SPARE_MEMORY))
    return answer


# -- speaks --------------------------------------------------------------------------------------------------


@trick
def floods(answer: AnswerRow) -> AnswerRow:
    text = b"\x1b[2Jno end of it\n" * 4096
    for _ in range((1 << 30) // len(text)):
        os.write(1, text)
        os.write(2, text[:100])
    return answer
