"""Check that a written report is complete: ``python -m reports.verify DIR``, as continuous integration does.

It reads what lies in the folder, not the run from which it was written. Exit status 0 when complete, 1 with a line
per gap, 2 when there is no report to check.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from oracles.outcome import COMPARED, Kind
from oracles.records import certificate_from_json, proven_interval
from oracles.scene import Scene
from reports.summary import FORMAT
from reports.tables import regimes_for

SUPPORTED = ("native", "emulated")


class NoReport(Exception):
    """There is no report in the folder, or none of this format."""


def completeness(folder: Path) -> list[str]:
    """Sentences on whatever the report in `folder` lacks; empty when it is complete.

    Raises
    ------
    NoReport
        When `report.json` is missing or is not of this format.
    """
    data = _read(folder / "report.json")
    try:
        return [*_run(data), *_coverage(data), *_pages(folder, data), *_buckets(folder, data)]
    except (LookupError, TypeError, AttributeError) as error:
        raise NoReport(f"{folder / 'report.json'} is damaged: {error!r}") from None


def _read(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise NoReport(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise NoReport(f"{path} is not JSON: {error}") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise NoReport(f"{path} is not of the format {FORMAT}")
    return data


def _run(data: dict[str, Any]) -> Iterator[str]:
    if data["interrupted"]:
        yield "the run was interrupted"
    yield from data["problems"]
    for name in ("engines", "versions", "regimes", "counts", "support", "timing"):
        if not data[name]:
            yield f"report.json names no {name}"


def _coverage(data: dict[str, Any]) -> Iterator[str]:
    """Every supported cell must have been compared in every regime."""
    compared: Counter[tuple[str, ...]] = Counter()
    words = {kind.value for kind in COMPARED}
    for entry in data["counts"]:
        if entry["verdict"] in words:
            compared[entry["engine"], entry["query"], entry["pair"], entry["regime"]] += entry["count"]
    cells = [e for e in data["support"] if e["kind"] in SUPPORTED]
    if not cells:
        yield "no engine supports any cell"
    for cell in cells:
        key = cell["engine"], cell["query"], cell["pair"]
        regimes = regimes_for(cell["query"], data["regimes"])
        silent = [regime for regime in regimes if compared[*key, regime] <= 0]
        if silent:
            where = "any regime" if len(silent) == len(regimes) else f"regime {', '.join(silent)}"
            yield f"nothing compared: {' · '.join(key)} in {where}"


def _pages(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    """Both pages must be there, to their end, with every bucket."""
    ends = {"index.html": ("</html>", r'id="bucket-(\d+)"'), "report.md": ("", r"^#### (\d+)\\\. ")}
    numbers = {bucket["number"] for bucket in data["buckets"]}
    for name, (end, heading) in ends.items():
        try:
            page = (folder / name).read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            yield f"cannot read {name}: {error}"
            continue
        if not page.strip().endswith(end) or not page.strip():
            yield f"{name} is empty or cut off"
        missing = numbers - {int(found) for found in re.findall(heading, page, re.MULTILINE)}
        if missing:
            yield f"{name} lacks the buckets {sorted(missing)}"


def _buckets(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    for bucket in data["buckets"]:
        name = f"bucket {bucket['number']} ({bucket['key']})"
        for gap in (*_contents(bucket), *_script(folder, bucket["repro"])):
            yield f"{name}: {gap}"


def _contents(bucket: dict[str, Any]) -> Iterator[str]:
    """A finding is a scene, both answers, and a proven interval."""
    try:
        Scene.from_json(bucket["scene"])
    except ValueError as error:
        yield str(error)
    if not bucket["reference"]:
        yield "the reference's answer is missing"
    if not bucket["answer"] and not bucket["text"]:
        yield "the engine's answer is missing, and so is what it said instead"
    yield from _interval(bucket)
    if not bucket["claim"]:
        yield "nothing says what is wrong"
    if bucket["count"] < 1 or sum(bucket["regimes"].values()) != bucket["count"]:
        yield f"seen {bucket['count']} times, but {sum(bucket['regimes'].values())} over all regimes"


def _interval(bucket: dict[str, Any]) -> Iterator[str]:
    """The proven interval must be there, and the certificate must prove it: it is checked anew, exactly."""
    lower, upper = float(bucket["lower"]), float(bucket["upper"])
    if math.isnan(lower) or math.isnan(upper):
        yield "the proven interval is missing"
    elif lower > upper:
        yield f"the proven interval is empty: {lower!r} > {upper!r}"
    elif bucket["certificate"] is not None:
        try:
            scene = Scene.from_json(bucket["proof_scene"] or bucket["scene"])
            low, high = proven_interval(certificate_from_json(bucket["certificate"], scene), scene, bucket["symptom"])
        except ValueError as error:
            yield f"the certificate is refused: {error}"
            return
        if low < math.nextafter(lower, -math.inf) or high > math.nextafter(upper, math.inf):
            yield f"the certificate proves only {float(low)!r} to {float(high)!r}"
    if bucket["certificate"] is None and bucket["kind"] == Kind.WRONG and math.isfinite(float(bucket["amount"])):
        yield "no certificate proves it wrong"


def _script(folder: Path, name: str) -> Iterator[str]:
    """The script must be there and must be Python."""
    try:
        compile((folder / name).read_text(encoding="utf-8"), name, "exec")
    except OSError:
        yield f"the script {name} is missing"
    except (SyntaxError, ValueError) as error:
        yield f"the script {name} does not compile: {error}"


def main(arguments: list[str]) -> int:
    """Check the folder named on the command line."""
    if len(arguments) != 1:
        print("usage: python -m reports.verify DIR", file=sys.stderr)
        return 2
    try:
        found = completeness(Path(arguments[0]))
    except NoReport as error:
        print(f"reports.verify: {error}", file=sys.stderr)
        return 2
    for gap in found:
        print(gap)
    print(f"{arguments[0]}: {'complete' if not found else f'{len(found)} gaps'}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
