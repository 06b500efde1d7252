"""Asking a broad phase in a process of its own, which may crash or hang.

The child gets the crowds as lines of JSON and answers each with a line; when it is lost, the crowd at which it was is
lost with it, and another child is asked about the rest.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from oracles.crowds.boxes import BoxCrowd, Pair
from oracles.engines import load_engine
from oracles.isolation.guarded import THREADS
from oracles.isolation.hands import how_it_ended

BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from oracles.crowds.asking import answer; answer()"
STARTING = 20.0
"""Seconds that a child has to start and import its engine."""
EACH = 5.0
"""Seconds for each crowd, on average over those that are asked together."""
LARGEST = 1 << 26
"""Bytes of answers that are read."""


@dataclass(frozen=True)
class Answer:
    """What an engine said of one crowd: pairs i < j, or in words why there are none; and the nearest pair."""

    pairs: frozenset[Pair] = frozenset()
    lost: str = ""
    nearest: Pair | None = None


def ask(spec: str, crowds: Sequence[BoxCrowd]) -> list[Answer]:
    """Have the engine of this name or address answer some crowds."""
    found: list[Answer] = []
    while len(found) < len(crowds):
        answers, why = _one_child(spec, crowds[len(found) :])
        found += answers
        if why:
            found.append(Answer(lost=why))
    return found


def _one_child(spec: str, crowds: Sequence[BoxCrowd]) -> tuple[list[Answer], str]:
    """Answers of one child, and how it was lost before it had answered everything."""
    command = [sys.executable, "-c", BOOT, json.dumps(sys.path), spec]
    lines = "".join(json.dumps(crowd.to_json()) + "\n" for crowd in crowds)
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as asked:
        asked.write(lines.encode())
        asked.seek(0)
        limit = STARTING + EACH * len(crowds)
        try:
            child = subprocess.run(
                command,
                stdin=asked,
                stdout=said,
                stderr=subprocess.DEVNULL,
                timeout=limit,
                env={**os.environ, **dict.fromkeys(THREADS, "1")},
                check=False,
            )
            why = how_it_ended("the engine's process", child.returncode)
        except subprocess.TimeoutExpired:
            why = f"no answer within {limit:g} s"
        said.seek(0)
        answers = list(_read(said.read(LARGEST), crowds))
    return answers, why if len(answers) < len(crowds) else ""


def _read(content: bytes, crowds: Sequence[BoxCrowd]) -> Iterator[Answer]:
    """Whole lines of a child, as answers."""
    for line, crowd in zip(content.decode("utf-8", "replace").split("\n")[:-1], crowds, strict=False):
        try:
            data = json.loads(line)
            pairs = frozenset((int(i), int(j)) for i, j in data["pairs"])
            lost = str(data["lost"])[:500]
            nearest = _nearest(data["nearest"], len(crowd))
        except (ValueError, LookupError, TypeError):
            yield Answer(lost="the engine's process printed something that is no answer")
            continue
        inside = all(0 <= i < j < len(crowd) for i, j in pairs)
        yield Answer(pairs, lost, nearest) if inside else Answer(lost="a pair of bodies that are none")


def _nearest(data: Any, count: int) -> Pair | None:
    if data is None:
        return None
    i, j = (int(number) for number in data)
    if not (0 <= i < count and 0 <= j < count and i != j):
        raise ValueError("no pair of bodies")
    return i, j


def answer() -> None:
    """Be the child: answer the crowds on standard input; what the engine prints goes elsewhere."""
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    solver = load_engine(sys.argv[2]).broad_phase()
    for line in sys.stdin:
        crowd = BoxCrowd.from_json(json.loads(line))
        said: dict[str, object] = {"pairs": [], "lost": "", "nearest": None}
        try:
            if solver is None:
                raise LookupError("the engine has no broad phase that is asked")  # noqa: TRY301
            said["pairs"] = sorted({(min(pair), max(pair)) for pair in solver.pairs(crowd) if pair[0] != pair[1]})
            said["nearest"] = solver.nearest(crowd.thinned())
        except Exception as error:  # whatever an engine raises is its answer
            said["lost"] = f"{type(error).__name__}: {error}"
        print(json.dumps(said), file=out, flush=True)
