"""Run every script of a report as a stranger would: ``python -m reports.repros DIR [--jobs N]``.

Each is executed by a fresh interpreter that sees nothing of this project (``python -I``, in an empty folder), and must
show what the report says: the engine's answer, the proven interval, the verdict, exit status 1. Exit status 0 when all
do, 1 with a line for each that does not, 2 when there is no report.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oracles.outcome import Bucket, Finding, Kind
from refimpl.proof import Certificate, SweepCertificate
from reports.findings import repro_file
from reports.reading import NoReport, bucket_from_data, read_report

PATIENCE = 120.0
"""Seconds for one script, which itself gives its engine 10."""


@dataclass(frozen=True)
class Ran:
    """One script that was run: its exit status, None if it did not end, and what it printed."""

    status: int | None
    printed: str


def run_script(script: Path, *arguments: str, variables: Mapping[str, str] | None = None) -> Ran:
    """Execute a script by itself; isolated, unless it is given environment variables."""
    isolated = ["-I"] if variables is None else []
    command = [sys.executable, *isolated, str(script.resolve()), *arguments]
    environment = {**os.environ, **(variables or {})}
    with tempfile.TemporaryDirectory() as empty:
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, cwd=empty, timeout=PATIENCE, check=False, env=environment
            )
        except subprocess.TimeoutExpired:
            return Ran(None, "")
    return Ran(done.returncode, done.stdout + done.stderr)


def differences(finding: Finding, ran: Ran) -> Iterator[str]:
    """In what a script that was run does not show its finding."""
    if ran.status != 1:
        yield "does not end" if ran.status is None else f"ends with status {ran.status}: {_last(ran.printed)}"
        return
    verdict = finding.verdict
    if verdict.kind is Kind.TIMED_OUT:
        wanted = ["no answer within", "no answer in time"]
        if not any(words in ran.printed for words in wanted):
            yield "does not show that the answer does not come in time"
    for line in _lines(finding):
        if line not in ran.printed:
            yield f"does not show {line.strip()!r}"


def _lines(finding: Finding) -> Iterator[str]:
    """What a script must print."""
    verdict, related = finding.verdict, finding.related
    for answer in (finding.answer, related.answer if related else {}):
        yield from (f"  {name} = {value!r}" for name, value in answer.items() if not _is_rubbish(value))
    if isinstance(verdict.certificate, Certificate) and related is None:
        yield from (repr(bound + 0.0) for bound in (verdict.lower, verdict.upper) if math.isfinite(bound))
    timed = isinstance(verdict.certificate, SweepCertificate) and verdict.kind is Kind.WRONG
    # of a sweep, the script shows the shapes at one time
    yield f"verdict: WRONG: {verdict.symptom if timed else ''}"
    if verdict.kind is Kind.WRONG and math.isfinite(verdict.amount) and verdict.amount > 0 and not timed:
        yield f", by at least {verdict.amount!r} "


def _is_rubbish(value: object) -> bool:
    """Whether an engine left its answer unset: what its memory held reads as tiny numbers, which change."""
    numbers = value if isinstance(value, list) else [value]
    return any(isinstance(x, float) and 0 < abs(x) < 1e-300 for x in numbers)


def _last(printed: str) -> str:
    lines = printed.strip().splitlines()
    return lines[-1][:300] if lines else "it printed nothing"


def faults(folder: Path, jobs: int) -> Iterator[tuple[str, list[str]]]:
    """Name of each script of a report, and in what it does not show what the report says."""
    entries: list[tuple[int, Bucket]] = []
    for number, data in enumerate(read_report(folder)["buckets"], 1):
        entries.append((number, bucket_from_data(data)))

    def one(entry: tuple[int, Bucket]) -> tuple[str, list[str]]:
        name = repro_file(*entry)
        if not (folder / name).is_file():
            return name, ["is missing"]
        return name, list(differences(entry[1].witness, run_script(folder / name)))

    with ThreadPoolExecutor(jobs) as pool:
        yield from pool.map(one, entries)


def main(arguments: list[str]) -> int:
    """Run the scripts of the folder that the command line names."""
    parser = argparse.ArgumentParser(prog="reports.repros", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--jobs", type=int, default=1, help="how many at a time")
    given: Any = parser.parse_args(arguments)
    bad, total = 0, 0
    try:
        for name, found in faults(given.folder, max(1, given.jobs)):
            total, bad = total + 1, bad + bool(found)
            for fault in found:
                print(f"{name} {fault}")
    except NoReport as error:
        print(f"reports.repros: {error}", file=sys.stderr)
        return 2
    print(f"{given.folder}: {total - bad} of {total} scripts show what the report says")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
