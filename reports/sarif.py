"""`report.sarif`: the findings in SARIF 2.1.0, for code scanning: a result for each bucket, a rule for each symptom.

A result carries the bucket's id as its fingerprint, so that it is the same result in each run. What the ledger
explains is suppressed, with the cause as the reason. The place of a result is its repro script.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from oracles.ledger.states import UNSETTLED
from oracles.outcome import Bucket, Run, Severity, State
from reports import text
from reports.findings import BucketView

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
FINGERPRINT = "proxyproofBucket/v1"
FOLDER = "REPORT"
"""Stands for the report's folder, to which all places are relative."""

LEVELS = {Severity.LARGE: "warning", Severity.SMALL: "note"}
"""Levels of what is no "error"."""

BASELINES = {State.NEW: "new", State.CHANGED: "updated"}

MARKUP = re.compile(r"[\\\[\]]")
"""What a SARIF message would take for a link."""


def render(run: Run, views: Sequence[BucketView]) -> str:
    """Return the run's findings as SARIF."""
    return json.dumps(log(run, views), ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def log(run: Run, views: Sequence[BucketView]) -> dict[str, Any]:
    """Return the run's findings as a SARIF log."""
    symptoms = sorted({bucket.symptom for bucket in run.buckets})
    return {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {"driver": _driver(symptoms)},
                "automationDetails": {"id": f"proxyproof/{'+'.join(map(text.visible, run.engines))}/"},
                "originalUriBaseIds": {FOLDER: {"description": _message("the report's folder")}},
                "invocations": [_invocation(run)],
                "columnKind": "unicodeCodePoints",
                "results": [_result(b, v, symptoms) for b, v in zip(run.buckets, views, strict=True)],
                "properties": text.plain({"seed": run.seed, "digest": run.digest, "versions": run.versions}),
            }
        ],
    }


def _driver(symptoms: list[str]) -> dict[str, Any]:
    try:
        own = {"version": version("proxyproof")}
    except PackageNotFoundError:
        own = {}
    return {"name": "proxyproof", **own, "rules": [_rule(symptom) for symptom in symptoms]}


def _rule(symptom: str) -> dict[str, Any]:
    said = text.visible(symptom)
    words = re.findall(r"[A-Za-z0-9]+", said)
    return {
        "id": "-".join(words).lower() or "finding",
        "name": "".join(word[:1].upper() + word[1:] for word in words) or "Finding",
        "shortDescription": _message(said[:1].upper() + said[1:]),
        "fullDescription": _message(
            f"The engine's answer shows: {said}. A certificate, which exact arithmetic has checked, excludes it; or "
            "the engine gave none."
        ),
        "help": _message(
            "Run the script that the result names: it asks the engine alone. The report, index.html beside it, has the "
            "scene, both answers in full precision, and the proof."
        ),
        "defaultConfiguration": {"level": "error"},
    }


def _message(words: str) -> dict[str, str]:
    return {"text": MARKUP.sub(lambda found: "\\" + found[0], words)}


def _invocation(run: Run) -> dict[str, Any]:
    """How the run went; what the ledger no longer describes is told with it."""
    told = [("error", problem) for problem in run.problems]
    told += [("warning", f"{what} ({text.plural(n, 'time')})") for what, n in run.incidents.most_common()]
    for note in run.ledger:
        if note.state in UNSETTLED:
            told.append(("warning", f"{note.state.value} entry of the ledger: {note.engine} · {note.name}: {note.why}"))
    notes = [{"level": level, "message": _message(text.visible(words, limit=1000))} for level, words in told]
    whole = not (run.interrupted or run.problems)
    spent = {"seconds": text.plain(run.timing)}
    return {"executionSuccessful": whole, "toolExecutionNotifications": notes, "properties": spent}


def _result(bucket: Bucket, view: BucketView, symptoms: list[str]) -> dict[str, Any]:
    number = symptoms.index(bucket.symptom)
    where = {"uri": view.file, "uriBaseId": FOLDER}
    return {
        "ruleId": _rule(bucket.symptom)["id"],
        "ruleIndex": number,
        "kind": "fail",
        "level": _level(bucket),
        "message": _message(f"{text.visible(bucket.engine)} {bucket.query} {text.visible(bucket.pair)}: {view.fact}"),
        "locations": [
            {
                "physicalLocation": {"artifactLocation": where, "region": {"startLine": 1}},
                "logicalLocations": [_logical(bucket)],
            }
        ],
        "fingerprints": {FINGERPRINT: bucket.id},
        "partialFingerprints": {"primaryLocationLineHash": f"{bucket.id}:1"},
        "occurrenceCount": max(1, bucket.count),
        "baselineState": BASELINES.get(bucket.state, "unchanged"),
        "suppressions": list(_suppressions(bucket)),
        "properties": _properties(bucket, view),
    }


def _level(bucket: Bucket) -> str:
    severity = bucket.witness.verdict.severity
    return "error" if severity is None else LEVELS.get(severity, "error")


def _logical(bucket: Bucket) -> dict[str, str]:
    cell = [text.visible(word) for word in (bucket.engine, bucket.query, bucket.pair)]
    return {"name": cell[2], "fullyQualifiedName": ".".join(cell), "kind": "function"}


def _suppressions(bucket: Bucket) -> Iterator[dict[str, str]]:
    if bucket.state is State.EXPECTED:
        reason = f"{bucket.entry}: {bucket.cause}"
        yield {"kind": "external", "status": "accepted", "justification": text.visible(reason, limit=4000)}


def _properties(bucket: Bucket, view: BucketView) -> dict[str, Any]:
    verdict = bucket.witness.verdict
    own = {
        "number": view.number,
        **{name: getattr(bucket, name) for name in ("engine", "query", "pair", "degeneracy", "decade")},
        **{name: getattr(bucket, name) for name in ("count", "proven", "worst", "regimes", "state", "entry")},
        **{name: getattr(verdict, name) for name in ("amount", "lower", "upper")},
        "severity": view.severity,
        "scene": bucket.witness.scene.id,
    }
    found: dict[str, Any] = text.plain({**own, "tags": ["proxyproof", bucket.engine, bucket.query]})
    return found
