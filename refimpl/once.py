"""Each kernel is compiled by one process: whoever needs it meanwhile waits, and then reads what that one has kept.

A campaign starts many processes at once. Without this each of them would compile the same kernels, for a minute.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

if sys.platform != "win32":
    import fcntl

PATIENCE = 120.0
"""Seconds after which a process no longer waits for another, which may have been stopped, and compiles for itself."""
LOOK = 0.02

_in_this_process = threading.RLock()
"""Taken before any file's lock, as numba compiles in one thread at a time and holds a lock of its own meanwhile."""
_held: set[Path] = set()


def compiled_once(kernel: Any, folder: Path) -> None:
    """Have a kernel (a dispatcher of numba) look for what others have kept, and compile, in one process at a time.

    A kernel's lock is held while those that it calls are compiled. They never call it, so no two processes can wait
    for each other.
    """
    compiling: Callable[[Any], Any] = kernel.compile
    path = folder / f"{kernel.__module__}.{kernel.__name__}.lock"

    def compiling_alone(signature: Any) -> Any:
        with alone(path):
            return compiling(signature)

    kernel.compile = compiling_alone


@contextmanager
def alone(path: Path, patience: float = PATIENCE) -> Iterator[None]:
    """Hold the lock of a file, which ends with the process if it is killed.

    Where there are no such locks, or the file cannot be made, or another process holds it for longer than `patience`
    seconds, go on without.
    """
    with _in_this_process:
        if path in _held:
            yield
            return
        descriptor = _locked(path, patience)
        _held.add(path)
        try:
            yield
        finally:
            _held.remove(path)
            if descriptor is not None:
                os.close(descriptor)


def _locked(path: Path, patience: float) -> int | None:
    """Descriptor of the file, locked; None without a lock."""
    if sys.platform == "win32":
        return None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError:
        return None
    end = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if isinstance(error, BlockingIOError) and time.monotonic() < end:
                time.sleep(LOOK)
                continue
            os.close(descriptor)
            return None
        return descriptor
