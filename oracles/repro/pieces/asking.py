"""The engine's answer: asked for in a process of its own, or given."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec

Answer = dict[str, float | list[float]]


def told(lines: Sequence[str], names: Sequence[str]) -> Answer:
    """Read an answer from lines such as ``distance = 3.0``; what is nan is not said."""
    found: Answer = {}
    for line in lines:
        name, equals, text = line.partition(" = ")
        if equals and name.strip() in names:
            values = [float(value) for value in text.strip().strip("[]()").split(",")]
            if not all(math.isnan(value) for value in values):
                found[name.strip()] = values if len(values) > 1 else values[0]
    return found


def asked(file: str, question: str, limit: float, names: Sequence[str]) -> tuple[Answer, str]:
    """Run the part of this file that asks the engine; gives its answer, or says why there is none."""
    isolated = ["-I"] if sys.flags.isolated else []
    command = [sys.executable, *isolated, file, question]
    try:
        ran = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return {}, f"no answer within {limit:g} seconds: its process was ended"
    lines = ran.stdout.splitlines()
    answer = told(lines, names)
    for line in lines:
        if line.partition(" = ")[0].strip() not in answer:
            print(" ", line)
    if ran.returncode < 0:
        return {}, f"its process ended with signal {-ran.returncode} ({signal.strsignal(-ran.returncode)})"
    if ran.returncode:
        errors = ran.stderr.strip().splitlines() or [f"exit status {ran.returncode}"]
        return {}, f"it raised an error: {errors[-1]}"
    return answer, "" if answer else "it answered nothing"


def missing(modules: Sequence[tuple[str, str]]) -> str:
    """Say which module is not installed, and how to get it; empty when all are there."""
    lacking = [f"{module} ({how})" for module, how in modules if find_spec(module) is None]
    return f"not installed: {', '.join(lacking)}" if lacking else ""
