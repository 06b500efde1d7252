"""Check that a written report is complete: ``python -m reports.verify DIR``, as continuous integration does.

It reads what lies in the folder, not the run from which it was written. Exit status 0 when complete, 1 with a line
per gap, 2 when there is no report to check.
"""

from __future__ import annotations

import math
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from oracles.closing import has_scenes
from oracles.outcome import COMPARED, FINDINGS, Kind
from oracles.records import certificate_from_json, proven_interval
from oracles.scene import Scene
from oracles.sweep_regimes import TURNING
from reports.reading import REPORT, NoReport, read_json, read_report
from reports.sarif import FINGERPRINT
from reports.tables import regimes_for

SUPPORTED = ("native", "emulated")


CUT = re.compile(r"^> \*\*Left out, to be short: (\d+) of (\d+) findings[.;]", re.MULTILINE)
"""What `report.md` says when it had to be cut."""


def completeness(folder: Path) -> list[str]:
    """Sentences on whatever the report in `folder` lacks; empty when it is complete.

    Raises
    ------
    NoReport
        When `report.json` is missing, damaged or of another format.
    """
    data = read_report(folder)
    try:
        found = [*_run(data), *_coverage(data), *_sums(data), *_pages(folder, data), *_buckets(folder, data)]
        return [*found, *_cases(folder, data), *_results(folder, data)]
    except (LookupError, TypeError, AttributeError) as error:
        raise NoReport(f"{folder / REPORT} is damaged: {error!r}") from None


def _run(data: dict[str, Any]) -> Iterator[str]:
    if data["interrupted"]:
        yield "the run was interrupted"
    yield from data["problems"]
    for name in ("engines", "versions", "regimes", "counts", "support", "timing"):
        if not data[name]:
            yield f"report.json names no {name}"


def _coverage(data: dict[str, Any]) -> Iterator[str]:
    """Every supported cell must have been compared in every regime, but for turning that an engine does not know."""
    compared: Counter[tuple[str, ...]] = Counter()
    words = {kind.value for kind in COMPARED}
    for entry in data["counts"]:
        if entry["verdict"] in words or (entry["verdict"] == Kind.UNSUPPORTED and entry["regime"] in TURNING):
            compared[entry["engine"], entry["query"], entry["pair"], entry["regime"]] += entry["count"]
    cells = [e for e in data["support"] if e["kind"] in SUPPORTED]
    if not cells:
        yield "no engine supports any cell"
    answered = {(cell["engine"], cell["pair"]) for cell in cells}
    for cell in cells:
        key = cell["engine"], cell["query"], cell["pair"]
        regimes = [name for name in regimes_for(cell["query"], data["regimes"]) if has_scenes(name, key[2], answered)]
        silent = [regime for regime in regimes if compared[*key, regime] <= 0]
        if silent:
            where = "any regime" if len(silent) == len(regimes) else f"regime {', '.join(silent)}"
            yield f"nothing compared: {' · '.join(key)} in {where}"


def _sums(data: dict[str, Any]) -> Iterator[str]:
    """Every finding must be in a bucket, and none in two."""
    told, gathered = Counter[tuple[str, ...]](), Counter[tuple[str, ...]]()
    words = {kind.value for kind in FINDINGS}
    for entry in data["counts"]:
        if entry["verdict"] in words:
            told[entry["engine"], entry["query"], entry["pair"]] += entry["count"]
    for bucket in data["buckets"]:
        gathered[bucket["engine"], bucket["query"], bucket["pair"]] += bucket["count"]
    for key in sorted(told.keys() | gathered.keys()):
        if told[key] != gathered[key]:
            yield f"{told[key]} findings, but {gathered[key]} in buckets: {' · '.join(key)}"


def _pages(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    """Both pages must be there, to their end, with every bucket, or with the number of those that were cut."""
    ends = {"index.html": ("</html>", r'<span class="no">(\d+)</span>'), "report.md": ("", r"^#### (\d+)\\\. ")}
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
        cut = CUT.search(page)
        if missing and not (cut and (int(cut[1]), int(cut[2])) == (len(missing), len(numbers))):
            yield f"{name} lacks the buckets {sorted(missing)}"


def _cases(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    """`junit.xml` must have a case for each cell, each entry of the ledger, question of a survey and broad phase."""
    try:
        root = ElementTree.parse(folder / "junit.xml").getroot()
    except (OSError, ElementTree.ParseError) as error:
        yield f"cannot read junit.xml: {error}"
        return
    asked = {(count["survey"], count["engine"], count["question"]) for count in data["surveys"]}
    asked |= {("broad phase", count["engine"], "") for count in data["crowds"]}
    wanted = 1 + len(data["support"]) + len(data["ledger"]) + len(asked)
    cases = len(root.findall("testsuite/testcase"))
    if cases != wanted:
        yield f"junit.xml has {cases} cases instead of {wanted}"


def _results(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    """`report.sarif` must have a result for each bucket, with its id."""
    try:
        results = read_json(folder / "report.sarif")["runs"][0]["results"]
    except NoReport as error:
        yield str(error)
        return
    told = Counter(result["fingerprints"][FINGERPRINT] for result in results)
    if told != Counter(bucket["id"] for bucket in data["buckets"]):
        yield "report.sarif has other findings"


def _buckets(folder: Path, data: dict[str, Any]) -> Iterator[str]:
    for bucket in data["buckets"]:
        name = f"bucket {bucket['number']} ({bucket['key']})"
        for gap in (*_contents(bucket), *_script(folder, bucket["repro"]), *_issue(folder, bucket["repro"])):
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


def _issue(folder: Path, script: str) -> Iterator[str]:
    """The issue's text must be there, to its end."""
    name = f"issues/{Path(script).stem}.md"
    try:
        if "Found by proxyproof" not in (folder / name).read_text(encoding="utf-8"):
            yield f"{name} is cut off"
    except (OSError, ValueError):
        yield f"{name} is missing"


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
