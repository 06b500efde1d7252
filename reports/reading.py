"""Reading what reports left: a folder's `report.json`, or a finding alone. Files may be anybody's.

Nothing of a file is executed, and nothing is believed that can be checked: sizes, structure and types here, the
certificates by whoever asks for them (`oracles.records.unproven`).
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from oracles.outcome import Bucket, EntryNote, Finding, Kind, Related, Run, Severity, State, SupportNote, Verdict
from oracles.records import certificate_from_json
from oracles.scene import Scene
from reports.accuracy_data import accuracy_from
from reports.broad_phase_data import crowd_from
from reports.summary import FORMAT
from reports.surveys_data import survey_from

REPORT = "report.json"
LARGEST = 1 << 28
"""Bytes of a file that is read."""

NUMBERS = ("amount", "lower", "upper")
DAMAGE = (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)
"""What data of another structure ends in."""


class NoReport(Exception):
    """There is no report or finding to be read; the text says in one line what is there instead."""


def read_json(path: Path) -> dict[str, Any]:
    """Read an object of JSON; raises `NoReport` for anything else, for numbers that are none, and for huge files."""
    try:
        if not path.is_file():
            raise NoReport(f"there is no file {path}")
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as error:
        raise NoReport(f"cannot read {path}: {error.strerror}") from None
    if len(content) > LARGEST:
        raise NoReport(f"{path} is larger than {LARGEST >> 20} MiB")
    try:
        data = json.loads(content, parse_constant=_refuse)
    except RecursionError:
        raise NoReport(f"{path} is nested too deeply") from None
    except ValueError as error:
        raise NoReport(f"{path} is not JSON: {error}") from None
    if not isinstance(data, dict):
        raise NoReport(f"{path} is not an object of JSON")
    return data


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number")


def report_file(place: Path) -> Path:
    """`report.json` of a folder, or the file itself."""
    return place / REPORT if place.is_dir() else place


def read_report(place: Path) -> dict[str, Any]:
    """Read the report in a folder, or a `report.json`; raises `NoReport`, also for other formats."""
    path = report_file(place)
    if not path.exists():
        raise NoReport(f"there is no report in {place}: no {REPORT}")
    data = read_json(path)
    if data.get("format") != FORMAT:
        raise NoReport(f"{path} is not of the format {FORMAT}")
    if not isinstance(data.get("buckets"), list) or not all(isinstance(item, dict) for item in data["buckets"]):
        raise NoReport(f"{path} is damaged: it has no list of buckets")
    return data


def run_from_data(data: dict[str, Any]) -> Run:
    """Rebuild what a report says of its run, but for the buckets; raises `NoReport` when it is damaged."""
    try:
        run = Run(int(data["seed"]), float(data["budget"]), _word(data["started"]), float(data["seconds"]))
        for name in ("engines", "models", "problems"):
            setattr(run, name, [_word(item) for item in data[name]])
        for name in ("versions", "engine_versions", "regimes"):
            setattr(run, name, {_word(key): _word(value) for key, value in data[name].items()})
        run.timing = {_word(key): float(value) for key, value in data["timing"].items()}
        run.incidents, run.hunters = (_counts(data[name]) for name in ("incidents", "hunters"))
        run.interrupted, run.digest, run.recalled = bool(data["interrupted"]), _word(data["digest"]), data["recalled"]
        for item in data["counts"]:
            engine, query, pair, regime = _words(item, "engine", "query", "pair", "regime")
            run.counts[engine, query, pair, regime, Kind(item["verdict"])] += int(item["count"])
        for item in data["relations"]:
            engine, relation, query = _words(item, "engine", "relation", "query")
            run.relations[engine, relation, query, Kind(item["verdict"])] += int(item["count"])
        for item in data["support"]:
            engine, query, pair, kind, reason = _words(item, "engine", "query", "pair", "kind", "reason")
            run.support[engine, query, pair] = SupportNote(kind, reason)
        run.accuracy = accuracy_from(data["accuracy"])
        run.crowds = [crowd_from(item) for item in data.get("crowds", [])]
        run.surveys = [survey_from(item) for item in data.get("surveys", [])]
        run.ledger = [_entry_note(item) for item in data["ledger"]]
    except DAMAGE as error:
        raise NoReport(f"the report is damaged: {in_words(error)}") from None
    return run


def _entry_note(item: dict[str, Any]) -> EntryNote:
    """Rebuild what a run makes of an entry: lists become tuples."""
    values: dict[str, Any] = {name: _tuples(value) for name, value in item.items()}
    return EntryNote(**{**values, "state": State(item["state"])})


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _words(item: dict[str, Any], *names: str) -> list[str]:
    return [_word(item[name]) for name in names]


def _counts(data: dict[str, Any]) -> Counter[str]:
    return Counter({_word(name): int(number) for name, number in data.items()})


def bucket_from_data(data: dict[str, Any]) -> Bucket:
    """Rebuild a bucket of a `report.json`, without its script; the certificate is read and not yet checked.

    Raises
    ------
    NoReport
        Names what is missing or is none.
    """
    try:
        named = (_word(data[name]) for name in ("engine", "query", "pair", "symptom", "degeneracy"))
        engine, query, pair, symptom, degeneracy = named
        return Bucket(
            engine,
            query,
            pair,
            symptom,
            degeneracy,
            None if data["decade"] is None else int(data["decade"]),
            finding_from_data(data),
            count=int(data["count"]),
            proven=int(data["proven"]),
            worst=float(data["worst"]),
            regimes=_counts(data["regimes"]),
            entry=None if data["entry"] is None else _word(data["entry"]),
            state=State(data["state"]),
            cause=_word(data["cause"]),
        )
    except DAMAGE as error:
        raise NoReport(f"{name_of(data)} is damaged: {in_words(error)}") from None


def finding_from_data(data: dict[str, Any]) -> Finding:
    """Rebuild the finding that a bucket shows; raises whatever its damage ends in (`DAMAGE`)."""
    scene = Scene.from_json(data["scene"])
    about = None if data["proof_scene"] is None else Scene.from_json(data["proof_scene"])
    certificate, severity = data["certificate"], data["severity"]
    verdict = Verdict(
        Kind(data["kind"]),
        _word(data["symptom"]),
        None if severity is None else Severity(severity),
        **{name: float(data[name]) for name in NUMBERS},
        claim=_word(data["claim"]),
        certificate=None if certificate is None else certificate_from_json(certificate, about or scene),
        proof_scene=about,
    )
    other = data["related"]
    related = None
    if other is not None:
        related = Related(_word(other["relation"]), Scene.from_json(other["scene"]), _answer(other["answer"]))
    answer, reference = _answer(data["answer"]), _answer(data["reference"])
    return Finding(_word(data["engine"]), scene, answer, reference, verdict, _word(data["text"]), related=related)


def name_of(data: dict[str, Any]) -> str:
    """What to call an item of `buckets`, whatever it holds."""
    number, key = data.get("number"), data.get("key")
    if isinstance(number, int) and isinstance(key, str):
        return f"bucket {number} ({key[:200]})"
    return "the finding"


def in_words(error: BaseException) -> str:
    """Say what kept data from being read."""
    if isinstance(error, KeyError):
        return f"it has no {str(error.args[0])[:100]!r}"
    return "it is nested too deeply" if isinstance(error, RecursionError) else str(error)[:300]


def chosen(data: dict[str, Any], wanted: str) -> dict[str, Any]:
    """Return the bucket of a report that has this number, or whose id begins so; raises `NoReport`."""
    buckets: list[dict[str, Any]] = data["buckets"]
    by_number = [bucket for bucket in buckets if str(bucket.get("number")) == wanted]
    prefix = wanted.casefold().removeprefix("b-")
    found = by_number or [b for b in buckets if prefix and str(b.get("id")).startswith(prefix)]
    if len(found) == 1:
        return found[0]
    if not found:
        raise NoReport(f"no finding has the number or id {wanted!r}: there are {_listed(buckets)}")
    raise NoReport(f"{wanted!r} begins the ids of several findings: {_listed(found)}")


def _listed(buckets: Iterable[dict[str, Any]], most: int = 6) -> str:
    names = [f"{bucket.get('number')} ({bucket.get('id')})" for bucket in buckets]
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "") or "none"


def _word(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"expected a text, got {str(value)[:50]!r}")
    return value


def _answer(data: Any) -> dict[str, object]:
    """What an engine said, by name; numbers that are not finite are written as texts."""
    return {_word(name): _value(value) for name, value in data.items()}


def _value(value: object) -> object:
    if isinstance(value, list):
        return [_value(item) for item in value]
    if value in ("NaN", "Infinity", "-Infinity"):
        return float(str(value))
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"expected numbers and texts in an answer, got {str(value)[:50]!r}")
