"""What Linux tells of processes (their memory, time and children), and how to end them all.

Elsewhere nothing is told: the lists are empty, and the times are NaN, which is no small number.
"""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

LINUX = sys.platform == "linux"
PAGE = os.sysconf("SC_PAGE_SIZE")
TICK = 1.0 / os.sysconf("SC_CLK_TCK")
PR_SET_PDEATHSIG = 1
PR_SET_CHILD_SUBREAPER = 36
NAN = float("nan")


@dataclass(frozen=True)
class Process:
    """One process as it is now."""

    number: int
    ended: bool
    """A zombie: it only waits for its parent to take note."""
    processor: float
    """Seconds of processor, of all its threads."""
    memory: int
    """Bytes that are resident."""


def process(number: int) -> Process | None:
    """Return what is known of a process; None when there is none."""
    fields = _stat(f"/proc/{number}/stat")
    if fields is None:
        return None
    return Process(number, fields[0] in "ZX", (int(fields[11]) + int(fields[12])) * TICK, int(fields[21]) * PAGE)


def main_thread_time(number: int) -> float:
    """Seconds of processor that the main thread of a process has used: what it left running does not count."""
    fields = _stat(f"/proc/{number}/task/{number}/stat")
    return NAN if fields is None else (int(fields[11]) + int(fields[12])) * TICK


def _stat(path: str) -> list[str] | None:
    """Fields behind the name, which may hold anything."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stat:
            fields = stat.read().rpartition(")")[2].split()
    except OSError:
        return None
    return fields if len(fields) > 21 else None


def children(number: int) -> list[int]:
    """Return the children of a process."""
    found: list[int] = []
    with suppress(OSError):
        for thread in os.listdir(f"/proc/{number}/task"):
            with suppress(OSError), open(f"/proc/{number}/task/{thread}/children", encoding="ascii") as told:
                found += map(int, told.read().split())
    return found


def below(roots: Iterable[int], spared: Collection[int] = ()) -> Iterator[Process]:
    """Give all processes below some, but neither those spared nor what is below them."""
    for root in roots:
        for child in children(root):
            if child not in spared and (known := process(child)) is not None:
                yield known
                yield from below((child,), spared)


def end_all_below(roots: Collection[int], spared: Collection[int] = (), patience: float = 5.0) -> None:
    """End all processes below some, and take note of those that are this process's own by now.

    Of a process that ends, the children become those of the nearest process above that adopts orphans
    (`adopt_orphans`), where the next round finds them.
    """
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        found = [p.number for p in below(roots, spared) if not p.ended]
        for one in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(one, signal.SIGKILL)
        for child in children(os.getpid()):
            if child not in spared:
                with suppress(ChildProcessError):
                    os.waitpid(child, os.WNOHANG)
        if not found:
            return
        time.sleep(0.001)


def adopt_orphans() -> None:
    """Make this process the parent of every process below it whose own parent ends."""
    if LINUX:
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)


def end_with(parent: int) -> None:
    """Have this process killed when its parent ends, even if it hangs by then; at once if that has ended."""
    if LINUX:
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def accept_limits(memory: int) -> None:
    """Have this process refused more than so many bytes beyond what it has, and leave no core behind."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with suppress(OSError, ValueError), open("/proc/self/statm", encoding="ascii") as told:
        most = int(told.read().split()[5]) * PAGE + memory
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    with suppress(OSError), open("/proc/self/oom_score_adj", "w", encoding="ascii") as score:
        score.write("1000")  # where memory runs out all the same, whoever else uses this machine is to live longer


def end_marked(mark: str, patience: float = 5.0) -> None:
    """End all processes that were started with this text in their environment, whoever their parent is by now."""
    deadline = time.monotonic() + patience
    while (found := marked(mark)) and time.monotonic() < deadline:
        for one in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(one, signal.SIGKILL)
        time.sleep(0.001)


def marked(mark: str) -> list[int]:
    """Return the processes, this one apart, that were started with this text in their environment."""
    text, found = mark.encode(), []
    for entry in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            if text in entry.read_bytes() and int(entry.parent.name) != os.getpid():
                found.append(int(entry.parent.name))
    return found
