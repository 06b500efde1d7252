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
from dataclasses import dataclass
from typing import Any, BinaryIO

from oracles.isolation.child import LONGEST
from oracles.isolation.guarded import THREADS
from oracles.isolation.hands import how_it_ended

BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from oracles.isolation.child import serve; serve()"
STARTING = 20.0
"""Seconds that a child has to start and to import its engine."""
LARGEST = 1 << 26
"""Bytes of answers that are read of one child."""
MOST_LOST = 3
"""Children that may be lost one after the other, none with an answer, before the rest is given up."""
NO_ANSWER = "the engine's process printed something that is no answer"


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
        Seconds for each question; a child that says nothing for so long is ended.
    """
    found: list[Said] = []
    idle = 0
    while len(found) < len(questions):
        answers, why = _one_child(maker, spec, questions[len(found) :], each)
        found += answers
        idle = 0 if answers else idle + 1
        found += [Said(lost=why)] * (bool(why) if idle < MOST_LOST else len(questions) - len(found))
    return found


def _one_child(maker: str, spec: str, questions: Sequence[Any], each: float) -> tuple[list[Said], str]:
    """Answers of one child, and how it was lost before it had answered everything."""
    command = [sys.executable, "-c", BOOT, json.dumps(sys.path), maker, spec]
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
        answers = list(_read(said.read(LARGEST)))[: len(questions)]
    return answers, why if len(answers) < len(questions) else ""


def _watched(child: subprocess.Popen[bytes], said: BinaryIO, each: float) -> str:
    """Wait for a child for as long as it goes on answering; give in words how it ended."""
    size, limit, since = 0, STARTING, time.monotonic()
    while True:
        try:
            return how_it_ended("the engine's process", child.wait(timeout=0.1))
        except subprocess.TimeoutExpired:
            now, before = os.fstat(said.fileno()).st_size, size
            if now > LARGEST:
                return f"answers of more than {LARGEST >> 20} MiB"
            if now > before:
                size, limit, since = now, each, time.monotonic()
            elif time.monotonic() - since > limit:
                return f"no answer within {limit:g} s"


def _read(content: bytes) -> Iterator[Said]:
    """Whole lines of a child, as answers; the first one only says that it is ready."""
    for line in content.decode("utf-8", "replace").split("\n")[1:-1]:
        try:
            data = json.loads(line)
            yield Said(data["answer"], str(data["lost"])[:LONGEST])
        except (ValueError, LookupError, TypeError, RecursionError):
            yield Said(lost=NO_ANSWER)
