"""A run as plain data: the file `report.json`, whose format `report.schema.json` describes (`proxyproof schema`).

Numbers are doubles that read back to the bit. JSON has none that are not finite: those are the strings "NaN",
"Infinity" and "-Infinity". What is missing is null.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from oracles.outcome import Bucket, Run
from oracles.scene import Scene
from refimpl.proof.wire import certificate_to_json
from reports import text
from reports.accuracy_data import accuracy_data
from reports.broad_phase_data import crowd_data
from reports.findings import repro_file
from reports.surveys_data import survey_data

FORMAT = "proxyproof-report-1"
SCHEMA = "report.schema.json"
"""Name of the schema, in this package and in each report's folder."""

UNCUT = 1_000_000
"""Longest text of the project's own, in characters; foreign texts are cut where the reports cut them."""


def report_data(run: Run) -> dict[str, Any]:
    """Return the run as data for `report.json`; `schema` describes it."""
    counts = [
        {"engine": engine, "query": query, "pair": pair, "regime": regime, "verdict": kind.value, "count": n}
        for (engine, query, pair, regime, kind), n in sorted(run.counts.items())
    ]
    relations = [
        {"engine": engine, "relation": relation, "query": query, "verdict": kind.value, "count": n}
        for (engine, relation, query, kind), n in sorted(run.relations.items())
    ]
    support = [
        {"engine": engine, "query": query, "pair": pair, "kind": note.kind, "reason": note.reason}
        for (engine, query, pair), note in sorted(run.support.items())
    ]
    data = {
        "$schema": SCHEMA,
        "format": FORMAT,
        **{name: getattr(run, name) for name in ("seed", "budget", "seconds", "started", "interrupted")},
        **{
            name: getattr(run, name)
            for name in ("engines", "engine_versions", "versions", "regimes", "problems", "incidents", "timing")
        },
        **{name: getattr(run, name) for name in ("hunters", "models", "digest", "recalled")},
        "counts": counts,
        "relations": relations,
        "support": support,
        "crowds": [crowd_data(count) for count in run.crowds],
        "accuracy": accuracy_data(run),
        "ledger": [dict(vars(note)) for note in run.ledger],
    }
    buckets = [_bucket(number, bucket) for number, bucket in enumerate(run.buckets, 1)]
    surveys = text.plain([survey_data(count) for count in run.surveys], UNCUT)
    return {**text.plain(data), "surveys": surveys, "buckets": buckets}


def report_json(run: Run) -> str:
    """Return the text of `report.json`: a line per entry, and per item of the lists."""
    lines = []
    for name, value in report_data(run).items():
        items = [_dump(item) for item in value] if isinstance(value, list) else []
        lines.append(f"{_dump(name)}: " + ("[\n" + ",\n".join(items) + "\n]" if items else _dump(value)))
    return "{\n" + ",\n".join(lines) + "\n}\n"


def schema() -> str:
    """Return the JSON Schema of `report.json`."""
    return files("reports").joinpath(SCHEMA).read_text(encoding="utf-8")


def _dump(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _bucket(number: int, bucket: Bucket) -> dict[str, Any]:
    finding, verdict = bucket.witness, bucket.witness.verdict
    own: dict[str, Any] = {
        "scene": _scene(finding.scene),
        "proof_scene": _scene(verdict.proof_scene) if verdict.proof_scene is not None else None,
        "certificate": certificate_to_json(verdict.certificate) if verdict.certificate is not None else None,
        "related": None,
    }
    related = finding.related
    if related is not None:
        own["related"] = {"relation": related.relation, "scene": _scene(related.scene), "answer": related.answer}
    said = {
        "key": bucket.key,
        **{name: getattr(bucket, name) for name in ("engine", "query", "pair", "symptom", "degeneracy", "decade")},
        **{name: getattr(bucket, name) for name in ("count", "proven", "worst", "regimes", "state", "entry", "cause")},
        **{name: getattr(verdict, name) for name in ("kind", "severity", "amount", "lower", "upper", "claim")},
        **{name: getattr(finding, name) for name in ("answer", "reference", "text")},
    }
    named = {"number": number, "id": bucket.id}
    return {**named, **text.plain(said), **text.plain(own, UNCUT), "repro": repro_file(number, bucket)}


def _scene(scene: Scene) -> dict[str, Any]:
    return {**scene.to_json(), "id": scene.id}
