"""The report where GitHub shows it: appended to the file that ``GITHUB_STEP_SUMMARY`` names."""

from __future__ import annotations

import os
from pathlib import Path

from oracles.outcome import Run
from reports import markdown

VARIABLE = "GITHUB_STEP_SUMMARY"
LIMIT = 1024 * 1024
"""Bytes of a step's summary, whatever else wrote to it; GitHub shows nothing of a longer one."""


def append(run: Run) -> str:
    """Append the report to the step's summary, where there is one; returns a sentence on what failed, else nothing."""
    name = os.environ.get(VARIABLE)
    if not name:
        return ""
    path = Path(name)
    try:
        there = path.stat().st_size if path.exists() else 0
        said = markdown.render(run, LIMIT - there - 1)
        if not said:
            return f"the step's summary is full: {there} bytes of {LIMIT}"
        with path.open("a", encoding="utf-8", errors="backslashreplace", newline="\n") as file:
            file.write(("\n" if there else "") + said)
    except OSError as error:
        return f"the step's summary cannot be written: {error.strerror or error}"
    return ""
