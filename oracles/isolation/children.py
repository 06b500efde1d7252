"""Asking in a process of its own, which may crash or hang: questions and answers are plain data.

The child gets the questions as lines of JSON and answers each with a line; when it is lost, the question at which it
was is lost with it, and another child is asked about the rest.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, BinaryIO

from oracles.isolation.child import LONGEST
from oracles.isolation.guarded import THREADS
from oracles.isolation.hands import how_it_ended
from oracles.isolation.lookout import PATIENCE
from oracles.isolation.processes import main_thread_time

BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from oracles.isolation.child import serve; serve()"
STARTING = 20.0
"""Seconds of processor that a child has to start and to import its engine."""
LARGEST = 1 << 26
"""Bytes of answers that are read of one child."""
MOST_LOST = 3
"""Children that may be lost by time, or before they were ready, until the rest is given up."""
MEMORY = 4 << 30
"""Bytes that a child may have beyond those of Python."""
READY = b"ready\n"
NO_ANSWER = "the engine's process printed something that is no answer"
NO_TIME = "no answer within"


@dataclass(frozen=True)
class Said:
    """What came back for one question: plain data, or in words why there is none."""

    answer: Any = None
    lost: str = ""


def ask_apart(maker: str, spec: str, questions: Sequence[Any], each: float) -> list[Said]:
    """Have some questions answered in a process of its own.

    Parameters
    ----------
    maker
        ``module:function`` of the project's own: makes an `Answerer` from `spec`, in the child.
    questions
        Plain data.
    each
        Seconds of processor for each question; a child that says nothing for so long is ended, and so is one that
        waits for several times as long.
    """
    found: list[Said] = []
    given_up = 0
    while len(found) < len(questions):
        answers, why, hopeless = _one_child(maker, spec, questions[len(found) :], each)
        found += answers
        given_up += hopeless
        left = len(questions) - len(found)
        if left:
            found.append(Said(lost=why))
        if given_up >= MOST_LOST:
            found += [Said(lost=f"not asked any more: {why}")] * (left - 1)
    return found


def _one_child(maker: str, spec: str, questions: Sequence[Any], each: float) -> tuple[list[Said], str, bool]:
    """Answers of one child, how it ended, and whether that was by time or before it was ready."""
    command = [sys.executable, "-c", BOOT, json.dumps(sys.path), maker, spec, str(os.getpid()), str(MEMORY)]
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as asked:
        asked.writelines(json.dumps(question).encode() + b"\n" for question in questions)
        asked.seek(0)
        environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
        with subprocess.Popen(
            command,
            stdin=asked,
            stdout=said,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,  # who interrupts the run does not mean the engine
        ) as child:
            try:
                why = _watched(child, said, each)
            finally:
                child.kill()
        said.seek(0)
        content = said.read(LARGEST)
    late = why.startswith(NO_TIME)
    return list(_read(content))[: len(questions)], why, late or not content.startswith(READY)


def _watched(child: subprocess.Popen[bytes], said: BinaryIO, each: float) -> str:
    """Wait for a child for as long as it goes on answering; give in words how it ended."""
    size, limit, since, used = 0, STARTING, time.monotonic(), 0.0
    while True:
        with suppress(subprocess.TimeoutExpired):
            return how_it_ended("the engine's process", child.wait(timeout=0.1))
        now, spent = os.fstat(said.fileno()).st_size, main_thread_time(child.pid)
        if now > LARGEST:
            return f"answers of more than {LARGEST >> 20} MiB"
        if now > size:
            size, limit, since, used = now, each, time.monotonic(), spent
        elif spent - used > limit or time.monotonic() - since > PATIENCE * limit:
            return f"{NO_TIME} {limit:g} s"


def _read(content: bytes) -> Iterator[Said]:
    """Whole lines of a child, as answers; the first one only says that it is ready."""
    for line in content.decode("utf-8", "replace").split("\n")[1:-1]:
        try:
            data = json.loads(line)
            yield Said(data["answer"], str(data["lost"])[:LONGEST])
        except (ValueError, LookupError, TypeError, RecursionError):
            yield Said(lost=NO_ANSWER)
